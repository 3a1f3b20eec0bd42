"""A sprung mass on a shaker whose motion is measured, and not its force: only the mass's equation is tested."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from types import MappingProxyType

import numpy as np
import pytest
from numpy.typing import NDArray

from symdyn.base.errors import InputError
from symdyn.compiler import robot_from_text
from symdyn.numeric.diagnose import diagnose
from symdyn.numeric.findings import Diagnosis, Verdict
from symdyn.numeric.identify import identify
from symdyn.numeric.recording import Recording
from symdyn.spec.records import Quantity, Robot, Side

Array = NDArray[np.float64]

MODEL = """
[robot]
name = "shaker"
gravity = [0, 0, 0]

[parameters]
m = "40 kg"
k = "1800 N/m"
b = "200 N s/m"

[[joint]]
name = "table"
kind = "prismatic"
placement = { xyz = [0, 0, 0] }
link = { mass = "10 kg" }

[[joint]]
name = "body"
kind = "prismatic"
PASSIVE
placement = { xyz = [0, 0, 0] }
link = { mass = "m" }

[[effect]]
type = "linear_spring"
at = "body"
stiffness = "k"
preload = "0 N"

[[effect]]
type = "viscous_friction"
at = "body"
coefficient = "b"
"""
MASS, STIFFNESS, DAMPING, HARDENING = 52.0, 2100.0, 160.0, 1e6  # the truth
RATE, COUNT, FINE, NOISE, FORCE_NOISE = 400.0, 4000, 10, 1e-5, 0.5


def robot(passive: bool) -> Robot:
    return robot_from_text(MODEL.replace("PASSIVE", "passive = true" if passive else ""), "shaker.toml")


@cache
def record(seed: int, hardening: float, pushed: float = 0.0) -> Recording:
    """The table follows a sum of sines; symplectic Euler, ten steps per sample. ``pushed`` (N) acts on the body."""
    rng = np.random.default_rng(seed)
    frequency = 2.0 * np.pi * np.linspace(0.3, 6.0, 14) * (1.0 + 0.04 * seed)
    phase, size = rng.uniform(0.0, 2.0 * np.pi, 14), 0.03 / frequency**0.8
    fine = np.arange(COUNT * FINE)[:, None] / (RATE * FINE)
    table = np.sin(frequency * fine + phase) @ size
    speed = np.cos(frequency * fine + phase) @ (size * frequency)
    force = pushed * np.sin(0.7 * frequency * fine[:, :1] + 2.0 * phase).sum(axis=1)
    at, place, quick = np.empty(len(table)), 0.0, 0.0
    for i, (x, v, f) in enumerate(zip(table.tolist(), speed.tolist(), force.tolist(), strict=True)):
        at[i] = place
        d = place - x
        quick += (f - STIFFNESS * d - hardening * d**3 - DAMPING * (quick - v)) / (MASS * RATE * FINE)
        place += quick / (RATE * FINE)
    noise = NOISE * rng.standard_normal((2, COUNT))
    channels = {
        (Quantity.POSITION, "table", Side.LINK): table[::FINE] + noise[0],
        (Quantity.POSITION, "body", Side.LINK): (at - table)[::FINE] + noise[1],
    }
    if pushed:
        channels[Quantity.EFFORT, "body", Side.LINK] = force[::FINE] + FORCE_NOISE * rng.standard_normal(COUNT)
    time = np.arange(COUNT) / RATE
    return Recording("shaker", time, MappingProxyType(channels), 1.0 / RATE, (slice(0, COUNT),), (), "0" * 64)


def told_of_the_table(found: Diagnosis) -> bool:
    return any("nothing was recorded of what moves table" in alarm for alarm in found.alarms)


def test_what_a_mass_on_a_shaker_lacks_is_told_without_the_force_of_the_shaker() -> None:
    found = diagnose(robot(passive=True), record(1, HARDENING), record(2, HARDENING))
    (finding,) = found.findings
    assert (finding.effect, finding.place) == ("hardening_spring", "body")
    stiffness = finding.parameters["stiffness"]
    assert stiffness.value * MASS / 40.0 == pytest.approx(HARDENING, rel=0.01)  # nothing tells its mass
    assert found.verdict is Verdict.MISSING_PHYSICS
    assert not found.remaining.structured
    assert set(found.per_joint) == {"body"}
    assert found.traces.joints == ("body",)
    assert told_of_the_table(found)
    assert found.judged == "inertial effort"


def test_with_a_measured_force_the_mass_is_told_while_another_joint_is_moved_by_hand() -> None:
    found = diagnose(robot(passive=False), record(1, 0.0, 8.0), record(2, 0.0, 8.0))
    assert found.verdict is Verdict.COMPLETE
    assert found.findings == ()
    assert found.judged == "effort"
    mass = found.model["m"]
    assert mass.se is not None
    assert abs(mass.value - MASS) < 4.0 * mass.se < 0.1 * MASS
    assert told_of_the_table(found)


def test_without_any_force_a_fit_takes_masses_as_given() -> None:
    done = identify(robot(passive=True), record(1, 0.0))
    assert "m" not in done.parameters
    share = 40.0 / MASS
    assert done.parameters["k"].value == pytest.approx(share * STIFFNESS, rel=0.01)
    assert done.parameters["b"].value == pytest.approx(share * DAMPING, rel=0.01)
    assert 0.0 < done.error < 0.05  # of what its inertia does
    assert any("nothing was recorded of what moves table" in alarm for alarm in done.alarms)


def test_what_moves_a_joint_is_recorded_in_both_runs_or_in_none() -> None:
    training, heldout = record(1, 0.0, 8.0), record(2, 0.0, 8.0)
    force = np.zeros(COUNT)
    more = MappingProxyType({**heldout.channels, (Quantity.EFFORT, "table", Side.LINK): force})
    with pytest.raises(InputError, match="no effort of joint 'table', and the other one does") as caught:
        diagnose(robot(passive=False), training, replace(heldout, channels=more))
    assert [problem.code for problem in caught.value.problems] == ["SD520"]
