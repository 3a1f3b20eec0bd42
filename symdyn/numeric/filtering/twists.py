"""How far a drive twists between two encoders, judged like a channel: beside many turns nobody would see it."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.filtering.signals import Signals
from symdyn.numeric.filtering.windows import noise_alone, white_noise

Array = NDArray[np.float64]

CLEAR = 0.1  # of how far a twist moves: what noise of the encoders may be of it


def with_twists(training: Signals, heldout: Signals) -> tuple[Signals, Signals]:
    """Both with the twists that the encoders show clearly in both; parts that turn rigidly have none."""
    rows = _differences(training)
    both = [replace(signals, twists=rows) for signals in (training, heldout)]
    noise = [noise_alone(signals, white_noise(signals))[len(signals.names) :] for signals in both]
    clear = np.all(np.array(noise) < CLEAR, axis=0)
    first, second = (replace(signals, twists=rows[clear]) for signals in both)
    return first, second


def _differences(signals: Signals) -> Array:
    """(t, m) of what neighbouring parts of a drive show, in units of their joint's own position."""
    drives: dict[str, list[int]] = {}
    for channel, index in enumerate(signals.index.tolist()):
        if index < len(signals.per_joint):
            drives.setdefault(signals.names[channel].partition(".")[0], []).append(channel)
    rows = []
    for channels in drives.values():
        for one, other in pairwise(sorted(channels, key=lambda c: signals.index[c])):
            row = np.zeros(len(signals.names))
            for channel, sign in ((one, 1.0), (other, -1.0)):
                row[channel] = sign / signals.per_joint[signals.index[channel]]
            rows.append(row)
    return np.array(rows).reshape(-1, len(signals.names))
