"""What a wrench on the tool exerts along the joints, J^T w, without the Jacobian.

The wrench goes outwards into every joint frame, the place of the tool inwards: the moment about joint i is then
n + (r x f)_z, which is cheaper than the columns of J.
"""

from __future__ import annotations

import sympy as sp

from symdyn.base import symbols
from symdyn.derive.joint_frames import joint_frames, tool_pose
from symdyn.derive.kinematics import fixed
from symdyn.derive.newton_euler import turns
from symdyn.derive.steps import Steps
from symdyn.spec.records import Robot


def wrench_effort(robot: Robot, steps: Steps) -> tuple[sp.Expr, ...]:
    """One per joint; the intermediates go to ``steps``.

    The wrench is that of ``symbols.wrench``: force at the origin of the tool's frame (of the last link's where there
    is no tool), then moment about it, both in the axes of the world frame.
    """
    frames, names = joint_frames(robot), [joint.name for joint in robot.joints]
    turned, (_, base) = turns(frames, names, steps), fixed(robot.base)
    force, moment = (sp.Matrix([symbols.wrench(k) for k in rows]) for rows in ((1, 2, 3), (4, 5, 6)))
    force = steps.vector("f_0", base.T * force, "base: force on the tool")
    moment = steps.vector("n_0", base.T * moment, "base: moment on the tool")
    forces, along = [], []
    for i, (frame, turn, name) in enumerate(zip(frames, turned, names, strict=True), start=1):
        law = f"link {i} ({name})"
        force = steps.vector(f"f_{i}t", frame.twist.T * force, f"{law}: force on the tool, before its turn")
        moment = steps.vector(f"n_{i}t", frame.twist.T * moment, f"{law}: moment on the tool, before its turn")
        forces.append(force)
        along.append(moment[2])
        force = steps.vector(f"f_{i}", turn.T * force, f"{law}: force on the tool")
        moment = steps.vector(f"n_{i}", turn.T * moment, f"{law}: moment on the tool")
    place, efforts = tool_pose(robot).position, list[sp.Expr]()
    for i in range(len(frames), 0, -1):
        frame, force, law = frames[i - 1], forces[i - 1], f"link {i} ({names[i - 1]}): place of the tool"
        place = steps.vector(f"r_{i}t", turned[i - 1] * place, f"{law}, before its turn")
        efforts.append(force[2] if frame.prismatic else along[i - 1] + place[0] * force[1] - place[1] * force[0])
        place = steps.vector(f"r_{i}", frame.position + frame.twist * place, f"{law} in frame {i - 1}")
    return tuple(reversed(efforts))
