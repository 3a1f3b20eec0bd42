"""What each number of a body or a placement is called, whatever file it comes from: parameter name, symbol, meaning."""

from __future__ import annotations

from symdyn.spec.effect_schema import EffectSchema, ParameterSchema
from symdyn.spec.numbers import Slot
from symdyn.spec.records import Place
from symdyn.spec.toml_positions import KeyPath

AXES = ("x", "y", "z")
MOMENTS = ("xx", "yy", "zz", "xy", "xz", "yz")


def mass_slot(path: KeyPath, owner: str) -> Slot:
    """``path`` is that of the body."""
    return Slot((*path, "mass"), (owner,), "mass", "kg", "m", f"mass of {owner}")


def com_slots(path: KeyPath, owner: str) -> list[Slot]:
    return [
        Slot(
            (*path, "com", i), (owner,), f"com_{axis}", "m", f"r_{{{axis}}}", f"centre of mass of {owner}, {axis}"
        )
        for i, axis in enumerate(AXES)
    ]  # fmt: skip


def inertia_slots(path: KeyPath, owner: str) -> list[Slot]:
    return [
        Slot(
            (*path, "inertia", entry),
            (owner,),
            f"inertia_{entry}",
            "kg m^2",
            f"I_{{{entry}}}",
            f"inertia of {owner}, {entry}",
        )
        for entry in MOMENTS
    ]


def position_slots(path: KeyPath, owner: str) -> list[Slot]:
    """``path`` is that of the placement."""
    return [
        Slot((*path, "xyz", i), (owner,), f"offset_{axis}", "m", f"p_{{{axis}}}", f"offset of {owner}, {axis}")
        for i, axis in enumerate(AXES)
    ]


def gravity_slots() -> list[Slot]:
    return [
        Slot(
            ("robot", "gravity", i), (), f"gravity_{axis}", "m/s^2", f"g_{{{axis}}}", f"gravity along base {axis}"
        )
        for i, axis in enumerate(AXES)
    ]  # fmt: skip


def effect_slot(path: KeyPath, parameter: ParameterSchema, schema: EffectSchema, place: Place) -> Slot:
    """``path`` is that of the effect."""
    return Slot(
        (*path, parameter.name),
        tuple(place.address.split(".")),
        f"{schema.identifier}_{parameter.name}",
        parameter.units[place.motion],
        parameter.latex,
        f"{parameter.meaning}, {place.address}",
    )
