"""C99 as compilers read it: no warning, the numbers of the Numba kernel, and names that C has not taken."""

from __future__ import annotations

import ctypes
import itertools
import math
import operator
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from symdyn.compiler import Compiled, compile_robot, load_robot, robot_from_text
from symdyn.emit.c_printer import C99, identifier, string
from symdyn.emit.c_source import c_files
from symdyn.emit.forms import Form
from symdyn.emit.kernel import Kernel
from symdyn.emit.tables import name_tables
from symdyn.program.evaluate import evaluate
from symdyn.program.ssa import Argument, Node, Op, Program
from tests.emit.machines import MACHINES
from tests.program.strategies import ARGUMENTS, POINTS, programs

STRICT = ("-std=c99", "-Wall", "-Wextra", "-Wshadow", "-Werror", "-pedantic", "-O2")
SANITIZERS = "-fsanitize=undefined,address"
# Of the largest entry of a result. On x86-64 both are equal to the last bit: the same operations in the same
# order, the same libm. Where compilers fuse multiplications and additions, 18 were seen.
ULPS = 64

Array = np.ndarray
Machine = Callable[[str], Compiled]
Machines = Callable[[str], Kernel]
Build = Callable[[Mapping[str, str]], "Library"]


def compilers() -> list[str]:
    """cc, gcc and clang as far as they are there, each once though it may have two names."""
    found = {os.path.realpath(path): name for name in ("cc", "gcc", "clang") if (path := shutil.which(name))}
    return sorted(found.values())


def run(*command: object) -> str:
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, f"{done.stderr}\n{done.stdout}"
    return done.stdout


class Library:
    """A compiled source, its functions called with arrays."""

    def __init__(self, folder: Path, files: Mapping[str, str], compiler: str) -> None:
        for name, text in files.items():
            (folder / name).write_text(text, encoding="utf-8")
        self.source = next(folder.glob("*.c"))
        self.path = folder / "library.so"
        run(compiler, *STRICT, "-shared", "-fPIC", self.source, "-o", self.path, "-lm")
        self.loaded = ctypes.CDLL(str(self.path))

    def __call__(self, name: str, arguments: Sequence[Array], shape: tuple[int, ...]) -> Array:
        out = np.full(shape, 77.0)
        function = getattr(self.loaded, f"{self.source.stem}_{name}")
        function.restype = None
        function(*(array.ctypes.data_as(ctypes.c_void_p) for array in (*arguments, out)))
        return out

    def texts(self, table: str, count: int) -> tuple[str, ...]:
        """The entries of a list, which must end where it says."""
        entries = (ctypes.c_char_p * (count + 1)).in_dll(self.loaded, f"{self.source.stem}_{table}")
        assert entries[count] is None
        return tuple((entry or b"").decode() for entry in entries[:count])


