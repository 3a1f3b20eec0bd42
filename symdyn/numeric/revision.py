"""Hypotheses that are no force at a joint: a sensor that shows something else, a drive's limit, wrong gravity."""

from __future__ import annotations

from dataclasses import replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.explanation import Revised
from symdyn.numeric.freed import missing_numbers, numbers_of, with_numbers
from symdyn.numeric.inquiry import Inquiry
from symdyn.numeric.misread import Misread
from symdyn.numeric.reading import READERS
from symdyn.numeric.setting import Setting
from symdyn.spec.places import places

Array = NDArray[np.float64]


class Revision(Protocol):
    """One hypothesis."""

    @property
    def key(self) -> tuple[str, str]: ...  # effect, place

    @property
    def label(self) -> str: ...

    def columns(self, inquiry: Inquiry) -> list[Array]:
        """For every value that is tried, (K, n, k): what it takes off the residual, per unit of k numbers."""

    def revised(self, inquiry: Inquiry, tried: int) -> Inquiry | None:
        """The case set right, with everything fitted anew; None where that runs out of bounds.

        Raises NumericalError where it does not settle.
        """

    def refitted(self, inquiry: Inquiry) -> Inquiry | None:
        """With its value fitted anew beside what was found since; None where it is fitted with all the rest anyway."""


def without(inquiry: Inquiry, revised: Revised) -> Inquiry:
    """The case as if that were not known, with all the rest."""
    setting, origin = inquiry.setting, inquiry.origin
    others = tuple(r for r in setting.revised if r is not revised)
    readings = list(setting.readings)
    if revised.names:
        setting = origin
        for other in (r for r in others if r.names):
            setting = with_numbers(setting, numbers_of(other.effect, other.place))
    else:
        joint, fields = setting.joints.index(revised.place), READERS[revised.effect].values()
        as_before = {name: getattr(origin.readings[joint], name) for name in fields}
        readings[joint] = replace(readings[joint], **as_before)
    setting = replace(setting, readings=tuple(readings), revised=others)
    case = setting.case(*inquiry.band)
    return replace(inquiry, setting=setting, case=case, current=case.explain(inquiry.current.found))


def revisions(setting: Setting) -> tuple[Revision, ...]:
    """All of them, of a machine that is driven.

    Without any effort nothing has a size: gravity and inertias could all be nothing, and would fit best.
    """
    if not np.any(setting.seen.tau):
        return ()
    found: list[Revision] = []
    at = {place.address: place for place in places(setting.robot)}
    for i, joint in enumerate(setting.joints):
        drive = setting.robot.joints[i].drive
        driven = bool(np.any(setting.seen.tau[:, i])) and (drive is None or drive.motor is None)
        for effect, fields in READERS.items():
            if (effect == "encoder" and setting.part.drive is not None) or not setting.part.has(effect, joint):
                continue
            if effect == "encoder" or driven:
                found += [Misread(i, at[joint], effect, what) for what in fields]
    return tuple(found) if setting.part.drive is not None else (*found, *missing_numbers(setting))
