"""What simpler models of the arm cost and save: without Coriolis terms, with diagonal inertia, gravity alone.

All are of the rigid arm; drives, friction and other effects would add the same to each.
"""

from __future__ import annotations

import math
import random
from collections.abc import Sequence
from dataclasses import dataclass

from symdyn.derive.coordinates import Coordinate
from symdyn.derive.equations import EquationsOfMotion
from symdyn.program.builder import Builder
from symdyn.program.compose import inline
from symdyn.program.cost import Cost, count, weight
from symdyn.program.evaluate import evaluate
from symdyn.program.folding import fold
from symdyn.program.function import Function
from symdyn.program.lower import lower
from symdyn.program.optimize import optimize
from symdyn.program.ssa import Argument, Op, Program
from symdyn.program.substitute import bind
from symdyn.spec.records import Joint

_DIGITS = 17
_RISE = 0.25  # seconds in which a joint reaches its top speed: it sets the accelerations


@dataclass(frozen=True, slots=True)
class VariantRow:
    """``error`` (joints,) is the root mean square over random states of what the variant misses, relative to that of
    the full model's effort; nan where the latter is zero. ``weight`` is the time in units of one addition."""

    name: str
    doc: str
    cost: Cost
    weight: int
    error: tuple[float, ...]


def variants(equations: EquationsOfMotion) -> tuple[Function, ...]:
    """Inverse dynamics of the arm in full, then in its simpler forms; parameters not yet folded in."""
    axes = equations.axes
    q, qd, qdd = (Argument(name, tuple(str(getattr(a, name)) for a in axes)) for name in ("q", "qd", "qdd"))
    p = Argument("p", tuple(str(symbol) for symbol in equations.parameters))
    arguments, n = (q, qd, qdd, p), len(axes)
    full = lower("full", arguments, equations.steps, equations.arm, (n,))
    still = bind(full, dict.fromkeys(qd.symbols, 0.0), "no_coriolis")
    gravity = bind(still, dict.fromkeys(qdd.symbols, 0.0), "gravity")
    diagonal = lower("diagonal", arguments, equations.mass_steps, [equations.arm_mass[i, i] for i in range(n)], (n,))
    builder = Builder()
    entries = zip(inline(builder, diagonal), inline(builder, gravity), qdd.symbols, strict=True)
    outputs = []
    for inertia, weight_of, symbol in entries:
        own = fold(builder, Op.MUL, (inertia, builder.input(symbol)), "effective inertia")
        outputs.append(fold(builder, Op.ADD, (own, weight_of), "effective inertia and gravity"))
    decoupled = builder.program("diagonal_inertia", arguments, outputs, (n,))
    return (
        Function(full, "all terms"),
        Function(still, "without Coriolis and centripetal terms"),
        Function(decoupled, "diagonal of the mass matrix, and gravity"),
        Function(gravity, "gravity alone"),
    )


def variant_table(
    equations: EquationsOfMotion, states: int = 100, speed: float = 1.0, seed: int = 0
) -> tuple[VariantRow, ...]:
    """A row per variant. States are drawn evenly: positions within the joint's limits (else a half turn or 0.5 m to
    either side), speeds to ``speed`` times its speed limit (else 1 rad/s or m/s), accelerations to four times that
    per second. The same seed draws the same states.

    Raises ValueError if a parameter is left free.
    """
    values = [p.value for p in equations.robot.parameters]
    numbers = [v for v in values if v is not None and math.isfinite(v)]
    if len(numbers) < len(values):
        raise ValueError("a parameter is left free")
    drawn = _states(equations, states, speed, random.Random(seed))
    at = [k for k, axis in enumerate(equations.axes) if axis.address in {j.name for j in equations.robot.joints}]
    rows: list[VariantRow] = []
    full: list[list[float]] = []
    for function in variants(equations):
        given = dict(zip(function.program.arguments[-1].symbols, numbers, strict=True))
        program = optimize(bind(function.program, given, drop=("p",))).program
        efforts = [_efforts(program, state, at) for state in drawn]
        full = full or efforts
        error = tuple(_relative(efforts, full, k) for k in range(len(at)))
        rows.append(VariantRow(function.name, function.doc, count(program), weight(program), error))
    return tuple(rows)


def _efforts(program: Program, state: dict[str, list[float]], at: Sequence[int]) -> list[float]:
    found = evaluate(program, state, _DIGITS)
    return [float(found[k]) for k in at]


def _relative(efforts: list[list[float]], full: list[list[float]], k: int) -> float:
    size = math.hypot(*(row[k] for row in full))
    missed = math.hypot(*(a[k] - b[k] for a, b in zip(efforts, full, strict=True)))
    return missed / size if size else math.nan


def _states(
    equations: EquationsOfMotion, number: int, speed: float, draw: random.Random
) -> list[dict[str, list[float]]]:
    joints = {joint.name: joint for joint in equations.robot.joints}
    found = []
    for _ in range(number):
        rows = [_drawn(joints.get(axis.address), axis, speed, draw) for axis in equations.axes]
        found.append({name: [row[k] for row in rows] for k, name in enumerate(("q", "qd", "qdd"))})
    return found


def _drawn(joint: Joint | None, axis: Coordinate, speed: float, draw: random.Random) -> tuple[float, float, float]:
    """Position, speed and acceleration of one coordinate; rotors rest, since the arm's efforts do not know them."""
    if joint is None:
        return 0.0, 0.0, 0.0
    reach = math.pi if axis.rotational else 0.5
    limits = joint.limits
    lower = -reach if limits is None or limits.lower is None else limits.lower
    upper = reach if limits is None or limits.upper is None else limits.upper
    top = speed * (1.0 if limits is None or limits.velocity is None else limits.velocity)
    return draw.uniform(lower, upper), draw.uniform(-top, top), draw.uniform(-top, top) / _RISE
