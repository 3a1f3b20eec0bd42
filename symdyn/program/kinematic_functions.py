"""The functions of the arm's geometry and of its Coriolis matrix, each derived for itself."""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp

from symdyn.base import symbols
from symdyn.derive.center_of_mass import center_of_mass
from symdyn.derive.chain_poses import chain_poses
from symdyn.derive.coriolis import coriolis_matrix
from symdyn.derive.equations import EquationsOfMotion
from symdyn.derive.jacobian import jacobian, jacobian_rate
from symdyn.derive.steps import Steps
from symdyn.derive.wrench_effort import wrench_effort
from symdyn.program.function import Function
from symdyn.program.lower import lower
from symdyn.program.ssa import Argument, Program

WRENCH = Argument("wrench", tuple(str(symbols.wrench(k)) for k in range(1, 7)))
_AXES = "in the axes of the world frame"


def kinematic_functions(equations: EquationsOfMotion) -> tuple[Function, ...]:
    """Arguments have an entry for every coordinate, rotors included; matrices are zero there."""
    robot, axes = equations.robot, equations.axes
    q, qd = Argument("q", tuple(str(a.q) for a in axes)), Argument("qd", tuple(str(a.qd) for a in axes))
    p = Argument("p", tuple(str(symbol) for symbol in equations.parameters))
    place = {axis.address: k for k, axis in enumerate(axes)}
    at = [place[joint.name] for joint in robot.joints]

    def program(
        name: str, arguments: Sequence[Argument], steps: Steps, outputs: sp.Matrix, flat: bool = False
    ) -> Program:
        shape = (len(outputs),) if flat else outputs.shape
        return lower(name, (*arguments, p), steps.freeze(), list(outputs), shape)

    def spread(matrix: sp.Matrix, rows: Sequence[int], columns: Sequence[int], shape: tuple[int, int]) -> sp.Matrix:
        found = sp.zeros(*shape)
        for i, row in enumerate(rows):
            for j, column in enumerate(columns):
                found[row, column] = matrix[i, j]
        return found

    n = len(axes)
    found = []
    steps = Steps()
    pose = chain_poses(robot, steps).tool
    doc = "Pose (4, 4) of the tool's frame in the world; of the last link's where there is no tool."
    found.append(Function(program("forward_kinematics", (q,), steps, pose), doc))
    steps = Steps()
    columns = spread(jacobian(robot, steps), range(6), at, (6, n))
    doc = f"Geometric Jacobian (6, n) of the tool's frame {_AXES}: linear rows first, then angular ones."
    found.append(Function(program("jacobian", (q,), steps, columns), doc))
    steps = Steps()
    columns = spread(jacobian_rate(robot, steps), range(6), at, (6, n))
    found.append(Function(program("jacobian_rate", (q, qd), steps, columns), "d jacobian / dt, (6, n)."))
    steps = Steps()
    center = center_of_mass(robot, steps)
    if center is not None:
        doc = "Centre of mass (3,) of links and tool in the world."
        found.append(Function(program("center_of_mass", (q,), steps, center, flat=True), doc))
    steps = Steps()
    matrix = spread(coriolis_matrix(robot, steps), at, at, (n, n))
    doc = "C (n, n): C qd are the Coriolis and centripetal efforts, and dM/dt - 2 C is skew."
    found.append(Function(program("coriolis_matrix", (q, qd), steps, matrix), doc))
    steps = Steps()
    efforts = spread(sp.Matrix(wrench_effort(robot, steps)), at, [0], (n, 1))
    doc = (
        f"Effort (n,) that a wrench on the tool exerts: force (3,) and moment (3,) at its frame's origin, {_AXES}. "
        "Take it from inverse dynamics, or add it to tau."
    )
    found.append(Function(program("wrench_effort", (q, WRENCH), steps, efforts, flat=True), doc))
    return tuple(found)
