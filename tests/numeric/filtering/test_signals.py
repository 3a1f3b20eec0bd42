"""What a recording shows of a model."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from symdyn.base.errors import InputError
from symdyn.compiler import compile_robot, load_robot
from symdyn.numeric.filtering.hypotheses import augmented, hypotheses
from symdyn.numeric.filtering.needed import has_hidden_parts
from symdyn.numeric.filtering.places import latents
from symdyn.numeric.filtering.signals import signals
from symdyn.spec.records import Quantity, Robot
from tests.numeric.filtering.drive import record


def test_channels_meet_states_inputs_and_sensors(robot: Robot, tmp_path: Path) -> None:
    recording = record(tmp_path / "a.csv", robot, 1)
    kernel = compile_robot(robot).kernel()
    found = signals(robot, kernel, recording)
    assert found.names == ("axis.motor.current", "axis.q", "axis.motor.voltage")
    assert [(*kernel.states, *kernel.outputs)[i] for i in found.index] == list(found.names)
    assert np.std(found.u) > 1.0  # the command, and not the tachometer's voltage of the same name
    assert found.floor[1] == pytest.approx(1e-8 / 12, rel=1e-6)
    assert found.floor[0] == 0.0
    assert np.isnan(found.steps[-1])
    assert len(set(found.steps[:-1])) == 1  # an even clock is exactly even
    assert has_hidden_parts(robot, recording)


@pytest.mark.parametrize(("gone", "code"), [((Quantity.VOLTAGE, "axis"), "SD520"), ((None, ""), "SD521")])
def test_what_is_missing_is_told(robot: Robot, gone: tuple[Quantity | None, str], code: str, tmp_path: Path) -> None:
    recording = record(tmp_path / "a.csv", robot, 1)
    quantity, at = gone
    command = (Quantity.VOLTAGE, "axis")
    kept = {k: v for k, v in recording.channels.items() if (k[:2] != (quantity, at) if quantity else k[:2] == command)}
    with pytest.raises(InputError, match=code):
        signals(robot, compile_robot(robot).kernel(), replace(recording, channels=kept))


@pytest.mark.slow
def test_every_equation_and_coupling_has_an_unknown_force() -> None:
    robot = load_robot("irb6-axis1")
    proposed = hypotheses(robot)
    kernel = compile_robot(augmented(robot, proposed)).kernel()
    found = {x.place: x.direction for x in latents(robot, kernel, proposed)}
    assert list(found) == [
        "axis1", "axis1.tachometer", "axis1.motor", "axis1.harmonic_drive",
        "axis1.tachometer_shaft", "axis1.motor_shaft", "axis1.flexspline", "axis1.circuit",
    ]  # fmt: skip
    still = np.zeros(9), np.zeros(1)
    push = kernel.state_derivative_parameter_jacobian_p(*still, kernel.values)
    torque = np.array([34e-6, 41e-6, 196e-6, 372e-6]) * (push @ found["axis1.flexspline"])[4:8]
    np.testing.assert_allclose(torque, [0.0, 0.0, 1.0, -1.0], atol=1e-12)  # equal and opposite on its two sides
