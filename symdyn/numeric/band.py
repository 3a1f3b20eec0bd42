"""The analysis band: where in frequency a mismatch lives, and the residual brought down to it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from symdyn.numeric.observation import Observation, is_cut, low_pass
from symdyn.numeric.position_spectrum import WHOLE

Array = NDArray[np.float64]

SHARE = 0.99  # of the residual's power above its noise floor that the band must hold ...
HEADROOM = 2.0  # ... at half its width, so that the shape of a mismatch is kept
TRANSIENT = 3.0  # periods of a Butterworth filter's edge in which its transients decay to a thousandth
SAMPLES_PER_PERIOD = 4  # samples kept per period of the band's edge


@dataclass(frozen=True, slots=True)
class Band:
    """Signals are low-passed at ``cutoff`` Hz and every ``stride``-th sample is kept."""

    cutoff: float
    stride: int

    def bring(self, values: Array, observation: Observation) -> Array:
        """(N, ...) to (K, ...): low-passed and thinned, the ends of each segment (filter transients) dropped.

        First those where derivatives are wrong, so that the band's own filter does not spread them.
        """
        edge = max(1, int(observation.rate / self.cutoff))
        pieces = []
        for part in sound(observation):
            if part.stop - part.start > 2 * edge + self.stride:
                pieces.append(low_pass(values[part], observation.rate, self.cutoff)[edge : -edge : self.stride])
        return np.concatenate(pieces)


def sound(observation: Observation) -> tuple[slice, ...]:
    """The segments without their ends, where the filter before differentiation has not settled.

    At most an eighth at either end: of a joint that hardly moves the filter would take everything.
    """
    filtered = is_cut(observation.rate, observation.cutoff)
    settled = int(np.ceil(TRANSIENT * observation.rate / observation.cutoff)) if filtered else 0
    ends = [min(settled, (part.stop - part.start) // 8) for part in observation.segments]
    return tuple(slice(p.start + end, p.stop - end) for p, end in zip(observation.segments, ends, strict=True))


def analysis_band(residual: Array, observation: Observation, limit: float | None = None) -> Band:
    """The band that holds the mismatch: 99 % of the residual's power above its noise floor, twice over.

    It ends at ``limit`` Hz; None: where the positions sink into their own noise, since what does not move
    visibly tests no model of inertia.

    ``residual`` (N, n): measured effort less the fitted model. Frequencies that hold noise alone
    would only blur the comparison of explanations.
    """
    longest = max(sound(observation), key=lambda part: part.stop - part.start)
    widest, limit = 0.0, observation.cutoff if limit is None else limit
    for column in residual[longest].T:
        frequency, power = signal.welch(
            column - column.mean(),
            observation.rate,
            nperseg=min(len(column), max(256, len(column) // 8)),
            detrend="constant",
        )
        floor = np.median(power[len(power) // 2 :])
        visible = frequency <= limit
        share = np.cumsum(np.where(visible, np.maximum(power - floor, 0.0), 0.0))
        if share[-1] > 0:
            widest = max(widest, float(frequency[np.searchsorted(share, SHARE * share[-1])]))
    edge = min(HEADROOM * widest, limit)
    return band_of(max(edge, 8.0 * float(frequency[1])), observation.rate)


def band_of(cutoff: float, rate: float) -> Band:
    """The band with a given edge in Hz."""
    cutoff = min(cutoff, WHOLE * rate)
    return Band(cutoff, max(1, int(rate / (SAMPLES_PER_PERIOD * cutoff))))
