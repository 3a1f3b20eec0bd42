"""What may be missing where only part of a machine is measured: effects at coordinates, couplings and circuits."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from symdyn.emit.kernel import Kernel
from symdyn.numeric.candidates import Candidate, counts_of, fitted_parameters
from symdyn.numeric.filtering.driving import limits
from symdyn.numeric.filtering.places import push_at
from symdyn.numeric.filtering.signals import Signals
from symdyn.numeric.gearing import joint_name, turns_with_joint
from symdyn.numeric.servo_loops import is_loop
from symdyn.physics import catalogue, in_stages, load_dependent
from symdyn.spec.effect_schema import ParameterSchema, Scan
from symdyn.spec.places import places
from symdyn.spec.records import EffectSpec, Monomial, Motion, Parameter, PlaceKind, Robot

Array = NDArray[np.float64]

LATE_REFERENCE = "reference_delay"
DELAYS = frozenset({"input_delay", LATE_REFERENCE})
HYSTERESIS = {  # and size
    "dahl_friction": "stiffness",
    "bouc_wen_hysteresis": "level",
    "lugre_friction": "stiffness",
    "hardening_hysteresis": "stiffness",
}
WARMING = {"warm_up_friction": "coefficient"}
MEMORIES = {**HYSTERESIS, **WARMING}
MOST = 2.0  # of a whole number that makes it another law, which has a machine of its own
PHASES = 8  # angles that are tried around the circle
NO_LIMIT = 1e12  # stands for an infinite limit, which a kernel cannot hold
SPEEDS = 10  # grid points over the speeds that occur
ORDERS = 32  # waves per turn that are tried


def hypotheses(robot: Robot) -> tuple[Candidate, ...]:
    """Every proposable effect at every place with an equation or coupling of its own, where the robot lacks it.

    Parameters without a value at which the effect vanishes in a continuous way are its shape, and searched;
    effects with more than one are left out, and so are those that do not open a search.
    """
    present = {(e.type, e.at) for e in robot.effects}
    looped = {joint_name(e.at) for e in robot.effects if is_loop(e)}
    found = []
    for place in places(robot):
        if any(turns_with_joint(joint, place.address) for joint in robot.joints):
            continue
        for effect in catalogue().values():
            if (
                not (effect.proposable and effect.opens)
                or effect.identifier in MEMORIES
                or place.kind not in effect.attaches_to
                or place.motion not in effect.motions
                or (effect.identifier in load_dependent() and place.kind is not PlaceKind.SHAFT)
            ):  # at a joint such a law follows from accelerations, which a filter does not hold
                continue
            if (effect.identifier, place.address) in present or _part_of_drive(effect.identifier, place.kind):
                continue
            if effect.identifier in DELAYS and (effect.reference_unit() or joint_name(place.address) in looped):
                continue  # within a loop it would be the loop that is late, and not its input
            free = [p for p in effect.parameters if not (p.is_count or p.scan is Scan.ASSUMED or _is_kept(p))]
            shapes = [p for p in free if _is_shape(p)]
            linear = tuple(p for p in free if not _is_shape(p))
            if len(shapes) > 1 or (place.motion is not Motion.ROTATIONAL and any(
                p.scan is Scan.ANGLE_ORDER for p in shapes
            )):  # fmt: skip
                continue
            found.append(Candidate(effect.identifier, effect.title, place, linear, tuple(shapes), effect.builds_on))
    return (*found, *_late_references(robot))


def _late_references(robot: Robot) -> list[Candidate]:
    """One for every position that a servo loop follows, and that does not come late in the model as it is."""
    law, by_address = catalogue()[LATE_REFERENCE], {place.address: place for place in places(robot)}
    (delay,) = (schema for schema in law.parameters if not schema.is_count)
    loops = [e for e in robot.effects if is_loop(e)]
    outermost = {joint_name(e.at): e for e in reversed(loops)}
    late = {joint_name(e.at) for e in loops if e.type == LATE_REFERENCE}
    return [
        Candidate(law.identifier, law.title, by_address[e.at], (delay,), (), law.builds_on)
        for joint, e in outermost.items()
        if joint not in late and catalogue()[e.type].reference_unit() == law.reference_unit()
    ]


def memories(robot: Robot, address: str, laws: Mapping[str, str]) -> tuple[Candidate, ...]:
    """Of laws of friction with a state of their own, those that the robot does not have yet at a place."""
    place = next(p for p in places(robot) if p.address == address)
    present = {e.type for e in robot.effects if e.at == address}
    found = []
    for identifier, size in laws.items():
        effect = catalogue()[identifier]
        if place.kind in effect.attaches_to and identifier not in present:
            linear = tuple(p for p in effect.parameters if p.name == size)
            free = [p for p in effect.parameters if not (p.is_count or p.scan is Scan.ASSUMED)]
            rest = tuple(p for p in free if p.name != size)
            for counts in counts_of(effect):
                if all(count <= MOST for count in counts.values()):
                    taken = tuple((p, counts[p.name]) for p in effect.parameters if p.name in counts)
                    found.append(Candidate(identifier, effect.title, place, linear, rest, None, taken))
    return tuple(found)


def without_memory(laws: Iterable[str]) -> frozenset[str]:
    """Friction that laws with a memory contain, and take the place of."""
    contained = {less for law in laws for less in catalogue()[law].generalises if catalogue()[less].dissipative}
    return frozenset(contained - set(MEMORIES))


def kept(candidate: Candidate) -> Mapping[str, float]:
    """Parameters of an effect that are taken for given: no recording of a drive tells them, or they are structure."""
    schemas = catalogue()[candidate.effect].parameters
    assumed = {p.name: p.tried[0] for p in schemas if p.scan is Scan.ASSUMED}
    return {**assumed, **dict(candidate.counts)}


def augmented(robot: Robot, proposed: Sequence[Candidate]) -> Robot:
    """The robot with every candidate attached at its null value: one kernel serves all hypotheses."""
    effects, parameters = list(robot.effects), list(robot.parameters)
    for candidate in in_stages(proposed):
        values = []
        if candidate.effect in DELAYS:
            continue  # the recorded input is shifted instead
        for key, number in kept(candidate).items():
            values.append((key, Monomial(Fraction(str(number)))))
        for schema in (*candidate.linear, *candidate.shapes):
            name = candidate.parameter(schema)
            null = 1.0 if schema.null is None else min(schema.null, NO_LIMIT)
            parameters.append(Parameter(name, null, candidate.unit(schema), schema.latex, schema.meaning))
            values.append((schema.name, Monomial(Fraction(1), ((name, 1),))))
        effects.append(EffectSpec(candidate.effect, candidate.place.address, tuple(values)))
    return replace(robot, effects=tuple(effects), parameters=tuple(parameters))


def free_parameters(robot: Robot) -> tuple[str, ...]:
    """The model's own parameters that a fit may move: those of bodies and effects, and those of its drives.

    A filter sees what no inverse dynamics can: the circuit, and the springs between measured and hidden parts.
    """
    names = set(fitted_parameters(robot))
    for joint in robot.joints:
        if joint.drive is None:
            continue
        values = [value for shaft in joint.drive.shafts for value in (shaft.stiffness, shaft.damping)]
        motor = joint.drive.motor
        if motor is not None:
            values += [motor.resistance, motor.inductance, motor.torque_constant, motor.back_emf_constant]
        names |= {name for value in values for name, _ in value.factors}
    return tuple(p.name for p in robot.parameters if p.name in names)


def delays(kernel: Kernel, proposed: Sequence[Candidate]) -> tuple[str, ...]:
    """For each input of the kernel a name for how late it comes, that of the hypothesis where there is one."""
    named = {joint_name(c.place.address): c.parameter(c.linear[0]) for c in proposed if c.effect in DELAYS}
    joints = [joint_name(name) for name in kernel.inputs]
    return tuple(named.get(joint, f"{joint}_delay") for joint in joints)


def _is_kept(schema: ParameterSchema) -> bool:
    """A parameter that is something when nobody names it: it stays so."""
    return schema.default is not None and schema.default != schema.null


def _is_shape(schema: ParameterSchema) -> bool:
    return schema.scan is not Scan.NONE or schema.null is None or not math.isfinite(schema.null)


def _part_of_drive(effect: str, kind: PlaceKind) -> bool:
    """A shaft has stiffness and damping, an inertia has inertia: their values are fitted, not found."""
    return (kind is PlaceKind.SHAFT and effect in ("linear_spring", "viscous_friction")) or (
        kind is not PlaceKind.SHAFT and effect == "added_inertia"
    )


def shape_values(candidate: Candidate, kernel: Kernel, signals: Signals, speed: float) -> Array:
    """Values of the shape parameter to try; ``speed`` is the fastest of the place."""
    if not candidate.shapes:
        return np.array([np.nan])
    (shape,) = candidate.shapes
    if shape.scan is Scan.ANGLE:  # any will do for a start
        return np.linspace(0.0, 2.0 * np.pi, PHASES, endpoint=False)
    if shape.scan is Scan.SPEED:
        return np.geomspace(speed / 100.0, speed, SPEEDS)
    if shape.scan is Scan.ANGLE_ORDER:
        return np.arange(1.0, ORDERS + 1.0)
    if candidate.place.kind is PlaceKind.CIRCUIT:
        return limits(kernel, signals, candidate.place.address, push_at(candidate.place))
    return np.zeros(0)
