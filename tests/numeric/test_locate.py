"""Where and when: each planted mismatch is told by the condition that it follows; joints at rest; noise floors."""

from __future__ import annotations

import re

import numpy as np
import pytest

from symdyn.compiler import robot_from_text
from symdyn.numeric.conclude import where_and_when
from symdyn.numeric.diagnose import diagnose
from symdyn.numeric.excitation import unexcited
from symdyn.numeric.explanation import Case
from symdyn.numeric.findings import Finding, Located
from symdyn.numeric.locate import with_found
from symdyn.numeric.noise_floor import in_band, noise_density
from symdyn.numeric.position_noise import speed_noise
from symdyn.numeric.recording import Recording
from symdyn.numeric.setting import prepare
from symdyn.numeric.standstill import admissible_residual
from symdyn.spec.edit import add_effect
from symdyn.spec.records import Robot

from .pendulum import ANGLE_NOISE, TORQUE_NOISE, Torque, pendulum, record, recording

HELDOUT = 100

FOLLOWS: dict[str, tuple[Torque, tuple[str, ...]]] = {
    "Coulomb friction": (lambda t, q, v, a: 0.3 * np.sign(v), ("sign of speed",)),
    "ripple": (lambda t, q, v, a: -0.25 * np.sin(9 * q + 0.7), ("angle order 9",)),
    "spring": (lambda t, q, v, a: 0.8 * (q + 0.5), ("always", "position")),
    "drag": (lambda t, q, v, a: 0.15 * v * np.abs(v), ("speed",)),
    "offset": (lambda t, q, v, a: np.full_like(q, 0.3), ("always",)),
    "size of acceleration": (lambda t, q, v, a: 0.02 * np.abs(a), ("acceleration",)),
    "drift": (lambda t, q, v, a: 0.3 * np.tanh(t - 8), ("time",)),
}


@pytest.fixture(scope="module")
def robot() -> Robot:
    return pendulum()


def located(robot: Robot, missing: Torque | None, seed: int = 1) -> tuple[Located, ...]:
    runs = (record(seed, missing), record(seed + HELDOUT, missing))
    case = case_of(robot, *runs)
    return where_and_when(case, case.explain())


@pytest.mark.parametrize("name", FOLLOWS)
def test_mismatch_is_told_by_what_it_follows(robot: Robot, name: str) -> None:
    missing, condition = FOLLOWS[name]
    (place,) = located(robot, missing)
    assert (place.place, place.group) == ("arm", ("arm",))
    assert place.when[: len(condition)] == condition
    assert place.evidence > 50.0


@pytest.mark.parametrize("seed", range(1, 6))
def test_a_complete_model_is_located_nowhere(robot: Robot, seed: int) -> None:
    assert located(robot, None, seed) == ()


def test_what_follows_no_condition_is_told_by_its_frequency(robot: Robot) -> None:
    (place,) = located(robot, lambda t, q, v, a: 0.3 * np.sin(2 * np.pi * 1.3 * t))
    assert place.when[-1] == "about 1.3 Hz"


def test_noise_floor_is_that_of_the_sensor_in_the_band(robot: Robot) -> None:
    case = case_of(robot, record(1), band=5.0)
    density = noise_density(case.bench, case.explain().fit.p)
    assert density == pytest.approx(TORQUE_NOISE * np.sqrt(2 / 500.0), rel=0.1)
    noise = TORQUE_NOISE * np.random.default_rng(0).standard_normal(case.bench.observation.tau.shape)
    assert in_band(density, case.bench) == pytest.approx(case.bench.bring(noise).std(), rel=0.15)


def test_speed_noise_is_that_of_the_differentiated_sensor(robot: Robot) -> None:
    o = case_of(robot, record(1), band=5.0).bench.observation
    quiet = case_of(robot, record(1, noise=False), band=5.0).bench.observation
    expected = ANGLE_NOISE * np.sqrt(2 / 500.0 * (2 * np.pi) ** 2 * o.cutoff**3 / 3)
    assert speed_noise(o) == pytest.approx(expected, rel=0.2)
    assert speed_noise(quiet)[0] < 0.2 * expected


