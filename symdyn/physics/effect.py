"""What a physical effect is: one declaration from which every layer derives what it needs."""

from __future__ import annotations

from abc import ABC
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import sympy as sp

from symdyn.base import symbols
from symdyn.spec.effect_schema import EffectSchema, ParameterSchema
from symdyn.spec.records import Motion, PlaceKind

Values = Mapping[str, sp.Expr]  # an effect's own parameter names -> symbols

ZERO = sp.Integer(0)


@dataclass(frozen=True, slots=True)
class Port:
    """Where an effect acts: a displacement ``x`` with its rate ``v``; a force along it does work F v.

    At a joint or rotor ``x`` is its coordinate; at a shaft it is the twist, end minus start, so that
    a force acts equal and opposite on the two sides.
    """

    x: sp.Expr
    v: sp.Expr


PORT = Port(symbols.local("x"), symbols.local("v"))


@dataclass(frozen=True, slots=True)
class HiddenState:
    """A state that the effect brings along: ``storage * d(state)/dt = rate``."""

    name: str
    unit: str
    latex: str


@dataclass(frozen=True, slots=True)
class Sensor:
    """What an effect measures: ``value`` in terms of the port."""

    name: str
    unit: str
    value: sp.Expr


class Effect(ABC):
    """One kind of physics. A subclass sets the class variables and defines the hooks it needs, no more.

    ``port`` holds the displacement and velocity at the place, ``p`` the parameter symbols; hooks
    return SymPy expressions in those alone.
    """

    identifier: ClassVar[str]
    title: ClassVar[str]
    attaches_to: ClassVar[frozenset[PlaceKind]]
    parameters: ClassVar[tuple[ParameterSchema, ...]]
    source: ClassVar[str]  # where the law is published
    signature: ClassVar[str] = ""  # how it shows in a recording, for people
    rivals: ClassVar[tuple[str, ...]] = ()  # effects that look alike in many recordings
    builds_on: ClassVar[str | None] = None  # the effect at the same place that this one is a correction of
    dissipative: ClassVar[bool] = False  # never gives energy to the machine (tested)
    proposable: ClassVar[bool] = False  # a diagnosis may propose it where it is missing

    def kinetic_energy(self, port: Port, p: Values) -> sp.Expr:
        return ZERO

    def potential_energy(self, port: Port, p: Values) -> sp.Expr:
        return ZERO

    def dissipation(self, port: Port, p: Values) -> sp.Expr:
        """Rayleigh's function W(v): the force is -dW/dv."""
        return ZERO

    def force(self, port: Port, p: Values) -> sp.Expr:
        """Any other force along the port, positive along +x."""
        return ZERO

    def transmission(self, port: Port, p: Values) -> Port | None:
        """What the other effects at this place feel instead of the port's own displacement."""
        return None

    def hidden_state(self) -> HiddenState | None:
        return None

    def storage_and_rate(self, port: Port, p: Values, state: sp.Expr, control: sp.Expr) -> tuple[sp.Expr, sp.Expr]:
        """(storage, rate) of the hidden state."""
        return sp.Integer(1), ZERO

    def state_force(self, port: Port, p: Values, state: sp.Expr) -> sp.Expr:
        """Force along the port that the hidden state causes."""
        return ZERO

    def input_unit(self) -> str | None:
        """Unit of the control input that drives the hidden state, if there is one."""
        return None

    def sensor(self, port: Port, p: Values) -> Sensor | None:
        return None

    @classmethod
    def schema(cls) -> EffectSchema:
        return EffectSchema(cls.identifier, cls.title, cls.attaches_to, cls.parameters)


def mechanical(rotational: str, translational: str) -> Mapping[Motion, str]:
    """The unit of a parameter at a rotational and at a translational place."""
    return {Motion.ROTATIONAL: rotational, Motion.TRANSLATIONAL: translational}


EFFORT = mechanical("N m", "N")
DAMPING = mechanical("N m s/rad", "N s/m")
STIFFNESS = mechanical("N m/rad", "N/m")
INERTIA = mechanical("kg m^2", "kg")
SPEED = mechanical("rad/s", "m/s")
DISPLACEMENT = mechanical("rad", "m")
MOVING = frozenset({PlaceKind.JOINT, PlaceKind.INERTIA})
MECHANICAL = MOVING | {PlaceKind.SHAFT}
