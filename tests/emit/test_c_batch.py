"""Batches in C99: those of Numba, by vector instructions; waves without libm. Each state by itself: test_c.py."""

from __future__ import annotations

import math
import platform
import subprocess
from pathlib import Path

import numpy as np
import pytest

from symdyn.emit.c_functions import BLOCKS, STACK, block_of
from symdyn.program.builder import Builder
from symdyn.program.ssa import Argument, Op, Program
from tests.emit.c_batches import assert_close, both, states_of
from tests.emit.c_library import STRICT, Build, Library, Machine, Machines, files_of, of_programs, run
from tests.emit.test_vectorised import ARITHMETIC


@pytest.mark.parametrize("name", ["inverse_dynamics", "mass_matrix_p", "state_derivative_state_jacobian"])
def test_batches_are_those_of_the_numba_kernel(
    name: str, build: Build, compiled: Machine, interpreted: Machines
) -> None:
    of, kernel = compiled("irb6-arm-rod"), interpreted("irb6-arm-rod")
    form = next(f for f in of.forms if f.name == name)
    library = build(files_of(of, [form]))
    arguments = states_of(form.program, kernel.values, 40)
    wanted = np.asarray(getattr(kernel, f"{name}_batch")(*arguments)).reshape(40, -1)
    for found in both(library, form, arguments, 40):
        assert_close(found, wanted, name)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["inverse_dynamics", "forward_dynamics", "forward_dynamics_state_jacobian"])
@pytest.mark.parametrize("machine", ["puma560", "panda"])
def test_batches_of_large_arms_are_those_that_numba_compiles(
    machine: str, name: str, build: Build, compiled: Machine
) -> None:
    of = compiled(machine)
    form, kernel = next(f for f in of.forms if f.name == name), of.kernel()
    library = build(files_of(of, [form]))
    arguments = states_of(form.program, kernel.values, 1000)
    wanted = np.asarray(getattr(kernel, f"{name}_batch")(*arguments)).reshape(1000, -1)
    for found in both(library, form, arguments, 1000):
        assert_close(found, wanted, name)


def test_blocks_stay_small_enough_for_a_stack() -> None:
    def program(size: int) -> Program:
        builder = Builder()
        line = builder.input("x_1")
        return builder.program("f", (Argument("x", ("x_1",)),), (line,) * size, (size,))

    sizes = {count: block_of(program(count)) for count in (1, 255, 256, 1000, 5000, 100_000)}
    assert list(sizes.values()) == [32, 32, 16, 8, 1, 1]
    assert BLOCKS[0] * 8 * 256 == STACK


@pytest.mark.skipif(platform.machine() not in ("x86_64", "AMD64"), reason="reads the assembly of x86-64")
@pytest.mark.parametrize("level", ["-O2", "-O3"])
def test_blocks_are_computed_with_vector_instructions(
    level: str, compiler: str, tmp_path: Path, compiled: Machine
) -> None:
    """Of the processor that compilers aim at without being told: SSE2 alone."""
    of, name = compiled("irb6-arm"), "inverse_dynamics"
    form = next(f for f in of.forms if f.name == name)
    for file, text in files_of(of, [form]).items():
        (tmp_path / file).write_text(text, encoding="utf-8")
    run(compiler, *STRICT, level, "-S", tmp_path / "irb6_arm.c", "-o", tmp_path / "irb6_arm.s")
    assembly = (tmp_path / "irb6_arm.s").read_text()
    kinds = ARITHMETIC.findall(assembly.partition(f"\nirb6_arm_{name}_block:")[2].partition(".cfi_endproc")[0])
    cost = form.costs[-1].cost
    assert kinds.count("pd") >= cost.multiplications + cost.additions
    assert kinds.count("sd") == 0


def waves() -> Program:
    builder = Builder()
    angle = builder.input("x_1")
    outputs = [builder.intern(op, (angle,)) for op in (Op.SIN, Op.COS)]
    return builder.program("waves", (Argument("x", ("x_1",)),), outputs, (2,))


ANGLES = np.concatenate(
    [
        np.random.default_rng(1).uniform(-1e6, 1e6, 2000),
        np.random.default_rng(2).uniform(-4, 4, 2000),
        np.arange(-200, 201) * (math.pi / 2),
    ]
)


@pytest.mark.parametrize(
    ("flags", "tolerance"),
    [((), 2.3e-16), (("-ffast-math",), 1e-15), (("-mfpmath=387",), 2.3e-16)],
    ids=["plain", "fast-math", "more digits"],
)
def test_waves_are_exact_also_where_sums_are_reordered(
    flags: tuple[str, ...], tolerance: float, compiler: str, tmp_path: Path
) -> None:
    if flags == ("-mfpmath=387",) and not has_387(compiler, tmp_path):
        pytest.skip(f"{compiler} has no unit of more digits here")  # x87 is of x86 alone, and clang may lack it
    library = Library(tmp_path, of_programs(waves()), compiler, flags)
    rows = library.many("f_0_batch", ANGLES.size, [ANGLES], (ANGLES.size, 2))
    wanted = [(math.sin(x), math.cos(x)) for x in ANGLES.tolist()]
    assert np.abs(rows - wanted).max() < tolerance + 0.6 * np.finfo(float).eps  # libm is not exact either


def has_387(compiler: str, folder: Path) -> bool:
    trial = folder / "trial"
    trial.mkdir()
    (trial / "trial.c").write_text("int nothing;\n")
    command = [compiler, "-Werror", "-mfpmath=387", "-c", trial / "trial.c", "-o", trial / "trial.o"]
    return subprocess.run(command, capture_output=True).returncode == 0


@pytest.mark.parametrize("x", [math.nan, math.inf, -math.inf, 1e15, -1e15, 1e300])
def test_no_angle_gives_no_number(x: float, build: Build) -> None:
    assert np.isnan(build(of_programs(waves()))("f_0", [np.array([x])], (2,))).all()


def test_the_largest_angle_still_gives_one(build: Build) -> None:
    found = build(of_programs(waves()))("f_0", [np.array([0.999e15])], (2,))
    np.testing.assert_allclose(found, [math.sin(0.999e15), math.cos(0.999e15)], atol=math.ulp(1e15))
