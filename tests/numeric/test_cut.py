"""A torque sensor between a drive and its joint: each side of it is tested by itself, and told by itself."""

from __future__ import annotations

import math
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
from symdyn.numeric.recording import ChannelKey, Recording
from symdyn.numeric.torque_sensors import parts
from symdyn.spec.records import Quantity, Robot, Side

from .arm_of_two import ARM_OF_TWO, rubbing, with_drives
from .pendulum import GRAVITY

Array = NDArray[np.float64]

POSITION, VELOCITY, EFFORT, CURRENT = Quantity.POSITION, Quantity.VELOCITY, Quantity.EFFORT, Quantity.CURRENT
RATIO = 50.0
MASS, ARM, TURNING, ROTOR, VISCOUS = 3.0, 0.25, 0.06, 6e-5, 2e-4  # the truth; the model has other numbers
MODEL = f"""
[robot]
name = "sensed"
gravity = [0, -{GRAVITY}, 0]

[parameters]
m = "2.6 kg"
l = "0.29 m"
I = "0.05 kg m^2"
J = "7.5e-5 kg m^2"
b = "1.6e-4 N m s/rad"

[dh]
rows = [["q", 0, 0, 0]]

[[joint]]
name = "arm"
link = {{ mass = "m", com = ["l", 0, 0], inertia = {{ zz = "I" }} }}

[joint.drive]
ratio = {RATIO:g}
rotors = [{{ name = "motor", inertia = "J", fixed_to_joint = true }}]

[[effect]]
type = "viscous_friction"
at = "arm.motor"
coefficient = "b"
"""


@cache
def recorded(seed: int, of_motor: float = 0.0, of_link: float = 0.0, gain: float = 1.0) -> Recording:
    """Coulomb friction before and beyond the sensor; the motor's torque is shown as ``gain`` times what it is."""
    rng = np.random.default_rng(seed)
    t = np.arange(6000) / 500.0
    w = 2.0 * np.pi * np.arange(0.1, 2.0, 0.1)
    phase, size = rng.uniform(0.0, 2.0 * np.pi, len(w)), 0.25 / np.sqrt(np.arange(1, len(w) + 1))
    angle = np.outer(t, w) + phase
    q, v, a = np.sin(angle) @ size, np.cos(angle) @ (size * w), -np.sin(angle) @ (size * w**2)
    beyond = (TURNING + MASS * ARM**2) * a + MASS * ARM * GRAVITY * np.cos(q) + of_link * np.sign(v)
    motor = beyond / RATIO + ROTOR * RATIO * a + VISCOUS * RATIO * v + of_motor * np.sign(v)
    channels: dict[ChannelKey, Array] = {
        (POSITION, "arm", Side.LINK): q + 1e-5 * rng.standard_normal(len(t)),
        (VELOCITY, "arm", Side.LINK): v + 1e-3 * rng.standard_normal(len(t)),
        (EFFORT, "arm", Side.OUTPUT): beyond + 0.02 * rng.standard_normal(len(t)),
        (EFFORT, "arm", Side.MOTOR): gain * motor + 0.001 * rng.standard_normal(len(t)),
    }
    return Recording(f"run-{seed}", t, MappingProxyType(channels), 1 / 500.0, (slice(0, len(t)),), (), "0" * 64)


def told_of(robot: Robot, *recordings: Recording) -> Diagnosis:
    return diagnose(robot, *recordings, band=12.0)


def changed(recording: Recording, channels: dict[ChannelKey, Array], *without: ChannelKey) -> Recording:
    kept = {key: values for key, values in recording.channels.items() if key not in without}
    return replace(recording, channels=MappingProxyType({**kept, **channels}))


@pytest.fixture(scope="module")
def robot() -> Robot:
    return robot_from_text(MODEL, "sensed.toml")


@pytest.mark.slow
def test_nothing_missing_is_told_so_and_both_sides_have_their_numbers(robot: Robot) -> None:
    told = told_of(robot, recorded(1), recorded(2))
    assert (told.verdict, told.findings) == (Verdict.COMPLETE, ())
    weight, turning = (told.model[n].value for n in ("m", "l")), told.model["I"].value
    mass, arm = weight
    assert mass * arm == pytest.approx(MASS * ARM, rel=2e-3)
    assert turning + mass * arm**2 == pytest.approx(TURNING + MASS * ARM**2, rel=5e-3)
    assert told.model["J"].value == pytest.approx(ROTOR, rel=5e-3)  # no recording of one effort tells it from the link
    assert told.model["b"].value == pytest.approx(VISCOUS, rel=5e-3)


