"""Machines in closed loop, of which the reference was recorded and not what the loop made of it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

import numpy as np
import pytest

from symdyn.compiler import robot_from_text
from symdyn.numeric.diagnose import diagnose
from symdyn.numeric.filtering.bench import FilterBench
from symdyn.numeric.filtering.between import Between
from symdyn.numeric.filtering.conclude import specification
from symdyn.numeric.filtering.driving import limits
from symdyn.numeric.filtering.hypotheses import hypotheses
from symdyn.numeric.filtering.judged import explained
from symdyn.numeric.filtering.likelihood import fit
from symdyn.numeric.filtering.model import Model, candidate_beliefs, prepare, without_latent
from symdyn.numeric.filtering.places import push_at
from symdyn.numeric.filtering.structure import with_shaft
from symdyn.numeric.findings import Diagnosis, Verdict
from symdyn.numeric.recording import Recording
from symdyn.numeric.servo_loops import as_driven, loops_left_out
from symdyn.spec.places import places
from symdyn.spec.records import Quantity, Robot, Side
from tests.numeric.filtering.positioner import GAIN, MODEL, recorded


@pytest.fixture(scope="module")
def robot() -> Robot:
    return robot_from_text(MODEL, "positioner.toml")


@pytest.fixture(scope="module")
def known() -> Robot:
    return robot_from_text(MODEL + GAIN, "positioner.toml")


def with_channel(recording: Recording, quantity: Quantity) -> Recording:
    more = {(quantity, "arm", Side.LINK): np.ones(len(recording.time))}
    return replace(recording, channels=MappingProxyType({**recording.channels, **more}))


def test_a_loop_is_cut_where_what_drives_the_motor_was_recorded(robot: Robot, tmp_path: Path) -> None:
    closed = recorded(tmp_path / "a.csv", robot, 1, seconds=1.0)
    assert as_driven(robot, [closed]) is robot
    for quantity in (Quantity.VOLTAGE, Quantity.CURRENT, Quantity.EFFORT):
        cut = as_driven(robot, [with_channel(closed, quantity)])
        assert [e.type for e in cut.effects] == ["viscous_friction"]
        assert loops_left_out(robot, cut) == (
            "the servo loop of arm is not tested: what was recorded behind it drives the machine",
        )


def test_a_sampled_loop_is_taken_for_continuous(tmp_path: Path) -> None:
    sampled = robot_from_text(MODEL.replace("limit = 1000", 'limit = 1000\nperiod = "2 ms"'), "sampled.toml")
    driven = as_driven(sampled, [recorded(tmp_path / "a.csv", sampled, 1, seconds=1.0)])
    assert loops_left_out(sampled, driven) == (
        "the servo loop at arm.motor is sampled every 0.002 s, and taken for continuous",
    )
    assert not dict(driven.effects[1].values)["period"].coefficient


def test_a_late_reference_is_asked_for_once(robot: Robot, tmp_path: Path) -> None:
    """Of each position that is followed; not where a voltage drives the machine, nor where the model has it."""
    declared = '\n[[effect]]\ntype = "reference_delay"\nat = "arm.motor"\ndelay = "5 ms"\n'
    told = robot_from_text(MODEL.replace("\n[recording]", f"{declared}\n[recording]"), "late.toml")
    text = MODEL.replace("position_servo", "speed_loop").replace('"P"', "0.1").replace('derivative = "D"\n', "")
    asked = 'quantity = "reference"\njoint = "arm"\nunit = "rad'
    speed = robot_from_text(text.replace(asked, f"{asked}/s"), "speed.toml")
    for machine, at in ((robot, ["arm.motor"]), (told, []), (speed, [])):
        found = [c for c in hypotheses(machine) if "delay" in c.effect]
        assert [c.place.address for c in found if c.effect == "reference_delay"] == at
        assert not [c for c in found if c.effect == "input_delay"]
    cut = as_driven(robot, [with_channel(recorded(tmp_path / "a.csv", robot, 1, seconds=1.0), Quantity.VOLTAGE)])
    assert [c.place.address for c in hypotheses(cut) if "delay" in c.effect] == ["arm.circuit"]


def _prepared(robot: Robot, recording: Recording) -> Model:
    return prepare(robot, recording, recording)


def test_a_centre_of_mass_may_be_on_either_side(robot: Robot, tmp_path: Path) -> None:
    """A link's frame is at its end in the standard convention, and its centre of mass behind it."""
    recording = recorded(tmp_path / "a.csv", robot, 1, seconds=1.0)
    rows = MODEL.replace('["q - 90 deg", 0, 0, 0]', '["q - 90 deg", 0, 0.35, 0]')
    for centre in (-0.15, 0.0):
        behind = robot_from_text(rows.replace('"0.2 m"', f'"{centre} m"'), "behind.toml")
        belief = prepare(behind, recording, recording, only=("",)).beliefs["c"]
        assert [belief.value(belief.coordinate(c)) for c in (centre, -0.2)] == [centre, -0.2]


def test_limits_that_are_tried_are_volts(robot: Robot, tmp_path: Path) -> None:
    """Not the reference's radians: of P = 3.6 V/rad on all of it and down to a hundredth."""
    model = _prepared(robot, recorded(tmp_path / "a.csv", robot, 1, seconds=1.0))
    circuit = next(place for place in places(robot) if place.address == "arm.circuit")
    tried = limits(model.kernel, model.training, circuit.address, push_at(circuit))
    most = 3.6 * np.max(np.abs(model.training.u))
    assert tried.max() == pytest.approx(most, rel=1e-6)
    assert tried.min() == pytest.approx(0.01 * most, rel=1e-6)


