"""Whether a loop that is stable without pause still is when it is sampled."""

from __future__ import annotations

import numpy as np
from scipy.linalg import expm

from symdyn.base.errors import Problem
from symdyn.base.linear_system import Array, LinearSystem

MOVED = 0.1  # of a closed-loop mode, from the nearest one without loops: what is nearer is the machine's own
GROWS = 1e-6  # per sample, or per time of the fastest mode: less is rounding of a mode that stays
SHORTEST = 20  # halvings of a period that are tried


def too_slow(closed: LinearSystem, open_: LinearSystem, period: float, what: str) -> Problem | None:
    """SD455 where loops make a machine unstable by being sampled every ``period`` s alone.

    ``closed``: the machine with its loops run without pause; ``open_``: without them.
    """
    try:
        a, own = _rates(closed), _rates(open_)
    except np.linalg.LinAlgError:
        return None  # something has no inertia: nothing is known
    plant = [closed.states.index(name) for name in open_.states]
    poles = np.linalg.eigvals(a)
    fastest = float(np.abs(poles).max(initial=0.0))
    if poles.real.max(initial=0.0) > GROWS * fastest or not _grows(a, own, plant, period):
        return None
    machine = np.linalg.eigvals(own)
    made = [abs(p) for p in poles if not len(machine) or np.abs(machine - p).min() > MOVED * abs(p)]
    mode = f": the mode of {max(made):.4g} rad/s that it makes is too fast for them" if made else ""
    shorter = next((k for k in range(1, SHORTEST) if not _grows(a, own, plant, period / 2**k)), None)
    period_hint = f"a period of {period / 2**shorter:.2g} s is stable" if shorter else "no period is short enough"
    message = f"{what} is stable without pause, but not with samples every {period:.4g} s{mode}"
    return Problem("SD455", message, hint=f"{period_hint}; or lower the gains")


def _rates(system: LinearSystem) -> Array:
    """A of dx/dt = A x."""
    return np.asarray(np.linalg.solve(system.e, system.f), dtype=np.float64)


def _grows(closed: Array, own: Array, plant: list[int], period: float) -> bool:
    """Whether the difference equation from sample to sample is unstable.

    Between samples the machine follows exp(own t), and what the loops put into it is held; their memory goes on by
    Euler's rule.
    """
    n, size = len(own), len(closed)
    memory = [k for k in range(size) if k not in plant]
    by_loops = closed[plant]
    by_loops[:, plant] -= own
    whole = np.zeros((2 * n, 2 * n))
    whole[:n, :n], whole[:n, n:] = own, np.eye(n)
    over = expm(period * whole)
    following = np.eye(size)
    following[plant] = over[:n, n:] @ by_loops
    following[np.ix_(plant, plant)] += over[:n, :n]
    following[memory] += period * closed[memory]
    return bool(np.abs(np.linalg.eigvals(following)).max(initial=0.0) > 1.0 + GROWS)
