from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from symdyn.base.latex_check import is_safe_latex
from symdyn.base.names import (
    collisions,
    escape_latex,
    identifier_problem,
    latex_of,
    robot_name_problem,
    with_subscripts,
)


def code(name: str) -> str | None:
    problem = identifier_problem(name)
    return problem.code if problem else None


@pytest.mark.parametrize("name", ["m", "g", "K_Et", "K_E", "q1", "elbow", "lambda_", "a" * 64, "T_f", "Q"])
def test_names_that_are_fine(name: str) -> None:
    assert code(name) is None


@pytest.mark.parametrize(
    "name",
    ["", "1a", "_a", "a b", "a-b", "ﬁ", "µ", "é", "a" * 65, '__import__("os").system("id")', r"\input{/etc/passwd}",
     "a\n", "a;import os", "x\x00", "a" * 10_000],
)  # fmt: skip
def test_malformed_names(name: str) -> None:
    assert code(name) == "SD101"


@pytest.mark.parametrize("name", ["lambda", "None", "pi", "t", "q", "qd", "qdd", "tau", "x", "u", "p", "out", "print"])
def test_reserved_names_suggest_an_underscore(name: str) -> None:
    problem = identifier_problem(name)
    assert problem is not None
    assert problem.code == "SD102"
    assert f"`{name}_`" in problem.hint
    assert code(name + "_") is None


def test_every_keyword_is_reserved() -> None:
    import keyword

    assert {name for name in (*keyword.kwlist, *keyword.softkwlist) if code(name) is None} == set()


def test_collisions_differ_by_case_alone() -> None:
    assert collisions(["K_E", "k_e", "K_Et", "m", "K_E"]) == ((1, 0), (4, 0))


def test_robot_names() -> None:
    assert [robot_name_problem(name) for name in ("irb6-axis1", "two_link", "emps", "a1")] == [None] * 4
    for name in ("", "Irb", "a--b", "a-", "-a", "a/b", "../x", "a" * 65, "1a"):
        problem = robot_name_problem(name)
        assert problem is not None, name
        assert problem.code == "SD101"
    reserved = robot_name_problem("class")
    assert reserved is not None
    assert reserved.code == "SD102"


@pytest.mark.parametrize(
    ("name", "latex"),
    [
        ("m", "m"),
        ("m_1", "m_{1}"),
        ("m1", "m_{1}"),
        ("K_Et", "K_{Et}"),
        ("alpha", r"\alpha"),
        ("G_tau", r"G_{\tau}"),
        ("alpha_2", r"\alpha_{2}"),
        ("lambda_", r"\lambda"),
        ("mass", r"\mathrm{mass}"),
        ("d_1_x", "d_{1,x}"),
        ("F_max", r"F_{\mathrm{max}}"),
        ("theta_dot_1", r"\theta_{\mathrm{dot},1}"),
        ("gravity_z", r"\mathrm{gravity}_{z}"),
        ("elbow_viscous_friction_coefficient", r"\mathrm{elbow}_{\mathrm{viscous\,friction\,coefficient}}"),
    ],
)
def test_latex_of(name: str, latex: str) -> None:
    assert latex_of(name) == latex


@pytest.mark.parametrize(
    ("symbol", "names", "latex"),
    [
        ("m", ("elbow",), r"m_{\mathrm{elbow}}"),
        ("F_c", ("axis1", "harmonic_drive"), r"F_{c,\mathrm{axis1},\mathrm{harmonic\,drive}}"),
        ("K_{Et}", ("a",), "K_{Et,a}"),
        (r"\sigma_0", ("a",), r"\sigma_{0,a}"),
        ("F^{+}_c", ("a",), "{F^{+}_c}_{a}"),
    ],
)
def test_with_subscripts(symbol: str, names: tuple[str, ...], latex: str) -> None:
    assert with_subscripts(symbol, names) == latex


@settings(deadline=None)
@given(st.from_regex(r"[A-Za-z][A-Za-z0-9_]{0,63}", fullmatch=True))
def test_latex_of_any_name_is_safe_and_without_double_subscript(name: str) -> None:
    latex = latex_of(name)
    assert is_safe_latex(latex) or len(latex) > 120, latex


@pytest.mark.parametrize(
    "text",
    ["m_2", r"\alpha_{1}", r"\dot q_{1}", r"F_{\mathrm{c}}", "x^2_1", r"F_{c}^{+}", r"\mathrm{elbow\,joint}", "a'"],
)
def test_safe_latex(text: str) -> None:
    assert is_safe_latex(text)


@pytest.mark.parametrize(
    "text",
    [r"\input{/etc/passwd}", r"\write18{id}", "a_b_c", "a^b^c", "a'^2", "{", "}", "m_", "_m", "", " ", r"\hat", "m_{2",
     "$x$", "a%b", "a&b", "#1", r"\def\x{}", r"\\", "é", "a" * 121, "{}", "a\nb", r"\mathrm_a"],
)  # fmt: skip
def test_unsafe_latex(text: str) -> None:
    assert not is_safe_latex(text)


@settings(deadline=None)
@given(st.text(max_size=50))
def test_any_latex_is_judged(text: str) -> None:
    if is_safe_latex(text):
        assert set(text) <= set("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_^{}\\,.+- '")


def test_escape_leaves_nothing_active() -> None:
    assert escape_latex(r"\input{a}_1 50%") == r"\textbackslash{}input\{a\}\_1 50\%"
