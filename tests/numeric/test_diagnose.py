"""Diagnosis of a pendulum: what is missing is named with its value, and nothing is invented."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from symdyn.base.errors import InputError
from symdyn.compiler import robot_from_text
from symdyn.numeric.candidates import candidates
from symdyn.numeric.diagnose import diagnose
from symdyn.numeric.findings import Diagnosis, Verdict
from symdyn.numeric.recording import Recording
from symdyn.spec.records import Robot

from .pendulum import INERTIA, MASS, TOML, TORQUE_NOISE, VISCOUS, Torque, motion, pendulum, record, recording
from .slide import SLIDE

HELDOUT = 100  # added to the seed: another motion, other noise

# The torque on the resisting side; the effects that make it, with the values they must have.
MISSING: dict[str, tuple[Torque, Mapping[str, Mapping[str, float]]]] = {
    "Coulomb friction": (lambda t, q, v, a: 0.3 * np.sign(v), {"coulomb_friction": {"level": 0.3}}),
    "spring": (lambda t, q, v, a: 0.8 * (q - 0.3), {"linear_spring": {"stiffness": 0.8, "preload": 0.24}}),
    "ripple": (
        lambda t, q, v, a: -0.25 * np.sin(9 * q + 0.7),
        {"torque_ripple": {"cosine": 0.25 * np.sin(0.7), "sine": 0.25 * np.cos(0.7), "order": 9.0}},
    ),
    "drag": (lambda t, q, v, a: 0.15 * v * np.abs(v), {"quadratic_drag": {"coefficient": 0.15}}),
    "hardening spring": (lambda t, q, v, a: 2.0 * q**3, {"hardening_spring": {"stiffness": 2.0}}),
    "friction that differs by direction": (
        lambda t, q, v, a: 0.08 * np.abs(v),
        {"asymmetric_viscous_friction": {"difference": 0.08}},
    ),
    "Stribeck friction": (
        lambda t, q, v, a: (0.3 + 0.3 * np.exp(-((v / 0.2) ** 2))) * np.sign(v),
        {"coulomb_friction": {"level": 0.3}, "stribeck_friction": {"excess": 0.3, "stribeck_velocity": 0.2}},
    ),
}
CORE = ("Coulomb friction", "ripple")  # the others are slow: a few seconds each

# Torques of a kind that no effect in the catalogue has, all of which a diagnosis can see something of.
FOREIGN: dict[str, Torque] = {
    "a hump in angle": lambda t, q, v, a: 0.4 * np.exp(-(((q + 0.4) / 0.1) ** 2)),
    "friction above a speed": lambda t, q, v, a: 0.3 * np.sign(v) * (np.abs(v) > 0.5),
    "a hump in speed": lambda t, q, v, a: 0.3 * np.exp(-(((v - 0.6) / 0.1) ** 2)),
    "size of acceleration": lambda t, q, v, a: 0.02 * np.abs(a),
    "a soft end stop": lambda t, q, v, a: 8.0 * np.maximum(q + 0.1, 0.0),
}


@pytest.fixture(scope="module")
def robot() -> Robot:
    return pendulum()


def diagnosed(robot: Robot, missing: Torque | None, seed: int = 1, **how: float) -> Diagnosis:
    return diagnose(robot, record(seed, missing, **how), record(seed + HELDOUT, missing, **how))  # type: ignore[arg-type]


@cache
def known(name: str) -> Diagnosis:
    """One of the catalogue's effects, found once for all tests."""
    return diagnosed(pendulum(), MISSING[name][0])


def cases(core: tuple[str, ...]) -> list[object]:
    return [pytest.param(name, marks=() if name in core else pytest.mark.slow) for name in MISSING]


