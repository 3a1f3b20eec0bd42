"""Where the energy of a machine goes: what each element takes from a supply, turns to heat and stores."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import sympy as sp

from symdyn.derive.equations import EquationsOfMotion
from symdyn.derive.forces import totals
from symdyn.derive.loads import under
from symdyn.derive.ports import Attachment
from symdyn.physics.effect import PORT

ZERO = sp.Integer(0)
LINKS = "links"
ENERGY_KINDS = ("supplied", "dissipated", "stored")


@dataclass(frozen=True, slots=True)
class PowerFlow:
    """One element: power ``supplied`` to it and ``dissipated`` by it in W, energy ``stored`` in it in J.

    Summed over all elements, d stored/dt = supplied - dissipated along every motion (tested). What a law gives
    without having taken it (a constant force, unequal constants of a motor) counts as dissipated, with a minus.
    """

    name: str
    supplied: sp.Expr
    dissipated: sp.Expr
    stored: sp.Expr


def power_flows(equations: EquationsOfMotion) -> tuple[PowerFlow, ...]:
    """Of the links, every attachment, and every input that is an effort; elements without energy are left out.

    The energy of the links is written with ``equations.energy_steps``.
    """
    kinetic, potential, _ = totals(equations.attachments)
    links = PowerFlow(LINKS, ZERO, ZERO, equations.kinetic - kinetic + equations.potential - potential)
    sizes = under(equations.actuation(), equations.loads)
    found = [links, *_told_apart([_flow(item, sizes) for item in equations.attachments]), *_efforts(equations)]
    return tuple(f for f in found if (f.supplied, f.dissipated, f.stored) != (0, 0, 0))


def of_kind(flows: Sequence[PowerFlow], kind: str) -> Mapping[str, sp.Expr]:
    """One of ENERGY_KINDS by name of element, for the elements that have it."""
    found = {flow.name: getattr(flow, kind) for flow in flows}
    return {name: expression for name, expression in found.items() if expression != 0}


def _flow(item: Attachment, loads: Mapping[sp.Expr, sp.Expr]) -> PowerFlow:
    """The work that the effect does on its port and does not take from its own store is taken from the supply."""
    effect, port, values, states = item.effect, item.port, item.values, item.states
    resisting = port.located(effect.force(PORT, values) + effect.damping(values)).xreplace(loads)
    driving = effect.state_force(port, values, states, item.control)
    hidden = effect.stored_energy(values, states)
    rates = effect.rates(port, values, states, item.control)
    taken_up = sum(
        (sp.diff(hidden, z) * rate.change / rate.storage for z, rate in zip(states, rates, strict=True)), ZERO
    )
    supplied = sp.sympify(effect.supplied(port, values, states, item.control))
    return PowerFlow(
        f"{item.address}.{effect.identifier}",
        supplied,
        supplied - (resisting + driving) * port.v - taken_up,
        effect.kinetic_energy(port, values) + effect.potential_energy(port, values) + hidden,
    )


def _efforts(equations: EquationsOfMotion) -> Iterator[PowerFlow]:
    for drive in equations.inputs:
        power = sum((f * axis.qd for f, axis in zip(drive.force, equations.axes, strict=True)), ZERO)
        yield PowerFlow(drive.name, power, ZERO, ZERO)


def _told_apart(flows: list[PowerFlow]) -> Iterator[PowerFlow]:
    seen: Counter[str] = Counter()
    for flow in flows:
        seen[flow.name] += 1
        count = seen[flow.name]
        yield flow if count == 1 else replace(flow, name=f"{flow.name}_{count}")
