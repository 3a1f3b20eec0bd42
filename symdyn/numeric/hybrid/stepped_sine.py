"""The frequency response that a sine of a given amplitude measures, one frequency after another."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symdyn.base.errors import Problem, UsageError
from symdyn.base.wording import did_you_mean
from symdyn.numeric.hybrid.fourier import Cycle, listener, settle
from symdyn.numeric.hybrid.machine import Machine
from symdyn.numeric.hybrid.signals import Signal, constant, sine

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

HARMONICS = 7
SAMPLES = 1024  # of a period, where the exact way is not possible
SETTLED = 1e-6  # relative change of the harmonics at which a period counts as the last
MOST_PERIODS = 4096

Progress = Callable[[str], None]


@dataclass(frozen=True, slots=True, eq=False)
class SteppedSine:
    """Harmonics of the output, (N, 7) complex, for ``amplitude`` sin(2 pi f t) at the input, f in ``hertz`` (N,)."""

    input: str
    output: str
    amplitude: float
    hertz: Array
    harmonics: Complex
    periods: NDArray[np.int64]  # simulated at each frequency
    settled: NDArray[np.bool_]
    events: NDArray[np.int64]  # in the last period

    @property
    def values(self) -> Complex:
        """(N,) the fundamental over the input: the describing function of the machine."""
        return self.harmonics[:, 0] / (-1j * self.amplitude)

    @property
    def odd(self) -> Array:
        """(N,) root of the sum of squares of harmonics 3, 5, 7, over the fundamental; 0 where nothing moves."""
        return _distortion(self.harmonics, slice(2, None, 2))

    @property
    def even(self) -> Array:
        """(N,) the same of harmonics 2, 4, 6."""
        return _distortion(self.harmonics, slice(1, None, 2))


def stepped_sine(
    machine: Machine,
    hertz: Array,
    amplitude: float,
    input: str | None = None,
    output: str | None = None,
    *,
    start: Array | None = None,
    held: Sequence[float] | None = None,
    settled: float = SETTLED,
    most_periods: int = MOST_PERIODS,
    tolerance: float = 1e-8,
    progress: Progress = lambda text: None,
) -> SteppedSine:
    """Simulate each frequency from ``start`` (nx,) (rest by default) until it repeats, then take its harmonics.

    ``held`` (nu,) are values of the inputs that the sine is added to. Machines that are affine in every mode are
    correlated exactly, events included; others by samples, simulated to ``tolerance``.

    Raises UsageError: SD302 for an amplitude or frequencies that are not positive and finite, SD305 for unknown names.
    """
    hertz = np.atleast_1d(np.asarray(hertz, dtype=np.float64))
    if not (np.isfinite(amplitude) and amplitude > 0.0 and np.all(np.isfinite(hertz)) and np.all(hertz > 0.0)):
        raise UsageError(Problem("SD302", "an amplitude and frequencies must be positive and finite"))
    heard = listener(machine, output, HARMONICS, exact=True, samples=SAMPLES, tolerance=tolerance)
    chosen, signals = inputs_of(machine, input, held)
    k = machine.kernel.inputs.index(chosen)
    x = np.zeros(len(machine.kernel.states)) if start is None else np.asarray(start, dtype=np.float64)
    offset = 0.0 if held is None else float(held[k])
    cycles: list[Cycle] = []
    for i, f in enumerate(map(float, hertz)):
        progress(f"{f:.4g} Hz, {i + 1} of {len(hertz)}")
        signals[k] = sine(amplitude, f, offset=offset)
        cycles.append(settle(heard, signals, 1.0 / f, x, settled, most_periods))
    return SteppedSine(
        chosen, heard.output, amplitude, hertz, np.stack([c.harmonics for c in cycles]),
        np.array([c.periods for c in cycles]), np.array([c.settled for c in cycles]),
        np.array([c.events for c in cycles]),
    )  # fmt: skip


def inputs_of(machine: Machine, input: str | None, held: Sequence[float] | None) -> tuple[str, list[Signal]]:
    """The name of the input, the first where none is given, and all inputs held at their values.

    Raises UsageError (SD305) for a name that the machine does not have.
    """
    known = machine.kernel.inputs
    if not known:
        raise UsageError(Problem("SD305", "the machine has no inputs"))
    chosen = input if input is not None else known[0]
    if chosen not in known:
        raise UsageError(Problem("SD305", f"no input `{chosen}`", hint=did_you_mean(chosen, known, "inputs")))
    return chosen, [constant(0.0 if held is None else float(held[k])) for k in range(len(known))]


def _distortion(harmonics: Complex, part: slice) -> Array:
    size, fundamental = np.linalg.norm(harmonics[:, part], axis=1), np.abs(harmonics[:, 0])
    return np.asarray(np.divide(size, fundamental, out=np.zeros_like(size), where=fundamental > 0.0), np.float64)
