"""Conditions that a mismatch may follow, as cells of samples: speed, reversals, angle orders, load, time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.position_noise import speed_noise
from symdyn.numeric.rest import REST
from symdyn.numeric.scan import orders, periodogram
from symdyn.numeric.workbench import Workbench

Array = NDArray[np.float64]
Cells = NDArray[np.int_]

BINS = 12  # equally filled by the training data
SLOW = 0.1  # of the usual top speed
SETTLED = 0.1  # of the usual travel between reversals: a mesh, a spring or a bristle has been taken up by then
EIGHTHS = 8


@dataclass(frozen=True, slots=True, eq=False)
class Condition:
    """Cell of each sample, out of ``cells``, of training (K,) and held-out data: a mean per cell is a free-form law."""

    name: str
    training: Cells
    heldout: Cells
    cells: int


@dataclass(frozen=True, slots=True, eq=False)
class _Motion:
    """One joint's motion in the analysis band, each (K,)."""

    q: Array
    qd: Array
    qdd: Array
    time: Array
    rest: float  # speed below which no direction can be told


def conditions(
    bench: Workbench, judge: Workbench, joints: Sequence[str], j: int, loads: tuple[Array, Array], residual: Array
) -> list[Condition]:
    """What the mismatch at joint ``j`` may follow; cells have the same edges in both recordings.

    ``loads`` (K, n) are the efforts that the model predicts (measured ones hold the mismatch itself).
    ``residual`` (K,) of the training data proposes the order of the angle to be tried, no more.
    """
    a, b = _motion(bench, j), _motion(judge, j)
    top = float(np.quantile(np.abs(a.qd), 0.95))
    stroke = _stroke(a)
    found = [
        Condition("always", np.zeros(len(a.q), dtype=int), np.zeros(len(b.q), dtype=int), 1),
        Condition("sign of speed", _sign(a), _sign(b), 3),
        Condition("low speed", _slow(a, top), _slow(b, top), 6),
        Condition("reversal", _turned(a, stroke), _turned(b, stroke), 6),
        _binned("speed", a.qd, b.qd),
        _binned("position", a.q, b.q),
        _binned("acceleration", a.qdd, b.qdd),
        Condition("time", _eighth(a, a), _eighth(b, a), 3 * EIGHTHS),
    ]
    if np.any(bench.effort[:, j]):  # where nothing drives, what the model predicts is all that is left
        found.insert(-1, _binned("load", loads[0][:, j], loads[1][:, j]))
    order = _order(a, residual, bench, j)
    if order is not None:
        found.append(Condition(f"angle order {order:.4g}", _phase(order, a.q), _phase(order, b.q), BINS))
    for i, other in enumerate(joints):
        if i != j:
            one, two = _motion(bench, i), _motion(judge, i)
            found.append(_binned(f"speed of {other}", one.qd, two.qd))
            found.append(_binned(f"position of {other}", one.q, two.q))
    return found


def _motion(bench: Workbench, j: int) -> _Motion:
    o = bench.observation
    q, qd, qdd = (bench.bring(np.ascontiguousarray(values[:, j])) for values in (o.q, o.qd, o.qdd))
    time = bench.bring(o.time)
    return _Motion(q, qd, qdd, time - time[0], REST * float(speed_noise(o)[j]))


def _binned(name: str, training: Array, heldout: Array) -> Condition:
    edges = np.quantile(training, np.linspace(0.0, 1.0, BINS + 1)[1:-1])
    return Condition(name, np.digitize(training, edges), np.digitize(heldout, edges), BINS)


def _sign(motion: _Motion) -> Cells:
    """0 backwards, 1 at rest, 2 forwards."""
    return np.asarray(np.where(np.abs(motion.qd) < motion.rest, 1, np.where(motion.qd > 0.0, 2, 0)), dtype=np.int_)


def travelled(q: Array, qd: Array) -> Array:
    """(K,) how far a joint went since it last turned round; at first, since the start."""
    turned = np.flatnonzero(np.diff((qd > 0.0).astype(int)) != 0) + 1
    starts = np.concatenate(([0], turned))
    index = np.searchsorted(starts, np.arange(len(q)), side="right") - 1
    return np.asarray(np.abs(q - q[starts[index]]))


def _stroke(motion: _Motion) -> float:
    """Median travel between two reversals; strokes of noise at rest are left out."""
    turned = np.flatnonzero(np.diff((motion.qd > 0.0).astype(int)) != 0) + 1
    strokes = np.abs(np.diff(motion.q[turned]))
    range_ = float(np.ptp(motion.q))
    real = strokes[strokes > 0.01 * range_]
    return float(np.median(real)) if len(real) else range_


def _slow(motion: _Motion, top: float) -> Cells:
    return 3 * (np.abs(motion.qd) < SLOW * top).astype(int) + _sign(motion)


def _turned(motion: _Motion, stroke: float) -> Cells:
    return 3 * (travelled(motion.q, motion.qd) < SETTLED * stroke).astype(int) + _sign(motion)


def _eighth(motion: _Motion, training: _Motion) -> Cells:
    """Which eighth of the training data's duration, by direction; what comes later counts to the last."""
    eighth = (EIGHTHS * motion.time / max(float(training.time[-1]), 1e-12)).astype(int)
    return np.asarray(3 * np.clip(eighth, 0, EIGHTHS - 1) + _sign(motion), dtype=np.int_)


def _order(motion: _Motion, residual: Array, bench: Workbench, j: int) -> float | None:
    """Waves per turn of the sine that the residual holds most of; None where the travel is too short for any."""
    tried = orders(bench.observation, j, bench.edge)
    if float(tried[0] * np.median(np.abs(motion.qd))) > 2.0 * np.pi * bench.edge:
        return None
    power = periodogram(residual - residual.mean(), motion.q, motion.qd, tried, bench.edge)
    return float(tried[int(np.argmax(power))])


def _phase(order: float, q: Array) -> Cells:
    wave = order * q / (2.0 * np.pi)
    return np.asarray(np.minimum(BINS * (wave - np.floor(wave)), BINS - 1), dtype=np.int_)
