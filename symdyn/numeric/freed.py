"""Hypotheses that give the model numbers it has none of: gravity that pulls elsewhere, a payload."""

from __future__ import annotations

import math
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from symdyn.base.errors import InputError
from symdyn.compiler import robot_from_text
from symdyn.numeric.candidates import GRAVITY
from symdyn.numeric.explanation import CERTAIN, SPECK, Revised
from symdyn.numeric.findings import Estimate
from symdyn.numeric.inquiry import Inquiry, estimates
from symdyn.numeric.mechanics import mechanical_kernel
from symdyn.numeric.regression import fit_linear
from symdyn.numeric.setting import Setting
from symdyn.numeric.sizes import STRONGEST
from symdyn.numeric.workbench import Workbench
from symdyn.spec.edit import add_effect, set_gravity
from symdyn.spec.monomials import value_of
from symdyn.spec.records import Robot

Array = NDArray[np.float64]

PAYLOAD = "payload"
AXES = ("x", "y", "z")
COM = tuple(f"com_{axis}" for axis in AXES)
LEAST_MASS = 0.01  # of the link that carries it: a search for a payload begins at no less


class Numbers(Protocol):
    """What is told of them, by the names that a finding has for them."""

    @property
    def effect(self) -> str: ...

    @property
    def place(self) -> str: ...

    @property
    def title(self) -> str: ...

    def written(self, robot: Robot) -> str:
        """The robot's text with them, none of them zero: a zero would be no parameter."""

    def names(self, freed: Robot) -> dict[str, str]:
        """The parameters that they are in a robot that has them."""

    @property
    def unit(self) -> Mapping[str, float]:
        """Values at which what follows from them is linear, if it is not so everywhere."""

    def started(self, robot: Robot, step: Array) -> Mapping[str, float]:
        """Where a fit begins, if not at what is written, by what a linear one finds."""

    def credible(self, fitted: Mapping[str, Estimate]) -> bool:
        """Whether a machine on Earth may have such numbers."""


@dataclass(frozen=True, slots=True)
class GravityVector:
    """A base that is tilted, or hangs, or gravity that the model leaves out."""

    effect: str = GRAVITY
    place: str = "base"
    title: str = "gravity"

    def written(self, robot: Robot) -> str:
        numbers = {p.name: p.value for p in robot.parameters}
        return set_gravity(robot.text, [value_of(m, numbers) or SPECK for m in robot.gravity])

    def names(self, freed: Robot) -> dict[str, str]:
        return {axis: m.factors[0][0] for axis, m in zip(AXES, freed.gravity, strict=True)}

    @property
    def unit(self) -> Mapping[str, float]:
        return {}  # they do so everywhere

    def started(self, robot: Robot, step: Array) -> Mapping[str, float]:
        return {}

    def credible(self, fitted: Mapping[str, Estimate]) -> bool:
        """Beside masses that no motion tells, it may be anything; what is too strong takes up something else."""
        told = any(e.se is None or abs(e.value) > CERTAIN * e.se for e in fitted.values())
        return told and math.hypot(*(e.value for e in fitted.values())) < STRONGEST


@dataclass(frozen=True, slots=True)
class PointPayload:
    """A mass that the link behind a joint carries; what is linear is the mass, and mass times position."""

    place: str
    effect: str = PAYLOAD
    title: str = PAYLOAD

    def written(self, robot: Robot) -> str:
        return add_effect(robot.text, PAYLOAD, self.place, {"mass": "1 kg"} | dict.fromkeys(COM, "0.1 m"))

    def names(self, freed: Robot) -> dict[str, str]:
        block = next(e for e in freed.effects if (e.type, e.at) == (PAYLOAD, self.place))
        return {told: value.factors[0][0] for told, value in block.values}

    @property
    def unit(self) -> Mapping[str, float]:
        return {"mass": 1.0} | dict.fromkeys(COM, 0.0)

    def started(self, robot: Robot, step: Array) -> Mapping[str, float]:
        numbers = {p.name: p.value for p in robot.parameters}
        link = next(joint.link for joint in robot.joints if joint.name == self.place)
        mass = max(float(step[0]), LEAST_MASS * (value_of(link.mass, numbers) or 1.0))
        return {"mass": mass} | {name: float(first) / mass for name, first in zip(COM, step[1:], strict=True)}

    def credible(self, fitted: Mapping[str, Estimate]) -> bool:
        """A moment without a mass is none: the fit goes to nothing, infinitely far away."""
        mass = fitted["mass"]
        return mass.se is not None and mass.value > CERTAIN * mass.se


