"""A transmission that the model takes for rigid: the same machine with a shaft between its motor and its joint."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction

import numpy as np

from symdyn.numeric.filtering.beliefs import untold
from symdyn.numeric.filtering.explain import remembered
from symdyn.numeric.filtering.hypotheses import hypotheses
from symdyn.numeric.filtering.judged import Explanation, explained
from symdyn.numeric.filtering.likelihood import fit
from symdyn.numeric.filtering.locate import POWERS
from symdyn.numeric.filtering.model import (
    Freed,
    Lagging,
    Model,
    carried,
    natural_force,
    prepare,
    with_latent,
    without_latent,
)
from symdyn.numeric.gearing import motor_rotor, turns_with_joint
from symdyn.numeric.recording import Recording
from symdyn.spec.records import JOINT_END, Joint, Monomial, Parameter, Quantity, Robot, Shaft, Side

EFFECT, TITLE = "joint_compliance", "compliance of the transmission"
SHAFT = "transmission"
STARTS = 8  # resonances that are tried, evenly on a logarithmic scale
FEW = 8  # rounds of a fit from each of them
LIGHT = 0.05  # damping ratio that a fit starts from


def rigid_joints(robot: Robot) -> tuple[Joint, ...]:
    """Joints whose motor is fixed to them: one with a circuit, or a rotor at which the effort was measured."""
    return tuple(
        joint
        for joint in robot.joints
        if joint.drive is not None
        and turns_with_joint(joint, motor_rotor(joint) or "")
        and (joint.drive.motor is not None or _driven_at_motor(robot, joint))
        and all(shaft.name != SHAFT for shaft in joint.drive.shafts)
    )


def _driven_at_motor(robot: Robot, joint: Joint) -> bool:
    channels = robot.channels.channels if robot.channels is not None else ()
    return any((c.quantity, c.joint, c.side) == (Quantity.EFFORT, joint.name, Side.MOTOR) for c in channels)


def _motor(joint: Joint) -> str:
    """The name of the rotor that drives a joint."""
    return (motor_rotor(joint) or "").rpartition(".")[2]


def with_shaft(
    robot: Robot,
    joint: Joint,
    freed: tuple[Freed, ...],
    lagging: tuple[Lagging, ...],
    current: Explanation,
    recordings: tuple[Recording, Recording],
    progress: Callable[[str], None],
) -> tuple[Model, Explanation]:
    """The machine with that shaft, fitted from where the rigid one stands; effects found are kept."""
    progress(f"deriving and compiling {robot.name} with a shaft at {joint.name}")
    flexible, new = _flexible(robot, joint)
    model = prepare(flexible, *recordings, remembered(current))
    model = replace(model, freed=(*freed, new), lagging=lagging)
    index = current.fit.bench.index
    p = model.values
    names = {name: i for i, name in enumerate((*model.kernel.parameters, *model.delays))}
    for name, i in names.items():
        if name in index:
            p[i] = current.fit.p[index[name]]
    free = {*current.beliefs, new.stiffness, new.damping}
    beliefs = {name: belief for name, belief in model.beliefs.items() if name in free}
    beliefs |= {name: belief for name, belief in current.beliefs.items() if name in names}
    noise = without_latent(model, model.training)
    latent = next(x for x in model.latents if x.place == joint.name)
    bench = model.bench(model.training, noise, current.fit.bench.between)
    powers = natural_force(model, model.training, latent.direction) ** 2 * POWERS
    trials = [bench.with_noise(with_latent(noise, latent, float(power))) for power in powers]
    inertia = p[names[_rotor_inertia(joint)]] if _rotor_inertia(joint) in names else 1.0
    rate = 1.0 / float(np.nanmedian(model.training.steps))
    tried = []
    for frequency in np.geomspace(1.0, 0.25 * rate, STARTS):
        stiffness = inertia * (2.0 * math.pi * frequency) ** 2
        trial = p.copy()
        for name, value in ((new.stiffness, stiffness), (new.damping, LIGHT * stiffness / (math.pi * frequency))):
            trial[names[name]] = value
            beliefs[name] = untold(value)
        losses = [each.filtered(trial).loss for each in trials]
        tried.append((fit(trials[int(np.argmin(losses))], trial, beliefs, most=FEW), dict(beliefs)))
    first, beliefs = min(tried, key=lambda item: item[0].loss)
    done = fit(first.bench, first.p, beliefs)
    kept = {(c.effect, c.place.address): c for c in model.proposed}
    found = tuple((kept.get((c.effect, c.place.address), c), shape) for c, shape in current.found)
    model = replace(model, beliefs={n: b for n, b in beliefs.items() if n in model.beliefs})
    return model, explained(model, found, beliefs, done)


def without_shaft(
    model: Model,
    new: Freed,
    current: Explanation,
    recordings: tuple[Recording, Recording],
    progress: Callable[[str], None],
) -> tuple[Model, Explanation]:
    """The machine with that rotor fixed to its joint again, fitted from where it stands; effects found are kept."""
    progress(f"deriving and compiling {model.robot.name} without the shaft at {new.joint}")
    robot = _rigid(model.robot, new)
    proposed = {c.label for c in hypotheses(robot)}
    rigid = prepare(robot, *recordings, [c for c, _ in current.found if c.label not in proposed])
    freed = tuple(other for other in model.freed if other is not new)
    rigid = replace(rigid, freed=freed, lagging=model.lagging)
    p, bench = carried(rigid, current.fit.p, current.fit.bench)
    own = (new.stiffness, new.damping)
    beliefs = {name: belief for name, belief in current.beliefs.items() if name not in own}
    rigid = replace(rigid, beliefs={name: belief for name, belief in model.beliefs.items() if name not in own})
    return rigid, explained(rigid, current.found, beliefs, fit(bench, p, beliefs))


def _flexible(robot: Robot, joint: Joint) -> tuple[Robot, Freed]:
    drive = joint.drive
    assert drive is not None
    at = _motor(joint)
    new = Freed(joint.name, at, SHAFT, f"{joint.name}_{SHAFT}_stiffness", f"{joint.name}_{SHAFT}_damping")
    stiffness, damping = (Monomial(Fraction(1), ((name, 1),)) for name in (new.stiffness, new.damping))
    rotors = tuple(replace(r, fixed_to_joint=False) if r.name == at else r for r in drive.rotors)
    shafts = (*drive.shafts, Shaft(SHAFT, at, JOINT_END, stiffness, damping))
    joints = tuple(
        replace(j, drive=replace(drive, rotors=rotors, shafts=shafts, effort_at="" if drive.motor else at))
        if j.name == joint.name
        else j
        for j in robot.joints
    )
    parameters = (
        *robot.parameters,
        Parameter(new.stiffness, 1.0, "N m/rad", "c_t", "stiffness of the transmission"),
        Parameter(new.damping, 1e-3, "N m s/rad", "d_t", "damping of the transmission"),
    )
    return replace(robot, joints=joints, parameters=parameters), new


def _rigid(robot: Robot, new: Freed) -> Robot:
    """What ``_flexible`` did to the robot is undone."""
    joint = next(j for j in robot.joints if j.name == new.joint)
    drive = joint.drive
    assert drive is not None
    rotors = tuple(replace(r, fixed_to_joint=True) if r.name == new.rotor else r for r in drive.rotors)
    drive = replace(drive, rotors=rotors, shafts=tuple(s for s in drive.shafts if s.name != new.shaft), effort_at="")
    return replace(
        robot,
        joints=tuple(replace(j, drive=drive) if j is joint else j for j in robot.joints),
        parameters=tuple(p for p in robot.parameters if p.name not in (new.stiffness, new.damping)),
    )


def _rotor_inertia(joint: Joint) -> str:
    """The parameter that is the inertia of the motor's rotor, where it is one."""
    drive = joint.drive
    assert drive is not None
    rotor = next(r for r in drive.rotors if r.name == _motor(joint))
    return rotor.inertia.factors[0][0] if len(rotor.inertia.factors) == 1 else ""
