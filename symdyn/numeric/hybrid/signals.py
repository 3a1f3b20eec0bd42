"""Inputs as pieces of linear systems: constants, ramps, polynomials and sines, which are propagated exactly."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symdyn.base.errors import InputError, Problem

Array = NDArray[np.float64]

MOST_PIECES = 1_000_000


@dataclass(frozen=True, slots=True)
class Piece:
    """From ``start`` on: value = sum of powers[k] t^k / k! + sum of a sin(omega t + phase), t since ``start``."""

    start: float
    powers: tuple[float, ...] = (0.0,)
    sines: tuple[tuple[float, float, float], ...] = ()  # (amplitude, omega in rad/s, phase in rad)

    def at(self, time: Array) -> Array:
        t = np.asarray(time, dtype=np.float64) - self.start
        value, factor = np.zeros_like(t), np.ones_like(t)
        for k, coefficient in enumerate(self.powers):
            value += coefficient * factor
            factor = factor * t / (k + 1)
        for amplitude, omega, phase in self.sines:
            value += amplitude * np.sin(omega * t + phase)
        return value

    def since(self, now: float) -> Piece:
        """The same, with time counted from ``now``."""
        t = now - self.start
        powers = tuple(
            sum(c * t ** (j - i) / math.factorial(j - i) for j, c in enumerate(self.powers) if j >= i)
            for i in range(len(self.powers))
        )
        return Piece(now, powers, tuple((a, omega, omega * t + phase) for a, omega, phase in self.sines))


@dataclass(frozen=True, slots=True)
class Signal:
    """One input over time: pieces in order of their start, the first of which also holds before it."""

    pieces: tuple[Piece, ...]

    def at(self, time: Array) -> Array:
        """Values at times, shape as given; a piece holds from its start on."""
        time = np.asarray(time, dtype=np.float64)
        starts = np.array([piece.start for piece in self.pieces])
        which = np.clip(np.searchsorted(starts, time, side="right") - 1, 0, None)
        value = np.zeros_like(time)
        for k, piece in enumerate(self.pieces):
            here = which == k
            value[here] = piece.at(time[here])
        return value

    def piece_at(self, time: float) -> Piece:
        held = [piece for piece in self.pieces if piece.start <= time]
        return held[-1] if held else self.pieces[0]


def constant(value: float) -> Signal:
    return Signal((Piece(0.0, (value,)),))


def step(value: float, at: float = 0.0, before: float = 0.0) -> Signal:
    """``before`` until the time ``at``, then ``value``."""
    first = () if at <= 0.0 else (Piece(0.0, (before,)),)
    return Signal((*first, Piece(max(at, 0.0), (value,))))


def ramp(rate: float, until: float | None = None) -> Signal:
    """Rises with ``rate`` from 0, and stays where it is from ``until`` on."""
    pieces = [Piece(0.0, (0.0, rate))]
    if until is not None:
        pieces.append(Piece(until, (rate * until,)))
    return Signal(tuple(pieces))


def sine(amplitude: float, hertz: float, phase: float = 0.0, offset: float = 0.0) -> Signal:
    return Signal((Piece(0.0, (offset,), ((amplitude, 2 * np.pi * hertz, phase),)),))


def multisine(amplitudes: Sequence[float], hertz: Sequence[float], phases: Sequence[float]) -> Signal:
    parts = tuple((a, 2 * np.pi * f, p) for a, f, p in zip(amplitudes, hertz, phases, strict=True))
    return Signal((Piece(0.0, (0.0,), parts),))


def flat_multisine(amplitude: float, lowest: float, highest: float, lines: int) -> Signal:
    """``lines`` sines, evenly spaced from ``lowest`` to ``highest`` in Hz, together with the power of one of
    ``amplitude``; their phases keep the crests low (Schroeder 1970)."""
    k = np.arange(lines)
    hertz = np.linspace(lowest, highest, lines)
    return multisine([amplitude / math.sqrt(lines)] * lines, hertz.tolist(), (-np.pi * k * (k + 1) / lines).tolist())


def chirp(amplitude: float, first: float, last: float, duration: float, offset: float = 0.0) -> Signal:
    """A sine whose frequency goes from ``first`` to ``last`` in Hz at a steady rate, and then stays.

    In pieces that are polynomials of degree 7, a sixteenth of the shortest period long: to 1e-12 of the amplitude.
    Raises InputError (SD302) where these are too many.
    """
    count = max(1, math.ceil(min(16.0 * max(abs(first), abs(last)) * duration, 2.0 * MOST_PIECES)))
    if count > MOST_PIECES:
        what = f"a chirp of {max(abs(first), abs(last)) * duration:.3g} periods is longer than can be simulated"
        raise InputError(Problem("SD302", what, hint="make it shorter, or its last frequency lower"))
    length = duration / count
    nodes = np.polynomial.chebyshev.chebpts1(8)
    to_powers = np.linalg.inv(np.vander(0.5 * (nodes + 1.0), increasing=True))
    rate = (last - first) / duration

    def phase(t: Array) -> Array:
        return 2.0 * np.pi * (first + 0.5 * rate * t) * t

    starts = length * np.arange(count)
    values = amplitude * np.sin(phase(starts[:, None] + 0.5 * length * (nodes + 1.0)))
    shares = values @ to_powers.T / length ** np.arange(8) * [math.factorial(k) for k in range(8)]
    shares[:, 0] += offset
    pieces = [Piece(float(start), tuple(row)) for start, row in zip(starts, shares.tolist(), strict=True)]
    end = ((amplitude, 2.0 * np.pi * last, float(phase(np.array(duration)))),)
    return Signal((*pieces, Piece(duration, (offset,), end)))


def trapezoid(distance: float, speed: float, acceleration: float) -> Signal:
    """From 0 to ``distance`` with trapezoidal speed, then at rest; ``speed`` and ``acceleration`` are its limits."""
    way, length = (1.0 if distance >= 0 else -1.0), abs(distance)
    rise = min(speed / acceleration, (length / acceleration) ** 0.5)
    top = acceleration * rise
    cruise = (length - top * rise) / top if top > 0.0 else 0.0
    ends = (rise, rise + cruise, 2 * rise + cruise)
    covered = 0.5 * acceleration * rise**2
    return Signal(
        (
            Piece(0.0, (0.0, 0.0, way * acceleration)),
            Piece(ends[0], (way * covered, way * top)),
            Piece(ends[1], (way * (covered + top * cruise), way * top, -way * acceleration)),
            Piece(ends[2], (distance,)),
        )
    )


def sampled(time: Array, values: Array, hold: bool = False) -> Signal:
    """Through given points: straight lines between them, or each held until the next."""
    pieces = []
    for k, (t, value) in enumerate(zip(time, values, strict=True)):
        last = k + 1 == len(time)
        rate = 0.0 if hold or last else float((values[k + 1] - value) / (time[k + 1] - t))
        pieces.append(Piece(float(t), (float(value), rate)))
    return Signal(tuple(pieces))


def exosystem(pieces: Sequence[Piece], now: float) -> tuple[Array, Array, Array]:
    """(S, U, w): dw/dt = S w makes the inputs u = U w, one of each piece; w (m,) is its state at time ``now``."""
    blocks: list[tuple[Array, Array, Array, int]] = []
    for k, piece in enumerate(pieces):
        here = piece.since(now)
        values = here.powers
        size = len(values)
        shift = np.eye(size, k=1)
        blocks.append((shift, np.eye(1, size)[0], np.array(values, dtype=np.float64), k))
        for amplitude, omega, phase in here.sines:
            turn = np.array([[0.0, omega], [-omega, 0.0]])
            start = amplitude * np.array([np.sin(phase), np.cos(phase)])
            blocks.append((turn, np.array([1.0, 0.0]), start, k))
    size = sum(len(b[2]) for b in blocks)
    system, output, start = np.zeros((size, size)), np.zeros((len(pieces), size)), np.zeros(size)
    at = 0
    for matrix, row, value, k in blocks:
        span = slice(at, at + len(value))
        system[span, span], output[k, span], start[span] = matrix, row, value
        at += len(value)
    return system, output, start
