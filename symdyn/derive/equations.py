"""The equations of motion of a robot with its drives: arm by Newton-Euler, effects by force balance."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import sympy as sp

from symdyn.base import symbols
from symdyn.derive.composite import mass_matrix
from symdyn.derive.coordinates import Coordinate, coordinates, joint_coordinates
from symdyn.derive.energy import energies
from symdyn.derive.forces import Contribution, balance, totals
from symdyn.derive.loads import Load, loads, under
from symdyn.derive.newton_euler import inverse_dynamics
from symdyn.derive.ports import Attachment, attachments
from symdyn.derive.quantities import expression
from symdyn.derive.steps import Step, Steps
from symdyn.physics.effect import unit_at
from symdyn.spec.records import Robot


@dataclass(frozen=True, slots=True)
class HiddenStateEquation:
    """``storage * d(symbol)/dt = rate``."""

    symbol: sp.Symbol
    name: str
    unit: str
    latex: str
    storage: sp.Expr
    rate: sp.Expr


@dataclass(frozen=True, slots=True)
class Reading:
    """What one sensor shows."""

    name: str
    unit: str
    value: sp.Expr


@dataclass(frozen=True, slots=True)
class Input:
    """A control input; ``force`` (n,) is what it exerts directly along each coordinate, through its limits."""

    symbol: sp.Symbol
    name: str
    unit: str
    force: tuple[sp.Expr, ...]


@dataclass(frozen=True, slots=True)
class EquationsOfMotion:
    """All that is derived of a robot; expressions are in symbols of ``symdyn.base.symbols``.

    arm + inertial = applied + actuation + external, per coordinate, where ``arm`` (n,) are the
    efforts of the rigid arm, affine in accelerations, written with the intermediates ``steps``.
    """

    robot: Robot
    axes: tuple[Coordinate, ...]
    parameters: tuple[sp.Symbol, ...]
    steps: tuple[Step, ...]
    arm: tuple[sp.Expr, ...]
    mass_steps: tuple[Step, ...]
    arm_mass: sp.Matrix  # (n, n), zero for coordinates that are no joint's
    contributions: tuple[Contribution, ...]
    states: tuple[HiddenStateEquation, ...]
    inputs: tuple[Input, ...]
    sensors: tuple[Reading, ...]
    energy_steps: tuple[Step, ...]
    kinetic: sp.Expr
    potential: sp.Expr
    loads: tuple[Load, ...] = ()  # of joints, on which the force of some contribution depends

    @property
    def attachments(self) -> tuple[Attachment, ...]:
        return tuple(c.attachment for c in self.contributions)

    def required(self) -> tuple[tuple[Step, ...], tuple[sp.Expr, ...]]:
        """Inverse dynamics: the effort (n,) that actuators must supply along each coordinate, with its steps."""
        steps, efforts = self.of_effects()
        total = [a + b for a, b in zip(self.arm, efforts, strict=True)]
        names = [a.address for a in self.axes]
        carried = tuple(Step(load.symbol, load.needed, f"load of {names[load.axis]}") for load in self.loads)
        for c in self.loaded:
            total = [a - b for a, b in zip(total, c.applied, strict=True)]
        return (*self.steps, *steps, *carried), tuple(total)

    @property
    def loaded(self) -> tuple[Contribution, ...]:
        """The contributions that depend on loads: friction that the acceleration decides, too."""
        return tuple(c for c in self.contributions if any(c.depends_on(load.symbol) for load in self.loads))

    def transmitted(self, efforts: Sequence[sp.Expr]) -> tuple[sp.Expr, ...]:
        """(n,) what friction that depends on loads leaves of ``efforts`` (n,) along each coordinate."""
        sizes, left = under(efforts, self.loads), list(efforts)
        for c in self.loaded:
            left = [a + sp.sympify(b).xreplace(sizes) for a, b in zip(left, c.applied, strict=True)]
        return tuple(left)

    def of_effects(self) -> tuple[tuple[Step, ...], tuple[sp.Expr, ...]]:
        """The share in it of those effects that depend on no load: affine in accelerations."""
        steps, loaded = Steps(), self.loaded
        total = [sp.Integer(0)] * len(self.axes)
        for c in (c for c in self.contributions if c not in loaded):
            name = f"{c.attachment.effect.identifier}_{c.attachment.address.replace('.', '_')}"
            for k, force in enumerate(sp.sympify(a) - b for a, b in zip(c.inertial, c.applied, strict=True)):
                total[k] += steps.name(f"{name}_{k + 1}", force, c.attachment.origin) if force != 0 else 0
        return steps.freeze(), tuple(total)

    def actuation(self) -> tuple[sp.Expr, ...]:
        """(n,) effort that inputs and hidden states supply along each coordinate."""
        return tuple(
            sum((i.force[k] for i in self.inputs), sp.Integer(0))
            + sum((c.actuation[k] for c in self.contributions), sp.Integer(0))
            for k in range(len(self.axes))
        )


def equations_of_motion(robot: Robot) -> EquationsOfMotion:
    """Derive the equations of a robot; nothing is expanded or simplified, so large arms are quick."""
    axes = coordinates(robot)
    steps, energy_steps, mass_steps = Steps(), Steps(), Steps()
    by_joint = dict(zip((c.address for c in joint_coordinates(robot)), inverse_dynamics(robot, steps), strict=True))
    arm_mass = _spread(mass_matrix(robot, mass_steps), robot, axes)
    items = attachments(robot)
    kinetic, potential = energies(robot, energy_steps)
    stored_kinetic, stored_potential, _ = totals(items)
    arm = tuple(sp.sympify(by_joint.get(c.address, 0)) for c in axes)
    contributions = tuple(balance(item, axes) for item in items)
    return EquationsOfMotion(
        robot=robot,
        axes=axes,
        parameters=tuple(symbols.parameter(p.name) for p in robot.parameters),
        steps=steps.freeze(),
        arm=arm,
        mass_steps=mass_steps.freeze(),
        arm_mass=arm_mass,
        contributions=contributions,
        states=_told_apart([state for item in items for state in _states(item)]),
        inputs=_inputs(robot, axes, items),
        sensors=_told_apart(_sensors(items)),
        energy_steps=energy_steps.freeze(),
        kinetic=kinetic + stored_kinetic,
        potential=potential + stored_potential,
        loads=loads(contributions, arm, axes),
    )


def _spread(mass: sp.Matrix, robot: Robot, axes: tuple[Coordinate, ...]) -> sp.Matrix:
    """From joints to all coordinates."""
    place = {c.address: k for k, c in enumerate(axes)}
    at = [place[joint.name] for joint in robot.joints]
    spread = sp.zeros(len(axes), len(axes))
    for i, row in enumerate(at):
        for j, column in enumerate(at):
            spread[row, column] = mass[i, j]
    return spread


def _states(item: Attachment) -> Iterator[HiddenStateEquation]:
    declared = item.effect.hidden_states(item.values)
    rates = item.effect.rates(item.port, item.values, item.states, item.control)
    for symbol, state, rate in zip(item.states, declared, rates, strict=True):
        unit = unit_at(state.unit, item.motion)
        yield HiddenStateEquation(
            symbol, f"{item.address}.{state.name}", unit, state.latex, sp.sympify(rate.storage), rate.change
        )


Named = TypeVar("Named", HiddenStateEquation, Reading)


def _told_apart(found: Sequence[Named]) -> tuple[Named, ...]:
    """The second of two alike at one place is called _2: names are what people and files refer to."""
    seen: Counter[str] = Counter()
    named = []
    for item in found:
        seen[item.name] += 1
        count = seen[item.name]
        named.append(item if count == 1 else replace(item, name=f"{item.name}_{count}"))
    return tuple(named)


def _inputs(robot: Robot, axes: tuple[Coordinate, ...], items: tuple[Attachment, ...]) -> tuple[Input, ...]:
    """One per driven joint: its motor's voltage or the reference of its servo, its actuator's input, or its effort."""
    driven = {item.joint: item for item in items if item.effect.input_unit() is not None}
    loops: dict[str, Attachment] = {}
    for item in items:
        if item.effect.reference_unit() is not None:
            loops.setdefault(item.joint, item)
    found = []
    for i, joint in enumerate(robot.joints, start=1):
        if joint.passive:
            continue
        symbol = symbols.control(i)
        acts_on = joint.drive.effort_at if joint.drive is not None else ""
        address = f"{joint.name}.{acts_on}" if acts_on else joint.name
        own = next(c for c in axes if c.address == address)
        effort, unit, name = sp.sympify(symbol), own.effort_unit, f"{address}.effort"
        if joint.name in driven:
            effort, unit = sp.Integer(0), driven[joint.name].effect.input_unit() or ""
            name = f"{driven[joint.name].address}.voltage"
            if (outer := loops.get(joint.name)) is not None:
                unit = unit_at(outer.effect.reference_unit() or "", outer.motion)
                name = f"{outer.address}.reference"
        elif joint.actuator is not None:
            effort, unit = expression(joint.actuator.gain) * symbol, joint.actuator.input_unit
            name = f"{joint.name}.input"
        for stage in (item for item in items if item.address == address):
            effort = stage.effect.amplified(stage.values, stage.states, effort) or effort
        force = tuple(effort if c is own else sp.Integer(0) for c in axes)
        found.append(Input(symbol, name, unit, force))
    return tuple(found)


def _sensors(items: tuple[Attachment, ...]) -> list[Reading]:
    found = []
    for item in items:
        sensor = item.effect.sensor(item.port, item.values, item.states)
        if sensor is not None:
            unit = unit_at(sensor.unit, item.motion)
            found.append(Reading(f"{item.address}.{sensor.name}", unit, sp.sympify(sensor.value)))
    return found
