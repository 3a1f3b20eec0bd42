"""C99 as a language: exact numbers, signs and brackets, and names that C has not taken."""

from __future__ import annotations

import math
import operator
import re
import shutil
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest

from symdyn.compiler import compile_robot, robot_from_text
from symdyn.emit.c_printer import C99, identifier, string
from symdyn.program.errors import ProgramError
from symdyn.program.ssa import Argument, Node, Op, Program
from tests.emit.c_library import (
    Build,
    files_of,
    of_programs,
    run,
    two_link,
)


def line(op: Op, *args: int, **facts: object) -> Node:
    return Node(op, args, **facts)  # type: ignore[arg-type]  # the fields of a node are of several types


def bits(values: Sequence[float]) -> list[str]:
    return [float(value).hex() for value in values]  # tells -0.0 from 0.0


NUMBERS = (0.0, -0.0, 1.0, -1.0, 2, -3, 0.1, 1e22, 1e16, 123456789012345680.0, 1e-05, 5e-324, -5e-324,
           2.2250738585072014e-308, 1.7976931348623157e308, math.pi, 1 / 3, 9.81)  # fmt: skip


def test_numbers_are_exact(build: Build) -> None:
    nodes = [line(Op.CONST, value=value) for value in NUMBERS]
    program = Program("numbers", (), tuple(nodes), tuple(range(len(nodes))), (len(nodes),))
    text = of_programs(program)
    assert bits(build(text)("f_0", [], program.shape)) == bits(NUMBERS)
    assert "out[4 * S + k] = 2.0;" in text["two_link.c"]


Tree = tuple[Op, "Tree", "Tree"] | tuple[Op, "Tree"] | float | str
X = {"x_1": 0.75, "x_2": -1.5}
INFIX: dict[Op, Callable[[float, float], float]] = {
    Op.ADD: operator.add,
    Op.SUB: operator.sub,
    Op.MUL: operator.mul,
    Op.DIV: operator.truediv,
}


def trees() -> list[Tree]:
    """Every way in which two operators meet, and each of these beside a third."""
    leaves: list[Tree] = ["x_1", "x_2", -2.0]
    small = [*leaves, *((op, "x_2", "x_1") for op in INFIX), *((Op.NEG, leaf) for leaf in leaves)]
    pairs = [*((op, a, b) for op in INFIX for a in small for b in small), *((Op.NEG, tree) for tree in small)]
    more = [(op, *both) for op in INFIX for tree in pairs[::3] for both in (("x_1", tree), (tree, "x_1"))]
    return [tree for tree in (*pairs, *more) if value(tree) is not None]


def value(tree: Tree) -> float | None:
    """None where something is divided by zero."""
    if isinstance(tree, float | str):
        return X[tree] if isinstance(tree, str) else tree
    args = [value(branch) for branch in tree[1:]]
    if None in args or (tree[0] is Op.DIV and args[1] == 0.0):
        return None
    return -args[0] if tree[0] is Op.NEG else INFIX[tree[0]](*args)  # type: ignore[operator, arg-type]  # a tree is a leaf or nested


def test_signs_and_brackets(build: Build) -> None:
    """No line is shared, so that none gets a variable and every expression is written whole."""
    nodes: list[Node] = []

    def write(tree: Tree) -> int:
        if isinstance(tree, str):
            return list(X).index(tree)
        facts = {"value": tree} if isinstance(tree, float) else {}
        args = () if isinstance(tree, float) else tuple(write(branch) for branch in tree[1:])
        nodes.append(line(Op.CONST if isinstance(tree, float) else tree[0], *args, **facts))
        return len(nodes) - 1

    nodes += [line(Op.INPUT, name=name) for name in X]
    found = trees()
    outputs = tuple(write(tree) for tree in found)
    program = Program("signs", (Argument("x", tuple(X)),), tuple(nodes), outputs, (len(found),))
    files = of_programs(program)
    assert "x_1 - (x_2 - x_1);" in files["two_link.c"]
    assert "-(-x_1)" in files["two_link.c"]
    results = build(files)("f_0", [np.array(list(X.values()))], program.shape)
    np.testing.assert_allclose(results, [value(tree) for tree in found], rtol=1e-14, atol=1e-14)