@pytest.mark.parametrize("name", cases(CORE))
def test_missing_effect_is_named_and_its_value_is_right(name: str) -> None:
    expected, found = MISSING[name][1], known(name)
    assert found.verdict is Verdict.MISSING_PHYSICS
    assert {finding.effect: finding.place for finding in found.findings} == dict.fromkeys(expected, "arm")
    for finding in found.findings:
        assert set(finding.parameters) == set(expected[finding.effect])
        for parameter, truth in expected[finding.effect].items():
            estimate = finding.parameters[parameter]
            assert estimate.se is not None
            # Effects that jump are low-passed with the motion, which costs them a little more than noise does.
            assert abs(estimate.value - truth) < max(4.0 * estimate.se, 0.01 * abs(truth)), parameter
            assert estimate.se < 0.1 * abs(truth)


@pytest.mark.slow
def test_a_wave_along_an_axis_that_slides_is_a_ripple_too() -> None:
    """A rack, a screw and a linear motor have a pitch: their order is in rad/m."""
    slide = robot_from_text(SLIDE, "slide.toml")

    def recorded(seed: int) -> Recording:
        time = np.arange(5000) / 500.0
        q, v, a = motion(seed, time, 0.4)
        force = 3.0 * a + 2.0 * v - 0.5 * np.cos(40.0 * q)  # a force that drives
        rng = np.random.default_rng([seed, 2])
        q, force = q + 1e-6 * rng.standard_normal(len(q)), force + 0.02 * rng.standard_normal(len(q))
        return recording(time, q, force, f"run-{seed}")

    found = diagnose(slide, recorded(1), recorded(1 + HELDOUT))
    assert found.verdict is Verdict.MISSING_PHYSICS
    (ripple,) = found.findings
    assert (ripple.effect, ripple.place) == ("torque_ripple", "arm")
    assert {name: e.value for name, e in ripple.parameters.items()} == pytest.approx(
        {"cosine": 0.5, "sine": 0.0, "order": 40.0}, abs=0.02
    )
    assert ripple.parameters["order"].unit == "rad/m"


@pytest.mark.slow
def test_two_effects_that_hide_each_other_are_found_together() -> None:
    """Fitted by viscous friction, dry friction and quadratic drag leave opposite curves of speed, of one size here."""
    slide = robot_from_text(SLIDE, "slide.toml")

    def recorded(seed: int) -> Recording:
        rng, time = np.random.default_rng([seed, 5]), np.arange(5000) / 500.0
        omega, size = 2.0 * np.pi * np.array([0.4, 0.93]) * (1.0 + 0.001 * seed), np.array([0.4, 0.02])
        angle = np.outer(time, omega) + rng.uniform(0.0, 2.0 * np.pi, 2)
        q, v, a = np.sin(angle) @ size, np.cos(angle) @ (size * omega), -np.sin(angle) @ (size * omega**2)
        noise = rng.standard_normal((2, len(time)))
        force = 3.0 * a + 2.0 * v + 0.3 * np.sign(v) + 1.0 * v * np.abs(v) + 0.02 * noise[0]
        return recording(time, q + 1e-6 * noise[1], force, f"run-{seed}")

    found = diagnose(slide, recorded(1), recorded(1 + HELDOUT))
    assert found.verdict is Verdict.MISSING_PHYSICS
    told = {f.effect: next(iter(f.parameters.values())) for f in found.findings}
    assert set(told) == {"coulomb_friction", "quadratic_drag"}
    for effect, truth in (("coulomb_friction", 0.3), ("quadratic_drag", 1.0)):
        se = told[effect].se
        assert se is not None
        assert abs(told[effect].value - truth) < 4.0 * se < 0.05 * truth


@pytest.mark.slow  # two whole diagnoses
@pytest.mark.parametrize("missing", [None, "Coulomb friction"])
def test_steps_of_an_encoder_make_no_inertia_smaller(robot: Robot, missing: str | None) -> None:
    """Second differences of 100 steps per turn are mostly steps: least squares on them loses all inertia but 0.4 %."""
    step, runs = 2.0 * np.pi / 100.0, []
    for seed in (1, 1 + HELDOUT):
        shown = record(seed, None if missing is None else MISSING[missing][0])
        channels = {k: step * np.round(x / step) if k[0] == "position" else x for k, x in shown.channels.items()}
        runs.append(replace(shown, channels=channels))
    found = diagnose(robot, *runs)
    assert {f.effect for f in found.findings} == {"encoder"} | ({"coulomb_friction"} if missing else set())
    assert found.verdict is Verdict.MISSING_PHYSICS
    model = {name: estimate.value for name, estimate in found.model.items()}
    assert model["I"] + model["m"] * model["r"] ** 2 == pytest.approx(INERTIA + MASS * 0.3**2, rel=0.01)


