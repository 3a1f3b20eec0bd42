"""The linear model of a compiled kernel as a python-control system."""

from __future__ import annotations

import numpy as np
import pytest

from symdyn.compiler import compile_robot, linearise, load_robot
from symdyn.derive.linearize import without_nonsmooth
from symdyn.numeric.frequency import linear_model
from symdyn.numeric.linear.signals import as_control


def test_the_seeds_drive_has_the_poles_of_its_printed_parameters() -> None:
    system = linear_model(compile_robot(without_nonsmooth(load_robot("irb6-axis1"))).kernel())
    assert system.nstates == 9
    poles = system.poles()
    real = sorted(p.real for p in poles if abs(p.imag) < 1e-6)
    assert real == pytest.approx([-18277.8, -8.859, 0.0], rel=1e-4, abs=1e-4)
    pairs = sorted((abs(p) / (2 * np.pi), -p.real / abs(p)) for p in poles if p.imag > 1e-6)
    assert [f for f, _ in pairs] == pytest.approx([15.17, 623.6, 1261.1], rel=5e-4)
    assert [z for _, z in pairs] == pytest.approx([0.116, 0.064, 0.105], abs=6e-4)


def test_the_kernel_and_the_arrays_say_the_same() -> None:
    robot = without_nonsmooth(load_robot("irb6-axis1"))
    compiled, arrays = linear_model(compile_robot(robot).kernel()), as_control(linearise(robot).nominal)
    for ours, theirs in zip((arrays.A, arrays.B, arrays.C, arrays.D), (compiled.A, compiled.B, compiled.C, compiled.D),
                            strict=True):  # fmt: skip
        assert ours == pytest.approx(theirs, rel=1e-12, abs=1e-12 * max(1.0, float(np.abs(theirs).max())))
    assert arrays.state_labels == compiled.state_labels
    assert arrays.output_labels == compiled.output_labels
