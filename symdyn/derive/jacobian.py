"""The geometric Jacobian of the tool's frame and its time derivative, in the axes of the world frame.

Rows 1 to 3 are the velocity of the frame's origin, rows 4 to 6 its angular velocity (Pinocchio's LOCAL_WORLD_ALIGNED).
"""

from __future__ import annotations

import sympy as sp

from symdyn.derive.chain_poses import ChainPoses, chain_poses
from symdyn.derive.steps import Steps
from symdyn.spec.records import Robot


def jacobian(robot: Robot, steps: Steps) -> sp.Matrix:
    """(6, number of joints); the intermediates go to ``steps``."""
    return _columns(chain_poses(robot, steps), steps)


def _columns(poses: ChainPoses, steps: Steps) -> sp.Matrix:
    found = []
    for i, (frame, origin, axis) in enumerate(zip(poses.frames, poses.origins, poses.axes, strict=True), start=1):
        if frame.prismatic:
            found.append(axis.col_join(sp.zeros(3, 1)))
            continue
        arm = steps.vector(f"r_{i}", poses.position - origin, f"joint {i}: lever arm of the tool")
        linear = steps.vector(f"j_{i}", axis.cross(arm), f"joint {i}: velocity of the tool for unit speed")
        found.append(linear.col_join(axis))
    return sp.Matrix.hstack(*found)


def jacobian_rate(robot: Robot, steps: Steps) -> sp.Matrix:
    """(6, number of joints): d jacobian / dt at the joint velocities; the intermediates go to ``steps``.

    A column j = z x r turns with the links before the joint, and changes with u, the velocity that this joint and
    those beyond it give the tool: dj/dt = omega x j + z x u.
    """
    poses = chain_poses(robot, steps)
    columns = _columns(poses, steps)
    speeds = [frame.coordinate.qd for frame in poses.frames]
    n = len(speeds)
    given = [sp.zeros(3, 1)] * (n + 1)
    for i in range(n, 0, -1):
        law = f"joint {i}: velocity of the tool from here on"
        given[i - 1] = steps.vector(f"u_{i}", given[i] + columns[:3, i - 1] * speeds[i - 1], law)
    omega, found = sp.zeros(3, 1), []
    for i, (frame, axis) in enumerate(zip(poses.frames, poses.axes, strict=True), start=1):
        turning = steps.vector(f"zd_{i}", omega.cross(axis), f"joint {i}: rate of its axis")
        if frame.prismatic:
            found.append(turning.col_join(sp.zeros(3, 1)))
            continue
        linear = omega.cross(columns[:3, i - 1]) + axis.cross(given[i - 1])
        found.append(linear.col_join(turning))
        omega = steps.vector(f"omega_{i}", omega + axis * speeds[i - 1], f"link {i}: angular velocity")
    return sp.Matrix.hstack(*found)
