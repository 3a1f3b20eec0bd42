"""The centre of mass of the whole arm in the world frame, from the tip inwards, every intermediate named."""

from __future__ import annotations

import sympy as sp

from symdyn.derive.joint_frames import joint_frames
from symdyn.derive.kinematics import fixed
from symdyn.derive.newton_euler import turns
from symdyn.derive.steps import Steps
from symdyn.spec.records import Robot


def center_of_mass(robot: Robot, steps: Steps) -> sp.Matrix | None:
    """(3,) of links and tool, without rotors; the intermediates go to ``steps``. None for an arm without mass."""
    frames, names = joint_frames(robot), [joint.name for joint in robot.joints]
    turned = turns(frames, names, steps)
    mass, moment = sp.Integer(0), sp.zeros(3, 1)  # of all links from here on, in this frame
    for i in range(len(frames), 0, -1):
        frame, law = frames[i - 1], f"link {i} ({names[i - 1]}): all from here on"
        own = frame.pseudo_inertia
        mass = steps.name(f"m_{i}", mass + own[3, 3], f"{law}: mass")
        moment = steps.vector(f"h_{i}", moment + own[:3, 3], f"{law}: first moment")
        moment = steps.vector(f"h_{i}t", turned[i - 1] * moment, f"{law}: first moment, before its turn")
        moment = frame.twist * moment + frame.position * mass
        moment = steps.vector(f"h_{i}b", moment, f"{law}: first moment, in frame {i - 1}")
    if mass == 0:
        return None
    position, rotation = fixed(robot.base)
    return position + rotation * moment / mass
