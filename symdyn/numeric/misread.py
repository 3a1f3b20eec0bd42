"""Hypotheses about sensors and drives: an encoder that shows something else, effort that is not what was recorded."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.explanation import CERTAIN, Explanation, Revised, joint_errors
from symdyn.numeric.findings import Estimate
from symdyn.numeric.inquiry import Inquiry
from symdyn.numeric.reading import READERS
from symdyn.numeric.regression import LinearFit, fit_linear
from symdyn.numeric.setting import Setting
from symdyn.physics import catalogue
from symdyn.spec.records import Place

Array = NDArray[np.float64]

ROUNDS = 10  # of Gauss-Newton
NEAR = 1e-2  # standard errors: a step that small has settled
LIMITS = (0.995, 0.98, 0.95, 0.9, 0.8, 0.65, 0.5, 0.35, 0.2)  # quantiles of the effort: limits that are tried
ALWAYS = 0.9  # of what is judged: what is that often at its limit tells nothing of how large efforts are
LOWEST = {"gain": 0.1, "offset": -np.pi, "limit": 0.0}  # beyond that nobody calls it a sensor, or a drive
HIGHEST = {"gain": 10.0, "offset": np.pi, "limit": np.inf}


@dataclass(frozen=True, slots=True)
class Misread:
    """An encoder is off by a gain or an offset; or another effort was given than recorded, by a gain or to a limit."""

    joint: int
    place: Place
    effect: str
    what: str  # which of the effect's parameters

    @property
    def key(self) -> tuple[str, str]:
        return self.effect, self.place.address

    @property
    def label(self) -> str:
        which = f" ({self.what})" if len(READERS[self.effect]) > 1 else ""
        return f"{catalogue()[self.effect].title}{which} at {self.place.address}"

    @property
    def unit(self) -> str:
        schema = next(s for s in catalogue()[self.effect].parameters if s.name == self.what)
        return schema.units[self.place.motion]

    def columns(self, inquiry: Inquiry) -> list[Array]:
        if self.what != "limit":
            return [self._slope(inquiry, inquiry.current, self._stands(inquiry.setting))]
        bench = inquiry.case.bench
        asked = bench.observation.tau[:, [self.joint]]
        kept = bench.bring(np.concatenate([asked - np.clip(asked, -v, v) for v in self._limits(inquiry)], axis=1))
        columns = np.zeros((kept.shape[1], *bench.effort.shape, 1))  # not given: no effort, whatever the model needs
        columns[:, :, self.joint, 0] = kept.T * bench.counted[:, self.joint]
        return list(columns)

    def revised(self, inquiry: Inquiry, tried: int) -> Inquiry | None:
        limited = self.what == "limit"
        after = self._from(inquiry, self._limits(inquiry)[tried] if limited else self._stands(inquiry.setting))
        return after if after is not None and self._has_a_size(after) else None

    def _has_a_size(self, after: Inquiry) -> bool:
        """Whether its value can be told from the one that was given, as the sizes of effects must be."""
        told = next(r.values[self.what] for r in after.setting.revised if (r.effect, r.place) == self.key)
        return told.se is None or abs(told.value - self._stands(after.origin)) > CERTAIN * told.se

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
            if not LOWEST[self.what] < value < HIGHEST[self.what] or self._always(inquiry, value):
                return None
        if not last.identifiable[-1]:
            return None
        se = float(last.standard_error[-1])
        known = next((r.values for r in inquiry.setting.revised if (r.effect, r.place) == self.key), {})
        values = {**known, self.what: Estimate(value, se, self.unit)}
        title = catalogue()[self.effect].title
        if len(READERS[self.effect]) > 1 and len(values) == 1:
            title = f"{title} {self.what}"
        revised = Revised(self.effect, title, self.place.address, values)
        setting = self._setting(inquiry.setting, value).with_revision(revised)
        case = setting.case(*inquiry.band)
        after = replace(inquiry, setting=setting, case=case, current=case.explain(current.found, current))
        return after if self._tells_more(inquiry, after) else None

    def _joint_fit(self, inquiry: Inquiry, current: Explanation, value: float) -> LinearFit:
        """Of a step of the value, last, together with all other parameters."""
        design = np.concatenate([current.design, self._slope(inquiry, current, value)], axis=2)
        return fit_linear(design * current.weight[:, None], current.training * current.weight)

    def _stands(self, setting: Setting) -> float:
        return float(getattr(setting.readings[self.joint], READERS[self.effect][self.what]))

    def _limits(self, inquiry: Inquiry) -> list[float]:
        asked = np.abs(inquiry.case.bench.observation.tau[:, self.joint])
        return [float(limit) for limit in np.quantile(asked, LIMITS)]

    def _tells_more(self, before: Inquiry, after: Inquiry) -> bool:
        """A limit leaves less effort to be explained, and of that, too, a smaller part must be unexplained.

        A limit of nothing would leave nothing, of noise too (``ALWAYS``). And a limit that is not reached where it is
        judged was not seen there: it took off what was large in training, and let other numbers move.
        """
        if self.what != "limit":
            return True
        reading = after.setting.readings[self.joint]
        left = [joint_errors(i.current.heldout, i.case.judge)[self.joint] for i in (before, after)]
        judged = self._setting(before.setting, np.inf).case(*before.band).judge.observation.tau[:, self.joint]
        reached = np.any(np.abs(judged) >= reading.limit)
        return bool(reached and left[1] < left[0])

    def _always(self, inquiry: Inquiry, value: float) -> bool:
        """Whether nearly every effort would be at that limit."""
        if self.what != "limit":
            return False
        asked = np.abs(inquiry.setting.readings[self.joint].effort_gain * inquiry.origin.seen.tau[:, [self.joint]])
        bench = inquiry.case.bench
        judged, beyond = bench.counted[:, self.joint], bench.bring((asked >= value).astype(float))[:, 0]
        return bool(np.sum(judged * beyond) >= ALWAYS * np.sum(judged))

    def _setting(self, setting: Setting, value: float) -> Setting:
        readings = list(setting.readings)
        readings[self.joint] = replace(readings[self.joint], **{READERS[self.effect][self.what]: value})
        return replace(setting, readings=tuple(readings))

    def _residual(self, inquiry: Inquiry, current: Explanation, value: float) -> Array:
        laws = self._setting(inquiry.setting, value).training_laws(*inquiry.band)
        return inquiry.case.residual(laws, current)

    def _slope(self, inquiry: Inquiry, current: Explanation, value: float) -> Array:
        """(K, n, 1) fall of the residual per unit of the value."""
        step = 1e-3 * value if self.what == "limit" else 1e-4 * max(abs(value), 1.0)
        high, low = (self._residual(inquiry, current, value + side) for side in (step, -step))
        return np.asarray(((low - high) / (2.0 * step))[:, :, None])
