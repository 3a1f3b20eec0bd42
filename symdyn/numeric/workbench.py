"""Residuals and regressors of one robot on one recording, brought to the analysis band."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from symdyn.emit.kernel import Kernel
from symdyn.numeric.band import Band
from symdyn.numeric.memory import remembered
from symdyn.numeric.observation import Observation
from symdyn.numeric.passive import Passive
from symdyn.numeric.position_spectrum import WHOLE
from symdyn.numeric.regression import times, without
from symdyn.numeric.rest import standing, turning
from symdyn.numeric.span import Span, find_span
from symdyn.numeric.swinging import started, swings

Array = NDArray[np.float64]

SLOPE_STEP = 1e-5  # of a parameter, where hidden states depend on it


class Workbench:
    """Evaluates the kernel on a recording; parameter vectors are those of its robot.

    Where a joint stands, or turns faster than its motion is known, nothing of its own equation is counted (residuals
    and columns are zero there), unless ``planned`` motion is looked at; nor ever where an unknown effort moves it. All
    that is in the analysis band is in units of efforts as they were shown: in those of the efforts that act, a
    sensor's gain of zero would leave no error.
    """

    def __init__(
        self, kernel: Kernel, observation: Observation, band: Band | None = None, planned: bool = False
    ) -> None:
        self.kernel, self.observation, self.band = kernel, observation, band
        self.index = {name: i for i, name in enumerate(kernel.parameters)}
        o = observation
        whole = np.ascontiguousarray
        self._motion = (whole(o.q), whole(o.qd), whole(o.qdd))
        self.turning = turning(o, band.cutoff if band else None, self.bring)  # (K, n)
        judged = ~standing(o, self.bring, self.turning) | planned
        self.counted: Array = judged * o.shown * o.tested  # (K, n) 0 where a joint stands: dry friction may be anything
        self.effort: Array = self.bring(o.tau) * self.counted
        self.reference = self._reference()  # (K, n) what errors are compared with
        self._remembers = len(kernel.states) > 2 * len(kernel.coordinates)
        self._spans: dict[tuple[str, ...], tuple[Span, Array]] = {}
        self._factors: dict[tuple[str, ...], list[tuple[Array, Array]]] = {}
        self._at_start: Array | None = None

    @cached_property
    def passive(self) -> Passive:
        """Joints that nothing drives."""
        return Passive(self.kernel, self.observation, self.index)

    def foldable(self, names: Sequence[str]) -> bool:
        """Whether these parameters enter by a sum of fixed columns: no hidden states, no characteristic speeds."""
        return bool(names) and not self._remembers and self.span(names)[0].exact

    def _reference(self) -> Array:
        """The measured effort; where none acts, on a passive joint, what the model gives its inertia to do."""
        idle = ~np.any(self.effort, axis=0)
        if not np.any(idle):
            return self.effort
        q, _, qdd = self._motion
        rest, p = np.zeros_like(q), self.kernel.values
        inertial = self.kernel.rows("inverse_dynamics_p", q, rest, qdd, p)
        inertial = inertial - self.kernel.rows("inverse_dynamics_p", q, rest, rest, p)
        return np.asarray(np.where(idle, self.bring(inertial) * self.counted, self.effort))

    def raw_residual(self, p: Array, speed: Array | None = None) -> Array:
        """(N, n) measured effort less inverse dynamics, over the full band; ``speed`` (N, n) instead of the measured.

        None of a joint that an unknown effort moves. Hidden states follow from the measured motion; what they exert
        counts as required effort.
        """
        o, (q, qd, qdd) = self.observation, self._motion
        required: Array = self.kernel.rows("inverse_dynamics_p", q, qd if speed is None else speed, qdd, p)
        if self._remembers:
            required = required - remembered(self.kernel, o.q, o.qd, o.time, o.segments, p)
        return np.asarray((o.tau - required - self._besides) * o.tested)

    @cached_property
    def _besides(self) -> Array:
        """(N, n) effort that goes on to what lies beyond torque sensors, and that known loads need."""
        o = self.observation
        passed_on = np.zeros_like(o.tau) if o.passed_on is None else o.passed_on
        return (
            passed_on if o.known is None else passed_on + o.known.effort(self.kernel, self._motion, self.kernel.values)
        )

    def residual(self, p: Array) -> Array:
        """(K, n) the same in the analysis band, where the joints move, less what the beginning of states would tell."""
        return without(self.bring(self.raw_residual(p)) * self.counted, self._begun(p))

    def columns(self, p: Array, names: Sequence[str]) -> Array:
        """(K, n, k) d inverse dynamics / d parameter, in the analysis band."""
        jacobian = self.kernel.rows("inverse_dynamics_parameter_jacobian_p", *self._motion, p)
        chosen = np.ascontiguousarray(jacobian[:, :, [self.index[name] for name in names]])
        for i in [i for i, name in enumerate(names) if name in self._lasting]:
            chosen[:, :, i] -= self._slope_of_memory(p, self.index[names[i]])
        return without(self.bring(chosen) * self.counted[:, :, None], self._begun(p))

    def _begun(self, p: Array) -> Array:
        """(K, n, m) efforts of hidden states that swing, because of how they began."""
        if not (self._remembers and swings(self.kernel, p)):
            return np.zeros((*self.effort.shape, 0))
        o = self.observation
        return np.asarray(self.bring(started(self.kernel, o.time, o.segments, p)) * self.counted[:, :, None])

    @cached_property
    def _lasting(self) -> frozenset[str]:
        """Parameters that the forces of hidden states depend on."""
        if not self._remembers:
            return frozenset()
        p = self.kernel.values
        return frozenset(n for n, i in self.index.items() if np.any(self._slope_of_memory(p, i)))

    def _slope_of_memory(self, p: Array, i: int) -> Array:
        """(N, n) by central difference."""
        o, ends = self.observation, []
        step = SLOPE_STEP * max(abs(p[i]), SLOPE_STEP)
        for side in (step, -step):
            moved = p.copy()
            moved[i] += side
            ends.append(remembered(self.kernel, o.q, o.qd, o.time, o.segments, moved))
        return np.asarray((ends[0] - ends[1]) / (2.0 * step))

    def span(self, names: Sequence[str]) -> tuple[Span, Array]:
        """The fixed columns (K, n, r), in the analysis band, of which inverse dynamics is a sum."""
        key = tuple(names)
        if key not in self._spans:
            span = find_span(self.kernel, key, self.index, self._motion)
            raw = np.empty((*self._motion[0].shape, len(span.sources)))
            for point, p in enumerate(span.points):
                mine = [i for i, (of, _) in enumerate(span.sources) if of == point]
                if mine:
                    jacobian = self.kernel.rows("inverse_dynamics_parameter_jacobian_p", *self._motion, p)
                    raw[:, :, mine] = jacobian[:, :, [self.index[key[span.sources[i][1]]] for i in mine]]
            self._spans[key] = span, np.ascontiguousarray(self.bring(raw) * self.counted[:, :, None])
        return self._spans[key]

    def factors(self, names: Sequence[str]) -> list[tuple[Array, Array]]:
        """Of each joint, an orthonormal basis (K, r) of those columns and of the residual at the span's start, and what
        makes them of it (r, columns + 1).
        """
        key = tuple(names)
        if key not in self._factors:
            span, fixed = self.span(names)
            start = self.left(span.start, names)
            stacked = (np.column_stack([fixed[:, j], start[:, j]]) for j in range(start.shape[1]))
            self._factors[key] = [(q, r) for q, r in map(np.linalg.qr, stacked)]
        return self._factors[key]

    def left(self, p: Array, names: Sequence[str]) -> Array:
        """(K, n) the residual at a ``p`` that differs from the kernel's in ``names`` alone.

        From the span of the names where a fit has found it: by itself it would not be worth the search.
        """
        if tuple(names) not in self._spans or not self.foldable(names):
            return self.residual(p)
        span, fixed = self.span(names)
        if self._at_start is None:
            self._at_start = self.residual(span.start)
        return self._at_start - times(fixed, span.coefficients(p))

    def moved(self, p: Array, names: Sequence[str]) -> Array:
        """(K, n, k) d inverse dynamics / d parameter there."""
        if not self.foldable(names):
            return self.columns(p, names)
        span, fixed = self.span(names)
        return times(fixed, span.slopes(p, names, self.index))

    @cached_property
    def motion(self) -> Array:
        """(K, 3 n) position, speed and acceleration of the joints in the analysis band."""
        return self.bring(np.concatenate(self._motion, axis=1))

    def bring(self, values: Array) -> Array:
        """(N, ...) to (K, ...): into the analysis band, if there is one."""
        return values if self.band is None else self.band.bring(values, self.observation)

    @property
    def samples_per_period(self) -> float:
        """Samples per period of the band's edge."""
        rate = self.observation.rate
        return 2.0 if self.band is None else rate / (self.band.stride * self.band.cutoff)

    @property
    def edge(self) -> float:
        """Of the analysis band, in Hz."""
        return self.band.cutoff if self.band else WHOLE * self.observation.rate
