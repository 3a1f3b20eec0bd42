"""A drive with its gear ratio, and the same reflected to the motor: the filter sees one machine."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from symdyn.compiler import robot_from_text
from symdyn.numeric.diagnose import diagnose
from symdyn.numeric.filtering.between import Between
from symdyn.numeric.filtering.gears import usual_speeds
from symdyn.numeric.filtering.model import Model, natural_force, prepare, without_latent
from symdyn.numeric.recording import Recording
from symdyn.spec.records import Quantity, Robot, Side
from tests.numeric.filtering.drive import MODEL, record

RATIO = 60.0
PLACES = ("axis.motor", "axis")


def drive(ratio: float) -> Robot:
    """With a shaft between motor and load; the joint's own numbers are those of its side of the gear."""
    text = MODEL.replace(", fixed_to_joint = true", "").replace("ratio = 1", f"ratio = {ratio}")
    text = text.replace('"4e-4 kg m^2"', f'"{4e-4 * ratio**2} kg m^2"')
    text = text.replace('b = "2.5e-4 N m s/rad"', f'b = "{2.5e-4 * ratio**2} N m s/rad"')
    text = text.replace(
        "[joint.drive.motor]",
        'shafts = [ { name = "shaft", from = "motor", to = "joint", stiffness = "2 N m/rad", '
        'damping = "1e-3 N m s/rad" } ]\n\n[joint.drive.motor]',
    )
    return robot_from_text(text, "drive.toml")


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    return record(tmp_path_factory.mktemp("drive") / "a.csv", drive(1.0), 1, stiffness=2.0)


@pytest.fixture(scope="module")
def reflected(recording: Recording) -> Model:
    return prepare(drive(1.0), recording, recording, only=("",))


@pytest.mark.slow  # compiles a second drive
def test_of_a_geared_joint_the_filter_says_the_same(reflected: Model, recording: Recording) -> None:
    geared = prepare(drive(RATIO), recording, recording, only=("",))
    losses = []
    for model in (reflected, geared):
        noise = without_latent(model, model.training)
        done = model.bench(model.training, noise, Between.HELD).filtered(model.values)
        losses.append(done.loss)
    assert losses[1] == pytest.approx(losses[0], rel=1e-6)
    first, second = (natural_force(m, m.training, m.latents[-1].direction) for m in (reflected, geared))
    np.testing.assert_allclose(geared.training.speeds, reflected.training.speeds / [1.0, RATIO])
    assert [x.place for x in geared.latents] == [x.place for x in reflected.latents]
    assert second == pytest.approx(first)  # of the circuit: no gear is between


def test_an_unknown_force_on_a_geared_joint_is_so_much_larger(reflected: Model, recording: Recording) -> None:
    geared = prepare(drive(RATIO), recording, recording, only=("",))
    found = [{x.place: natural_force(m, m.training, x.direction) for x in m.latents} for m in (reflected, geared)]
    assert found[1]["axis"] == pytest.approx(RATIO * found[0]["axis"])
    assert found[1]["axis.motor"] == pytest.approx(found[0]["axis.motor"])


def test_speeds_come_from_the_encoder_or_the_tachometer_or_the_voltage(recording: Recording) -> None:
    robot = drive(RATIO)
    whole = usual_speeds(robot, recording, PLACES)
    no_encoder = {k: v for k, v in recording.channels.items() if k[0] is not Quantity.POSITION}
    blind = {k: v for k, v in no_encoder.items() if k[1] != "axis.motor"}
    nothing = {k: v for k, v in blind.items() if k[0] is Quantity.CURRENT}
    assert whole[0] == pytest.approx(RATIO * whole[1])
    by_tachometer = usual_speeds(robot, replace(recording, channels=no_encoder), PLACES)
    np.testing.assert_allclose(by_tachometer, whole, rtol=0.5)  # one differs over 20 ms, the other shows every swing
    by_voltage = usual_speeds(robot, replace(recording, channels=blind), PLACES)
    assert whole[0] < by_voltage[0] < 10.0 * whole[0]  # what the resistance takes is not speed
    np.testing.assert_allclose(usual_speeds(robot, replace(recording, channels=nothing), PLACES), [RATIO, 1.0])


def test_a_channel_of_the_joint_tells_the_motor(recording: Recording) -> None:
    robot = drive(RATIO)
    key = next(k for k in recording.channels if k[0] is Quantity.POSITION)
    shown = {(Quantity.POSITION, "axis", Side.LINK): recording.channels[key] / RATIO}
    at_joint = usual_speeds(robot, replace(recording, channels=shown), PLACES)
    np.testing.assert_allclose(at_joint, usual_speeds(robot, recording, PLACES))


@pytest.mark.slow  # a whole diagnosis
def test_friction_of_the_motor_of_a_geared_drive_is_named(tmp_path: Path) -> None:
    robot = drive(RATIO)
    runs = [record(tmp_path / f"{seed}.csv", robot, seed, stiffness=2.0, coulomb=0.02) for seed in (1, 2)]
    found = diagnose(robot, *runs)
    assert [(f.effect, f.place) for f in found.findings] == [("coulomb_friction", "axis.motor")]
    level = found.findings[0].parameters["level"]
    assert level.se is not None
    assert abs(level.value - 0.02) < 3.0 * level.se
