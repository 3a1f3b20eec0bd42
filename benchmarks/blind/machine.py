"""What every machine of the benchmark offers: places, recordings of its plant, and the model that is handed over."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from benchmarks.blind.motions import rng_of

if TYPE_CHECKING:
    from benchmarks.blind.planting import Planted


@dataclass(frozen=True)
class Place:
    """Where an effect can be planted, with what is usual there: the size of an effect follows from it."""

    address: str
    kind: str  # joint, inertia, shaft, circuit
    force: float  # N m: about a tenth of the torque there; V at a circuit
    speed: float  # rad/s
    reach: float  # rad
    peak: float = 0.0  # N m: the most that the motion takes, of arms
    centre: float = 0.0  # rad, of the motion
    lead: float = 1.0  # m per rad of its encoder, of a joint that slides
    same_as: tuple[str, ...] = ()  # addresses that are the same coordinate in the model handed over


@dataclass(frozen=True)
class Recorded:
    """Columns that sensors showed at the instants ``time`` (s)."""

    time: np.ndarray
    columns: Mapping[str, np.ndarray]

    @classmethod
    def even(cls, sample_time: float, columns: Mapping[str, np.ndarray]) -> Recorded:
        """Columns with one row per ``sample_time`` s."""
        return cls(sample_time * np.arange(len(next(iter(columns.values())))), columns)

    def csv(self) -> str:
        names = list(self.columns)
        table = np.column_stack([self.columns[name] for name in names])
        lines = [",".join(("t", *names))]
        rows = zip(self.time, table, strict=True)
        lines += [f"{t:.6f}," + ",".join(f"{value:.7g}" for value in row) for t, row in rows]
        return "\n".join(lines) + "\n"


class Machine(ABC):
    """A plant and its model. ``truth`` holds the nominal value and the unit of every parameter that is off."""

    name: ClassVar[str]
    places: ClassVar[tuple[Place, ...]]
    truth: ClassVar[Mapping[str, tuple[float, str]]]

    @abstractmethod
    def record(
        self, planted: tuple[Planted, ...], true: Mapping[str, float], run: int, level: str, seed: int
    ) -> Recorded:
        """What the sensors show in the training run (0) or the held-out run (1)."""

    @abstractmethod
    def model(self, given: Mapping[str, float], planted: tuple[Planted, ...], seed: int, form: bool = False) -> str:
        """robot.toml with the values ``given``; with ``form``, what was planted is in it (the oracle's model)."""

    def rng(self, planted: Sequence[Planted], run: int, level: str, seed: int) -> np.random.Generator:
        """Of motion and noise: other ones in every case and run."""
        return rng_of(self.name, run, level, seed, *(f"{plant.kind}@{plant.place}" for plant in planted))

    def place(self, address: str) -> Place:
        return next(place for place in self.places if place.address == address)

    @staticmethod
    def plant_of(planted: Sequence[Planted], place: str) -> dict[str, float]:
        return {key: value for plant in planted if plant.place == place for key, value in plant.plant.items()}

    @staticmethod
    def fault_of(planted: Sequence[Planted], channel: str) -> dict[str, float]:
        faults = [plant.fault[1] for plant in planted if plant.fault is not None and plant.fault[0] == channel]
        return {key: value for fault in faults for key, value in fault.items()}

    def form_text(self, planted: Sequence[Planted], wanted: bool) -> str:
        """The first form of everything planted, as [[effect]] tables; nothing when it is not wanted."""
        if not wanted:
            return ""
        found = []
        for plant in planted:
            for effect, values in plant.forms[0].items() if plant.forms else ():
                found.append(effect_table(effect, plant.place, {k: f"{value:.9g}" for k, value in values.items()}))
        return "".join(found)


def parameter_lines(truth: Mapping[str, tuple[float, str]], given: Mapping[str, float], left_out: set[str]) -> str:
    return "\n".join(f'{k} = "{given[k]:.9g} {unit}"' for k, (_, unit) in truth.items() if k not in left_out)


def effect_table(effect: str, at: str, values: Mapping[str, str]) -> str:
    lines = "".join(f"{name} = {value}\n" for name, value in values.items())
    return f'\n[[effect]]\ntype = "{effect}"\nat = "{at}"\n{lines}'


def joint_channels(joints: Sequence[str], quantity: str, unit: str, position: str = "rad") -> str:
    """The [recording] table of an arm: columns x1, x2, .. are positions, y1, y2, .. what drives the joints."""
    text = '\n[recording]\ntime = { column = "t", unit = "s" }\n'
    for i, joint in enumerate(joints, 1):
        for column, what, how in ((f"x{i}", "position", position), (f"y{i}", quantity, unit)):
            text += f'\n[[recording.channel]]\ncolumn = "{column}"\nquantity = "{what}"\n'
            text += f'joint = "{joint}"\nunit = "{how}"\n'
    return text
