"""C99 as compilers read it: no warning, and the numbers of the Numba kernel and of the evaluator."""

from __future__ import annotations

import ctypes
import os
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from symdyn.compiler import Compiled
from symdyn.emit.forms import Form
from symdyn.emit.kernel import Kernel
from symdyn.emit.tables import name_tables
from symdyn.program.evaluate import evaluate
from symdyn.program.ssa import Program
from tests.emit.c_batches import assert_batches
from tests.emit.c_library import (
    SANITIZERS,
    STRICT,
    ULPS,
    Array,
    Build,
    Library,
    Machine,
    Machines,
    files_of,
    of_programs,
    run,
)
from tests.emit.machines import MACHINES
from tests.program.strategies import ARGUMENTS, POINTS, programs

EPS = np.finfo(float).eps


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
            tolerance = ULPS * EPS * np.abs(wanted).max(initial=0.0)
            if np.abs(found - wanted).max(initial=0.0) > tolerance:  # a joint's inertia may be a small difference
                tolerance += last_digit(getattr(kernel, form.name), arguments, wanted)
            np.testing.assert_allclose(found, wanted, rtol=0.0, atol=tolerance, err_msg=form.name)


def last_digit(function: Callable[..., Array], arguments: Sequence[Array], wanted: Array) -> float:
    """How far the last digit of the arguments moves a result: two ways of rounding agree no better (Higham 2002)."""
    rng = np.random.default_rng(5)
    moved = [function(*(a * (1.0 + EPS * rng.uniform(-1.0, 1.0, a.size)) for a in arguments)) for _ in range(5)]
    return max(float(np.abs(some - wanted).max()) for some in moved)


@pytest.mark.parametrize("machine", MACHINES)
def test_functions_and_tables_are_those_of_the_kernel(
    machine: str, build: Build, compiled: Machine, interpreted: Machines
) -> None:
    of = compiled(machine)
    assert len(of.forms) >= 26
    library = build(files_of(of))
    assert_same(library, interpreted(machine), of.forms)
    assert_batches(library, of.forms, interpreted(machine).values)
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


@settings(
    deadline=None, max_examples=8, suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow]
)
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
    if subprocess.run(trial, capture_output=True).returncode != 0:  # their runtime is a package of its own
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