@pytest.mark.slow
@pytest.mark.parametrize(("place", "level"), [("arm.motor", 0.03), ("arm", 1.2)])
def test_friction_is_told_on_the_side_where_it_is(robot: Robot, place: str, level: float) -> None:
    sizes = (level, 0.0) if place == "arm.motor" else (0.0, level)
    told = told_of(robot, recorded(1, *sizes), recorded(2, *sizes))
    assert [(f.effect, f.place, f.group) for f in told.findings] == [("coulomb_friction", place, (place,))]
    assert told.findings[0].parameters["level"].value == pytest.approx(level, rel=5e-3)
    assert set(told.per_joint) == set(told.per_joint_before) == {"arm", "arm.motor"}
    parts_of = [errors.heldout for errors in told.per_joint.values()]
    assert told.after.heldout == pytest.approx(math.hypot(*parts_of) / math.sqrt(2.0))
    assert [at.place for at in told.located] == [place]
    assert [(e.type, e.at) for e in told.diagnosed.effects][1:] == [("coulomb_friction", place)]
    again = told_of(told.diagnosed, recorded(3, *sizes), recorded(4, *sizes))  # what was written is what was meant
    assert again.verdict is Verdict.COMPLETE


@pytest.mark.slow
def test_a_motor_that_gives_less_than_it_says_is_told(robot: Robot) -> None:
    told = told_of(robot, recorded(1, gain=1.08), recorded(2, gain=1.08))
    assert [(f.effect, f.place) for f in told.findings] == [("effort_gain", "arm")]
    assert told.findings[0].parameters["gain"].value == pytest.approx(1 / 1.08, rel=2e-3)


@pytest.mark.slow
def test_a_parameter_of_one_side_may_be_held(robot: Robot) -> None:
    told = diagnose(robot, recorded(1), recorded(2), band=12.0, hold=["J"])
    assert "J" not in told.model
    assert "b" in told.model
    assert "I" in told.model


@pytest.mark.slow  # a whole diagnosis
def test_an_effort_of_the_link_beside_one_of_the_motor_is_that_of_a_sensor(robot: Robot) -> None:
    output, link = (EFFORT, "arm", Side.OUTPUT), (EFFORT, "arm", Side.LINK)
    runs = [changed(r, {link: r.channels[output]}, output) for r in (recorded(1, 0.03), recorded(2, 0.03))]
    told = told_of(robot, *runs)
    assert [f.place for f in told.findings] == ["arm.motor"]
    assert any("taken for that of a torque sensor" in alarm for alarm in told.alarms)


@pytest.mark.slow  # a whole diagnosis
def test_without_an_effort_of_the_motor_the_links_alone_are_tested(robot: Robot) -> None:
    runs = [changed(recorded(seed, 0.03, 1.2), {}, (EFFORT, "arm", Side.MOTOR)) for seed in (1, 2)]
    told = told_of(robot, *runs)
    assert [(f.effect, f.place) for f in told.findings] == [("coulomb_friction", "arm")]
    assert "the drive of arm is not tested: no effort of its motor was recorded" in told.alarms
    assert "J" not in told.model


@pytest.mark.slow
def test_what_lies_beyond_a_sensor_may_have_hidden_parts(robot: Robot) -> None:
    """Of the joint its speed alone is known, so a filter follows it; findings are written into the whole text."""
    before = robot_from_text(
        f'{MODEL}\n[[effect]]\ntype = "viscous_friction"\nat = "arm"\ncoefficient = 0.01\n', "s.toml"
    )
    runs = [changed(recorded(seed, 0.0, 1.2), {}, (POSITION, "arm", Side.LINK)) for seed in (1, 2)]
    told = told_of(before, *runs)
    assert [(f.effect, f.place) for f in told.findings] == [("coulomb_friction", "arm")]
    assert told.findings[0].parameters["level"].value == pytest.approx(1.2, rel=0.02)
    assert "the drive of arm is not tested: no position was recorded, of its motor or of the joint" in told.alarms
    motor, arm, new = told.diagnosed.effects
    assert (motor.at, arm.at, new.type) == ("arm.motor", "arm", "coulomb_friction")
    assert (motor.values, arm.values[0][0]) == (before.effects[0].values, "coefficient")


def test_a_fit_takes_either_side_for_what_it_is(robot: Robot) -> None:
    found = identify(robot, recorded(1), band=12.0)
    assert found.error < 0.01
    assert found.parameters["J"].value == pytest.approx(ROTOR, rel=1e-2)
    assert found.parameters["m"].value * found.parameters["l"].value == pytest.approx(MASS * ARM, rel=5e-3)


