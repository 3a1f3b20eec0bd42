"""Numbers of many linear models of one machine, spread over processes or a cluster by the executor."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from symdyn import compiler
from symdyn.base.linear_system import Array, LinearFamily
from symdyn.numeric.executor import Executor, Task
from symdyn.numeric.linear.cost import Band
from symdyn.numeric.linear.scalars import Scalar, scalars
from symdyn.spec.records import Robot

CHUNK = 32  # models per task: whatever the number of workers, so that the tasks are the same


@dataclass(frozen=True, slots=True, eq=False)
class Spread:
    """The linear models of ``robot`` (without jumps) at the state ``x`` and input ``u``, and which numbers of them."""

    robot: Robot
    x: Array
    u: Array
    bands: tuple[Band, ...]
    input: str | None
    output: str | None
    executor: Executor

    def __call__(self, names: Sequence[str], points: Array, progress: Callable[[str], None]) -> Array:
        """(number of points, number of numbers) at each point, which holds values of the named parameters."""
        told = {
            "robot": compiler.robot_to_toml(self.robot),
            "x": self.x.tolist(),
            "u": self.u.tolist(),
            "bands": [[band.low, band.high] for band in self.bands],
            "input": self.input,
            "output": self.output,
            "names": list(names),
        }
        tasks = [told | {"points": points[i : i + CHUNK].tolist()} for i in range(0, len(points), CHUNK)]
        return np.concatenate(
            [np.array(rows) for rows in self.executor.map(evaluate, tasks, "lots of models", progress)]
        )


def evaluate(task: Task, seed: int) -> list[list[float]]:
    """One row of numbers per point; the same for every seed."""
    bands = tuple((float(low), float(high)) for low, high in task["bands"])
    family, numbers = _opened(task["robot"], tuple(task["x"]), tuple(task["u"]), bands, task["input"], task["output"])
    at = [family.index(name) for name in task["names"]]
    return [row_of(family, numbers, at, np.array(point)) for point in task["points"]]


def row_of(family: LinearFamily, numbers: Sequence[Scalar], at: Sequence[int], point: Array) -> list[float]:
    """The numbers of one model, whose parameters ``at`` these places have the values ``point``."""
    p = family.values.copy()
    p[list(at)] = point
    system = family.at(p)
    return [scalar.value(system) for scalar in numbers]


@lru_cache(maxsize=2)
def _opened(text: str, x: Any, u: Any, bands: Any, input: str | None, output: str | None) -> Any:
    """Derived once in each process."""
    family = compiler.linearise(compiler.robot_from_text(text, "model"), np.array(x), np.array(u))
    return family, scalars(family, tuple(Band(low, high) for low, high in bands), input, output)
