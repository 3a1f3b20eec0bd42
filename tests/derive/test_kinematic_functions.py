"""Geometry, Coriolis matrix, inverse of the mass matrix, effort of a wrench: against Pinocchio and each other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from mpmath import mp, mpf

from symdyn.compiler import load_robot
from symdyn.derive.equations import equations_of_motion
from symdyn.program.builder import Builder
from symdyn.program.compose import inline
from symdyn.program.differentiate import differentiate
from symdyn.program.evaluate import evaluate
from symdyn.program.functions import functions
from symdyn.program.kinematic_functions import kinematic_functions
from symdyn.program.lower import lower
from symdyn.program.solve import invert_symmetric
from symdyn.program.ssa import Argument, Program
from symdyn.spec.records import JOINT_END, Drive, Robot, Rotor, Shaft

from .evaluation import State, close
from .robots import equipped_robots, plain
from .test_machines import MACHINES, arm, states
from .test_pinocchio import model_of, pin

TOLERANCE = 1e-10
Values = Mapping[str, Sequence[float]]
DIGITS = 25


def programs_of(robot: Robot) -> dict[str, Program]:
    return {f.name: f.program for f in functions(equations_of_motion(robot))}


def few_programs_of(robot: Robot) -> dict[str, Program]:
    """The same without those that calculus makes of inverse dynamics: quick, for many robots."""
    equations = equations_of_motion(robot)
    found = {f.name: f.program for f in kinematic_functions(equations)}
    q = Argument("q", tuple(str(axis.q) for axis in equations.axes))
    arguments, n = (q, Argument("p", tuple(str(p) for p in equations.parameters))), len(equations.axes)
    mass = lower("mass_matrix", arguments, equations.mass_steps, list(equations.arm_mass), (n, n))
    builder = Builder()
    lines = inline(builder, mass)
    inverse = invert_symmetric(builder, [lines[i * n : (i + 1) * n] for i in range(n)])
    entries = [entry for row in inverse for entry in row]
    return found | {
        "mass_matrix": mass,
        "mass_matrix_inverse": builder.program("mass_matrix_inverse", arguments, entries, (n, n)),
    }


programs = cache(lambda name: few_programs_of(arm(name)))
model = cache(lambda name: model_of(arm(name)))


def value(program: Program, given: Values, dps: int = DIGITS) -> np.ndarray:
    """The function at the arguments that it takes of ``given``."""
    taken = {a.name: given.get(a.name, ()) for a in program.arguments}
    return np.array(evaluate(program, taken, dps), dtype=float).reshape(program.shape)


def theirs(of: Any, state: Values) -> dict[str, np.ndarray]:
    """What Pinocchio has for each of our functions."""
    data, tool = of.createData(), of.getFrameId("tool")
    q, qd = np.array(state["q"]), np.array(state["qd"])
    pin.computeJointJacobiansTimeVariation(of, data, q, qd)
    pin.framesForwardKinematics(of, data, q)
    aligned = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
    jacobian = np.reshape(pin.getFrameJacobian(of, data, tool, aligned), (6, of.nv))
    rate = np.reshape(pin.getFrameJacobianTimeVariation(of, data, tool, aligned), (6, of.nv))
    mass = np.triu(np.reshape(pin.crba(of, of.createData(), q), (of.nv, of.nv)))
    found = {
        "forward_kinematics": data.oMf[tool].homogeneous,
        "jacobian": jacobian,
        "jacobian_rate": rate,
        "center_of_mass": pin.centerOfMass(of, of.createData(), q),
        "mass_matrix_inverse": np.linalg.inv(mass + np.triu(mass, 1).T),
    }
    if "wrench" in state:
        found["wrench_effort"] = jacobian.T @ np.array(state["wrench"])
    return found


def check(ours: Mapping[str, Program], of: Any, state: Values) -> None:
    for name, wanted in theirs(of, state).items():
        assert close(value(ours[name], state), wanted, TOLERANCE), name
    data = of.createData()
    q, qd, still = np.array(state["q"]), np.array(state["qd"]), np.zeros(of.nv)
    speed = pin.nonLinearEffects(of, data, q, qd) - pin.nonLinearEffects(of, data, q, still)
    coriolis = value(ours["coriolis_matrix"], state)
    assert close(coriolis @ qd, speed, TOLERANCE)
    # dM/dt by Pinocchio's own matrix: any C that is skew with it has dM/dt = C + C^T.
    his = np.reshape(pin.computeCoriolisMatrix(of, data, q, qd), (of.nv, of.nv))
    assert close(coriolis + coriolis.T, his + his.T, TOLERANCE)


def with_wrench(state: State, seed: int) -> dict[str, list[float]]:
    wrench = np.random.default_rng([seed, 7]).uniform(-10, 10, 6)
    return {name: list(values) for name, values in state.items()} | {"wrench": list(wrench)}


@pytest.mark.parametrize("name", MACHINES)
def test_bundled_arms_as_pinocchio(name: str) -> None:
    for seed, state in enumerate(states(name, 4)):
        check(programs(name), model(name), with_wrench(state, seed))


@settings(max_examples=25, deadline=None)
@given(equipped_robots())
def test_random_arms_as_pinocchio(case: tuple[Robot, dict[str, list[float]]]) -> None:
    """On a base, with a tool that may have mass, both conventions, joints of both kinds."""
    robot, state = case
    check(few_programs_of(robot), model_of(robot), with_wrench(state, 0))


def christoffel(mass: Program, state: Values) -> np.ndarray:
    """C_ij = 1/2 sum of (dM_ij/dq_k + dM_ik/dq_j - dM_jk/dq_i) qd_k, by calculus on the mass matrix."""
    d = value(differentiate(mass, mass.arguments[0].symbols, "d"), state)
    return np.array(0.5 * np.einsum("ijk,k->ij", d + d.transpose(0, 2, 1) - d.transpose(2, 1, 0), state["qd"]))


@pytest.mark.parametrize("name", MACHINES)
def test_coriolis_matrix_is_that_of_the_christoffel_symbols(name: str) -> None:
    for state in states(name, 2):
        ours = value(programs(name)["coriolis_matrix"], state)
        assert close(ours, christoffel(programs(name)["mass_matrix"], state), TOLERANCE)


@settings(max_examples=10, deadline=None)
@given(equipped_robots(3))
def test_coriolis_matrix_of_random_arms_too(case: tuple[Robot, dict[str, list[float]]]) -> None:
    robot, state = case
    ours = few_programs_of(robot)
    assert close(value(ours["coriolis_matrix"], state), christoffel(ours["mass_matrix"], state), TOLERANCE)


@pytest.mark.parametrize("name", MACHINES)
def test_mass_matrix_changes_by_c_and_its_transpose(name: str) -> None:
    """M' - 2C is skew, by differences along the motion: no derivative of ours, none of Pinocchio's."""
    state = states(name, 1)[0]
    ours = programs(name)
    with mp.workdps(50):
        h = mpf(10) ** -20
        ends = []
        for sign in (1, -1):
            q = [mpf(a) + sign * h * mpf(v) for a, v in zip(state["q"], state["qd"], strict=True)]
            ends.append(evaluate(ours["mass_matrix"], {"q": q, "p": ()}, dps=50))
        rate = np.array([float((a - b) / (2 * h)) for a, b in zip(*ends, strict=True)])
    c = value(ours["coriolis_matrix"], state)
    assert close(rate.reshape(c.shape), c + c.T, TOLERANCE)


def test_rotors_have_zero_columns() -> None:
    """Joints turn the tool, rotors of their own do not."""
    drive = Drive(
        plain(5), (Rotor("motor", plain(1e-3)),), (Shaft("shaft", "motor", JOINT_END, plain(100), plain(0.1)),), None
    )
    robot = load_robot("two-link")
    robot = replace(robot, joints=tuple(replace(joint, drive=drive) for joint in robot.joints))
    equations = equations_of_motion(robot)
    of = {f.name: f.program for f in functions(equations)}
    joints = {joint.name for joint in robot.joints}
    rotors = [k for k, axis in enumerate(equations.axes) if axis.address not in joints]
    assert len(rotors) == 2
    n = len(equations.axes)
    generator = np.random.default_rng(5)
    given = {
        "q": list(generator.uniform(0.2, 1, n)),
        "qd": list(generator.uniform(0.2, 1, n)),
        "wrench": list(generator.uniform(0.2, 1, 6)),
        "p": [p.value or 0.1 for p in robot.parameters],
    }
    for name in ("jacobian", "jacobian_rate", "coriolis_matrix"):
        found = value(of[name], given)
        assert np.any(found)
        assert not np.any(found[:, rotors]), name
    found = value(of["wrench_effort"], given)
    np.testing.assert_allclose(found, value(of["jacobian"], given).T @ given["wrench"], rtol=1e-12, atol=1e-12)
    assert not np.any(value(of["coriolis_matrix"], given)[rotors])
    mass = value(of["mass_matrix"], given)
    np.testing.assert_allclose(value(of["mass_matrix_inverse"], given) @ mass, np.eye(n), rtol=0, atol=1e-9)


def test_parameters_stay_symbols() -> None:
    """The general form at the file's numbers is the arm with its numbers put in."""
    robot = load_robot("stanford")
    general = few_programs_of(robot)
    state = with_wrench(states("stanford", 1)[0], 1)
    values = {"p": [p.value or 0.0 for p in robot.parameters]}
    for name, program in programs("stanford").items():
        assert close(value(general[name], state | values), value(program, state), TOLERANCE), name


def test_an_arm_without_mass_has_no_centre() -> None:
    axis = load_robot("irb6-axis1")
    massless = all(joint.link.mass.is_zero for joint in axis.joints)
    assert ("center_of_mass" in programs_of(axis)) == (not massless)
    joints = tuple(replace(j, link=replace(j.link, mass=replace(j.link.mass, coefficient=0))) for j in axis.joints)
    assert "center_of_mass" not in programs_of(replace(axis, joints=joints, tool=None))
