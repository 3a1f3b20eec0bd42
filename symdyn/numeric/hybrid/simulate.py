"""Simulation with located events: exact where the machine is affine in every mode, else step by step."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.hybrid.affine_simulation import simulate_affine
from symdyn.numeric.hybrid.general_simulation import simulate_general
from symdyn.numeric.hybrid.machine import Machine
from symdyn.numeric.hybrid.signals import Signal
from symdyn.numeric.hybrid.trajectory import HybridTrajectory

Array = NDArray[np.float64]


def simulate_events(
    machine: Machine,
    time: Array,
    signals: Sequence[Signal],
    *,
    start: Array | None = None,
    tolerance: float = 1e-8,
) -> HybridTrajectory:
    """States at evenly spaced ``time`` (N,), and every event between; see the two ways for what they raise.

    ``tolerance`` has no meaning for a machine that is propagated exactly.
    """
    if machine.affine:
        return simulate_affine(machine, time, signals, start=start)
    return simulate_general(machine, time, signals, start=start, tolerance=tolerance)
