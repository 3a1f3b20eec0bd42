"""When a machine of which part is hidden does not do what its model says: conditions that an unknown force follows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.conditions import travelled
from symdyn.numeric.filtering.bench import FilterBench
from symdyn.numeric.filtering.judged import WORTH, Explanation
from symdyn.numeric.filtering.model import Model
from symdyn.numeric.filtering.places import Latent
from symdyn.numeric.filtering.score import Left, whitened

Array = NDArray[np.float64]

BINS = 10  # of a speed or a position, equally filled by the training data
EIGHTHS = 8  # of the recording's time
REST, SLOW = 0.01, 0.1  # of the usual top speed: no direction below, slow below
WAYS = (0.02, 0.05, 0.15)  # after a reversal within which a force settles, as part of the travel
ORDERS = 32  # waves per turn
SIMPLER = 0.8  # of the best gain: with that much, the condition of the fewest numbers is taken
MOST = 3  # conditions that are told


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """Of one place, each (N,): displacement, speed and time; a scale of the speed."""

    x: Array
    v: Array
    time: Array
    top: float


def when(model: Model, given: Explanation, latent: Latent) -> tuple[str, ...]:
    """What the force that is missing at a place follows, strongest first; nothing is told of a circuit.

    Each condition is a force with one number per cell of samples: learnt on training data against the innovations of
    the model as given (BIC), and held against the held-out ones. What one tells is taken out before the next.
    """
    if not latent.motion.any():
        return ()
    bench, p = given.fit.bench, given.fit.p
    judge = model.bench(model.heldout, bench.noise, bench.between)
    first = motion_of(bench, p, latent, None)
    second = motion_of(judge, p, latent, first.top)
    cells = conditions(first, first)
    columns, others = (_columns(b, p, latent, c) for b, c in ((bench, cells), (judge, conditions(second, first))))
    own = tuple(given.beliefs)
    left, checked = Left.of(bench, p, own), Left.of(judge, p, own)
    told: list[str] = []
    while len(told) < MOST:
        best = _best(left, columns, float(np.log(len(first.x))))
        if best is None or best in told:
            break
        everything = np.full(columns[best].shape[1], np.inf)
        _, force, rest = left.explained(columns[best], -everything, everything)
        after = checked.residual - checked.without(others[best] @ force)
        if 0.5 * (checked.power - float(after @ after)) < WORTH:
            break
        told.append(best)
        left, checked = Left(rest, left.basis), Left(after, checked.basis)
    return tuple(told)


def conditions(motion: Motion, reference: Motion) -> dict[str, Array]:
    """(N, k) weights of each condition's numbers; cells have the edges of the ``reference`` in every recording."""
    v, top = motion.v, reference.top
    sign = np.where(np.abs(v) < REST * top, 1, np.where(v > 0.0, 2, 0))
    slow = 3 * (np.abs(v) < SLOW * top) + sign
    ways = np.array([*WAYS, np.inf]) * float(np.ptp(reference.x))  # the last of them is the sign alone
    turned = np.exp(-np.divide.outer(travelled(motion.x, v), ways))
    since = (motion.time - motion.time[0]) / float(np.ptp(reference.time))
    found = {
        "always": np.ones((len(v), 1)),
        "sign of speed": _cells(sign, 3),
        "low speed": _cells(slow, 6),
        "reversal": np.sign(v)[:, None] * turned,
        "speed": _binned(v, reference.v),
        "position": _binned(motion.x, reference.x),
        "time": _cells(np.minimum((EIGHTHS * since).astype(int), EIGHTHS - 1), EIGHTHS),
    }
    if float(np.ptp(reference.x)) > 0.5 * np.pi:
        for order in range(1, ORDERS + 1):
            found[f"angle order {order}"] = np.column_stack([np.cos(order * motion.x), np.sin(order * motion.x)])
    return found


def _best(left: Left, columns: dict[str, Array], per_number: float) -> str | None:
    """The simplest of the conditions that gain most, where any is worth its numbers (half of ``per_number`` each)."""
    gains = {}
    for name, own in columns.items():
        everything = np.full(own.shape[1], np.inf)
        gains[name] = left.explained(own, -everything, everything)[0] - 0.5 * per_number * own.shape[1]
    most = max(gains.values())
    if most < WORTH:
        return None
    good = [name for name, gain in gains.items() if gain >= SIMPLER * most]
    return min(good, key=lambda name: (columns[name].shape[1], -gains[name]))


def _columns(bench: FilterBench, p: Array, latent: Latent, weights: dict[str, Array]) -> dict[str, Array]:
    pushes = np.flatnonzero(latent.direction)
    each = np.hstack(list(weights.values()))
    names = tuple(bench.kernel.parameters[i] for i in pushes for _ in range(each.shape[1]))
    found = whitened(bench.filtered(p, names, np.tile(each, len(pushes))))
    found = found.reshape(-1, len(pushes), each.shape[1])
    together = np.einsum("ijk,j->ik", found, latent.direction[pushes])
    ends = np.cumsum([w.shape[1] for w in weights.values()])
    return dict(zip(weights, np.split(together, ends[:-1], axis=1), strict=True))


def motion_of(bench: FilterBench, p: Array, latent: Latent, top: float | None) -> Motion:
    n = len(latent.motion)
    states = bench.filtered(p).states
    v = states[:, n : 2 * n] @ latent.motion
    usual = max(float(np.quantile(np.abs(v), 0.95)), 1e-300)
    return Motion(states[:, :n] @ latent.motion, v, bench.signals.time, usual if top is None else top)


def _cells(index: NDArray[np.integer], count: int) -> Array:
    return np.asarray(np.equal.outer(index, np.arange(count)), dtype=np.float64)


def _binned(values: Array, reference: Array) -> Array:
    edges = np.quantile(reference, np.linspace(0.0, 1.0, BINS + 1)[1:-1])
    return _cells(np.digitize(values, edges), BINS)
