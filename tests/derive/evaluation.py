"""Numbers of a derivation, in many digits, through the reference evaluator."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
import sympy as sp
from mpmath import mpf

from symdyn.derive.coordinates import Coordinate
from symdyn.derive.equations import EquationsOfMotion
from symdyn.derive.steps import Step
from symdyn.program.evaluate import evaluate
from symdyn.program.lower import lower
from symdyn.program.ssa import Argument

State = Mapping[str, Sequence[float | mpf]]  # "q", "qd", "qdd" -> (n,)
DIGITS = 40


def function(
    axes: Sequence[Coordinate], steps: Sequence[Step], outputs: Sequence[sp.Expr]
) -> Callable[[State], list[mpf]]:
    """The outputs as a function of q, qd, qdd."""
    arguments = (
        Argument("q", tuple(str(c.q) for c in axes)),
        Argument("qd", tuple(str(c.qd) for c in axes)),
        Argument("qdd", tuple(str(c.qdd) for c in axes)),
    )
    program = lower("f", arguments, steps, outputs, (len(outputs),))
    return lambda state: evaluate(program, dict(state), dps=DIGITS)


def inverse_dynamics(equations: EquationsOfMotion) -> Callable[[State], np.ndarray]:
    """(n,) efforts that the motion needs, for a robot without free parameters."""
    compute = function(equations.axes, *equations.required())
    return lambda state: np.array(compute(state), dtype=float)


def energy(equations: EquationsOfMotion) -> Callable[[State], tuple[mpf, mpf]]:
    """(kinetic, potential)."""
    compute = function(equations.axes, equations.energy_steps, (equations.kinetic, equations.potential))

    def at(state: State) -> tuple[mpf, mpf]:
        kinetic, potential = compute(state)
        return kinetic, potential

    return at


def mass_matrix(equations: EquationsOfMotion, q: Sequence[float]) -> np.ndarray:
    """(n, n), column by column: efforts for unit accelerations at rest, less those for none."""
    compute = inverse_dynamics(equations)
    n = len(q)
    rest = [0.0] * n
    still = compute({"q": q, "qd": rest, "qdd": rest})
    unit = np.eye(n)
    return np.column_stack([compute({"q": q, "qd": rest, "qdd": list(unit[j])}) - still for j in range(n)])


def close(first: Sequence[float] | np.ndarray, second: Sequence[float] | np.ndarray, tolerance: float) -> bool:
    """Whether two arrays differ by less than ``tolerance`` of the larger one's size (or of 1, if that is smaller)."""
    a, b = np.asarray(first, dtype=float), np.asarray(second, dtype=float)
    size = max(1.0, float(np.max(np.abs(a))), float(np.max(np.abs(b))))
    return a.shape == b.shape and bool(np.max(np.abs(a - b)) <= tolerance * size)