def test_a_joint_that_nothing_drives_has_no_friction_by_load() -> None:
    """What its links need is its friction, and nothing else: any part of it would do."""
    passive = robot_from_text(TOML.replace('name = "arm"', 'name = "arm"\npassive = true', 1), "free.toml")
    effects = {False: candidates(pendulum()), True: candidates(passive)}
    assert {k for k, found in effects.items() if any(c.effect == "load_dependent_friction" for c in found)} == {False}


def test_errors_told_are_those_of_the_finding() -> None:
    found = known("Coulomb friction")
    (friction,) = found.findings
    assert friction.heldout_before == found.before.heldout
    assert friction.heldout_after == pytest.approx(found.after.heldout, rel=1e-4)
    assert friction.heldout_gain == pytest.approx(found.before.heldout - found.after.heldout, rel=1e-4)
    # Left is the noise of the sensor that fits in the band, and what the friction's jumps lose in it.
    band = 2 * found.band / 500.0
    assert found.after.heldout * np.sqrt(np.mean(found.traces.effort**2)) < 2 * TORQUE_NOISE * np.sqrt(band)
    assert friction.p_value < 1e-6


def test_the_specification_that_comes_out_is_the_machine() -> None:
    """Diagnosed again, the machine lacks nothing: its file holds the effect, in its units, with its value."""
    again = robot_from_text(known("Coulomb friction").diagnosed.text, "again.toml")
    assert [(e.type, e.at) for e in again.effects] == [("viscous_friction", "arm"), ("coulomb_friction", "arm")]
    ((level, _),) = dict(again.effects[1].values)["level"].factors
    assert {p.name: p.value for p in again.parameters}[level] == pytest.approx(0.3, rel=0.01)
    second = diagnosed(again, MISSING["Coulomb friction"][0], seed=2)
    assert (second.verdict, second.findings) == (Verdict.COMPLETE, ())


@pytest.mark.parametrize("seed", [1, 2, *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(3, 13))])
def test_complete_model_is_called_complete(robot: Robot, seed: int) -> None:
    found = diagnosed(robot, None, seed)
    assert (found.verdict, found.findings) == (Verdict.COMPLETE, ())
    assert not found.remaining.structured
    assert found.after.heldout == pytest.approx(found.before.heldout, rel=1e-4)  # values are written with 8 digits
    viscous = found.model["b"]
    assert viscous.se is not None
    assert abs(viscous.value - VISCOUS) < 5 * viscous.se


def test_inertia_that_the_model_can_take_up_is_no_finding(robot: Robot) -> None:
    """A wrong number in the model is not missing physics."""
    found = diagnosed(robot, lambda t, q, v, a: 0.03 * a)
    assert found.verdict is Verdict.COMPLETE
    model = {name: estimate.value for name, estimate in found.model.items()}
    turning = model["I"] + model["m"] * model["r"] ** 2
    assert turning == pytest.approx(INERTIA + MASS * 0.3**2 + 0.03, rel=0.01)


@pytest.mark.slow
@pytest.mark.parametrize("name", list(FOREIGN))
def test_torque_outside_the_catalogue_is_not_explained_away(robot: Robot, name: str) -> None:
    found = diagnosed(robot, FOREIGN[name])
    assert found.verdict is Verdict.UNEXPLAINED  # whatever effects come near
    assert found.remaining.structured
    quantity = {"acceleration": "acceleration", "speed": "speed"}.get(name.rpartition(" ")[2], "position")
    assert found.remaining.variable == f"{quantity} of arm"


