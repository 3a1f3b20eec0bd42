"""Motors of which the current was recorded, and no voltage: what the current exerts drives the machine."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

import numpy as np
import pytest

from symdyn.compiler import compile_robot, robot_from_text
from symdyn.numeric.circuits import driven_by_current
from symdyn.numeric.diagnose import diagnose
from symdyn.numeric.filtering.needed import has_hidden_parts
from symdyn.numeric.filtering.signals import seen_by, signals
from symdyn.numeric.identify import identify
from symdyn.numeric.mechanics import mechanics, untested
from symdyn.numeric.recording import Recording
from symdyn.spec.records import Quantity, Robot, Side

from .arm_of_two import ARM_OF_TWO, rubbing, run, with_drives
from .filtering.drive import MODEL, record

RATIOS = {"one": 100.0, "two": -80.0}
CONSTANTS = {"one": 0.06, "two": 0.04}


def with_motors() -> Robot:
    """The arm, each of its joints behind a gear and a d.c. motor."""
    drives = {
        name: f"""ratio = {ratio:g}
rotors = [{{ name = "motor", inertia = "1e-9 kg m^2", fixed_to_joint = true }}]

[joint.drive.motor]
name = "circuit"
at = "motor"
resistance = "1 Ohm"
inductance = "1 mH"
torque_constant = "{CONSTANTS[name]} N m/A"
back_emf_constant = "{CONSTANTS[name]} V s/rad"
"""
        for name, ratio in RATIOS.items()
    }
    return robot_from_text(with_drives(drives), "motors.toml")


def by_currents(recording: Recording, at: str = "") -> Recording:
    channels = {key: values for key, values in recording.channels.items() if key[0] is Quantity.POSITION}
    for (quantity, joint, _), values in recording.channels.items():
        if quantity is Quantity.EFFORT:
            current = values / RATIOS[joint] / CONSTANTS[joint]
            channels[Quantity.CURRENT, f"{joint}.{at}" if at else joint, Side.LINK] = current
    return replace(recording, channels=MappingProxyType(channels))


@pytest.mark.parametrize("at", ["", "motor", "circuit"])
def test_an_arm_recorded_by_its_currents_is_fitted_as_by_its_efforts(at: str) -> None:
    robot, recording = with_motors(), run(1)
    plain = robot_from_text(ARM_OF_TWO, "arm.toml")
    expected = identify(plain, recording, band=12.0)
    for shown in (by_currents(recording, at), recording):  # with efforts, circuits add nothing to them either
        assert not has_hidden_parts(robot, shown)
        told = identify(robot, shown, band=12.0)
        assert told.error == pytest.approx(expected.error, rel=1e-4)
    assert expected.error < 0.02


@pytest.mark.slow
def test_friction_is_found_by_an_arms_currents_alone() -> None:
    runs = [by_currents(rubbing(seed, 0.2)) for seed in (1, 2)]
    found = diagnose(with_motors(), *runs, band=12.0)
    assert [(f.effect, f.place) for f in found.findings] == [("coulomb_friction", "two")]
    assert found.findings[0].parameters["level"].value == pytest.approx(0.2, rel=0.02)
    assert sum("circuit" in alarm and "is not tested" in alarm for alarm in found.alarms) == 2


ELASTIC = MODEL.replace(", fixed_to_joint = true", "").replace(
    "[joint.drive.motor]",
    'shafts = [{ name = "shaft", from = "motor", to = "joint", stiffness = "2 N m/rad", '
    'damping = "1e-3 N m s/rad" }]\n\n[joint.drive.motor]',
)


@pytest.mark.parametrize(
    ("text", "efforts"), [(ELASTIC, {"axis": 0.0, "axis.motor": 0.08}), (MODEL, {"axis": 3 * 0.08})]
)
def test_without_a_voltage_the_current_is_the_filters_input(
    text: str, efforts: dict[str, float], tmp_path: Path
) -> None:
    robot = robot_from_text(text.replace("ratio = 1\n", "ratio = 3\n"), "drive.toml")
    recording = record(tmp_path / "a.csv", robot, 1)
    kept = {k: v for k, v in recording.channels.items() if k[:2] != (Quantity.VOLTAGE, "axis")}
    without = replace(recording, channels=MappingProxyType(kept))
    assert driven_by_current(robot, (recording, without)) is robot  # a voltage in either, and the circuit stays
    seen = seen_by(robot, (without, without))
    kernel = compile_robot(seen).kernel()
    found = signals(seen, kernel, without)
    assert (kernel.inputs, kernel.input_units) == (("axis.input",), ("A",))
    np.testing.assert_array_equal(found.u[:, 0], recording.channels[Quantity.CURRENT, "axis", Side.LINK])
    per_ampere = kernel.actuation_p(np.zeros(len(kernel.states)), np.ones(1), kernel.values)
    assert dict(zip(kernel.coordinates, np.asarray(per_ampere), strict=True)) == pytest.approx(efforts)
    assert untested(robot, seen) == (
        "the circuit of axis is not tested: its motor is driven by what was recorded behind it",
    )


def test_a_robot_without_motors_is_its_own_mechanics() -> None:
    robot = robot_from_text(ARM_OF_TWO, "arm.toml")
    assert mechanics(robot) is robot
    assert untested(robot, robot) == ()
