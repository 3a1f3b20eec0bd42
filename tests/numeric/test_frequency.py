"""The linear model of the seed's drive as a python-control system, and beside its compiled kernel."""

from __future__ import annotations

import numpy as np
import pytest

from symdyn.compiler import compile_robot, linearise, load_robot
from symdyn.derive.linearize import without_nonsmooth
from symdyn.numeric.linear.signals import as_control


def test_the_seeds_drive_has_the_poles_of_its_printed_parameters() -> None:
    system = as_control(linearise(without_nonsmooth(load_robot("irb6-axis1"))).nominal)
    assert system.nstates == 9
    poles = system.poles()
    real = sorted(p.real for p in poles if abs(p.imag) < 1e-6)
    assert real == pytest.approx([-18277.8, -8.859, 0.0], rel=1e-4, abs=1e-4)
    pairs = sorted((abs(p) / (2 * np.pi), -p.real / abs(p)) for p in poles if p.imag > 1e-6)
    assert [f for f, _ in pairs] == pytest.approx([15.17, 623.6, 1261.1], rel=5e-4)
    assert [z for _, z in pairs] == pytest.approx([0.116, 0.064, 0.105], abs=6e-4)


def test_the_kernel_and_the_arrays_say_the_same() -> None:
    robot = without_nonsmooth(load_robot("irb6-axis1"))
    kernel, nominal = compile_robot(robot).kernel(), linearise(robot).nominal
    system = as_control(nominal)
    x, u = np.zeros(len(kernel.states)), np.zeros(len(kernel.inputs))
    pairs = (
        (system.A, kernel.state_derivative_state_jacobian(x, u)),
        (system.B, kernel.state_derivative_input_jacobian(x, u)),
        (system.C, kernel.output_state_jacobian(x, u)),
        (system.D, kernel.output_input_jacobian(x, u)),
    )
    for arrays, compiled in pairs:
        assert arrays == pytest.approx(compiled, rel=1e-12, abs=1e-12 * max(1.0, float(np.abs(compiled).max())))
    assert nominal.states == kernel.states
    assert nominal.outputs == kernel.outputs
