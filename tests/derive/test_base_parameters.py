"""Base inertial parameters: as many as Pinocchio's regressor has rank, and the textbook's where there is one."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import sympy as sp
from hypothesis import given, settings

from symdyn.compiler import load_robot
from symdyn.derive.base_parameters import base_parameters
from symdyn.spec.records import DHRow, Joint, JointKind, Link, Robot

from .robots import plain, serial_robots
from .test_machines import MACHINES, arm
from .test_pinocchio import model_of, pin


def full(robot: Robot) -> Robot:
    """The arm with all ten inertial parameters at every link, none of them special.

    Seven digits: a centre of mass with fewer may lie on a joint's axis by accident, and then shows no moment there.
    """
    generator = np.random.default_rng(1)

    def number(low: float, high: float) -> Any:
        return plain(float(round(generator.uniform(low, high), 7)))

    def link() -> Link:
        com = (number(0.1, 0.5), number(0.1, 0.5), number(0.1, 0.5))
        moments = [number(1, 1.4) for _ in range(3)] + [number(0.1, 0.2) for _ in range(3)]
        return Link(number(1, 3), com, (moments[0], moments[1], moments[2], moments[3], moments[4], moments[5]))

    return replace(robot, joints=tuple(replace(joint, link=link()) for joint in robot.joints))


def rank(robot: Robot) -> int:
    """Of the regressor of all ten parameters of each link, over random states."""
    model = model_of(robot)
    data, generator = model.createData(), np.random.default_rng(2)
    rows = [
        np.array(pin.computeJointTorqueRegressor(model, data, *(generator.uniform(-2, 2, model.nv) for _ in range(3))))
        for _ in range(40 + 10 * model.nv)
    ]
    sizes = np.linalg.svd(np.vstack(rows), compute_uv=False)
    return int(np.sum(sizes > 1e-10 * sizes[0]))


@pytest.mark.parametrize("name", MACHINES)
def test_as_many_as_the_rank_of_the_regressor(name: str) -> None:
    assert len(base_parameters(full(arm(name)))) == rank(full(arm(name)))


@settings(max_examples=15, deadline=None)
@given(serial_robots(4))
def test_never_fewer_than_the_rank(robot: Robot) -> None:
    """Fewer would be a model that cannot be right; the rules may leave a few more where axes stand specially."""
    assert len(base_parameters(full(robot))) >= rank(full(robot))


def planar(kinds: str, pull: tuple[int, int, int]) -> Robot:
    """Joints whose axes are all parallel, offset by one length; R turns, P slides."""
    types = {"R": JointKind.REVOLUTE, "P": JointKind.PRISMATIC}
    row = DHRow(plain(0), plain(0), plain(0.5), plain(0))
    joints = tuple(Joint(f"joint{i}", types[kind], row, Link()) for i, kind in enumerate(kinds, start=1))
    gravity = (plain(pull[0]), plain(pull[1]), plain(pull[2]))
    return full(replace(arm("scara"), gravity=gravity, joints=joints))


@pytest.mark.parametrize("pull", [(0, 0, -10), (0, -10, 0), (1, 2, 3)], ids=str)
@pytest.mark.parametrize("kinds", ["R", "RR", "RRR", "RRPR", "RPR", "P", "RP", "RPPR"])
def test_parallel_axes(kinds: str, pull: tuple[int, int, int]) -> None:
    robot = planar(kinds, pull)
    assert len(base_parameters(robot)) == rank(robot)


def test_expressions_of_the_two_link() -> None:
    found = {(b.link, b.entry): b for b in base_parameters(load_robot("two-link"))}
    length, mass, radius = (sp.Symbol(f"p_{name}", real=True) for name in ("l_1", "m_2", "r_2"))
    assert found["elbow", "x1"].expression == mass * radius
    assert found["elbow", "x1"].unit == "kg m"
    assert found["shoulder", "x1"].expression.coeff(mass) == length
    assert found["shoulder", "xx + yy"].expression.coeff(mass) == length**2


def test_a_carriage_shows_its_mass_alone() -> None:
    (mass,) = base_parameters(load_robot("emps"))
    assert (mass.entry, mass.unit) == ("11", "kg")
    assert mass.expression == sp.Symbol("p_M", real=True)
