"""What all servo loops share: a control law, run without pause or sampled with a period and a computational delay."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from typing import ClassVar

import sympy as sp

from symdyn.physics.effect import MOVING, Effect, HiddenState, Port, Rate, Unit, Update, Values, same_unit
from symdyn.spec.effect_schema import ParameterSchema
from symdyn.spec.records import Motion

ONE, ZERO = sp.Integer(1), sp.Integer(0)


def sampling(seconds: Mapping[Motion, str]) -> tuple[ParameterSchema, ParameterSchema]:
    """Period and delay of a loop, with their unit by the motion of its place."""
    return (
        ParameterSchema(
            "period", seconds, "T_s", "time between samples, 0: continuous", None, 0.0, default=0.0,
            zero_is_structural=True,
        ),
        ParameterSchema(
            "delay", seconds, r"T_{\mathrm{c}}", "time from a sample to its output", None, 0.0, default=0.0,
            zero_is_structural=True,
        ),
    )  # fmt: skip


SAMPLING = sampling(same_unit("s"))


class ServoLoop(Effect):
    """A control law, its ``output`` a function of the port, its memory and its reference.

    Sampled, it measures at whole multiples of the period; its memory goes on by Euler's difference equations, and
    the output that belongs to a sample is held from the delay after it until the next one comes. The hidden states are
    then the memory, the output that is held and, where there is a delay, the one that waits.
    """

    attaches_to = MOVING
    hands_on: ClassVar[Unit]  # unit of the output

    @abstractmethod
    def output(self, port: Port, p: Values, memory: Sequence[sp.Expr], reference: sp.Expr) -> sp.Expr: ...

    def memory(self, p: Values) -> tuple[HiddenState, ...]:
        return ()

    def memory_rates(self, port: Port, p: Values, memory: Sequence[sp.Expr], reference: sp.Expr) -> tuple[sp.Expr, ...]:
        return ()

    def hidden_states(self, p: Values) -> tuple[HiddenState, ...]:
        held: tuple[HiddenState, ...] = ()
        if p["period"] != 0:
            held = (HiddenState("output", self.hands_on, r"\bar u"),)
            held += (HiddenState("waiting", self.hands_on, r"\tilde u"),) if p["delay"] != 0 else ()
        return (*self.memory(p), *held)

    def rates(self, port: Port, p: Values, z: Sequence[sp.Expr], control: sp.Expr) -> tuple[Rate, ...]:
        if p["period"] != 0:
            return tuple(Rate(ONE, ZERO) for _ in z)
        return tuple(Rate(ONE, change) for change in self.memory_rates(port, p, z, control))

    def controls(self, port: Port, p: Values, z: Sequence[sp.Expr], control: sp.Expr) -> sp.Expr:
        return self.output(port, p, z, control) if p["period"] == 0 else z[len(self.memory(p))]

    def updates(self, port: Port, p: Values, z: Sequence[sp.Expr], control: sp.Expr) -> tuple[Update, ...]:
        period, delay = p["period"], p["delay"]
        if period == 0:
            return ()
        count = len(self.memory(p))
        memory, held = tuple(z[:count]), tuple(z[count:])
        rates = self.memory_rates(port, p, memory, control)
        new = tuple(old + period * rate for old, rate in zip(memory, rates, strict=True))
        asked = self.output(port, p, memory, control)
        if delay == 0:
            return (Update(period, ZERO, (*new, asked)),)
        return (
            Update(period, delay, (*memory, held[1], held[1])),
            Update(period, ZERO, (*new, held[0], asked)),
        )
