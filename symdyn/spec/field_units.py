"""The SI unit of every field of a robot, by what its place moves in."""

from __future__ import annotations

from collections.abc import Mapping
from enum import StrEnum
from types import MappingProxyType

from symdyn.spec.records import JointKind, Motion, Quantity


class FieldUnit(StrEnum):
    """A kind of quantity whose unit depends on the motion of its place."""

    INERTIA = "inertia"
    STIFFNESS = "stiffness"
    DAMPING = "damping"
    EFFORT = "effort"
    POSITION = "position"
    VELOCITY = "velocity"
    TORQUE_CONSTANT = "torque_constant"
    BACK_EMF_CONSTANT = "back_emf_constant"


_UNITS: Mapping[FieldUnit, tuple[str, str]] = MappingProxyType(
    {
        FieldUnit.INERTIA: ("kg m^2", "kg"),
        FieldUnit.STIFFNESS: ("N m/rad", "N/m"),
        FieldUnit.DAMPING: ("N m s/rad", "N s/m"),
        FieldUnit.EFFORT: ("N m", "N"),
        FieldUnit.POSITION: ("rad", "m"),
        FieldUnit.VELOCITY: ("rad/s", "m/s"),
        FieldUnit.TORQUE_CONSTANT: ("N m/A", "N/A"),
        FieldUnit.BACK_EMF_CONSTANT: ("V s/rad", "V s/m"),
    }
)
ACTUATOR_INPUTS = ("V", "A")


def motion_of(kind: JointKind) -> Motion:
    return Motion.ROTATIONAL if kind is JointKind.REVOLUTE else Motion.TRANSLATIONAL


def unit_of(field: FieldUnit, motion: Motion) -> str:
    """The SI unit of a field at a place that turns or slides."""
    rotational, translational = _UNITS[field]
    return rotational if motion is Motion.ROTATIONAL else translational


def channel_unit(quantity: Quantity, motion: Motion) -> str:
    """The SI unit of a measured quantity at a joint."""
    if quantity is Quantity.VOLTAGE:
        return "V"
    if quantity is Quantity.CURRENT:
        return "A"
    return unit_of(FieldUnit(quantity.value), motion)


def gain_units(motion: Motion) -> tuple[str, ...]:
    """The units that an actuator's gain may have: effort per volt or per ampere, as ACTUATOR_INPUTS."""
    effort = unit_of(FieldUnit.EFFORT, motion)
    return tuple(f"{effort}/{unit}" for unit in ACTUATOR_INPUTS)
