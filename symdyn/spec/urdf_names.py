"""Names of a URDF as names that symdyn allows: a joint's, a robot's."""

from __future__ import annotations

import re

from symdyn.base.names import identifier_problem


def joint_identifier(name: str) -> str:
    """``"arm-joint 1"`` is ``"arm_joint_1"``, ``"1st"`` is ``"joint_1st"``, ``"lambda"`` is ``"lambda_"``."""
    words = re.sub(r"[^A-Za-z0-9]+", "_", name).strip("_")
    if not words or not words[0].isalpha():
        words = f"joint_{words}".rstrip("_")
    problem = identifier_problem(words)
    return f"{words}_" if problem is not None and problem.code == "SD102" else words


def robot_identifier(name: str) -> str:
    """``"UR5 (e)"`` is ``"ur5-e"``; ``"robot"`` where nothing is left."""
    words = "-".join(re.findall(r"[a-z0-9]+", name.lower()))[:64].strip("-")
    if not words:
        return "robot"
    return words if words[0].isalpha() else f"robot-{words}"[:64].strip("-")


def shown(name: str) -> str:
    """A name of the file for a description, which is one printable line."""
    return "".join(character if character.isprintable() else "?" for character in name)