def test_a_filter_takes_parameters_that_change_from_run_to_run(known: Robot, tmp_path: Path) -> None:
    """As likely as each run by itself with its own gain, given to the filter as a number."""
    one, other = (recorded(tmp_path / f"{g}.csv", known, 1, 200.0, 2.0, gain=g) for g in (2.0, 6.0))
    channels = {key: np.concatenate([one.channels[key], other.channels[key]]) for key in one.channels}
    both = replace(
        one,
        time=np.concatenate([one.time, one.time[-1] + 1.0 + other.time]),
        channels=MappingProxyType(channels),
        segments=(slice(0, len(one.time)), slice(len(one.time), 2 * len(one.time))),
    )
    model = _prepared(known, both)
    noise = without_latent(model, model.training)
    told = model.bench(model.training, noise, Between.STRAIGHT).filtered(model.values)
    gain = model.kernel.parameters.index("P")
    for part, recording in zip(both.segments, (one, other), strict=True):
        alone = _prepared(known, recording)
        values = model.values
        values[gain] = 2.0 if recording is one else 6.0
        signals = replace(alone.training, known=None)
        bench = FilterBench(model.kernel, signals, noise, Between.STRAIGHT, 3, model.delays)
        late = slice(part.start + 50, part.stop)  # a run begins less well known after another than alone
        np.testing.assert_allclose(told.innovations[late], bench.filtered(values).innovations[50:], atol=2e-5)
    wrong = FilterBench(model.kernel, replace(model.training, known=None), noise, Between.STRAIGHT, 3, model.delays)
    assert wrong.filtered(model.values).loss > told.loss + 1000.0


def test_a_model_keeps_what_a_fit_did_not_move_as_it_was_written(robot: Robot, tmp_path: Path) -> None:
    """No default of the loop, such as its tracking time, is written down, and no number in other digits."""
    model = _prepared(robot, recorded(tmp_path / "a.csv", robot, 1, 200.0, 2.0))
    bench = model.bench(model.training, without_latent(model, model.training), Between.STRAIGHT)
    told = fit(bench, model.values, {"c": model.beliefs["c"]}, most=1)
    after = specification(model, robot, explained(model, (), dict(model.beliefs), told)).text.splitlines()
    changed = [line for line, old in zip(after, robot.text.splitlines(), strict=True) if line != old]
    assert len(changed) == 1
    assert changed[0].startswith("c = ")


def _diagnosed(robot: Robot, tmp_path: Path, **concealed: float) -> Diagnosis:
    runs = (recorded(tmp_path / f"{seed}.csv", robot, seed, **concealed) for seed in (1, 2))
    return diagnose(robot, *runs)


@pytest.mark.slow
def test_nothing_is_missing_in_closed_loop(robot: Robot, tmp_path: Path) -> None:
    found = _diagnosed(robot, tmp_path)
    assert (found.verdict, found.findings) == (Verdict.COMPLETE, ())


@pytest.mark.slow
def test_dry_friction_behind_a_servo(robot: Robot, tmp_path: Path) -> None:
    found = _diagnosed(robot, tmp_path, dry=1.1)
    assert [(f.effect, f.place) for f in found.findings] == [("coulomb_friction", "arm")]
    level = found.findings[0].parameters["level"]
    assert level.se is not None
    assert abs(level.value - 1.1) < 3.0 * level.se  # no scale of effort is known but that of a data sheet


@pytest.mark.slow
def test_a_limit_that_a_servo_reaches(robot: Robot, tmp_path: Path) -> None:
    found = _diagnosed(robot, tmp_path, limit=9.0)
    assert [(f.effect, f.place) for f in found.findings] == [("amplifier_saturation", "arm.circuit")]
    assert found.after.heldout < 0.02 * found.before.heldout


@pytest.mark.slow
def test_a_reference_that_comes_late(robot: Robot, tmp_path: Path) -> None:
    """Or half a sample less, if the loop holds it between samples, which looks the same."""
    found = _diagnosed(robot, tmp_path, late=0.013)
    assert [(f.effect, f.place) for f in found.findings] == [("reference_delay", "arm.motor")]
    delay = found.findings[0].parameters["delay"]
    assert min(abs(delay.value - late) for late in (0.012, 0.013)) < 1e-4
    assert [e.type for e in found.diagnosed.effects][-1] == "reference_delay"


@pytest.mark.slow
def test_a_delay_that_was_found_stays_where_a_rotor_is_freed(robot: Robot, tmp_path: Path) -> None:
    recording = recorded(tmp_path / "a.csv", robot, 1, 200.0, 2.0, late=0.02)
    model = _prepared(robot, recording)
    late = next(c for c in model.proposed if c.effect == "reference_delay")
    bench, p = model.bench(model.training, without_latent(model, model.training), Between.STRAIGHT), model.values
    p[bench.index[late.parameter(late.linear[0])]] = 0.02
    beliefs = {**model.beliefs, **candidate_beliefs(late, None)}
    current = explained(model, ((late, None),), beliefs, fit(bench, p, beliefs, most=2))
    _, after = with_shaft(model.robot, model.robot.joints[0], (), (), current, (recording, recording), lambda _: None)
    delay = after.fit.bench.index[late.parameter(late.linear[0])]
    assert after.fit.p[delay] == pytest.approx(0.02, abs=0.003)
    assert late.parameter(late.linear[0]) in after.beliefs
