"""Against Pinocchio, which derives nothing and shares no code: efforts, mass matrix, energies of random arms."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings

from symdyn.derive.equations import equations_of_motion
from symdyn.spec.records import Convention, DHRow, InertiaAbout, JointKind, Link, Monomial, Placement, Robot

from .evaluation import close, energy, inverse_dynamics, mass_matrix
from .robots import moving_robots

pin = pytest.importorskip("pinocchio")

State = dict[str, list[float]]
TOLERANCE = 1e-10


def turn(axis: np.ndarray, angle: float) -> Any:
    return pin.SE3(pin.AngleAxis(angle, axis).toRotationMatrix(), np.zeros(3))


def shift(along: np.ndarray) -> Any:
    return pin.SE3(np.eye(3), along)


X, Z = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])


def model_of(robot: Robot) -> Any:
    """The arm in Pinocchio: joints about or along z, placed by the rows; a link sits behind its joint."""
    model = pin.Model()
    model.gravity = pin.Motion(np.array([float(g.coefficient) for g in robot.gravity]), np.zeros(3))
    parent, reached = 0, placed(robot.base)  # reached: the last link's frame, seen from the last joint
    for joint in robot.joints:
        row = joint.placement
        assert isinstance(row, DHRow)
        theta, d, a, alpha = (float(m.coefficient) for m in (row.theta, row.d, row.a, row.alpha))
        along_z = turn(Z, theta) * shift(d * Z)
        along_x = shift(a * X) * turn(X, alpha)
        kind = pin.JointModelPZ() if joint.kind is JointKind.PRISMATIC else pin.JointModelRZ()
        if robot.convention is Convention.STANDARD:
            before, after = pin.SE3.Identity(), along_z * along_x
        else:
            before, after = along_x * along_z, pin.SE3.Identity()
        parent = model.addJoint(parent, kind, reached * before, joint.name)
        model.appendBodyToJoint(parent, inertia_of(joint.link), after)
        reached = after
    reached = reached * placed(robot.tool.placement if robot.tool is not None else None)
    if robot.tool is not None:
        model.appendBodyToJoint(parent, inertia_of(robot.tool.link), reached)
    model.addFrame(pin.Frame("tool", parent, reached, pin.FrameType.OP_FRAME))
    return model


def placed(placement: Placement | None) -> Any:
    if placement is None:
        return pin.SE3.Identity()
    return pin.SE3(np.array(placement.rotation), np.array([float(c.coefficient) for c in placement.position]))


def inertia_of(link: Link) -> Any:
    def number(monomial: Monomial) -> float:
        return float(monomial.coefficient)

    mass, com = number(link.mass), np.array([number(c) for c in link.com])
    xx, yy, zz, xy, xz, yz = (number(entry) for entry in link.inertia)
    tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    if link.about is InertiaAbout.JOINT:
        tensor = tensor - mass * (com @ com * np.eye(3) - np.outer(com, com))
    return pin.Inertia(mass, com, tensor)


@settings(max_examples=40, deadline=None)
@given(moving_robots())
def test_inverse_dynamics(case: tuple[Robot, State]) -> None:
    robot, state = case
    model = model_of(robot)
    theirs = pin.rnea(model, model.createData(), *(np.array(state[name]) for name in ("q", "qd", "qdd")))
    assert close(inverse_dynamics(equations_of_motion(robot))(state), theirs, TOLERANCE)


@settings(max_examples=20, deadline=None)
@given(moving_robots())
def test_mass_matrix(case: tuple[Robot, State]) -> None:
    robot, state = case
    model = model_of(robot)
    theirs = np.triu(pin.crba(model, model.createData(), np.array(state["q"])))
    theirs = theirs + np.triu(theirs, 1).T
    assert close(mass_matrix(equations_of_motion(robot), state["q"]), theirs, TOLERANCE)


@settings(max_examples=20, deadline=None)
@given(moving_robots())
def test_energies(case: tuple[Robot, State]) -> None:
    robot, state = case
    model = model_of(robot)
    data, q, qd = model.createData(), np.array(state["q"]), np.array(state["qd"])
    theirs = [pin.computeKineticEnergy(model, data, q, qd), pin.computePotentialEnergy(model, data, q)]
    assert close([float(e) for e in energy(equations_of_motion(robot))(state)], theirs, TOLERANCE)
