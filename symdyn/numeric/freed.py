"""Hypotheses that give the model numbers it has none of: gravity that pulls elsewhere, a payload."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from symdyn.base.errors import InputError
from symdyn.compiler import compile_robot, robot_from_text
from symdyn.numeric.explanation import SPECK, Revised
from symdyn.numeric.inquiry import Inquiry
from symdyn.numeric.regression import fit_linear
from symdyn.numeric.setting import Setting
from symdyn.numeric.workbench import Workbench
from symdyn.spec.edit import add_effect, set_gravity
from symdyn.spec.monomials import value_of
from symdyn.spec.records import Robot

Array = NDArray[np.float64]

GRAVITY, PAYLOAD = "gravity", "payload"
AXES = ("x", "y", "z")
COM = tuple(f"com_{axis}" for axis in AXES)
COM_UNITS = tuple((name, "m") for name in COM)
LEAST_MASS = 0.01  # of the link that carries it: a search for a payload begins at no less


class Numbers(Protocol):
    """What is told of them; values by the names that a finding has for them."""

    @property
    def effect(self) -> str: ...

    @property
    def place(self) -> str: ...

    @property
    def title(self) -> str: ...

    def written(self, robot: Robot, values: Mapping[str, float]) -> str:
        """The robot's text with them; those without a value are a speck, or what they are already."""

    def names(self, freed: Robot) -> dict[str, str]:
        """The parameters that they are in a robot that has them."""

    @property
    def unit(self) -> Mapping[str, float]:
        """Values at which what follows from them is linear, if it is not so everywhere."""

    def started(self, robot: Robot, step: Array) -> dict[str, float]:
        """Where a fit begins, by what a linear one finds."""


@dataclass(frozen=True, slots=True)
class GravityVector:
    """A base that is tilted, or hangs, or gravity that the model leaves out."""

    effect: str = GRAVITY
    place: str = "base"
    title: str = "gravity"

    def written(self, robot: Robot, values: Mapping[str, float]) -> str:
        numbers = {p.name: p.value for p in robot.parameters}
        given = [value_of(m, numbers) or SPECK for m in robot.gravity]
        return set_gravity(robot.text, [values.get(axis, old) or SPECK for axis, old in zip(AXES, given, strict=True)])

    def names(self, freed: Robot) -> dict[str, str]:
        return {axis: m.factors[0][0] for axis, m in zip(AXES, freed.gravity, strict=True)}

    @property
    def unit(self) -> Mapping[str, float]:
        return {}  # they do so everywhere

    def started(self, robot: Robot, step: Array) -> dict[str, float]:
        return {}


@dataclass(frozen=True, slots=True)
class PointPayload:
    """A mass that the link behind a joint carries; what is linear is the mass, and mass times position."""

    place: str
    effect: str = PAYLOAD
    title: str = PAYLOAD

    def written(self, robot: Robot, values: Mapping[str, float]) -> str:
        told = {name: f"{values.get(name) or SPECK!r} {unit}" for name, unit in (("mass", "kg"), *COM_UNITS)}
        return add_effect(robot.text, PAYLOAD, self.place, told)

    def names(self, freed: Robot) -> dict[str, str]:
        block = next(e for e in freed.effects if (e.type, e.at) == (PAYLOAD, self.place))
        return {told: value.factors[0][0] for told, value in block.values}

    @property
    def unit(self) -> Mapping[str, float]:
        return {"mass": 1.0} | dict.fromkeys(COM, 0.0)

    def started(self, robot: Robot, step: Array) -> dict[str, float]:
        numbers = {p.name: p.value for p in robot.parameters}
        link = next(joint.link for joint in robot.joints if joint.name == self.place)
        mass = max(float(step[0]), LEAST_MASS * (value_of(link.mass, numbers) or 1.0))
        return {"mass": mass} | {name: float(first) / mass for name, first in zip(COM, step[1:], strict=True)}


def numbers_of(effect: str, place: str) -> Numbers:
    return GravityVector() if effect == GRAVITY else PointPayload(place)


@dataclass(frozen=True, slots=True, eq=False)
class Freed:
    """One of them, as a hypothesis."""

    numbers: Numbers
    _settings: dict[str, Setting] = field(default_factory=dict)  # by the text of the robot that lacks them

    @property
    def key(self) -> tuple[str, str]:
        return self.numbers.effect, self.numbers.place

    @property
    def label(self) -> str:
        return f"{self.numbers.title} at {self.numbers.place}"

    def columns(self, inquiry: Inquiry) -> list[Array]:
        setting = self._settings.get(inquiry.setting.robot.text)
        if setting is None:
            setting = given_numbers(inquiry.setting, self.numbers, {})
            self._settings[inquiry.setting.robot.text] = setting
        names, old = self.numbers.names(setting.robot), inquiry.case.bench
        bench = Workbench(setting.kernel, old.observation, old.band)
        p = setting.kernel.values
        for name, i in bench.index.items():
            if name in old.index and name not in names.values():
                p[i] = inquiry.current.fit.p[old.index[name]]
        for told, value in self.numbers.unit.items():
            p[bench.index[names[told]]] = value
        return [bench.columns(p, tuple(names.values()))]

    def revised(self, inquiry: Inquiry, tried: int) -> Inquiry:
        current, columns = inquiry.current, self.columns(inquiry)[tried]
        design = np.concatenate([current.design, columns], axis=2)
        step = fit_linear(design * current.weight[:, None], current.training * current.weight).estimate
        start = self.numbers.started(inquiry.setting.robot, step[-columns.shape[2] :])
        setting = given_numbers(inquiry.setting, self.numbers, start)
        names = self.numbers.names(setting.robot)
        setting = setting.with_revision(
            Revised(self.numbers.effect, self.numbers.title, self.numbers.place, names=names)
        )
        case = setting.case(*inquiry.band)
        return replace(inquiry, setting=setting, case=case, current=case.explain(current.found))

    def refitted(self, inquiry: Inquiry) -> None:
        return None


def given_numbers(setting: Setting, numbers: Numbers, values: Mapping[str, float]) -> Setting:
    """The same machine with these numbers as parameters of its own. InputError where no text can say them."""
    robot = setting.robot
    freed = robot_from_text(numbers.written(robot, values), robot.where.file if robot.where else robot.name)
    names = tuple(numbers.names(freed).values())
    own = (*(name for name in setting.own if name not in names), *names)
    return replace(setting, robot=freed, kernel=compile_robot(freed).kernel(), own=own, _shown={})


def missing_numbers(setting: Setting) -> list[Freed]:
    """Those that can be asked for: gravity where a text says it, a payload where the weight of the last link is held.

    A mass that is free takes up that of a payload without a trace.
    """
    found: list[Freed] = []
    try:
        tilted = given_numbers(setting, GravityVector(), {})
    except InputError:
        pass
    else:
        found.append(Freed(GravityVector(), {setting.robot.text: tilted}))
    last = setting.robot.joints[-1]
    weighed = not {name for name, _ in last.link.mass.factors} & set(setting.own)
    if weighed and (PAYLOAD, last.name) not in {(e.type, e.at) for e in setting.robot.effects}:
        found.append(Freed(PointPayload(last.name)))
    return found
