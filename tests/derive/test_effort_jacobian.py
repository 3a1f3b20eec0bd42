"""Derivatives of inverse dynamics by composite bodies, against forward mode on Newton-Euler: no formula is shared."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from symdyn.compiler import load_robot
from symdyn.derive import pairs
from symdyn.derive.equations import EquationsOfMotion, equations_of_motion
from symdyn.derive.newton_euler import joints_of
from symdyn.derive.screws import Joint
from symdyn.derive.steps import Steps
from symdyn.program.differentiate import differentiate
from symdyn.program.effort_tangent import effort_tangent
from symdyn.program.functions import functions
from symdyn.program.kinematic_functions import kinematic_functions
from symdyn.program.lower import lower
from symdyn.program.ssa import Argument, Program
from symdyn.spec.records import DHRow, Robot
from symdyn.spec.records import Joint as JointRecord

from .evaluation import State, close
from .robots import equipped_robots, plain, serial_robots
from .robots import states as states_of
from .test_kinematic_functions import value
from .test_machines import MACHINES, arm, states
from .test_pinocchio import model_of, pin

TOLERANCE = 1e-12
WITH_DRIVES = ("emps", "irb6-arm", "irb6-axis1", "panda", "puma560", "two-link")


def by_forward_mode(equations: EquationsOfMotion, state: State) -> np.ndarray:
    """(n, 3 n + 1), as ``effort_tangent``, of inverse dynamics as a program."""
    axes = equations.axes
    arguments = [Argument(name, tuple(str(getattr(a, name)) for a in axes)) for name in ("q", "qd", "qdd")]
    steps, efforts = equations.required()
    p = Argument("p", tuple(str(symbol) for symbol in equations.parameters))
    program = lower("efforts", (*arguments, p), steps, efforts, (len(axes),))
    wrt = tuple(symbol for argument in arguments for symbol in argument.symbols)
    bias = value(program, {**state, "qdd": [0.0] * len(axes)})
    return np.column_stack([value(differentiate(program, wrt, "d"), state), bias])


def assert_same(robot: Robot, state: State) -> None:
    equations = equations_of_motion(robot)
    given = {**state, "p": [p.value or 0.1 for p in robot.parameters]}
    n = len(equations.axes)
    ours, theirs = value(effort_tangent(equations), given), by_forward_mode(equations, given)
    for first in range(0, 3 * n + 1, n):
        block = slice(first, first + n)
        assert close(ours[:, block], theirs[:, block], TOLERANCE)


@settings(max_examples=12, deadline=None)
@given(equipped_robots())
def test_random_arms(case: tuple[Robot, State]) -> None:
    """On a base, with a tool that may have mass, both conventions, joints of both kinds."""
    assert_same(*case)


@st.composite
def arms_with_parallel_axes(draw: st.DrawFn) -> tuple[Robot, State]:
    """Runs of parallel axes wherever they come."""
    robot = draw(serial_robots(5))

    def straight(joint: JointRecord) -> JointRecord:
        row = joint.placement
        return replace(joint, placement=replace(row, alpha=plain(0))) if isinstance(row, DHRow) else joint

    joints = tuple(straight(joint) if draw(st.booleans()) else joint for joint in robot.joints)
    robot = replace(robot, joints=joints)
    return robot, draw(states_of(robot))


@pytest.mark.slow
@settings(max_examples=25, deadline=None)
@given(arms_with_parallel_axes())
def test_random_arms_with_parallel_axes(case: tuple[Robot, State]) -> None:
    assert_same(*case)


@pytest.mark.parametrize("name", MACHINES)
def test_bundled_arms(name: str) -> None:
    assert_same(arm(name), states(name, 1)[0])


@pytest.mark.parametrize("name", WITH_DRIVES)
def test_with_drives_and_parameters(name: str) -> None:
    """Rotors of their own, springs, friction, backlash: effects are differentiated for themselves, and added."""
    robot = load_robot(name)
    n = len(equations_of_motion(robot).axes)
    rows = np.random.default_rng(3).uniform(0.3, 2, (3, n))
    assert_same(robot, dict(zip(("q", "qd", "qdd"), rows.tolist(), strict=True)))


@pytest.mark.parametrize("name", MACHINES)
def test_with_respect_to_speeds_it_is_twice_the_coriolis_matrix(name: str) -> None:
    equations, state = equations_of_motion(arm(name)), states(name, 1)[0]
    n = len(equations.axes)
    coriolis = next(f.program for f in kinematic_functions(equations) if f.name == "coriolis_matrix")
    assert close(value(effort_tangent(equations), state)[:, n : 2 * n], 2 * value(coriolis, state), TOLERANCE)


@cache
def compiled(name: str) -> dict[str, Program]:
    return {f.name: f.program for f in functions(equations_of_motion(arm(name)))}


@pytest.mark.parametrize("name", MACHINES)
def test_forward_dynamics_by_the_implicit_function_theorem_is_forward_mode_on_it(name: str) -> None:
    ours, state = compiled(name), states(name, 1)[0]
    given = {**state, "tau": state["qdd"]}
    forward = ours["forward_dynamics"]
    wrt = tuple(symbol for argument in forward.arguments[:2] for symbol in argument.symbols)
    theirs = value(differentiate(forward, wrt, "d"), given)
    assert close(value(ours["forward_dynamics_state_jacobian"], given), theirs, 1e-10)


@pytest.mark.parametrize("name", MACHINES)
def test_gravity_as_pinocchio(name: str) -> None:
    model = model_of(arm(name))
    for state in states(name, 4):
        theirs = pin.computeGeneralizedGravity(model, model.createData(), np.array(state["q"]))
        assert close(value(compiled(name)["gravity"], state), theirs, 1e-10)


# Where rows and columns meet is a matter of cost alone.


@pytest.mark.parametrize(
    ("name", "places"),
    [
        ("panda", (0, 1, 2, 3, 4, 5, 6)),  # no axis is parallel to the next
        ("puma560", (2, 2, 2, 3, 4, 5)),  # shoulder and elbow
        ("ur10e", (3, 3, 3, 3, 4, 5)),  # shoulder, elbow and wrist
        ("two-link", (1, 1)),
    ],
)
def test_parallel_axes_meet_at_the_last_of_them(name: str, places: tuple[int, ...]) -> None:
    assert pairs.meeting_places(joints_of(load_robot(name), Steps())) == places


@pytest.mark.parametrize("places", [(0, 1, 2, 3, 4, 5), (5, 5, 5, 5, 5, 5), (1, 4, 2, 5, 4, 5)])
def test_any_meeting_place_gives_the_same(places: tuple[int, ...], monkeypatch: pytest.MonkeyPatch) -> None:
    def chosen(joints: Sequence[Joint]) -> tuple[int, ...]:
        assert len(joints) == len(places)
        return places

    monkeypatch.setattr(pairs, "meeting_places", chosen)
    assert_same(arm("stanford"), states("stanford", 1)[0])
