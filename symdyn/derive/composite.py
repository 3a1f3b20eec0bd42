"""The mass matrix of the arm by composite rigid bodies, every intermediate named (Walker and Orin 1982).

With all joints but one locked, the links beyond it move as one body: the effort at each joint when
joint j alone is accelerated by one is column j of M. Frames and pseudo-inertias are those of Newton-Euler.
"""

from __future__ import annotations

import sympy as sp

from symdyn.derive.grouping import group
from symdyn.derive.joint_frames import joint_frames, moved
from symdyn.derive.newton_euler import turns
from symdyn.derive.steps import Steps
from symdyn.spec.records import Robot

_AXES = "xyz1"


def mass_matrix(robot: Robot, steps: Steps) -> sp.Matrix:
    """(n, n) of the rigid arm, symmetric; the intermediates go to ``steps``."""
    chain = joint_frames(robot)
    names = [joint.name for joint in robot.joints]
    inertias = group(chain, names, steps)
    turn = turns(chain, names, steps)
    n = len(chain)
    matrix = sp.zeros(n, n)
    beyond = sp.zeros(4, 4)
    for j in range(n, 0, -1):
        frame, label = chain[j - 1], f"link {j} ({names[j - 1]})"
        body = _symmetric(f"C_{j}", inertias[j - 1] + beyond, f"{label}: composite body", steps)
        force, moment = _unit_acceleration(body, frame.prismatic)
        for i in range(j, 0, -1):
            here, law = chain[i - 1], f"link {i} ({names[i - 1]}): effort when joint {j} is accelerated"
            entry = force[2] if here.prismatic else moment[2]
            matrix[i - 1, j - 1] = matrix[j - 1, i - 1] = steps.name(f"M_{i}_{j}", entry, law)
            if i == 1:
                break
            turned = steps.vector(f"m_{i}_{j}_f", turn[i - 1] * force, law)
            force = here.twist * turned
            turned = steps.vector(f"m_{i}_{j}_n", turn[i - 1] * moment, law)
            moment = steps.vector(f"m_{i}_{j}_b", here.twist * turned + here.position.cross(force), law)
        turned = moved(body, turn[j - 1], sp.zeros(3, 1))
        turned = _symmetric(f"C_{j}t", turned, f"{label}: composite body, before its turn", steps)
        beyond = moved(turned, frame.twist, frame.position)
    return matrix


def _unit_acceleration(body: sp.Matrix, prismatic: bool) -> tuple[sp.Matrix, sp.Matrix]:
    """Force and moment about the frame's origin that accelerate a body by one along, or about, z."""
    second, first, mass = body[:3, :3], body[:3, 3], body[3, 3]
    if prismatic:
        return sp.Matrix([0, 0, mass]), sp.Matrix([first[1], -first[0], 0])
    spin = second[0, 0] + second[1, 1]
    return sp.Matrix([-first[1], first[0], 0]), sp.Matrix([-second[0, 2], -second[1, 2], spin])


def _symmetric(name: str, matrix: sp.Matrix, origin: str, steps: Steps) -> sp.Matrix:
    named = sp.zeros(4, 4)
    for r in range(4):
        for c in range(r, 4):
            named[r, c] = named[c, r] = steps.name(f"{name}_{_AXES[r]}{_AXES[c]}", matrix[r, c], origin)
    return named
