"""Poses of the joint frames in the world frame, from the base outwards, every intermediate named."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import sympy as sp

from symdyn.derive.joint_frames import JointFrame, joint_frames, tool_pose
from symdyn.derive.kinematics import fixed
from symdyn.derive.newton_euler import turns
from symdyn.derive.steps import Steps
from symdyn.spec.records import Robot


@dataclass(frozen=True, slots=True)
class ChainPoses:
    """In the world frame: ``origins`` (3,) of the joint frames and ``axes`` (3,) of the joints, base first;
    ``position`` (3,) and ``rotation`` (3, 3) of the tool's frame (the last link's where there is no tool)."""

    frames: Sequence[JointFrame]
    origins: Sequence[sp.Matrix]
    axes: Sequence[sp.Matrix]
    position: sp.Matrix
    rotation: sp.Matrix

    @property
    def tool(self) -> sp.Matrix:
        """The tool's frame in the world frame, 4 x 4."""
        return self.rotation.row_join(self.position).col_join(sp.Matrix([[0, 0, 0, 1]]))


def chain_poses(robot: Robot, steps: Steps) -> ChainPoses:
    """The poses of one robot; the intermediates go to ``steps``."""
    frames, names = joint_frames(robot), [joint.name for joint in robot.joints]
    position, rotation = fixed(robot.base)
    origins, axes = [], []
    for i, (frame, turn, name) in enumerate(zip(frames, turns(frames, names, steps), names, strict=True), start=1):
        law = f"link {i} ({name})"
        position = steps.vector(f"x_{i}", position + rotation * frame.position, f"{law}: origin of its joint")
        twisted = steps.matrix(f"R_{i}t", rotation * frame.twist, f"{law}: orientation, before its turn")
        rotation = steps.matrix(f"R_{i}", twisted * turn, f"{law}: orientation")
        origins.append(position)
        axes.append(twisted[:, 2])
    tool = tool_pose(robot)
    position = steps.vector("x_tool", position + rotation * tool.position, "tool: position")
    rotation = steps.matrix("R_tool", rotation * tool.rotation, "tool: orientation")
    return ChainPoses(frames, origins, axes, position, rotation)