def test_integers_do_not_divide_as_integers(build: Build) -> None:
    nodes = (line(Op.CONST, value=3), line(Op.CONST, value=-2), line(Op.DIV, 0, 1))
    program = Program("integers", (), nodes, (2,), (1,))
    assert build(of_programs(program))("f_0", [], (1,)) == -1.5


@pytest.mark.parametrize("x", [0.5, -0.5, 0.0, -0.0, math.inf, -math.inf, math.nan])
def test_jumps_and_choices_are_those_of_python(build: Build, x: float) -> None:
    ops = (Op.SIGN, Op.STEP, Op.ABS)
    nodes = [line(Op.INPUT, name="x_1"), line(Op.CONST, value=0.25), *(line(op, 0) for op in ops)]
    nodes += [line(op, *args) for op in (Op.MIN, Op.MAX) for args in ((0, 1), (1, 0))]
    program = Program("jumps", (Argument("x", ("x_1",)),), tuple(nodes), tuple(range(2, 9)), (7,))
    wanted = [float((x > 0) - (x < 0)), float(x > 0), abs(x), min(x, 0.25), min(0.25, x), max(x, 0.25), max(0.25, x)]
    assert bits(build(of_programs(program))("f_0", [np.array([x])], (7,))) == bits(wanted)


def test_what_is_unused_does_not_warn(build: Build) -> None:
    arguments = (Argument("x", ("x_1",)), Argument("p", ()))
    idle = Program("idle", arguments, (line(Op.CONST, value=1.0),), (0,), (1,))
    empty = Program("empty", arguments, (), (), (0,))
    library = build(of_programs(idle, empty))
    assert library("f_0", [np.ones(1), np.ones(0)], (1,)) == 1.0
    assert library("f_1", [np.ones(1), np.ones(0)], (0,)).size == 0


TAKEN = sorted(word for word in (*C99.reserved, "y0", "j1", "gamma", "log2", "p_2", "t9") if word.isidentifier())


def test_names_that_c_has_taken(build: Build) -> None:
    """Every reserved word as a label, then as an input, and as an argument."""
    words = [word for word in TAKEN if identifies(word)]
    assert {"double", "int", "INFINITY", "near", "sin", "sign_of", "restrict", "out"} <= set(words)
    nodes = [line(Op.INPUT, name="seed")]
    nodes += [line(Op.ADD, k, 0, name=word, origin="a label") for k, word in enumerate(words)]
    labels = Program("labels", (Argument("p", ("seed",)),), tuple(nodes), (len(words),), (1,))
    reads = [line(Op.INPUT, name=word) for word in words]
    sums = [line(Op.ADD, len(words) + k - 1 if k else 0, k + 1) for k in range(len(words) - 1)]
    last = len(words) + len(sums) - 1
    jump = [line(Op.SIGN, last), line(Op.MUL, last, last + 1)]  # calls sign_of, which is also an input
    inputs = Program("inputs", (Argument("double", tuple(words)),), (*reads, *sums, *jump), (last + 2,), (1,))
    library = build(of_programs(labels, inputs))
    assert library("f_0", [np.array([1.0])], (1,)) == len(words) + 1
    assert library("f_1", [np.arange(len(words), dtype=float)], (1,)) == len(words) * (len(words) - 1) / 2


def identifies(word: str) -> bool:
    """Whether a program may have the name at all: Python's keywords may not."""
    try:
        Program("f", (Argument("x", (word,)),), (), (), (0,))
    except ProgramError:
        return False
    return True


@pytest.mark.parametrize("flags", [("-std=c99",), ("-std=gnu99",)], ids=" ".join)
def test_every_macro_of_the_compiler_is_reserved(compiler: str, tmp_path: Path, flags: tuple[str, ...]) -> None:
    (tmp_path / "empty.c").write_text("#include <math.h>\n#include <stddef.h>\n")
    macros = set(re.findall(r"^#define (\w+)", run(compiler, *flags, "-dM", "-E", tmp_path / "empty.c"), re.MULTILINE))
    assert {"INFINITY", "isnan"} <= macros
    assert {name for name in macros if not name.startswith("_")} <= C99.reserved


