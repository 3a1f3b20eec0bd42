"""What one arm costs before it runs: operations; seconds of processor to derive and emit, to compile, to load."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from benchmarks.speed.arms import Arm
from benchmarks.speed.native import FUNCTIONS
from symdyn.compiler import Compiled, compile_robot
from symdyn.derive.equations import equations_of_motion
from symdyn.program.cost import Cost
from symdyn.program.functions import Function, fold_parameters
from symdyn.program.lower import lower
from symdyn.program.optimize import optimize
from symdyn.program.ssa import Argument

FIRST_USE = Path(__file__).with_name("first_use.py")


@dataclass(frozen=True)
class Costs:
    """Of one arm. Seconds (of processor) of a kernel are those of seven functions: four of one state, three batches."""

    operations: dict[str, Cost]
    derive: float
    compile: float
    load: float  # the module and seven first calls, compiled before, in a new process


def costs(arm: Arm) -> tuple[Compiled, Costs]:
    start = time.process_time()
    compiled = compile_robot(arm.robot)
    source = compiled.source
    derive = time.process_time() - start
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "kernel.py"
        path.write_text(source, encoding="utf-8")
        cold, warm = (sum(_first_use(path)) for _ in range(2))
    operations = {form.name: form.costs[-1].cost for form in compiled.forms if form.name in FUNCTIONS}
    return compiled, Costs(operations, derive, cold, warm)


def _first_use(path: Path) -> list[float]:
    # Python as it comes: where it may write no bytecode, it parses the module again in every process.
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    command = [sys.executable, str(FIRST_USE), str(path)]
    done = subprocess.run(command, capture_output=True, text=True, check=True, env=environment)
    seconds: list[float] = json.loads(done.stdout)
    return seconds


def inverse_dynamics_cost(arm: Arm) -> Cost:
    """Operations of inverse dynamics alone, numbers folded in."""
    equations = equations_of_motion(arm.robot)
    steps, efforts = equations.required()
    rows: Sequence[Argument] = [
        Argument(name, tuple(str(getattr(axis, name)) for axis in equations.axes)) for name in ("q", "qd", "qdd")
    ]
    p = Argument("p", tuple(str(p) for p in equations.parameters))
    program = lower("inverse_dynamics", (*rows, p), steps, efforts, (len(efforts),))
    folded = fold_parameters(Function(program, ""), [v.value for v in arm.robot.parameters if v.value is not None])
    return optimize(folded.program).costs[-1].cost
