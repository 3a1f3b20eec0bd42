"""What a physical effect is: one declaration from which every layer derives what it needs."""

from __future__ import annotations

from abc import ABC
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import sympy as sp

from symdyn.base import symbols
from symdyn.spec.effect_schema import EffectSchema, ParameterSchema
from symdyn.spec.records import Motion, PlaceKind

Values = Mapping[str, sp.Expr]  # an effect's own parameter names -> symbols
Unit = str | Mapping[Motion, str]  # one unit, or one by the motion of the place

ZERO = sp.Integer(0)


@dataclass(frozen=True, slots=True)
class Port:
    """Where an effect acts: a displacement ``x`` with its rate ``v``; a force along it does work F v.

    At a joint or rotor ``x`` is its coordinate; at a shaft it is the twist, end minus start, so that
    a force acts equal and opposite on the two sides. In a circuit ``v`` is the current.
    """

    x: sp.Expr
    v: sp.Expr
    load: sp.Expr = ZERO  # the force along +x of the springs at the same place
    start: Port | None = None  # of a shaft: where it begins

    def located(self, law: sp.Expr) -> sp.Expr:
        """A law that is written in PORT, at this port."""
        assert PORT.start is not None
        here = {PORT.x: self.x, PORT.v: self.v, PORT.load: self.load}
        if self.start is not None:
            here |= {PORT.start.x: self.start.x, PORT.start.v: self.start.v}
        return sp.sympify(law, strict=True).subs(here, simultaneous=True)


PORT = Port(
    symbols.local("x"),
    symbols.local("v"),
    symbols.local("load"),
    Port(symbols.local("start_x"), symbols.local("start_v")),
)


@dataclass(frozen=True, slots=True)
class HiddenState:
    """A state that the effect brings along."""

    name: str
    unit: Unit
    latex: str


@dataclass(frozen=True, slots=True)
class Rate:
    """``storage * d(state)/dt = change`` of one hidden state."""

    storage: sp.Expr
    change: sp.Expr


@dataclass(frozen=True, slots=True)
class Update:
    """What the hidden states become at the times ``delay + k period``, from what holds right before (k = 0, 1, ...)."""

    period: sp.Expr
    delay: sp.Expr  # no longer than the period
    values: tuple[sp.Expr, ...]


@dataclass(frozen=True, slots=True)
class Sensor:
    """What an effect measures: ``value`` in terms of the port and of its hidden states."""

    name: str
    unit: Unit
    value: sp.Expr


@dataclass(frozen=True, slots=True)
class PointMass:
    """A mass that moves with the link of a joint, at a position (x, y, z) in the link's frame."""

    mass: sp.Expr
    position: tuple[sp.Expr, sp.Expr, sp.Expr]


def unit_at(unit: Unit, motion: Motion) -> str:
    """The unit of a state or sensor at a place that moves so."""
    return unit if isinstance(unit, str) else unit[motion]


