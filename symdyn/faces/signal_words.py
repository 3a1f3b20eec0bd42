"""Inputs as people write them on the command line: NAME=5, NAME=sine:1,0.2, NAME=step:1,0.5, NAME=file:a.csv ..."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from symdyn.base.errors import Problem, UsageError
from symdyn.base.wording import did_you_mean
from symdyn.numeric.hybrid.signal_file import read_signal
from symdyn.numeric.hybrid.signals import Signal, chirp, constant, flat_multisine, ramp, sine, step, trapezoid


class Shape(NamedTuple):
    """A way to write an input: how many numbers follow it at least and at most, and what they are.

    ``positive`` are the places of those that must be, ``whole`` of those that count something.
    """

    make: Callable[..., Signal]
    least: int
    most: int
    words: str
    positive: tuple[int, ...] = ()
    whole: tuple[int, ...] = ()


SHAPES: Mapping[str, Shape] = {
    "constant": Shape(constant, 1, 1, "VALUE"),
    "step": Shape(step, 1, 3, "VALUE[,TIME[,BEFORE]]"),
    "ramp": Shape(ramp, 1, 2, "RATE[,UNTIL]"),
    "sine": Shape(sine, 2, 4, "AMPLITUDE,HERTZ[,PHASE[,OFFSET]]"),
    "trapezoid": Shape(trapezoid, 3, 3, "DISTANCE,SPEED,ACCELERATION", positive=(1, 2)),
    "chirp": Shape(chirp, 4, 5, "AMPLITUDE,FIRST_HERTZ,LAST_HERTZ,DURATION[,OFFSET]", positive=(3,)),
    "multisine": Shape(
        flat_multisine, 4, 4, "AMPLITUDE,LOWEST_HERTZ,HIGHEST_HERTZ,LINES", positive=(1, 2, 3), whole=(3,)
    ),
}
FILE = "file"
FILE_WORDS = "PATH[,TIME COLUMN,COLUMN]"


def read_signals(
    given: Sequence[str], names: Sequence[str], units: Sequence[str], option: str = "--input"
) -> list[Signal]:
    """One signal per name, zero where none is given; ``units`` are those of the names, for files.

    Raises UsageError (SD305) for an unknown name or shape, a number that is none, and too few or too many of them;
    InputError for a file that does not hold the course of an input, with the place.
    """
    found = {name: constant(0.0) for name in names}
    for item in given:
        name, _, text = item.partition("=")
        if name not in found:
            raise UsageError(Problem("SD305", f"{option} {item}: no such name", hint=f"known: {', '.join(names)}"))
        kind, _, rest = text.partition(":")
        if kind == FILE:
            found[name] = _from_file(item, rest, name, units[list(names).index(name)], option)
        else:
            found[name] = _read(item, text, option)
    return [found[name] for name in names]


def _from_file(item: str, rest: str, name: str, unit: str, option: str) -> Signal:
    """Without columns, those that ``symdyn simulate --out`` writes."""
    path, *columns = rest.split(",")
    if not path or len(columns) not in (0, 2):
        raise UsageError(Problem("SD305", f"{option} {item}: which file, which columns?", hint=f"{FILE}:{FILE_WORDS}"))
    time, column = columns or ("time [s]", f"{name} [{unit}]")
    return read_signal(Path(path), unit, time, column)


def _read(item: str, text: str, option: str) -> Signal:
    kind, colon, rest = text.partition(":")
    if not colon:
        kind, rest = "constant", text
    shape = SHAPES.get(kind)
    if shape is None:
        hint = did_you_mean(kind, [*SHAPES, FILE], "shapes")
        raise UsageError(Problem("SD305", f"{option} {item}: no shape {kind!r}", hint=hint))
    numbers = [_number(part, item, option) for part in rest.split(",")]
    if not shape.least <= len(numbers) <= shape.most:
        raise UsageError(Problem("SD305", f"{option} {item}: {len(numbers)} numbers", hint=f"{kind}:{shape.words}"))
    words = shape.words.replace("[", "").replace("]", "").lower().replace("_", " ").split(",")
    for place in shape.positive:
        if place < len(numbers) and numbers[place] <= 0.0:
            raise UsageError(Problem("SD305", f"{option} {item}: {words[place]} must be positive"))
    for place in shape.whole:
        if numbers[place] != int(numbers[place]):
            raise UsageError(Problem("SD305", f"{option} {item}: {words[place]} must be a whole number"))
    return shape.make(*(int(n) if k in shape.whole else n for k, n in enumerate(numbers)))


def _number(text: str, item: str, option: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise UsageError(Problem("SD305", f"{option} {item}: {text!r} is no finite number"))
    return value
