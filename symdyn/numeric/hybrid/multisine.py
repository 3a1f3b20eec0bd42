"""The best linear approximation and the distortions that random-phase multisines on an odd grid measure.

Pintelon and Schoukens, System Identification: A Frequency Domain Approach, 2nd ed. 2012, chapters 3 and 4.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symdyn.base.errors import Problem, UsageError
from symdyn.numeric.hybrid.fourier import listener, settle
from symdyn.numeric.hybrid.machine import Machine
from symdyn.numeric.hybrid.signals import Piece, Signal
from symdyn.numeric.hybrid.stepped_sine import SETTLED, inputs_of

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Ints = NDArray[np.int64]

GROUP = 4  # of this many odd lines in a row, one is a detection line
HIGHEST = 8192  # harmonic of the lowest frequency
OVERSAMPLING = 32  # samples per period of the highest line
MOST_PERIODS = 128

Progress = Callable[[str], None]


@dataclass(frozen=True, slots=True, eq=False)
class Grid:
    """Odd harmonics of ``lowest`` in Hz: those that are excited, and those left out to see odd distortion."""

    lowest: float
    excited: Ints
    detection: Ints

    @property
    def even(self) -> Ints:
        """The even harmonics above each of them, where even distortion is seen."""
        return np.sort(np.concatenate([self.excited, self.detection])) + 1


@dataclass(frozen=True, slots=True, eq=False)
class Multisine:
    """Responses (M, E) of M realisations at the excited lines; outputs at lines where only distortion can be."""

    input: str
    output: str
    amplitude: float  # of the sine of the same power
    grid: Grid
    responses: Complex  # (M, E)
    level: Array  # (E,) r.m.s. over realisations of |output| at the excited lines
    odd: Array  # (D,) the same at the detection lines
    even: Array  # (F,) at the even lines
    periods: Ints  # (M,)
    settled: NDArray[np.bool_]  # (M,)

    @property
    def hertz(self) -> Array:
        return np.asarray(self.grid.lowest * self.grid.excited, np.float64)

    @property
    def values(self) -> Complex:
        """(E,) the best linear approximation: the mean over realisations."""
        return np.asarray(self.responses.mean(axis=0), np.complex128)

    @property
    def deviation(self) -> Array:
        """(E,) of one realisation, by its phases: stochastic nonlinear distortion, for there is no noise."""
        if len(self.responses) < 2:
            return np.full(self.responses.shape[1], np.nan)
        return np.asarray(np.std(self.responses, axis=0, ddof=1), np.float64)


def odd_grid(low: float, high: float, lines: int, seed: int = 0) -> Grid:
    """About ``lines`` odd harmonics of ``low``, evenly spaced in their logarithm, one in four left out at random.

    Raises UsageError (SD302) for a band that is empty or too wide, and fewer than four lines.
    """
    if not (np.isfinite(high) and 0 < low < high and high <= HIGHEST * low and lines >= GROUP):
        raise UsageError(
            Problem("SD302", f"a multisine from {low:g} to {high:g} Hz with {lines} lines",
                    hint=f"0 < from < to, to at most {HIGHEST} times from, {GROUP} lines or more")
        )  # fmt: skip
    wanted = np.geomspace(1.0, high / low, lines)
    odd = np.unique(2 * np.round((wanted - 1.0) / 2.0).astype(np.int64) + 1)
    odd = odd[odd <= high / low]
    rng = np.random.default_rng(seed)
    out = np.array([k + int(rng.integers(GROUP)) for k in range(0, len(odd) - GROUP + 1, GROUP)], np.int64)
    return Grid(low, np.delete(odd, out), odd[out])


def random_phases(grid: Grid, amplitude: float, offset: float, seed: int, realisation: int) -> Piece:
    """A multisine on the excited lines, each of the same size, with the power of a sine of ``amplitude``."""
    phases = np.random.default_rng([seed, realisation]).uniform(0.0, 2 * np.pi, len(grid.excited))
    size = amplitude / np.sqrt(len(grid.excited))
    omega = 2 * np.pi * grid.lowest * grid.excited
    return Piece(0.0, (offset,), tuple((size, float(w), float(p)) for w, p in zip(omega, phases, strict=True)))


def multisine_response(
    machine: Machine,
    grid: Grid,
    amplitude: float,
    input: str | None = None,
    output: str | None = None,
    *,
    realisations: int = 4,
    seed: int = 0,
    start: Array | None = None,
    held: Sequence[float] | None = None,
    settled: float = SETTLED,
    most_periods: int = MOST_PERIODS,
    tolerance: float = 1e-8,
    progress: Progress = lambda text: None,
) -> Multisine:
    """Simulate realisations of the phases until they repeat; the same ``seed`` gives the same numbers.

    ``held`` (nu,) are values of the inputs that the multisine is added to. The output is sampled 32 times or more per
    period of the highest line.

    Raises UsageError: SD302 for an amplitude or a number of realisations that is not positive, SD305 for unknown names.
    """
    if not (np.isfinite(amplitude) and amplitude > 0.0 and realisations >= 1):
        raise UsageError(Problem("SD302", "an amplitude and a number of realisations must be positive"))
    highest = int(grid.even[-1])
    samples = 1 << int(np.ceil(np.log2(OVERSAMPLING * highest)))
    heard = listener(machine, output, highest, exact=False, samples=samples, tolerance=tolerance)
    chosen, signals = inputs_of(machine, input, held)
    k = machine.kernel.inputs.index(chosen)
    x = np.zeros(len(machine.kernel.states)) if start is None else np.asarray(start, dtype=np.float64)
    offset = 0.0 if held is None else float(held[k])
    outputs, responses, periods, calm = [], [], [], []
    for r in range(realisations):
        progress(f"realisation {r + 1} of {realisations}")
        piece = random_phases(grid, amplitude, offset, seed, r)
        signals[k] = Signal((piece,))
        found = settle(heard, signals, 1.0 / grid.lowest, x, settled, most_periods)
        given = np.array([-1j * a * np.exp(1j * p) for a, _, p in piece.sines])
        outputs.append(found.harmonics)
        responses.append(found.harmonics[grid.excited - 1] / given)
        periods.append(found.periods)
        calm.append(found.settled)
    level = np.sqrt(np.mean(np.abs(np.stack(outputs)) ** 2, axis=0))
    return Multisine(
        chosen, heard.output, amplitude, grid, np.stack(responses), level[grid.excited - 1], level[grid.detection - 1],
        level[grid.even - 1], np.array(periods), np.array(calm),
    )  # fmt: skip