class Effect(ABC):
    """One kind of physics. A subclass sets the class variables and defines the hooks it needs, no more.

    ``port`` holds the displacement and velocity at the place, ``p`` the parameter symbols, ``z`` the
    hidden states in the order of their declaration, ``control`` the input that reaches the place;
    hooks return SymPy expressions in those alone. A parameter that is structurally zero is the number 0.
    """

    identifier: ClassVar[str]
    title: ClassVar[str]
    attaches_to: ClassVar[frozenset[PlaceKind]]
    motions: ClassVar[frozenset[Motion]] = frozenset(
        {Motion.ROTATIONAL, Motion.TRANSLATIONAL}
    )  # of the places where it has a meaning
    parameters: ClassVar[tuple[ParameterSchema, ...]]
    source: ClassVar[str]  # where the law is published
    signature: ClassVar[str] = ""  # how it shows in a recording, for people
    rivals: ClassVar[tuple[str, ...]] = ()  # effects that look alike in many recordings
    builds_on: ClassVar[str | None] = None  # the effect at the same place that this one is a correction of
    generalises: ClassVar[tuple[str, ...]] = ()  # effects at the same place that it contains, nearly or exactly
    sums: ClassVar[tuple[tuple[str, ...], ...]] = ()  # laws at one place that may together be it, by another name
    opens: ClassVar[bool] = True  # whether a search may begin with it; else one that it contains must be there before
    dissipative: ClassVar[bool] = False  # never gives more energy than it was given before (tested)
    proposable: ClassVar[bool] = False  # a diagnosis may propose it where it is missing
    # Of what is added between input and motor a signal passes the lower one first; loops come after what is below 0.
    stage: ClassVar[int] = 0

    def seat(self, port: Port) -> Port:
        """The port that the laws are written in: the place's own, or at a shaft that of one of its ends."""
        return port

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

    def body(self, p: Values) -> PointMass | None:
        """A mass on the link behind the joint."""
        return None

    def transmission(self, port: Port, p: Values) -> Port | None:
        """What the other effects at this place feel instead of the port's own displacement."""
        return None

    def play(self, p: Values) -> sp.Expr | None:
        """Half the clearance of a contact, whose flanks push but never pull."""
        return None

    def hidden_states(self, p: Values) -> tuple[HiddenState, ...]:
        return ()

    def rates(self, port: Port, p: Values, z: Sequence[sp.Expr], control: sp.Expr) -> tuple[Rate, ...]:
        """Of the hidden states, in their order."""
        return ()

    def updates(self, port: Port, p: Values, z: Sequence[sp.Expr], control: sp.Expr) -> tuple[Update, ...]:
        """Of what is sampled: how the hidden states jump. At one instant, earlier updates come first."""
        return ()

    def state_force(self, port: Port, p: Values, z: Sequence[sp.Expr], control: sp.Expr) -> sp.Expr:
        """Force along the port that the hidden states, or the control input, cause."""
        return ZERO

    def stored_energy(self, p: Values, z: Sequence[sp.Expr]) -> sp.Expr:
        """Energy in the hidden states that can come back."""
        return ZERO

    def supplied(self, port: Port, p: Values, z: Sequence[sp.Expr], control: sp.Expr) -> sp.Expr:
        """Power that the effect takes from a supply."""
        return ZERO

    def input_unit(self) -> str | None:
        """Unit of the control input that drives the effect, if there is one."""
        return None

    def current(self, port: Port, p: Values, z: Sequence[sp.Expr], control: sp.Expr) -> sp.Expr | None:
        """Of what drives a circuit: the current in it."""
        return None

    def amplified(self, p: Values, z: Sequence[sp.Expr], control: sp.Expr) -> sp.Expr | None:
        """What this stage hands on in place of the control input, towards the motor."""
        return None

    def controls(self, port: Port, p: Values, z: Sequence[sp.Expr], control: sp.Expr) -> sp.Expr | None:
        """Of a servo loop: what it hands on, when ``control`` is its reference and it measures the port."""
        return None

    @classmethod
    def reference_unit(cls) -> Unit | None:
        """Of a servo loop: the unit of its reference."""
        return None

    def sensor(self, port: Port, p: Values, z: Sequence[sp.Expr]) -> Sensor | None:
        return None

    @classmethod
    def summed(cls, parts: Mapping[str, Mapping[str, float]]) -> Mapping[str, float] | None:
        """Its parameters where ``parts``, by effect and parameter, are one of its ``sums``; None where they are not."""
        return None

    def conservative(self, p: Values) -> sp.Expr:
        """Force along PORT of the potential energy."""
        return -sp.diff(self.potential_energy(PORT, p), PORT.x)

    def damping(self, p: Values) -> sp.Expr:
        """Force along PORT of Rayleigh's function."""
        return -sp.diff(self.dissipation(PORT, p), PORT.v)

    @classmethod
    def schema(cls) -> EffectSchema:
        return EffectSchema(cls.identifier, cls.title, cls.attaches_to, cls.parameters, cls.reference_unit())


def mechanical(rotational: str, translational: str) -> Mapping[Motion, str]:
    """The unit of a parameter at a rotational and at a translational place."""
    return {Motion.ROTATIONAL: rotational, Motion.TRANSLATIONAL: translational}


def same_unit(unit: str) -> Mapping[Motion, str]:
    """A unit that does not depend on how the place moves."""
    return {Motion.ROTATIONAL: unit, Motion.TRANSLATIONAL: unit}


EFFORT = mechanical("N m", "N")
DAMPING = mechanical("N m s/rad", "N s/m")
STIFFNESS = mechanical("N m/rad", "N/m")
INERTIA = mechanical("kg m^2", "kg")
SPEED = mechanical("rad/s", "m/s")
DISPLACEMENT = mechanical("rad", "m")
MOVING = frozenset({PlaceKind.JOINT, PlaceKind.INERTIA})
MECHANICAL = MOVING | {PlaceKind.SHAFT}
CIRCUIT = frozenset({PlaceKind.CIRCUIT})
ELECTRICAL = frozenset({Motion.ELECTRICAL})
TURNING = frozenset({Motion.ROTATIONAL})
