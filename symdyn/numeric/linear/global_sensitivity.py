"""Global sensitivities over ranges of the parameters: Morris's elementary effects, Sobol's indices (by SALib)."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import ModuleType
from typing import Any

import numpy as np

from symdyn.base.errors import InputError, NumericalError, Problem, UsageError
from symdyn.base.linear_system import Array, LinearFamily
from symdyn.numeric.linear.scalars import Scalar
from symdyn.numeric.linear.spread_evaluation import row_of

SPREAD = 0.2  # relative half-width of the range of a parameter for which none is declared
LEVELS = 4  # of Morris's grid
CONFIDENCE = 0.95

Ranges = Mapping[str, tuple[float, float]]
Progress = Callable[[str], None]
Evaluated = Callable[[Sequence[str], Array, Progress], Array]  # names, points -> numbers, a row per point


@dataclass(frozen=True, slots=True)
class MorrisEffect:
    """Of one parameter on one number, over its whole range: mean size ``mu_star`` (with the half-width of its
    interval), mean ``mu``, and ``sigma``: large beside mu_star where it acts in a curved way or together with others.
    """

    parameter: str
    mu_star: float
    mu_star_interval: float
    mu: float
    sigma: float


@dataclass(frozen=True, slots=True)
class SobolIndex:
    """Share of the variance that one parameter causes alone, and in all; half-widths of the intervals."""

    parameter: str
    first: float
    first_interval: float
    total: float
    total_interval: float


@dataclass(frozen=True, slots=True)
class GlobalSensitivity:
    """``table`` has the rows of each number by its name, most important first; ``evaluations`` of the model."""

    method: str
    ranges: Ranges
    evaluations: int
    table: Mapping[str, tuple[MorrisEffect, ...] | tuple[SobolIndex, ...]]


def default_ranges(
    family: LinearFamily, spread: float = SPREAD, parameters: Sequence[str] = ()
) -> dict[str, tuple[float, float]]:
    """Nominal value -+ ``spread``, of those named or of all that are not zero and in the linear model."""
    ranges = {}
    used = family.derivatives(family.values).used
    for name, value, moves in zip(family.parameters, family.values, used, strict=True):
        if value != 0 and (name in parameters if parameters else moves):
            low, high = sorted((value * (1 - spread), value * (1 + spread)))
            ranges[name] = (float(low), float(high))
    return ranges


def morris(
    family: LinearFamily,
    outputs: Sequence[Scalar],
    ranges: Ranges,
    trajectories: int = 20,
    seed: int = 0,
    progress: Progress = lambda _: None,
    evaluated: Evaluated | None = None,
) -> GlobalSensitivity:
    """Elementary effects (Morris 1991; Campolongo et al. 2007); the same seed gives the same numbers.

    ``evaluated`` finds the numbers of all models at once, elsewhere (``Spread``); None: one after the other, here.

    Raises UsageError (SD306) without SALib, InputError (SD307) for a range that is none, NumericalError (SD611) where
    a number is not finite somewhere in the ranges.
    """
    sample, analyze = _salib("morris")
    problem = _problem(family, ranges)
    points = sample.sample(problem, trajectories, num_levels=LEVELS, seed=_own(seed))
    values = _evaluated(family, outputs, list(ranges), points, progress, evaluated)
    table = {}
    for scalar, column in zip(outputs, values.T, strict=True):
        found = analyze.analyze(problem, points, column, num_levels=LEVELS, conf_level=CONFIDENCE, seed=_own(seed))
        columns = (found[key] for key in ("names", "mu_star", "mu_star_conf", "mu", "sigma"))
        rows = [MorrisEffect(str(n), *map(float, numbers)) for n, *numbers in zip(*columns, strict=True)]
        table[scalar.name] = tuple(sorted(rows, key=lambda row: -row.mu_star))
    return GlobalSensitivity("morris", dict(ranges), len(points), table)


def sobol(
    family: LinearFamily,
    outputs: Sequence[Scalar],
    ranges: Ranges,
    samples: int = 256,
    seed: int = 0,
    progress: Progress = lambda _: None,
    evaluated: Evaluated | None = None,
) -> GlobalSensitivity:
    """First-order and total indices (Saltelli et al. 2010), from ``samples`` (a power of two) per parameter.

    Errors as those of ``morris``, and UsageError (SD302) for a number of samples that is no power of two.
    """
    if samples < 2 or samples & (samples - 1):
        raise UsageError(Problem("SD302", f"Sobol's sequence needs a power of two, not {samples} samples"))
    sample, analyze = _salib("sobol")
    problem = _problem(family, ranges)
    points = sample.sample(problem, samples, calc_second_order=False, seed=_own(seed))
    values = _evaluated(family, outputs, list(ranges), points, progress, evaluated)
    table = {}
    for scalar, column in zip(outputs, values.T, strict=True):
        if np.ptp(column) == 0.0:
            zero = [SobolIndex(name, 0.0, 0.0, 0.0, 0.0) for name in ranges]
            table[scalar.name] = tuple(zero)
            continue
        found = analyze.analyze(problem, column, calc_second_order=False, conf_level=CONFIDENCE, seed=_own(seed))
        columns = (found[key] for key in ("S1", "S1_conf", "ST", "ST_conf"))
        rows = [SobolIndex(n, *map(float, numbers)) for n, *numbers in zip(ranges, *columns, strict=True)]
        table[scalar.name] = tuple(sorted(rows, key=lambda row: -row.total))
    return GlobalSensitivity("sobol", dict(ranges), len(points), table)


def _salib(method: str) -> tuple[ModuleType, ModuleType]:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of its own dependencies, when they are imported
            import SALib.analyze.morris
            import SALib.analyze.sobol
            import SALib.sample.morris
            import SALib.sample.sobol
    except ImportError:
        hint = "pip install 'symdyn[sensitivity]'"
        raise UsageError(Problem("SD306", "global sensitivities need SALib", hint=hint)) from None
    return getattr(SALib.sample, method), getattr(SALib.analyze, method)


def _own(seed: int) -> int:
    """SALib takes the seed 0 for none."""
    return seed + 1


def _problem(family: LinearFamily, ranges: Ranges) -> dict[str, Any]:
    wrong = []
    for name, (low, high) in ranges.items():
        if name not in family.parameters:
            wrong.append(Problem("SD307", f"no parameter `{name}`"))
        elif not (np.isfinite(low) and np.isfinite(high) and low < high):
            wrong.append(Problem("SD307", f"{name}: {low:g} to {high:g} is no range"))
    if not ranges:
        wrong.append(Problem("SD307", "there is no parameter to vary"))
    if wrong:
        raise InputError(wrong)
    return {"num_vars": len(ranges), "names": list(ranges), "bounds": [list(r) for r in ranges.values()]}


def _evaluated(
    family: LinearFamily,
    outputs: Sequence[Scalar],
    names: Sequence[str],
    points: Array,
    progress: Progress,
    evaluated: Evaluated | None,
) -> Array:
    """(number of points, number of outputs)."""
    values = (
        _one_by_one(family, outputs, names, points, progress)
        if evaluated is None
        else evaluated(names, points, progress)
    )
    bad = np.argwhere(~np.isfinite(values))
    if len(bad):
        i, j = bad[0]
        where = ", ".join(f"{n} = {v:.4g}" for n, v in zip(names, points[i], strict=True))
        hint = "narrow the ranges, so that every mode stays one"
        raise NumericalError(Problem("SD611", f"{outputs[j].name} does not exist at {where}", hint=hint))
    return values


def _one_by_one(
    family: LinearFamily, outputs: Sequence[Scalar], names: Sequence[str], points: Array, progress: Progress
) -> Array:
    at = [family.index(name) for name in names]
    values = np.empty((len(points), len(outputs)))
    shown = -1
    for i, point in enumerate(points):
        percent = 100 * i // len(points)
        if percent > shown:
            shown = percent
            progress(f"step {i} of {len(points)} models")
        values[i] = row_of(family, outputs, at, point)
    return values
