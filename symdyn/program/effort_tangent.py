"""Inverse dynamics to first order: its derivatives, the arm's as derived and those of effects by forward mode.

What does not depend on accelerations comes along, so that forward dynamics follows from it: the arm's bias force is
half its derivative with respect to speeds, times the speeds, and gravity, where Newton-Euler would begin anew.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import sympy as sp

from symdyn.derive.effort_jacobian import effort_jacobian
from symdyn.derive.equations import EquationsOfMotion
from symdyn.derive.steps import Step
from symdyn.program.builder import Builder
from symdyn.program.compose import inline
from symdyn.program.differentiate import differentiate
from symdyn.program.folding import fold
from symdyn.program.lower import lower
from symdyn.program.smooth import smooth
from symdyn.program.ssa import Argument, Op, Program
from symdyn.program.substitute import bind

_SUM = "effort of the arm and of effects"


def effort_tangent(equations: EquationsOfMotion, smoothing: float | Mapping[str, float] | None = None) -> Program:
    """Of (q, qd, qdd, p), an array (n, 3 n + 1): derivatives with respect to q, qd and qdd, then the bias force.

    The last n + 1 columns do not depend on qdd. ``smoothing``: over which width jumps are
    smoothed before anything is differentiated; with one for each speed those of friction alone.
    """
    axes = equations.axes
    n, place = len(axes), {axis.address: k for k, axis in enumerate(axes)}
    q, qd, qdd = (Argument(name, tuple(str(getattr(a, name)) for a in axes)) for name in ("q", "qd", "qdd"))
    arguments = (q, qd, qdd, Argument("p", tuple(str(symbol) for symbol in equations.parameters)))
    at = [place[joint.name] for joint in equations.robot.joints]

    def lowered(steps: Sequence[Step], outputs: sp.Matrix) -> Program:
        program = lower("effort_tangent", arguments, steps, list(outputs), outputs.shape)
        return program if smoothing is None else smooth(program, smoothing)

    derived = effort_jacobian(equations.robot)
    blocks = sp.zeros(n, 3 * n + 1)
    for i, row in enumerate(at):
        for block, matrix in enumerate((derived.by_position, derived.by_speed, derived.by_acceleration)):
            for j, column in enumerate(at):
                blocks[row, block * n + column] = matrix[i, j]
        blocks[row, 3 * n] = derived.gravity[i] + sum(
            derived.by_speed[i, j] * (axes[column].qd / 2) for j, column in enumerate(at)
        )
    steps, efforts = equations.of_effects()
    effects = lowered(steps, sp.Matrix(efforts))
    still = bind(effects, dict.fromkeys(qdd.symbols, 0.0))
    builder = Builder()
    arm = inline(builder, lowered(derived.steps, blocks))
    added = inline(builder, differentiate(effects, (*q.symbols, *qd.symbols, *qdd.symbols), "effects"))
    bias = inline(builder, still)
    entries = []
    for i in range(n):
        own = (*added[3 * n * i : 3 * n * (i + 1)], bias[i])
        pairs = zip(arm[(3 * n + 1) * i : (3 * n + 1) * (i + 1)], own, strict=True)
        entries += [fold(builder, Op.ADD, pair, _SUM) for pair in pairs]
    return builder.program("effort_tangent", arguments, entries, (n, 3 * n + 1))
