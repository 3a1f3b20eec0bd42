"""Base inertial parameters by rules: what a link cannot show by its own motion is handed to the link before it.

Mass on the axis of a revolute joint does not move when the joint turns: its share of the pseudo-inertia
(mass, first and second moment along z) may as well belong to the previous link. The second moments of a
link on a prismatic joint never turn against the previous link, and belong to it too. These are the rules
of Gautier and Khalil (1990) and Khalil and Kleinfinger (1987), in terms of the pseudo-inertia, in which
both are one line each. Where all axes so far are parallel, and the joint slides along them (the quill of a SCARA), the
first moments across the axis stay at their distance from it, and belong to the previous link as well. The equations of
motion are the same, with fewer numbers in them.
"""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp

from symdyn.derive.joint_frames import JointFrame, moved
from symdyn.derive.steps import Steps

ENTRIES = [(r, c) for r in range(4) for c in range(r, 4)]
_AXES = "xyz1"


def group(frames: Sequence[JointFrame], names: Sequence[str], steps: Steps) -> tuple[sp.Matrix, ...]:
    """Pseudo-inertias (4, 4) of the links after grouping, from the last link inwards; entries go to ``steps``."""
    found = []
    handed = sp.zeros(4, 4)
    parallel = parallel_axes(frames)
    for i in range(len(frames), 0, -1):
        frame = frames[i - 1]
        own = _named(frame.pseudo_inertia + handed, i, f"link {i} ({names[i - 1]}): base parameters", steps)
        share = _share(own, frame.prismatic)
        position = sp.zeros(3, 1) if frame.prismatic else frame.position  # second moments know no place
        handed = moved(share, frame.twist * _turn(frame), position)
        if frame.prismatic and parallel[i - 1]:
            across = _first_moments_across(own)
            distance = frame.position - frame.axis * frame.axis.dot(frame.position)
            handed += moved(across, frame.twist * _turn(frame), distance.applyfunc(sp.expand))
            # What a turn about one direction cannot show: the moments along it.
            share = share + across + _along(own)
        found.append(own - share)
    return tuple(reversed(found))


def parallel_axes(frames: Sequence[JointFrame]) -> list[bool]:
    """Per link: whether it turns, about the direction of its joint's axis alone, whatever the joints do."""
    found = []
    along: sp.Matrix | None = None  # the axis of the revolute joints so far, in the frame that was reached
    parallel = True
    for frame in frames:
        if along is None:
            parallel_here = not frame.prismatic
        else:
            along = frame.twist.T * along
            parallel_here = parallel and all(sp.simplify(entry) == 0 for entry in along[:2])
        found.append(parallel_here)
        if frame.prismatic:
            along = None if along is None else _turn(frame).T * along
        else:
            along, parallel = sp.Matrix([0, 0, 1]), parallel_here
    return found


def _first_moments_across(inertia: sp.Matrix) -> sp.Matrix:
    moments = sp.zeros(4, 4)
    for r in (0, 1):
        moments[r, 3] = moments[3, r] = inertia[r, 3]
    return moments


def _along(inertia: sp.Matrix) -> sp.Matrix:
    moments = sp.zeros(4, 4)
    moments[2, 3] = moments[3, 2] = inertia[2, 3]
    return moments


def _share(inertia: sp.Matrix, prismatic: bool) -> sp.Matrix:
    kept = sp.zeros(4, 4)
    rows = (0, 1, 2) if prismatic else (2, 3)
    for r in rows:
        for c in rows:
            kept[r, c] = inertia[r, c]
    return kept


def _turn(frame: JointFrame) -> sp.Matrix:
    """Only a prismatic joint has a fixed angle; what sits on the axis of a revolute one does not see it."""
    if not frame.prismatic:
        return sp.eye(3)
    c, s = sp.cos(frame.angle), sp.sin(frame.angle)
    return sp.Matrix([[c, -s, 0], [s, c, 0], [0, 0, 1]])


def _named(inertia: sp.Matrix, i: int, origin: str, steps: Steps) -> sp.Matrix:
    named = sp.zeros(4, 4)
    for r, c in ENTRIES:
        named[r, c] = named[c, r] = steps.name(name_of(i, r, c), inertia[r, c], origin)
    return named


def name_of(link: int, row: int, column: int) -> str:
    """Of an entry of the grouped pseudo-inertia of a link, counted from 1: ``J_2_xx``, ``J_2_x1``, ``J_2_11``."""
    return f"J_{link}_{_AXES[row]}{_AXES[column]}"
