"""Several recordings as one, and one recording as two: what is fitted, and what judges."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from symdyn.base.errors import InputError, Problem
from symdyn.numeric.recording import ChannelKey, Recording, frozen
from symdyn.numeric.recording_time import GAP_STEPS, MIN_SAMPLES
from symdyn.spec.records import Quantity

Array = NDArray[np.float64]
Runs = Recording | Sequence[Recording]

BLOCKS = 9  # of a recording that is to judge itself; every third of them judges
FEWEST_BLOCKS = 3  # of a short one
GAP = 0.1  # part of a block that is left out where fitting and judging would touch
SAME_RATE = 0.01


def training_and_heldout(training: Runs, heldout: Runs | None) -> tuple[Recording, Recording]:
    """What is fitted and what judges: recordings as given, or blocks of the training ones (``split``).

    Raises InputError (SD526, SD527) where recordings do not go together or are too short to be split.
    """
    runs = _listed(training)
    if heldout is not None:
        return joined(runs), joined(_listed(heldout))
    pairs = [split(run) for run in runs]
    return joined([fitted for fitted, _ in pairs]), joined([judge for _, judge in pairs])


def doubts(*runs: Runs | None) -> list[str]:
    """What is suspect about recordings, or was put right as they were read, each with the recording's name."""
    each = [run for some in runs if some is not None for run in _listed(some)]
    return [f"{run.name}: {warning.message}" for run in each for warning in run.warnings]


def joined(runs: Sequence[Recording]) -> Recording:
    """One recording of several runs, each a segment (or more) of its own; later runs are moved in time behind earlier.

    Raises InputError (SD526) for runs of different sampling rates or that measure different things.
    """
    first = runs[0]
    if len(runs) == 1:
        return first
    problems = [problem for run in runs[1:] for problem in _misfits(first, run)]
    if problems:
        raise InputError(problems)
    step = first.sample_time
    times, segments, start, samples = [], [], 0.0, 0
    for run in runs:
        times.append(run.time - run.time[0] + start)
        segments += [slice(part.start + samples, part.stop + samples) for part in run.segments]
        start, samples = float(times[-1][-1]) + 2.0 * GAP_STEPS * step, samples + len(run.time)
    return Recording(
        name=", ".join(run.name for run in runs),
        time=frozen(np.concatenate(times)),
        channels=MappingProxyType(
            {key: frozen(np.concatenate([run.channels[key] for run in runs])) for key in _shared(runs)}
        ),
        sample_time=step,
        segments=tuple(segments),
        warnings=tuple(warning for run in runs for warning in run.warnings),
        sha256=hashlib.sha256("".join(run.sha256 for run in runs).encode()).hexdigest(),
    )


def split(recording: Recording) -> tuple[Recording, Recording]:
    """(fitted, judging): nine blocks of equal length (three of a short recording), every third of which judges.

    Blocks are contiguous, since neighbouring samples of a machine are alike and a random draw would give
    the judge what was fitted; a tenth of a block is left out on either side of where the two touch.

    Raises InputError (SD527) for a recording too short for that.
    """
    count = len(recording.time)
    blocks = BLOCKS if count >= BLOCKS * MIN_SAMPLES else FEWEST_BLOCKS
    if count < FEWEST_BLOCKS * MIN_SAMPLES:
        message = f"'{recording.name}' has {count} samples, too few to be split into fitted and judging blocks"
        hint = f"give another recording with --holdout, or one of at least {FEWEST_BLOCKS * MIN_SAMPLES} samples"
        raise InputError(Problem("SD527", message, hint=hint))
    edges = np.linspace(0, count, blocks + 1).astype(int)
    margin = max(1, round(GAP * count / blocks / 2))
    judging, fitted = [], []
    for first in range(0, blocks, 3):  # two blocks that are fitted, then one that judges
        start, middle, stop = edges[first], edges[first + 2], edges[first + 3]
        fitted.append((start + (margin if first else 0), middle - margin))
        judging.append((middle + margin, stop - (margin if first + 3 < blocks else 0)))
    return _part(recording, fitted, "fitted blocks"), _part(recording, judging, "judging blocks")


def _part(recording: Recording, spans: Sequence[tuple[int, int]], what: str) -> Recording:
    """The samples of these spans; each is a segment, or several where the recording has gaps."""
    pieces = [
        (max(start, part.start), min(stop, part.stop))
        for start, stop in spans
        for part in recording.segments
        if min(stop, part.stop) > max(start, part.start)
    ]
    index = np.concatenate([np.arange(start, stop) for start, stop in pieces])
    ends = np.cumsum([0, *(stop - start for start, stop in pieces)])
    return replace(
        recording,
        name=f"{recording.name} ({what})",
        time=frozen(recording.time[index]),
        channels=MappingProxyType({key: frozen(values[index]) for key, values in recording.channels.items()}),
        segments=tuple(slice(int(a), int(b)) for a, b in pairwise(ends)),
    )


def _misfits(first: Recording, run: Recording) -> list[Problem]:
    problems = []
    if abs(run.sample_time / first.sample_time - 1.0) > SAME_RATE:
        rates = f"{1.0 / first.sample_time:.6g} and {1.0 / run.sample_time:.6g} Hz"
        message = f"recordings '{first.name}' and '{run.name}' were sampled at {rates}"
        problems.append(Problem("SD526", message, hint="resample one of them, or diagnose them one by one"))
    if not _shared([first, run]):
        message = f"recordings '{first.name}' and '{run.name}' measure nothing in common"
        problems.append(Problem("SD526", message, hint="diagnose them one by one"))
    known = [{at for quantity, at, _ in each.channels if quantity is Quantity.PARAMETER} for each in (first, run)]
    if alone := sorted(known[0] ^ known[1]):
        message = f"of recordings '{first.name}' and '{run.name}' one alone tells {', '.join(alone)}"
        problems.append(
            Problem("SD526", message, hint="give the other a column, too: what it does not carry is 0 there")
        )
    return problems


def _shared(runs: Sequence[Recording]) -> list[ChannelKey]:
    """Channels that every run has, in the order of the first."""
    return [key for key in runs[0].channels if all(key in run.channels for run in runs[1:])]


def _listed(runs: Runs) -> list[Recording]:
    return [runs] if isinstance(runs, Recording) else list(runs)