def case_of(robot: Robot, training: Recording, heldout: Recording | None = None, band: float | None = None) -> Case:
    setting = prepare(robot, training, heldout or training, lambda _: None)
    return setting.case(band or setting.given())


def test_dry_friction_at_rest_is_any_force_between_its_limits(robot: Robot) -> None:
    """The arm stands for half of the time, and its motor pushes with less than the friction."""
    time = np.arange(10_000) / 500.0
    moving = (time % 4.0) < 2.0
    swing = np.where(moving, 0.5 * np.sin(np.pi * time / 2.0) ** 2 * np.sin(np.pi * time), 0.0)
    q = np.where(moving, swing, 0.0) - 0.5
    v, a = np.gradient(q, time), np.gradient(np.gradient(q, time), time)
    push = 0.2 * np.sin(9.0 * time)
    law = 1.5 * 9.81 * 0.3 * np.cos(q) + 0.185 * a + 0.2 * v
    tau = law + np.where(moving, 0.3 * np.sign(v), push)
    held = robot_from_text(add_effect(robot.text, "coulomb_friction", "arm", {"level": "0 N m"}), "held.toml")
    case = case_of(held, recording(time, q + 1e-7 * np.sin(1e5 * time), tau), band=5.0)
    p = case.bench.kernel.values
    friction = case.bench.index["arm_coulomb_friction_level"]
    phase = case.bench.bring(time) % 4.0
    rest = (phase > 2.4) & (phase < 3.6)  # clear of the filters' transients
    without = admissible_residual(case.bench, p)[rest, 0]
    np.testing.assert_array_equal(without, case.bench.bring(case.bench.raw_residual(p))[rest, 0])
    assert np.abs(without).max() > 0.15
    p[friction] = 0.3
    assert np.abs(admissible_residual(case.bench, p)[rest, 0]).max() == 0.0
    p[friction] = 0.1  # holds less than the motor pushes
    short = np.abs(admissible_residual(case.bench, p)[rest, 0]).max()
    assert short == pytest.approx(0.1, abs=0.03)


@pytest.mark.parametrize(("amplitude", "told"), [(1.2, False), (0.0, True)])
def test_directions_that_are_not_excited_are_named(robot: Robot, amplitude: float, told: bool) -> None:
    case = case_of(robot, record(1, amplitude=amplitude), record(2, amplitude=amplitude))
    fitted = case.explain()
    sentences = unexcited(case.bench, fitted.fit.p, fitted.fit.names, fitted.training, fitted.weight)
    assert bool(sentences) is told
    assert all("do not excite" in sentence for sentence in sentences)
    assert any("b" in re.findall(r"\w+", sentence) for sentence in sentences) is told


@pytest.mark.slow  # a whole diagnosis
def test_evidence_and_group_stand_in_the_finding(robot: Robot) -> None:
    def friction(t: np.ndarray, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
        return 0.3 * np.sign(v)

    short, long = (
        diagnose(robot, record(1, friction, duration=d), record(101, friction, duration=d)) for d in (10.0, 20.0)
    )
    (first,), (second,) = short.findings, long.findings
    assert (first.group, second.group) == (("arm",), ("arm",))
    assert 50.0 < first.evidence < second.evidence


def test_a_place_where_an_effect_was_found_is_told_where_no_condition_pointed_at_it() -> None:
    def finding(place: str, evidence: float, *group: str) -> Finding:
        return Finding("spring", "spring", place, {}, 0.1, 0.01, 0.0, (), group=group, evidence=evidence)

    told = Located("j1", ("j1", "j1.motor"), 20.0, ("speed",))
    found = [finding("j1.motor", 90.0, "j1.motor"), finding("j2", 50.0), finding("j2", 9.0), finding("j3", 0.0)]
    assert with_found((told,), found) == (Located("j2", (), 50.0), told)
