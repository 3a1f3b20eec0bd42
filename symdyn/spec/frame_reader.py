"""Reads the geometry of the chain: one DH table for all joints, or a placement at each."""

from __future__ import annotations

from symdyn.base.wording import quoted
from symdyn.spec.dh_reader import read_dh
from symdyn.spec.frames import JointFrame
from symdyn.spec.numbers import NumberReader
from symdyn.spec.placement_reader import read_placement
from symdyn.spec.records import Convention, JointKind
from symdyn.spec.schema import JointTable, RobotFile


def read_frames(shape: RobotFile, joint_names: tuple[str, ...], numbers: NumberReader) -> tuple[JointFrame, ...] | None:
    """One frame per joint; None where the kind of a joint cannot be told (SD105, SD107)."""
    if shape.dh is not None:
        for i, joint in enumerate(shape.joint):
            _refuse_second_geometry(joint, i, numbers)
        return read_dh(shape.dh, joint_names, numbers)
    return _read_placements(shape.joint, joint_names, numbers)


def convention_of(shape: RobotFile) -> Convention:
    """Frames of placed joints sit at the near ends, as those of the modified convention do."""
    return Convention(shape.dh.convention) if shape.dh is not None else Convention.MODIFIED


def _refuse_second_geometry(joint: JointTable, i: int, numbers: NumberReader) -> None:
    for key in ("placement", "kind"):
        if getattr(joint, key) is not None:
            numbers.findings.error(
                ("joint", i, key),
                "SD105",
                f"the DH table tells the {key} of {quoted(joint.name)} already",
                f"remove {quoted(key)} here, or [dh] and give every joint a placement",
                key=True,
            )


def _read_placements(
    joints: list[JointTable], names: tuple[str, ...], numbers: NumberReader
) -> tuple[JointFrame, ...] | None:
    frames = []
    for i, (joint, name) in enumerate(zip(joints, names, strict=True)):
        if joint.placement is None:
            numbers.findings.error(
                ("joint", i),
                "SD107",
                f"the file has no `dh`, and joint {quoted(joint.name)} no `placement`",
                'a [dh] table with a row per joint, or: placement = { xyz = [0, 0, 0.3], rpy = ["90 deg", 0, 0] }',
            )
            return None
        placement = read_placement(joint.placement, ("joint", i, "placement"), name, numbers)
        frames.append(JointFrame(JointKind(joint.kind or "revolute"), placement))
    return tuple(frames)
