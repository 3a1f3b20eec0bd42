"""Inputs as pieces of linear systems: constants, ramps, polynomials and sines, which are propagated exactly."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


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
