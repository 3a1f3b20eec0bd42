"""The spans of a trajectory: between events, reporting times and changes of the inputs, where nothing switches."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.hybrid.machine import Machine
from symdyn.numeric.hybrid.trajectory import HybridTrajectory

Array = NDArray[np.float64]

ROUNDING = 1e-14  # of a time: an event at the end of a stretch of inputs still belongs to it


@dataclass(frozen=True, slots=True)
class Span:
    """From ``first`` to ``last`` in s with the switches (S,) given; ``begun`` is when the course of the inputs began.

    ``row`` is the reporting time that ends it, None where an event does.
    """

    first: float
    last: float
    begun: float
    switches: tuple[int, ...]
    row: int | None


def spans(trajectory: HybridTrajectory, names: Sequence[str], kinds: Sequence[str]) -> Iterator[Span]:
    """In order of time; ``names`` and ``kinds`` are those of the machine's switches."""
    place = {pair: k for k, pair in enumerate(zip(names, kinds, strict=True))}
    marks: list[tuple[float, int, int]] = []  # time, what, which
    marks += [(e.time - ROUNDING * max(1.0, abs(e.time)), 0, k) for k, e in enumerate(trajectory.events)]
    marks += [(b.time, 1, k) for k, b in enumerate(trajectory.beginnings)]
    marks += [(float(t), 2, k) for k, t in enumerate(trajectory.time)]
    now = begun = float(trajectory.time[0])
    state: list[int] = []
    for time, what, which in sorted(marks):
        row = which if what == 2 and which > 0 else None
        if time > now or row is not None:
            yield Span(now, max(time, now), begun, tuple(state), row)
            now = max(time, now)
        if what == 0:
            event = trajectory.events[which]
            state[place[event.switch, event.kind]] = event.after
        elif what == 1:
            begun, state = time, list(trajectory.beginnings[which].switches)


def divided_at(instants: Array, found: Iterable[Span], close: float) -> Iterator[Span]:
    """Spans that end at the ``instants`` (M,), too, unless they do so within ``close`` already, in s."""
    for span in found:
        first = span.first
        inside = slice(*np.searchsorted(instants, [span.first + close, span.last - close]))
        for instant in instants[inside]:
            if instant > first + close:
                yield replace(span, first=first, last=float(instant), row=None)
                first = float(instant)
        yield replace(span, first=first)


def mode_of(switches: Sequence[int]) -> Array:
    """The modes that the functions of a kernel take: a contact that does not push is open."""
    return np.array([0.0 if abs(k) == 2 else float(k) for k in switches])


def settled(machine: Machine, switches: Sequence[int], x: Array, u: Array) -> Array:
    """x with the speeds of frictions that stick put to zero, along what the frictions do."""
    stuck = [k for k in range(machine.count("friction")) if switches[k] == 0]
    if not stuck:
        return x
    s = mode_of(switches)
    levers = machine.call("guards_state_jacobian", x, u, s)[stuck]
    pull = machine.call("state_derivative_friction_jacobian", x, u, s)[:, stuck]
    return np.asarray(x - pull @ np.linalg.solve(levers @ pull, levers @ x))
