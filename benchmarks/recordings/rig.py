"""A rig: its model as a first guess would have it, its recordings, and what others have published about it."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from symdyn.compiler import robot_from_text
from symdyn.numeric.recording import ChannelKey, Recording
from symdyn.spec.records import Quantity, Robot, Side

Array = NDArray[np.float64]
Columns = dict[str, Array]

CHECKOUT = Path(__file__).resolve().parents[2]
DIGEST_OF_DERIVED = "0" * 64  # what was cut or joined from files has no file of its own


@dataclass(frozen=True, slots=True)
class Rig:
    """``runs`` reads (training, held out) from the rig's folder; ``split`` says in words how they were divided."""

    name: str
    title: str
    folder: str
    model: Callable[[], str]  # the text of its robot.toml
    runs: Callable[[Robot, Path], tuple[Recording, Recording]]
    split: str
    published: str  # what the sources say is there
    joints: int = 1
    hold: tuple[str, ...] = ()  # what the model is right about
    remark: str = ""  # what a reader must know of the model or of the recording

    def robot(self) -> Robot:
        return robot_from_text(self.model(), f"{self.name}.toml")


def datasets() -> Path:
    """The folder of the recordings: SYMDYN_DATASETS, or ../shared/datasets seen from the checkout."""
    return Path(os.environ.get("SYMDYN_DATASETS") or CHECKOUT.parent / "shared" / "datasets")


def channels(quantities: dict[tuple[str, str], str], *, time: str = "t") -> str:
    """The [recording] part of a model: (quantity, joint) -> "column [unit]"."""
    parts = [f'[recording]\ntime = {{ column = "{time}", unit = "s" }}']
    for (quantity, joint), column in quantities.items():
        name, _, unit = column.partition(" ")
        parts.append(
            f'[[recording.channel]]\ncolumn = "{name}"\nquantity = "{quantity}"\njoint = "{joint}"\n'
            f'unit = "{unit.strip("[]")}"'
        )
    return "\n\n".join(parts)


def made(name: str, time: Array, values: dict[ChannelKey, Array], breaks: Sequence[int] = ()) -> Recording:
    """A recording from arrays: ``time`` (N,) in s, channels in SI; ``breaks`` are indices where a segment begins."""
    edges = [0, *sorted(breaks), len(time)]
    segments = tuple(slice(a, b) for a, b in pairwise(edges) if b - a > 1)
    step = float(np.median(np.concatenate([np.diff(time[part]) for part in segments])))
    return Recording(name, time, MappingProxyType(dict(values)), step, segments, (), DIGEST_OF_DERIVED)


def cut(recording: Recording, name: str, parts: Sequence[slice]) -> Recording:
    """Those parts of a recording, each a segment (or several, where it had gaps)."""
    pieces = []
    for part in parts:
        for old in recording.segments:
            start, stop = max(part.start, old.start), min(part.stop, old.stop)
            if stop - start > 1:
                pieces.append(slice(start, stop))
    rows = np.concatenate([np.arange(p.start, p.stop) for p in pieces])
    breaks = np.cumsum([p.stop - p.start for p in pieces])[:-1]
    values = {key: column[rows] for key, column in recording.channels.items()}
    return replace(made(name, recording.time[rows], values, [int(b) for b in breaks]), sha256=recording.sha256)


def interleaved(recording: Recording, count: int) -> tuple[Recording, Recording]:
    """``count`` blocks of equal length: the odd ones to train on, the even ones to judge on."""
    edges = [round(i * len(recording.time) / count) for i in range(count + 1)]
    blocks = [slice(a, b) for a, b in pairwise(edges)]
    return cut(recording, "odd blocks", blocks[0::2]), cut(recording, "even blocks", blocks[1::2])


def joined(name: str, recordings: Sequence[Recording]) -> Recording:
    """Several runs one after the other, each with segments of its own."""
    offset, times, breaks, count = 0.0, [], [], 0
    for recording in recordings:
        times.append(recording.time - recording.time[0] + offset)
        offset = float(times[-1][-1]) + 10.0 * recording.sample_time
        breaks += [count + part.start for part in recording.segments]
        count += len(recording.time)
    keys = recordings[0].channels
    values = {key: np.concatenate([r.channels[key] for r in recordings]) for key in keys}
    return made(name, np.concatenate(times), values, breaks[1:])


def position(joint: str) -> ChannelKey:
    return Quantity.POSITION, joint, Side.LINK


def effort(joint: str) -> ChannelKey:
    return Quantity.EFFORT, joint, Side.LINK