def numbers_of(effect: str, place: str) -> Numbers:
    return GravityVector() if effect == GRAVITY else PointPayload(place)


@dataclass(frozen=True, slots=True, eq=False)
class Freed:
    """One of them, as a hypothesis."""

    numbers: Numbers
    _settings: dict[str, Setting]  # with them, by the text of the robot that lacks them

    @property
    def key(self) -> tuple[str, str]:
        return self.numbers.effect, self.numbers.place

    @property
    def label(self) -> str:
        return f"{self.numbers.title} at {self.numbers.place}"

    def columns(self, inquiry: Inquiry) -> list[Array]:
        setting = self._setting(inquiry.setting)
        old, names = inquiry.case.bench, self.numbers.names(setting.robot)
        bench = Workbench(setting.kernel, old.observation, old.band)
        return [bench.columns(self._values(inquiry, setting, self.numbers.unit), tuple(names.values()))]

    def revised(self, inquiry: Inquiry, tried: int) -> Inquiry | None:
        current, columns = inquiry.current, self.columns(inquiry)[tried]
        design = np.concatenate([current.design, columns], axis=2)
        step = fit_linear(design * current.weight[:, None], current.training * current.weight).estimate
        setting = self._setting(inquiry.setting)
        start = self._values(inquiry, setting, self.numbers.started(inquiry.setting.robot, step[-columns.shape[2] :]))
        names = self.numbers.names(setting.robot)
        revised = Revised(self.numbers.effect, self.numbers.title, self.numbers.place, names=names)
        setting = replace(setting, readings=inquiry.setting.readings, revised=inquiry.setting.revised)
        setting = setting.with_revision(revised)
        case = setting.case(*inquiry.band)
        near = replace(current, fit=replace(current.fit, p=start))
        after = case.explain(current.found, near)
        if not self.numbers.credible(estimates(case, revised, after)):
            return None
        return replace(inquiry, setting=setting, case=case, current=after)

    def refitted(self, inquiry: Inquiry) -> None:
        return None

    def _setting(self, setting: Setting) -> Setting:
        text = setting.robot.text
        if text not in self._settings:
            self._settings[text] = with_numbers(setting, self.numbers)
        return self._settings[text]

    def _values(self, inquiry: Inquiry, setting: Setting, told: Mapping[str, float]) -> Array:
        """Parameters of a machine that has the numbers: those ``told``, the others as they are fitted so far."""
        names, p, old = self.numbers.names(setting.robot), setting.kernel.values, inquiry.case.bench.index
        for i, name in enumerate(setting.kernel.parameters):
            if name in old and name not in names.values():
                p[i] = inquiry.current.fit.p[old[name]]
        for what, value in told.items():
            p[setting.kernel.parameters.index(names[what])] = value
        return p


def with_numbers(setting: Setting, numbers: Numbers) -> Setting:
    """The same machine with these numbers as parameters of its own. InputError where no text can say them."""
    robot = setting.robot
    file = robot.where.file if robot.where else robot.name
    freed = setting.part.of(robot_from_text(numbers.written(robot), file))
    names = tuple(numbers.names(freed).values())
    own = (*(name for name in setting.own if name not in names), *names)
    return setting.anew(robot=freed, kernel=mechanical_kernel(freed), own=own)


def missing_numbers(setting: Setting) -> list[Freed]:
    """Those that can be asked for: gravity, where a text says it, and a payload on each link whose masses are held.

    One that is free takes up the mass of a payload without a trace.
    """
    robot = setting.robot
    asked: list[Numbers] = [] if GRAVITY in setting.held else [GravityVector()]
    present = {(e.type, e.at) for e in robot.effects}
    for joint in robot.joints:
        masses = [joint.link.mass]
        if joint is robot.joints[-1] and robot.tool is not None:
            masses.append(robot.tool.link.mass)
        free = {name for mass in masses for name, _ in mass.factors} & set(setting.own)
        if not free and (PAYLOAD, joint.name) not in present:
            asked.append(PointPayload(joint.name))
    found = []
    for numbers in asked:
        with suppress(InputError):  # no text says them
            found.append(Freed(numbers, {robot.text: with_numbers(setting, numbers)}))
    return found
