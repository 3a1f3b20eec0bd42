"""A diagnosis made by hand: the two-link arm whose elbow has a torque ripple that its model lacks."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from symdyn.compiler import load_robot, robot_from_text
from symdyn.numeric.findings import (
    Alternative,
    Diagnosis,
    Errors,
    Estimate,
    Finding,
    Located,
    NoiseFloor,
    Remaining,
    Traces,
    Verdict,
)
from symdyn.numeric.fitting import relative_error
from symdyn.spec.edit import add_effect
from symdyn.spec.records import Robot

RIPPLE = Finding(
    effect="torque_ripple",
    title="torque ripple (cogging)",
    place="elbow",
    parameters={
        "cosine": Estimate(0.22551, 0.00412, "N m"),
        "sine": Estimate(0.26770, 0.00398, "N m"),
        "order": Estimate(11.0, None, "rad/rad"),
    },
    heldout_before=0.1286,
    heldout_after=0.0492,
    p_value=3e-12,
    rivals=(),
    alternatives=(Alternative("linear_spring", "elbow", 0.1102),),
    group=("elbow", "elbow.motor"),
    evidence=412.6,
)
COULOMB = Finding(
    effect="coulomb_friction",
    title="Coulomb friction",
    place="shoulder",
    parameters={"level": Estimate(0.4134, 0.0091, "N m")},
    heldout_before=0.0492,
    heldout_after=0.0407,
    p_value=0.0021,
    rivals=(),
)


def two_link() -> Robot:
    return load_robot("two-link")


def with_findings(robot: Robot, *findings: Finding) -> Robot:
    """The robot with one effect per finding, as a diagnosis writes it."""
    text = robot.text
    for finding in findings:
        values = {name: f"{e.value:.8g} {e.unit}" for name, e in finding.parameters.items()}
        text = add_effect(text, finding.effect, finding.place, values)
    return robot_from_text(text, "two-link.toml")


def traces(samples: int = 600, noise: float = 0.08) -> Traces:
    """Sums of sines; before lacks ripple at the elbow and Coulomb friction at the shoulder."""
    rng = np.random.default_rng(7)
    t = np.arange(samples) / 40.0
    q = np.stack(
        [0.9 * np.sin(0.7 * t) + 0.4 * np.sin(1.9 * t), 1.1 * np.sin(0.9 * t + 1.0) + 0.3 * np.sin(2.3 * t)], 1
    )
    qd = np.gradient(q, t, axis=0)
    model = np.stack([9.0 * np.cos(q[:, 0]) + 0.3 * qd[:, 0], 1.7 * np.cos(q.sum(axis=1)) + 0.12 * qd[:, 1]], 1)
    lacking = np.stack(
        [0.41 * np.tanh(qd[:, 0] / 0.02), 0.2255 * np.cos(11 * q[:, 1]) + 0.2677 * np.sin(11 * q[:, 1])], 1
    )
    effort = model + lacking + noise * rng.standard_normal(q.shape)
    return Traces(t, q, qd, effort, model, model + lacking, ("shoulder", "elbow"), ("N m", "N m"))


def diagnosis(robot: Robot | None = None, *findings: Finding, samples: int = 600) -> Diagnosis:
    """Missing physics with the given findings (ripple at the elbow when there are none)."""
    given = robot or two_link()
    made = findings or (RIPPLE,)
    shown = traces(samples)
    before, after = (relative_error(shown.effort - model, shown.effort) for model in (shown.before, shown.after))
    given_errors, errors = (
        [relative_error((shown.effort - model)[:, [j]], shown.effort[:, [j]]) for j in (0, 1)]
        for model in (shown.before, shown.after)
    )
    return Diagnosis(
        verdict=Verdict.MISSING_PHYSICS,
        robot=given,
        diagnosed=with_findings(given, *made),
        findings=made,
        model={
            "I_1": Estimate(0.0231, None, "kg m^2"),
            "m_2": Estimate(0.8653, 0.0021, "kg"),
            "elbow_inertia_yy": Estimate(1.152e-5, 3.1e-7, "kg m^2"),
        },
        before=Errors(0.97 * before, before),
        after=Errors(0.97 * after, after),
        per_joint_before={
            "shoulder": Errors(given_errors[0], given_errors[0]),
            "elbow": Errors(given_errors[1], given_errors[1]),
        },
        per_joint={"shoulder": Errors(errors[0], errors[0]), "elbow": Errors(errors[1], errors[1])},
        remaining=Remaining(after, False, 0.0, None, 1.0, 0.0),
        alarms=("backlash at elbow fits the training data better, but not the held-out data",),
        band=10.4,
        training="identification.csv.gz",
        heldout="holdout.csv.gz",
        traces=replace(shown, noise=np.array([0.012, 0.011])),
        located=(Located("elbow", ("elbow", "elbow.motor"), 312.4, ("angle order 11", "low speed")),),
        noise_floor=NoiseFloor(Errors(0.031, 0.032), {"shoulder": Errors(0.021, 0.022), "elbow": Errors(0.033, 0.034)}),
    )


def without_findings(verdict: Verdict) -> Diagnosis:
    """The model as given explains what can be explained."""
    plain = diagnosis()
    structured = verdict is Verdict.UNEXPLAINED
    left = Remaining(0.071, structured, 0.62 if structured else 0.04, "position of elbow", 0.0003, 0.05)
    errors = Errors(0.069, 0.071)
    return replace(
        plain,
        verdict=verdict,
        diagnosed=plain.robot,
        findings=(),
        before=errors,
        after=errors,
        remaining=left,
        alarms=(),
    )
