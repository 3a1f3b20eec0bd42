"""Inputs as people write them on the command line: NAME=5, NAME=sine:1,0.2, NAME=step:1,0.5 ..."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

from symdyn.base.errors import Problem, UsageError
from symdyn.base.wording import did_you_mean
from symdyn.numeric.hybrid.signals import Signal, constant, ramp, sine, step, trapezoid


class Shape(NamedTuple):
    """A way to write an input: how many numbers follow it at least and at most, and what they are."""

    make: Callable[..., Signal]
    least: int
    most: int
    words: str


SHAPES: Mapping[str, Shape] = {
    "constant": Shape(constant, 1, 1, "VALUE"),
    "step": Shape(step, 1, 3, "VALUE[,TIME[,BEFORE]]"),
    "ramp": Shape(ramp, 1, 2, "RATE[,UNTIL]"),
    "sine": Shape(sine, 2, 4, "AMPLITUDE,HERTZ[,PHASE[,OFFSET]]"),
    "trapezoid": Shape(trapezoid, 3, 3, "DISTANCE,SPEED,ACCELERATION"),
}
HELP = "; ".join(f"{name}:{shape.words}" for name, shape in SHAPES.items())


def read_signals(given: Sequence[str], names: Sequence[str], option: str = "--input") -> list[Signal]:
    """One signal per name, zero where none is given.

    Raises UsageError (SD305) for an unknown name or shape, a number that is none, and too few or too many of them.
    """
    found = {name: constant(0.0) for name in names}
    for item in given:
        name, _, text = item.partition("=")
        if name not in found:
            raise UsageError(Problem("SD305", f"{option} {item}: no such name", hint=f"known: {', '.join(names)}"))
        found[name] = _read(item, text, option)
    return [found[name] for name in names]


def _read(item: str, text: str, option: str) -> Signal:
    kind, colon, rest = text.partition(":")
    if not colon:
        kind, rest = "constant", text
    shape = SHAPES.get(kind)
    if shape is None:
        hint = did_you_mean(kind, list(SHAPES), "shapes")
        raise UsageError(Problem("SD305", f"{option} {item}: no shape {kind!r}", hint=hint))
    numbers = [_number(part, item, option) for part in rest.split(",")]
    if not shape.least <= len(numbers) <= shape.most:
        raise UsageError(Problem("SD305", f"{option} {item}: {len(numbers)} numbers", hint=f"{kind}:{shape.words}"))
    if kind == "trapezoid" and min(numbers[1:]) <= 0.0:
        raise UsageError(Problem("SD305", f"{option} {item}: speed and acceleration must be positive"))
    return shape.make(*numbers)


def _number(text: str, item: str, option: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise UsageError(Problem("SD305", f"{option} {item}: {text!r} is no finite number"))
    return value
