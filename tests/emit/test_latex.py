"""The LaTeX of every bundled machine compiles, and no line leaves the page."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

from symdyn.compiler import load_robot
from symdyn.derive.equations import equations_of_motion
from symdyn.emit.latex import document, operators
from symdyn.emit.latex_recursion import step_name
from symdyn.spec.machines import machine_names

needs_latex = pytest.mark.skipif(shutil.which("pdflatex") is None, reason="no LaTeX is here")


@needs_latex
@pytest.mark.parametrize("machine", machine_names())
def test_the_document_compiles_without_overfull_lines(machine: str, tmp_path: Path) -> None:
    (tmp_path / "equations.tex").write_text(document(equations_of_motion(load_robot(machine))), encoding="utf-8")
    done = subprocess.run(
        ["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "equations.tex"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        errors="replace",
        check=False,
    )
    assert done.returncode == 0, done.stdout[-2000:]
    log = (tmp_path / "equations.log").read_text(encoding="utf-8", errors="replace")
    assert "Overfull" not in log
    assert (tmp_path / "equations.pdf").stat().st_size > 10_000


def test_a_large_arm_is_told_by_its_recursion() -> None:
    text = document(equations_of_motion(load_robot("panda")))
    assert r"\section*{Recursion of the arm}" in text
    for law in ("angular velocity of link 1", "Newton, inertial force", "force from link 3", "base parameters"):
        assert law in text
    assert r"\tau^{\mathrm{arm}}_{7} &= " in text
    assert r"\section*{Coefficients of the arm}" not in text


def test_a_small_arm_is_told_by_its_coefficients() -> None:
    text = document(equations_of_motion(load_robot("two-link")))
    assert "B_{11} &=" in text
    assert r"\section*{Recursion of the arm}" not in text


@pytest.mark.parametrize(
    ("name", "latex"),
    [
        ("omega_2r_x", r"\omega^{r}_{2,x}"),
        ("alpha_3_z", r"\alpha_{3,z}"),
        ("c_2", r"\mathrm{c}_{2}"),
        ("J_4_x1", r"J_{4,x1}"),
        ("U_2_zx", r"U_{2,zx}"),
        ("n_1b_z", r"n^{b}_{1,z}"),
        ("coulomb", r"\mathrm{coulomb}"),
    ],
)
def test_names_of_intermediates(name: str, latex: str) -> None:
    assert step_name(name) == latex


def test_each_operator_that_occurs_is_explained_and_no_other() -> None:
    drive, rigid = (equations_of_motion(load_robot(name)) for name in ("irb6-axis1", "two-link"))
    symbols = [symbol for symbol, _ in operators(drive)]
    assert symbols == [
        r"\operatorname{sign}(x)",
        r"\operatorname{dz}_S(x)",
        r"\operatorname{out}_S(x)",
        r"\operatorname{push}_S(x)",
    ]
    assert all(f"${symbol}$ &" in document(drive) for symbol in symbols)
    assert operators(rigid) == ()
    assert "Notation" not in document(rigid)
