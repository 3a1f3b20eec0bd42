"""A one-joint machine with a drive, all of its numbers letters."""

from __future__ import annotations

from fractions import Fraction

from symdyn.spec.records import (
    JOINT_END,
    ONE,
    ZERO,
    Convention,
    DHRow,
    Drive,
    EffectSpec,
    Joint,
    JointKind,
    Link,
    Monomial,
    Motor,
    Parameter,
    Robot,
    Rotor,
    Shaft,
)


def letter(name: str) -> Monomial:
    return Monomial(Fraction(1), ((name, 1),))


BELT = Drive(
    letter("N"),
    (Rotor("motor", letter("J_m")),),
    (Shaft("belt", "motor", JOINT_END, letter("c"), letter("d")),),
    Motor("circuit", "motor", letter("R"), letter("L"), letter("K_T"), letter("K_E")),
)


def driven(
    drive: Drive = BELT, effects: tuple[EffectSpec, ...] = (), kind: JointKind = JointKind.REVOLUTE, name: str = "arm"
) -> Robot:
    """One joint about or along a vertical axis: inertia I (mass M on a slide), gravity without effect."""
    return chain((name, drive, kind), effects=effects)


def chain(*joints: tuple[str, Drive | None, JointKind], effects: tuple[EffectSpec, ...] = ()) -> Robot:
    """Joints on one axis with the same link each, no gravity."""
    link = Link(mass=letter("M"), inertia=(ZERO, ZERO, letter("I"), ZERO, ZERO, ZERO))
    row = DHRow(ZERO, ZERO, ZERO, ZERO)
    made = tuple(Joint(name, kind, row, link, drive) for name, drive, kind in joints)
    names = sorted({name for number in _numbers(made, effects) for name, _ in number.factors})
    parameters = tuple(Parameter(name, None, "1", name) for name in names)
    return Robot("driven", "", Convention.STANDARD, (ZERO,) * 3, made, effects, parameters)


def _numbers(joints: tuple[Joint, ...], effects: tuple[EffectSpec, ...]) -> list[Monomial]:
    found = [value for effect in effects for _, value in effect.values]
    for joint in joints:
        found += [joint.link.mass, *joint.link.inertia]
        if joint.drive is not None:
            found += [joint.drive.ratio, *(r.inertia for r in joint.drive.rotors)]
            found += [number for s in joint.drive.shafts for number in (s.stiffness, s.damping)]
            motor = joint.drive.motor
            if motor is not None:
                found += [motor.resistance, motor.inductance, motor.torque_constant, motor.back_emf_constant]
    return found


RIGID = Drive(ONE, (), (), None)