CLASHES = """
[robot]
name = "NAME"
description = 'ends a comment */ int x; /* "quoted" \\ and ??/ µ'
gravity = [0, 0, -9.81]
[parameters]
short = "2 kg"
INFINITY = "0.5 m"
near = { free = "kg" }
[dh]
rows = [ ["q", 0, "INFINITY", "90 deg"], ["q", 0, "INFINITY", 0] ]
[[joint]]
name = "double"
link = { mass = "short", com = ["-1/2 INFINITY", 0, 0] }
[[joint]]
name = "NAN"
link = { mass = "near", com = ["-1/2 INFINITY", 0, 0] }
[[effect]]
type = "coulomb_friction"
at = "double"
level = "0.3 N m"
"""


@pytest.mark.parametrize(("name", "stem"), [("double", "double"), ("math", "math_robot"), ("a-b_c", "a_b_c")])
def test_a_robot_of_words_that_c_has_taken(build: Build, name: str, stem: str) -> None:
    of = compile_robot(robot_from_text(CLASHES.replace("NAME", name), "clash.toml"))
    files = files_of(of)
    assert set(files) == {f"{stem}.h", f"{stem}.c"}
    assert "hence no form with parameters folded in, and NAN in the table: near" in files[f"{stem}.h"]
    assert {form.name[-2:] for form in of.forms} == {"_p"}
    run_prefix = identifier(name)
    assert f"void {run_prefix}_gravity_p(const double *q, const double *p, double *out);" in files[f"{stem}.h"]
    library = build(files)
    assert library.source.stem == stem
    assert 3 * len(of.forms) == len(re.findall(rf"^void {run_prefix}_", files[f"{stem}.c"], re.MULTILINE))


def test_every_name_of_a_file_has_the_prefix(build: Build) -> None:
    library = build(files_of(two_link()))
    symbols = [row.split() for row in run("nm", "-D", "--defined-only", library.path).splitlines()]
    own = {row[-1] for row in symbols if not row[-1].startswith("_")}
    assert len(own) == 3 * len(two_link().forms) + 13  # NAME, NAME_batch, NAME_soa
    assert {name for name in own if not name.startswith("two_link_")} == set()
    written = {row[-1] for row in symbols if row[-2] in "BCDS" and row[-1] in own}
    # Lists of pointers are constant, and writable only while they are loaded (relocation).
    assert written == set() or all(f"const char *const {name}[]" in library.source.read_text() for name in written)


def test_strings_and_identifiers() -> None:
    assert string('a"b\\c??/µ') == '"a\\042b\\134c\\077\\077/\\302\\265"'
    assert [identifier(name) for name in ("irb6-axis1", "1a", "_x", "", "double")] == [
        "irb6_axis1", "robot_1a", "x", "robot_", "double",
    ]  # fmt: skip


def test_the_header_is_also_one_of_cpp(tmp_path: Path, build: Build) -> None:
    cpp = shutil.which("c++") or shutil.which("clang++")
    if cpp is None:  # symdyn needs none: C++ is what users of the header may have
        pytest.skip("no C++ compiler is here")  # the header is read as C everywhere else
    library = build(files_of(two_link()))
    main = tmp_path / "main.cpp"
    main.write_text(
        '#include "two_link.h"\n#include "two_link.h"\n#include <cstdio>\n'
        "int main() { double q[two_link_n_coordinates] = {0.3, 0.4}, out[2]; two_link_gravity(q, out);\n"
        '  std::printf("%.17g %.17g", out[0], out[1]); }\n'
    )
    flags = ("-std=c++11", "-Wall", "-Wextra", "-Werror", "-pedantic")
    run(cpp, *flags, f"-I{library.source.parent}", main, library.path, "-o", tmp_path / "main")
    found = [float(word) for word in run(tmp_path / "main").split()]
    assert found == library("gravity", [np.array([0.3, 0.4])], (2,)).tolist()
