"""The cases of the benchmark: which machine, what is concealed where, how good the sensors are; all drawn by seed."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache, cached_property
from itertools import product

from benchmarks.blind.axis import Axis
from benchmarks.blind.blemishes import BLEMISHES, REFUSED, blemish
from benchmarks.blind.drive import RigidDrive, SeedDrive
from benchmarks.blind.effects import ELASTIC, MOVING, Draw
from benchmarks.blind.faults import ARM, CIRCUIT, MISSING_SHAFT, SHAFT, TACHO, WHOLE
from benchmarks.blind.geared import GearedArm
from benchmarks.blind.machine import Machine, Recorded
from benchmarks.blind.motions import rng_of
from benchmarks.blind.planting import Planted
from benchmarks.blind.sensors import LEVELS
from benchmarks.blind.six_joint import SixJoint
from benchmarks.blind.two_link import TwoLink
from benchmarks.blind.unknown import UNKNOWN

MACHINES: Mapping[str, Machine] = {
    m.name: m for m in (Axis(), TwoLink(), SixJoint(), RigidDrive(), SeedDrive(), GearedArm())
}
DRAWS: Mapping[str, Draw] = {
    **MOVING, **ELASTIC, **ARM, **WHOLE, **SHAFT, **MISSING_SHAFT, **CIRCUIT, **TACHO, **UNKNOWN,
}  # fmt: skip
OFF = 0.3  # the largest relative error of a parameter that is handed over
SPREAD = 0.15  # of the true ones, from case to case
NULLS = {  # at the middle level
    "axis": 20, "two-link": 60, "six-joint": 20, "rigid-drive": 50, "seed-drive": 50, "geared-arm": 20,
}  # fmt: skip
PAIRS = {"axis": 12, "two-link": 24, "six-joint": 8, "rigid-drive": 8, "seed-drive": 16, "geared-arm": 8}
GROUPS = ("null", "single", "pair", "unknown", "recording")
DRAW = 1000  # between the seeds of a draw and the next one

_ARM_ONLY = ("counterbalance", "load_dependent")
_KINDS: Mapping[tuple[str, str], tuple[str, ...]] = {  # what can be planted, and told, at a place
    # The mass of the axis takes up what is added to it, and an encoder's gain; where its zero is nothing tells.
    ("axis", "j1"): (
        *(k for k in MOVING if k not in ("added_inertia", "counterbalance", "unbalance")),
        "encoder_steps",
        "effort_limit",
        *ELASTIC,
    ),
    ("axis", ""): ("late_efforts",),
    # The inertia of joint 1 takes up what is added to it; on link 2 gravity does not turn with the joint's angle.
    # Its effort is measured: a limit ahead of that would be none of its physics.
    ("two-link", "j1"): tuple(k for k in (*MOVING, *ARM, *ELASTIC) if k not in ("added_inertia", "effort_limit")),
    ("two-link", "j2"): tuple(k for k in (*MOVING, *ARM, *ELASTIC) if k not in ("unbalance", "effort_limit")),
    ("two-link", ""): tuple(WHOLE),
    ("six-joint", ""): tuple(WHOLE),
    ("rigid-drive", "j1.motor"): tuple(k for k in MOVING if k not in ("added_inertia", *_ARM_ONLY)) + tuple(TACHO),
    ("rigid-drive", "j1.shaft"): tuple(MISSING_SHAFT),
    ("rigid-drive", "j1.circuit"): tuple(CIRCUIT),
    # The friction of the other rotors takes up what is viscous at one of them, or at the load.
    ("seed-drive", "j1.motor"): tuple(
        k for k in MOVING if k not in ("added_inertia", "viscous", "unbalance", "warm_up", *_ARM_ONLY)
    ),
    ("seed-drive", "j1"): tuple(k for k in MOVING if k not in ("added_inertia", "viscous", *_ARM_ONLY)),
    ("seed-drive", "j1.tacho"): tuple(TACHO),
    ("seed-drive", "j1.shaft3"): tuple(SHAFT),
    ("seed-drive", "j1.circuit"): tuple(CIRCUIT),
    # Weight takes up an unbalance; an inertia is free anyway.
    ("geared-arm", "j1.motor"): tuple(
        k for k in MOVING if k not in ("added_inertia", "viscous", "unbalance", "warm_up", *_ARM_ONLY)
    ),
    ("geared-arm", "j1"): tuple(k for k in MOVING if k not in ("added_inertia", "unbalance", "warm_up", *_ARM_ONLY)),
    ("geared-arm", "j1.gear"): tuple(SHAFT),
}
# On a wrist the centre of mass and the inertia of the motor take up what unbalance and added inertia would show.
_SIX = (*(k for k in MOVING if k not in ("added_inertia", "unbalance")), *ARM, *ELASTIC)
# What shows in the weight of the arm alone is concealed where there is some.
_LOADED = ("encoder_offset", "encoder_gain", "load_dependent", "effort_limit")
_SIX_AT = {kind: ("j2", "j3") if kind in _LOADED else tuple(f"j{i}" for i in range(1, 7)) for kind in _SIX}
_SIX_AT["encoder_offset"] = ()  # centres of mass that are free in two directions take it up without a trace


@dataclass(frozen=True)
class Case:
    """One question to the tool; ``kinds`` are (kind of effect, place)."""

    machine: str
    group: str
    kinds: tuple[tuple[str, str], ...]
    level: str
    seed: int

    @property
    def id(self) -> str:
        what = "+".join(f"{kind}@{place}" if place else kind for kind, place in self.kinds) or "nothing"
        return f"{self.machine}_{self.group}_{what}_{self.level}_{self.seed}"

    @property
    def draw(self) -> int:
        """By which draw of all cases this one is made."""
        return self.seed // DRAW

    @property
    def lot(self) -> str:
        """By this the cases are put in order: any that are done first are a fair sample of all."""
        return hashlib.sha256(self.id.encode()).hexdigest()

    @cached_property
    def planted(self) -> tuple[Planted, ...]:
        machine = MACHINES[self.machine]
        found = []
        for kind, address in self.kinds:
            if kind in BLEMISHES:
                found.append(blemish(kind))
                continue
            place = machine.place(address) if address else machine.places[0]
            plant = DRAWS[kind](rng_of("size", kind, address, self.machine, self.seed), place)
            found.append(replace(plant, also_at=(*plant.also_at, *place.same_as)))
        return tuple(found)

    @cached_property
    def true(self) -> dict[str, float]:
        """The parameters of the plant."""
        rng = rng_of("true", self.machine, self.group, self.kinds, self.seed)
        nominal = MACHINES[self.machine].truth
        found = {name: value * rng.uniform(1 - SPREAD, 1 + SPREAD) for name, (value, _) in nominal.items()}
        if "K_E" in found:
            found["K_E"] = found["K_T"]  # one magnet, one constant in SI units; a model may hold two
        return found

    @cached_property
    def given(self) -> dict[str, float]:
        """The parameters that are handed over."""
        rng = rng_of("given", self.machine, self.group, self.kinds, self.seed)
        return {name: value * rng.uniform(1 - OFF, 1 + OFF) for name, value in self.true.items()}


def all_cases(draw: int = 0) -> list[Case]:
    """Every case, in the order in which they are run.

    Each ``draw`` has as many of every sort, with other numbers, other pairs and another order: cases that nobody saw.
    """
    drawn = (*_nulls(), *_singles(), *_pairs(draw), *_unknowns(), *_recordings(draw))
    found = [replace(case, seed=case.seed + DRAW * draw) for case in drawn]
    assert len({case.id for case in found}) == len(found)
    return sorted(found, key=lambda case: case.lot)


def case_of(id: str) -> Case:
    """The case of that id, of whichever draw."""
    return _by_id(int(id.rsplit("_", 1)[1]) // DRAW)[id]


@cache
def _by_id(draw: int) -> dict[str, Case]:
    return {case.id: case for case in all_cases(draw)}


def _nulls() -> Iterator[Case]:
    for machine, count in NULLS.items():
        for level in LEVELS:
            for seed in range(count if level == "middle" else count // 5):
                yield Case(machine, "null", (), level, seed)


def _singles() -> Iterator[Case]:
    for level in LEVELS:
        for seed in range(2 if level == "middle" else 1):
            for (machine, place), kinds in _KINDS.items():
                for kind in kinds:
                    yield Case(machine, "single", ((kind, place),), level, seed)
            for turn, (kind, places) in enumerate(_SIX_AT.items()):
                if places:
                    yield Case("six-joint", "single", ((kind, places[(turn + seed) % len(places)]),), level, seed)


def _pairs(draw: int) -> Iterator[Case]:
    for (machine, count), level in product(PAIRS.items(), LEVELS):
        for seed in range(count if level == "middle" else count // 4):
            yield Case(machine, "pair", _two(machine, level, seed + DRAW * draw), level, seed)


def _two(machine: str, level: str, seed: int) -> tuple[tuple[str, str], ...]:
    """Two effects of different kinds; at one place only where neither takes the other's friction away."""
    rng = rng_of("pair", machine, level, seed)
    open_ = [found for found in _open(machine) if found[0] not in ELASTIC]  # added later: no other pair may change
    while True:
        first, second = (open_[i] for i in rng.choice(len(open_), 2, replace=False))
        planted = Case(machine, "pair", (first, second), level, seed).planted
        clash = {plant.replaces for plant in planted} if first[1] == second[1] else set()
        if first[0] != second[0] and (len(clash) != 1 or clash == {""}):
            return first, second


