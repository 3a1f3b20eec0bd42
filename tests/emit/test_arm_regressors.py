"""The regressor of every bundled arm against Pinocchio's own, entry by entry, over a thousand random states.

A kernel's columns are derivatives with respect to the numbers of the robot's file; Pinocchio's go with ten inertial
parameters of each body (mass, first moments, inertia about the joint), in which efforts are linear. Between the two
stands how those ten depend on the numbers of the file.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from symdyn.compiler import Compiled, compile_robot, load_robot
from symdyn.emit.kernel import Kernel
from symdyn.spec.records import Monomial, Robot
from tests.derive.test_machines import with_numbers
from tests.derive.test_pinocchio import model_of, pin
from tests.emit.test_arms import ARMS, TOLERANCE, states


@cache
def arm(name: str) -> Robot:
    """The rigid arm, its numbers as parameters."""
    robot = load_robot(name)
    return replace(robot, joints=tuple(replace(joint, drive=None) for joint in robot.joints), effects=())


@pytest.fixture(scope="module")
def kernel(interpret: Callable[[Compiled], Kernel]) -> Callable[[str], Kernel]:
    return cache(lambda name: interpret(compile_robot(arm(name))))


def inertial(robot: Robot) -> list[str]:
    """The parameters that stand in an inertial of the file, each of them once and alone, and nowhere else."""
    numbers = [n for j in robot.joints for n in (j.link.mass, *j.link.com, *j.link.inertia)]
    written = [n for n in numbers if n.factors]
    assert all(n == Monomial(n.coefficient, ((name, 1),)) for n in written for name, _ in n.factors)
    names = [name for n in written for name, _ in n.factors]
    assert len(set(names)) == len(names)
    return names


def ten_of_each(robot: Robot, values: dict[str, float]) -> np.ndarray:
    """(10 n,) Pinocchio's parameters of all bodies, in the frames of their joints."""
    model = model_of(with_numbers(robot, values))
    return np.concatenate([body.toDynamicParameters() for body in list(model.inertias)[1:]])


def derivatives_of_ten(robot: Robot) -> np.ndarray:
    """(10 n, numbers): none enters with more than its square, so that central differences of any width are exact."""
    values = {p.name: p.value for p in robot.parameters if p.value is not None}
    found = []
    for name in inertial(robot):
        step = values[name] / 2
        more, less = (ten_of_each(robot, values | {name: values[name] + way * step}) for way in (1, -1))
        found.append((more - less) / (2 * step))
    return np.column_stack(found)


@pytest.mark.parametrize("name", ARMS)
def test_regressor(name: str, kernel: Callable[[str], Kernel]) -> None:
    robot, found = arm(name), kernel(name)
    values = {p.name: p.value for p in robot.parameters if p.value is not None}
    model, between = model_of(with_numbers(robot, values)), derivatives_of_ten(robot)
    data = model.createData()
    columns = [found.parameters.index(p) for p in inertial(robot)]
    assert len(columns) >= 3 * len(robot.joints)
    for q, qd, qdd in states(name):
        theirs = np.array(pin.computeJointTorqueRegressor(model, data, q, qd, qdd)) @ between
        ours = found.inverse_dynamics_parameter_jacobian(q, qd, qdd)[:, columns]
        np.testing.assert_allclose(ours, theirs, rtol=TOLERANCE, atol=TOLERANCE * np.abs(theirs).max())
