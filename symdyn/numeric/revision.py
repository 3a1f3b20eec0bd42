"""Hypotheses that are no force at a joint: a sensor that shows something else, a drive's limit, wrong gravity."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from symdyn.base.errors import InputError
from symdyn.compiler import compile_robot, robot_from_text
from symdyn.numeric.explanation import SPECK, Explanation, Revised
from symdyn.numeric.findings import Estimate
from symdyn.numeric.inquiry import Inquiry
from symdyn.numeric.readings import READERS
from symdyn.numeric.regression import LinearFit, fit_linear
from symdyn.numeric.setting import Setting
from symdyn.numeric.workbench import Workbench
from symdyn.physics import catalogue
from symdyn.spec.edit import set_gravity
from symdyn.spec.monomials import value_of
from symdyn.spec.places import places
from symdyn.spec.records import Place

Array = NDArray[np.float64]

ROUNDS = 10  # of Gauss-Newton
NEAR = 1e-2  # standard errors: a step that small has settled
LIMITS = (0.995, 0.98, 0.95, 0.9, 0.8, 0.65)  # quantiles of the effort: limits that are tried
MOSTLY = 0.5  # of the samples
LOWEST = {"gain": 0.1, "offset": -np.pi, "limit": 0.0}  # beyond that nobody calls it a sensor, or a drive
HIGHEST = {"gain": 10.0, "offset": np.pi, "limit": np.inf}
GRAVITY = "gravity"


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


@dataclass(frozen=True, slots=True)
class Misread:
    """An encoder is off by a gain or an offset; or effort that was asked for beyond a limit was not given."""

    joint: int
    place: Place
    effect: str
    what: str  # of a reading

    @property
    def key(self) -> tuple[str, str]:
        return self.effect, self.place.address

    @property
    def label(self) -> str:
        return f"{catalogue()[self.effect].title} ({self.what}) at {self.place.address}"

    @property
    def unit(self) -> str:
        schema = next(s for s in catalogue()[self.effect].parameters if s.name == self.what)
        return schema.units[self.place.motion]

    def columns(self, inquiry: Inquiry) -> list[Array]:
        if self.what != "limit":
            return [self._slope(inquiry, inquiry.current, self._stands(inquiry.setting))]
        before = inquiry.current.training
        return [
            (before - self._residual(inquiry, inquiry.current, value))[:, :, None] for value in self._limits(inquiry)
        ]

    def revised(self, inquiry: Inquiry, tried: int) -> Inquiry | None:
        limited = self.what == "limit"
        return self._from(inquiry, self._limits(inquiry)[tried] if limited else self._stands(inquiry.setting))

    def refitted(self, inquiry: Inquiry) -> Inquiry | None:
        return self._from(inquiry, self._stands(inquiry.setting))

    def _from(self, inquiry: Inquiry, value: float) -> Inquiry | None:
        """Fitted, from that value on."""
        case, current = inquiry.case, inquiry.current
        for _ in range(ROUNDS):
            case = self._setting(inquiry.setting, value).case(*inquiry.band)
            current = case.explain(current.found, current)
            last = self._joint_fit(inquiry, current, value)
            step = float(last.estimate[-1])
            if not np.isfinite(step) or abs(step) <= NEAR * float(last.standard_error[-1]):
                break
            value += step
            if not LOWEST[self.what] < value < HIGHEST[self.what]:
                return None
        if not last.identifiable[-1] or not self._mostly_free(inquiry, value):
            return None
        se = float(last.standard_error[-1])
        known = next((r.values for r in inquiry.setting.revised if (r.effect, r.place) == self.key), {})
        values = {**known, self.what: Estimate(value, se, self.unit)}
        title = catalogue()[self.effect].title
        if self.what != "limit" and len(values) == 1:
            title = f"{title} {self.what}"
        revised = Revised(self.effect, title, self.place.address, values)
        setting = self._setting(inquiry.setting, value).with_revision(revised)
        case = setting.case(*inquiry.band)
        return replace(inquiry, setting=setting, case=case, current=case.explain(current.found, current))

    def _joint_fit(self, inquiry: Inquiry, current: Explanation, value: float) -> LinearFit:
        """Of a step of the value, last, together with all other parameters."""
        design = np.concatenate([current.design, self._slope(inquiry, current, value)], axis=2)
        return fit_linear(design * current.weight[:, None], current.training * current.weight)

    def _stands(self, setting: Setting) -> float:
        return float(getattr(setting.readings[self.joint], self.what))

    def _limits(self, inquiry: Inquiry) -> list[float]:
        asked = np.abs(inquiry.case.bench.observation.tau[:, self.joint])
        return [float(limit) for limit in np.quantile(asked, LIMITS)]

    def _mostly_free(self, inquiry: Inquiry, value: float) -> bool:
        """A drive that is at its limit most of the time would hide everything, noise too."""
        effort = inquiry.origin.seen.tau[:, self.joint]
        return self.what != "limit" or bool(np.mean(np.abs(effort) >= value) < MOSTLY)

    def _setting(self, setting: Setting, value: float) -> Setting:
        readings = list(setting.readings)
        readings[self.joint] = replace(readings[self.joint], **{self.what: value})
        return replace(setting, readings=tuple(readings))

    def _residual(self, inquiry: Inquiry, current: Explanation, value: float) -> Array:
        laws = self._setting(inquiry.setting, value).training_laws(*inquiry.band)
        return inquiry.case.residual(laws, current)

    def _slope(self, inquiry: Inquiry, current: Explanation, value: float) -> Array:
        """(K, n, 1) fall of the residual per unit of the value."""
        step = 1e-3 * value if self.what == "limit" else 1e-4 * max(abs(value), 1.0)
        high, low = (self._residual(inquiry, current, value + side) for side in (step, -step))
        return np.asarray(((low - high) / (2.0 * step))[:, :, None])


@dataclass(frozen=True, slots=True, eq=False)
class Gravity:
    """Gravity that the model knows nothing of, or that pulls elsewhere: a base that is tilted, or hangs."""

    setting: Setting  # of the same machine with all three components as parameters
    names: tuple[str, str, str]

    @property
    def key(self) -> tuple[str, str]:
        return GRAVITY, "base"

    @property
    def label(self) -> str:
        return "gravity at base"

    def columns(self, inquiry: Inquiry) -> list[Array]:
        old = inquiry.case.bench
        bench = Workbench(self.setting.kernel, old.observation, old.band)
        p = self.setting.kernel.values
        for name, i in bench.index.items():
            if name in old.index and name not in self.names:
                p[i] = inquiry.current.fit.p[old.index[name]]
        return [bench.columns(p, self.names)]

    def revised(self, inquiry: Inquiry, tried: int) -> Inquiry:
        setting = replace(self.setting, readings=inquiry.setting.readings, revised=inquiry.setting.revised)
        setting = setting.with_revision(
            Revised(GRAVITY, "gravity", "base", names=dict(zip("xyz", self.names, strict=True)))
        )
        case = setting.case(*inquiry.band)
        return replace(inquiry, setting=setting, case=case, current=case.explain(inquiry.current.found))

    def refitted(self, inquiry: Inquiry) -> None:
        return None


def without(inquiry: Inquiry, revised: Revised) -> Inquiry:
    """The case as if that were not known, with all the rest."""
    setting, readings = inquiry.setting, list(inquiry.setting.readings)
    if revised.effect == GRAVITY:
        setting = inquiry.origin
    else:
        joint = inquiry.case.joints.index(revised.place)
        readings[joint] = replace(inquiry.origin.readings[joint], late=readings[joint].late)
    others = tuple(r for r in inquiry.setting.revised if r is not revised)
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
        for effect, fields in READERS.items():
            if effect == "encoder" or np.any(setting.seen.tau[:, i]):
                found += [Misread(i, at[joint], effect, what) for what in fields]
    gravity = free_gravity(setting)
    return tuple(found) if gravity is None else (*found, gravity)


def free_gravity(setting: Setting) -> Gravity | None:
    """The same machine with gravity's components as parameters of its own; None where no text says them."""
    robot = setting.robot
    numbers = {p.name: p.value for p in robot.parameters}
    given = [value_of(m, numbers) or 0.0 for m in robot.gravity]
    try:
        text = set_gravity(robot.text, [value or SPECK for value in given])
        freed = robot_from_text(text, robot.where.file if robot.where else robot.name)
    except InputError:
        return None
    names = tuple(m.factors[0][0] for m in freed.gravity)
    own = (*(name for name in setting.own if name not in names), *names)
    free = replace(setting, robot=freed, kernel=compile_robot(freed).kernel(), own=own, _shown={})
    return Gravity(free, (names[0], names[1], names[2]))