@pytest.fixture(params=compilers() or [pytest.param("cc", marks=pytest.mark.skip(reason="no C compiler is here"))])
def compiler(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture
def build(compiler: str, tmp_path: Path) -> Build:
    numbers = itertools.count()

    def library(files: Mapping[str, str]) -> Library:
        folder = tmp_path / str(next(numbers))  # a library is loaded once by its path
        folder.mkdir()
        return Library(folder, files, compiler)

    return library


@cache
def two_link() -> Compiled:
    return compile_robot(load_robot("two-link"))


def files_of(of: Compiled, forms: Sequence[Form] | None = None) -> Mapping[str, str]:
    return c_files(of.equations, of.forms if forms is None else forms)


def of_programs(*found: Program) -> Mapping[str, str]:
    """Programs as the functions f_0, f_1, ... of a robot."""
    return files_of(two_link(), [Form(f"f_{k}", "One.", program, ()) for k, program in enumerate(found)])


def random_arguments(program: Program, p: Array, rng: np.random.Generator) -> list[Array]:
    return [
        p * rng.uniform(0.8, 1.2, p.size) if argument.name == "p" else rng.uniform(-2.0, 2.0, len(argument.symbols))
        for argument in program.arguments
    ]


def assert_same(library: Library, kernel: Kernel, forms: Sequence[Form]) -> None:
    rng = np.random.default_rng(3)
    for form in forms:
        for _ in range(10):
            arguments = random_arguments(form.program, kernel.values, rng)
            wanted = np.asarray(getattr(kernel, form.name)(*arguments))
            found = library(form.name, arguments, wanted.shape)
            assert np.all(np.isfinite(wanted))
            tolerance = ULPS * np.finfo(float).eps * np.abs(wanted).max(initial=0.0)
            np.testing.assert_allclose(found, wanted, rtol=0.0, atol=tolerance, err_msg=form.name)


@pytest.mark.parametrize("machine", MACHINES)
def test_functions_and_tables_are_those_of_the_kernel(
    machine: str, build: Build, compiled: Machine, interpreted: Machines
) -> None:
    of = compiled(machine)
    assert len(of.forms) >= 26
    library = build(files_of(of))
    assert_same(library, interpreted(machine), of.forms)
    assert_same_tables(library, of, interpreted(machine))


@pytest.mark.slow
@pytest.mark.parametrize("machine", MACHINES)
def test_all_functions_equal_those_that_numba_compiles(machine: str, build: Build, compiled: Machine) -> None:
    of = compiled(machine)
    assert_same(build(files_of(of)), of.kernel(), of.forms)


def assert_same_tables(library: Library, of: Compiled, kernel: Kernel) -> None:
    for table in name_tables(of.equations):
        wanted = getattr(kernel.module, table)
        assert library.texts(table.lower(), len(wanted)) == wanted
    values = ctypes.c_double * len(kernel.parameters)
    assert list(values.in_dll(library.loaded, f"{library.source.stem}_parameter_values")) == kernel.values.tolist()


@settings(deadline=None, max_examples=8, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(found=st.lists(programs(size=80), min_size=10, max_size=25))
def test_random_programs_mean_what_the_evaluator_says(build: Build, found: list[Program]) -> None:
    library = build(of_programs(*found))
    for k, program in enumerate(found):
        for point in POINTS:
            arguments = [np.array(point[argument.name]) for argument in ARGUMENTS]
            assert_near(library(f"f_{k}", arguments, program.shape), program, point)


def assert_near(found: Array, program: Program, point: Mapping[str, Sequence[float]]) -> None:
    """As near to the true value as it must be: runs with fewer digits than a double has show what rounding does."""
    wanted = evaluate(program, point, 50)
    coarse = [evaluate(program, point, digits) for digits in (9, 11, 13)]
    for k, value in enumerate(wanted):
        spread = max(abs(run[k] - value) for run in coarse)
        assert abs(found[k] - value) <= spread + 1e-13 * (1 + abs(value))


def line(op: Op, *args: int, **facts: object) -> Node:
    return Node(op, args, **facts)  # type: ignore[arg-type]


def bits(values: Sequence[float]) -> list[str]:
    return [float(value).hex() for value in values]  # tells -0.0 from 0.0


NUMBERS = (0.0, -0.0, 1.0, -1.0, 2, -3, 0.1, 1e22, 1e16, 123456789012345680.0, 1e-05, 5e-324, -5e-324,
           2.2250738585072014e-308, 1.7976931348623157e308, math.pi, 1 / 3, 9.81)  # fmt: skip


def test_numbers_are_exact(build: Build) -> None:
    nodes = [line(Op.CONST, value=value) for value in NUMBERS]
    program = Program("numbers", (), tuple(nodes), tuple(range(len(nodes))), (len(nodes),))
    text = of_programs(program)
    assert bits(build(text)("f_0", [], program.shape)) == bits(NUMBERS)
    assert "out[4] = 2.0;" in text["two_link.c"]


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
    return -args[0] if tree[0] is Op.NEG else INFIX[tree[0]](*args)  # type: ignore[operator, arg-type]


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
    except Exception:
        return False
    return True


@pytest.mark.parametrize("flags", [("-std=c99",), ("-std=gnu99",)], ids=" ".join)
def test_every_macro_of_the_compiler_is_reserved(compiler: str, tmp_path: Path, flags: tuple[str, ...]) -> None:
    (tmp_path / "empty.c").write_text("#include <math.h>\n")
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
    assert len(of.forms) == len(re.findall(rf"^void {run_prefix}_", files[f"{stem}.c"], re.MULTILINE))


def test_every_name_of_a_file_has_the_prefix(build: Build) -> None:
    library = build(files_of(two_link()))
    symbols = [row.split() for row in run("nm", "-D", "--defined-only", library.path).splitlines()]
    own = {row[-1] for row in symbols if not row[-1].startswith("_")}
    assert len(own) == len(two_link().forms) + 13
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
    if cpp is None:
        pytest.skip("no C++ compiler is here")
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


def driver(stem: str, forms: Sequence[Form], arguments: Mapping[str, Sequence[Array]]) -> str:
    """A program that calls every function with arrays of exactly their sizes, from the heap, and prints the results."""
    calls = []
    for form in forms:
        lists = [f"(double[]){{{', '.join(map(repr, values.tolist()))}}}" for values in arguments[form.name]]
        sizes = [values.size for values in arguments[form.name]]
        copies = ", ".join(f"copy({size}, {values})" for size, values in zip(sizes, lists, strict=True))
        count = len(form.program.outputs)
        names = ", ".join(f"a[{k}]" for k in range(len(sizes)))
        calls.append(
            f"    {{ double *a[] = {{{copies}}}, *out = malloc({count} * sizeof *out);\n"
            f"      {stem}_{form.name}({names}, out);\n"
            f'      for (int k = 0; k < {count}; k++) printf("%.17g\\n", out[k]);\n'
            f"      for (int k = 0; k < {len(sizes)}; k++) free(a[k]);\n      free(out); }}"
        )
    return "\n".join(
        [
            f'#include "{stem}.h"',
            "#include <stdio.h>\n#include <stdlib.h>\n#include <string.h>",
            "static double *copy(size_t n, const double *from)",
            "{ double *to = malloc(n * sizeof *to); memcpy(to, from, n * sizeof *to); return to; }",
            "int main(void)\n{",
            *calls,
            "    return 0;\n}\n",
        ]
    )


def test_sanitizers_find_nothing(
    compiler: str, build: Build, tmp_path: Path, compiled: Machine, interpreted: Machines
) -> None:
    """Every read and write within bounds, nothing undefined; and a planted fault is found."""
    machine = "emps"
    (tmp_path / "trial.c").write_text("int main(int n, char **v) { int a[2] = {0, 0}; return a[n + 1] + (v == 0); }\n")
    trial = [compiler, SANITIZERS, "-fno-sanitize-recover=all", tmp_path / "trial.c", "-o", tmp_path / "trial"]
    if subprocess.run(trial, capture_output=True).returncode != 0:
        pytest.skip(f"{compiler} has no sanitizers here")
    assert subprocess.run([tmp_path / "trial"], capture_output=True).returncode != 0
    of, kernel, library = compiled(machine), interpreted(machine), build(files_of(compiled(machine)))
    rng = np.random.default_rng(5)
    arguments = {form.name: random_arguments(form.program, kernel.values, rng) for form in of.forms}
    main = library.source.parent / "main.c"
    main.write_text(driver(library.source.stem, of.forms, arguments))
    flags = (*STRICT, "-g", SANITIZERS, "-fno-sanitize-recover=all")
    run(compiler, *flags, library.source, main, "-o", tmp_path / "main", "-lm")
    found = [float(word) for word in run(tmp_path / "main").split()]
    wanted = [library(form.name, arguments[form.name], form.program.shape).ravel().tolist() for form in of.forms]
    np.testing.assert_allclose(found, np.concatenate(wanted), rtol=1e-12, atol=1e-14 * np.abs(found).max())


WRITE = """
import sys
from pathlib import Path
from symdyn.compiler import generate, load_robot
generate(load_robot("emps"), Path(sys.argv[1]), ["c"])
"""


def test_the_same_bytes_under_any_hash_seed(tmp_path: Path) -> None:
    folders = [tmp_path / seed for seed in ("0", "20260")]
    for folder in folders:
        environment = {"PYTHONHASHSEED": folder.name, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
        subprocess.run([sys.executable, "-c", WRITE, folder], env={**os.environ, **environment}, check=True)
    first, second = ({path.name: path.read_bytes() for path in folder.iterdir()} for folder in folders)
    assert set(first) == {"emps.h", "emps.c", "equations.tex", "manifest.json"}
    assert first == second