@pytest.mark.slow
def test_one_joint_of_two_has_a_sensor_and_a_soft_drive_with_a_circuit() -> None:
    """The current tells what the motor exerts; that shafts and circuit are not tested is told."""
    drive = """ratio = 80
rotors = [{ name = "motor", inertia = "1e-9 kg m^2" }]
shafts = [{ name = "gear", from = "motor", to = "joint", stiffness = "9 N m/rad", damping = "1e-3 N m s/rad" }]
motor = { name = "circuit", at = "motor", resistance = 1, torque_constant = 0.1, back_emf_constant = "0.1 V s/rad" }
"""
    robot = robot_from_text(with_drives({"two": drive}), "two.toml")

    def sensed(seed: int) -> Recording:
        plain = rubbing(seed, 0.1)
        effort = plain.channels[EFFORT, "two", Side.LINK]
        speed = np.gradient(plain.channels[POSITION, "two", Side.LINK], plain.time)
        current = (effort / 80.0 + 0.004 * np.tanh(speed / 1e-3)) / 0.1
        return changed(
            plain,
            {(EFFORT, "two", Side.OUTPUT): effort, (CURRENT, "two", Side.LINK): current},
            (EFFORT, "two", Side.LINK),
        )

    told = told_of(robot, sensed(1), sensed(2))
    found = {f.place: f for f in told.findings}
    assert [(f.effect, f.place) for f in told.findings] == [
        ("coulomb_friction", "two"),
        ("coulomb_friction", "two.motor"),
    ]
    assert found["two"].parameters["level"].value == pytest.approx(0.1, rel=0.02)
    assert found["two.motor"].parameters["level"].value == pytest.approx(0.004, rel=0.02)
    assert set(told.per_joint) == {"one", "two", "two.motor"}
    first, second = told.findings
    assert told.before.heldout == pytest.approx(first.heldout_before, rel=1e-3)
    assert first.heldout_before > first.heldout_after == pytest.approx(second.heldout_before, rel=1e-2)
    assert second.heldout_after == pytest.approx(told.after.heldout, rel=1e-2)  # of the whole, step by step
    assert "the transmission of two is taken for rigid, and its shafts are not tested" in told.alarms
    assert any(alarm.startswith("the circuit of two is not tested") for alarm in told.alarms)


def test_a_drive_without_a_rotor_has_nothing_to_test() -> None:
    turning = 'rotors = [{ name = "motor", inertia = "J", fixed_to_joint = true }]\n'
    bare = MODEL.replace(turning, "").split("[[effect]]")[0].replace('J = "7.5e-5 kg m^2"\n', "")
    bare = bare.replace('b = "1.6e-4 N m s/rad"\n', "")
    (links,), told = parts(robot_from_text(bare, "bare.toml"), [recorded(1)])
    assert links.drive is None
    assert told == ["the drive of arm is not tested: the model has no rotor there"]


def test_without_a_drive_its_output_is_the_joint() -> None:
    channel = 'column = "tau"\nquantity = "effort"\njoint = "one"\nunit = "N m"\nside = "output"\n'
    text = f'{ARM_OF_TWO}\n[recording]\ntime = {{ column = "t", unit = "s" }}\n\n[[recording.channel]]\n{channel}'
    channels = robot_from_text(text, "two.toml").channels
    assert channels is not None
    assert [c.side for c in channels.channels] == [Side.LINK]


def test_names_of_a_part_are_those_of_the_whole_again(robot: Robot) -> None:
    (links, drive), _ = parts(robot, [recorded(1)])
    assert [joint.name for joint in drive.of(robot).joints] == ["arm__motor"]
    assert drive.named("Coulomb friction at arm__motor lowers") == "Coulomb friction at arm.motor lowers"
    assert drive.named("arm__motor.tachometer") == "arm.tachometer"
    assert links.named("arm__motor") == "arm__motor"


def test_at_a_drives_output_only_efforts_are_measured() -> None:
    channel = (
        '[[recording.channel]]\ncolumn = "q"\nquantity = "position"\njoint = "arm"\nunit = "rad"\nside = "output"\n'
    )
    text = f'{MODEL}\n[recording]\ntime = {{ column = "t", unit = "s" }}\n\n{channel}'
    with pytest.raises(InputError) as caught:
        robot_from_text(text, "sensed.toml")
    (problem,) = caught.value.problems
    assert problem.code == "SD203"
    assert "at a drive's output an effort is measured, and no position" in problem.message