def _open(machine: str) -> list[tuple[str, str]]:
    """(kind, place): all that can be planted in a machine."""
    if machine == "six-joint":
        return [(kind, place) for kind, places in _SIX_AT.items() for place in places]
    return [(kind, place) for (name, place), kinds in _KINDS.items() for kind in kinds if name == machine]


def _unknowns() -> Iterator[Case]:
    places: Mapping[str, tuple[str, ...]] = {
        "axis": ("j1",), "two-link": ("j1", "j2"), "six-joint": (), "rigid-drive": ("j1.motor",),
        "seed-drive": ("j1.motor",), "geared-arm": ("j1.motor", "j1"),
    }  # fmt: skip
    for (machine, fixed), level, kind in product(places.items(), LEVELS, UNKNOWN):
        turn = list(UNKNOWN).index(kind)
        for place in fixed or (f"j{1 + turn % 6}",):
            yield Case(machine, "unknown", ((kind, place),), level, 0)


def _recordings(draw: int) -> Iterator[Case]:
    """Faults of recordings: those that can be mended with nothing else concealed, and beside an effect."""
    without = {"axis": ("turned_angles", "exchanged_efforts", "degrees")}  # of which it has none
    for machine, level, kind in product(("axis", "two-link", "six-joint"), LEVELS, BLEMISHES):
        if kind in without.get(machine, ()):
            continue
        yield Case(machine, "recording", ((kind, ""),), level, 0)
        if kind not in REFUSED:
            open_ = [found for found in _open(machine) if found[0] not in WHOLE]
            drawn = (draw,) if draw else ()  # those of the first are as they always were
            other = open_[rng_of("beside", kind, machine, level, *drawn).integers(len(open_))]
            yield Case(machine, "recording", ((kind, ""), other), level, 1)


def recordings(case: Case) -> tuple[str, str]:
    """The training and the held-out run as CSV."""
    return _recording(case, 0).csv(), _recording(case, 1).csv()


def _recording(case: Case, run: int) -> Recorded:
    shown = MACHINES[case.machine].record(case.planted, case.true, run, case.level, case.seed)
    for plant in case.planted:
        if plant.blemish:
            shown = BLEMISHES[plant.kind](rng_of("blemish", case.id, run), shown)
    return shown


def model(case: Case) -> str:
    """The robot.toml that is handed over."""
    return MACHINES[case.machine].model(case.given, case.planted, case.seed)


def oracle_model(case: Case) -> str:
    """The robot.toml of one that knows the truth: what was planted is in it, every number is the true one."""
    return MACHINES[case.machine].model(case.true, case.planted, case.seed, form=True)