@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_torque_that_no_effect_comes_near_leaves_the_recording_unexplained(robot: Robot, seed: int) -> None:
    found = diagnosed(robot, lambda t, q, v, a: 0.1 * v**3 * q, seed)
    assert (found.verdict, found.findings) == (Verdict.UNEXPLAINED, ())
    assert found.remaining.structured
    assert found.remaining.heldout == found.after.heldout > 0.05


@pytest.mark.parametrize("amplitude", [0.0, 1e-2])
def test_recording_that_hardly_moves_invents_nothing(robot: Robot, amplitude: float) -> None:
    found = diagnosed(robot, None, amplitude=amplitude)
    assert (found.verdict, found.findings) == (Verdict.COMPLETE, ())
    assert found.model["m"].se is None  # mass and arm are one number here, and it says so


@pytest.mark.parametrize("duration", [1.0, pytest.param(2.0, marks=pytest.mark.slow)])
@pytest.mark.parametrize("seed", [1, 2, *(pytest.param(s, marks=pytest.mark.slow) for s in range(3, 7))])
def test_short_recording_invents_nothing(robot: Robot, duration: float, seed: int) -> None:
    assert diagnosed(robot, None, seed, duration=duration).findings == ()


def test_same_recordings_give_the_same_bytes(robot: Robot) -> None:
    again = diagnosed(robot, MISSING["ripple"][0])
    first, other = (json.dumps(known(name).to_json()) for name in ("ripple", "Coulomb friction"))
    assert json.dumps(again.to_json()) == first != other


def test_json_has_the_fields_that_programs_read() -> None:
    told = json.loads(json.dumps(known("Coulomb friction").to_json(), allow_nan=False))
    assert told["verdict"] == "missing_physics"
    (finding,) = told["findings"]
    assert (finding["effect"], finding["place"]) == ("coulomb_friction", "arm")
    assert set(finding["parameters"]["level"]) == {"value", "se", "unit"}
    assert finding["parameters"]["level"]["unit"] == "N m"
    assert finding["heldout_gain"] > 0.9 * told["fit"]["before"]["heldout"]
    for when in ("before", "after"):
        assert set(told["fit"][when]) == {"training", "heldout"}
    assert told["recordings"] == {"training": "run-1", "heldout": "run-101"}


def test_band_that_is_given_is_used(robot: Robot) -> None:
    found = diagnose(robot, record(1), record(1 + HELDOUT), band=7.5)
    assert found.band == 7.5


def test_effort_that_nobody_measured_is_asked_for(robot: Robot) -> None:
    full = record(1)
    blind = type(full)(
        full.name,
        full.time,
        {key: values for key, values in full.channels.items() if key[0] != "effort"},
        full.sample_time,
        full.segments,
        (),
        full.sha256,
    )
    with pytest.raises(InputError, match="no effort") as caught:
        diagnose(robot, blind, full)
    assert [problem.code for problem in caught.value.problems] == ["SD520"]


UNSEEN: dict[str, Torque] = {
    "angle times speed": lambda t, q, v, a: 0.3 * v * q,
    "a drift": lambda t, q, v, a: 0.3 * np.tanh(t - 8),
    "a disturbance from outside": lambda t, q, v, a: 0.3 * np.sin(2 * np.pi * 1.3 * t),
}


@pytest.mark.parametrize("name", UNSEEN)
def test_what_no_single_variable_tells_is_not_called_complete(robot: Robot, name: str) -> None:
    found = diagnosed(robot, UNSEEN[name])
    assert found.verdict is Verdict.UNEXPLAINED
    assert found.remaining.share > 0.5


@pytest.mark.slow
def test_a_finding_has_no_rival_that_contains_it(robot: Robot) -> None:
    """A spring without stiffness is an offset: it fits as well by being the same."""
    found = diagnosed(robot, lambda t, q, v, a: np.full_like(q, 0.2))
    assert [f.effect for f in found.findings] == ["force_offset"]
    assert found.findings[0].rivals == ()
    assert found.verdict is Verdict.MISSING_PHYSICS
