"""Bodies that nothing drives: a link that bends as mass, spring and damper; a load in two parts on a torsion spring."""

from __future__ import annotations

import math

import numpy as np
import pytest

from symdyn.base.errors import InputError
from symdyn.compiler import robot_from_text
from symdyn.derive.equations import equations_of_motion
from symdyn.physics import schemas
from symdyn.program.evaluate import evaluate
from symdyn.program.functions import functions
from symdyn.spec.records import Robot
from symdyn.spec.toml_writer import to_toml

BENDING = """\
[robot]
name = "bending"
gravity = [0, 0, 0]
[dh]
convention = "modified"
rows = [["q", 0, 0, 0], ["q", 0, 0.4, 0]]
[[joint]]
name = "arm"
link = { inertia = { zz = 0.5 } }
[[joint]]
name = "tip"
passive = true
link = { mass = 2, com = [0.6, 0, 0], inertia = { zz = 0.01 } }
[[effect]]
type = "torsion_spring"
at = "tip"
stiffness = 300
rest_position = 0
[[effect]]
type = "viscous_friction"
at = "tip"
coefficient = 0.8
"""
SHAFT = """\
[robot]
name = "shaft"
gravity = [0, 0, 0]
[dh]
rows = [["q", 0, 0, 0]]
[[joint]]
name = "axis"
link = { inertia = { zz = 0.5 } }
[joint.drive]
ratio = 20
rotors = [{ name = "motor", inertia = 0.002 }, { name = "flywheel", inertia = 0.001 }]
shafts = [
  { name = "belt", from = "motor", to = "joint", stiffness = 9 },
  { name = "column", from = "joint", to = "flywheel", stiffness = 4 },
]
"""


def matrix(robot: Robot, name: str) -> np.ndarray:
    """A Jacobian of the kernel at rest, by the reference evaluator."""
    equations = equations_of_motion(robot)
    program = next(f.program for f in functions(equations) if f.name == name)
    p = [p.value for p in robot.parameters if p.value is not None]
    at = {a.name: [0.0] * len(a.symbols) for a in program.arguments} | {"p": p}
    return np.array(evaluate(program, at), dtype=float).reshape(program.shape)


def frequencies(robot: Robot) -> list[float]:
    """rad/s of the modes that oscillate."""
    poles = np.linalg.eigvals(matrix(robot, "state_derivative_state_jacobian"))
    return sorted(abs(pole) for pole in poles if pole.imag > 1e-3)


def test_a_passive_joint_has_no_input() -> None:
    equations = equations_of_motion(robot_from_text(BENDING, "bending"))
    assert [item.name for item in equations.inputs] == ["arm.effort"]
    assert matrix(equations.robot, "state_derivative_input_jacobian").shape == (4, 1)


def test_a_link_that_bends_swings_at_its_frequency() -> None:
    """With 2 degrees of freedom and M = [[a, b], [b, d]], K = diag(0, k): omega^2 = k a / (a d - b^2)."""
    robot = robot_from_text(BENDING, "bending")
    a = 0.5 + 0.01 + 2 * (0.4 + 0.6) ** 2
    b = 0.01 + 2 * 0.6 * (0.4 + 0.6)
    d = 0.01 + 2 * 0.6**2
    (found,) = frequencies(robot)
    assert found == pytest.approx(math.sqrt(300 * a / (a * d - b**2)), rel=1e-9)


def test_a_load_in_parts_hangs_on_the_joint_by_its_own_shaft() -> None:
    """Inertias and shafts beyond the gear are rotors too, in motor-side numbers: here 0.4 kg m^2 and 1600 N m/rad."""
    found = frequencies(robot_from_text(SHAFT, "shaft"))
    inertia = np.diag([0.002 * 400, 0.001 * 400, 0.5])  # on the joint's side, coordinates divided by the ratio
    belt, column = 9 * 400, 4 * 400
    stiffness = np.array([[belt, 0, -belt], [0, column, -column], [-belt, -column, belt + column]])
    expected = np.sqrt(np.sort(np.linalg.eigvals(np.linalg.solve(inertia, stiffness)).real)[1:])
    np.testing.assert_allclose(found, expected, rtol=1e-9)


def test_a_passive_joint_is_written_as_such() -> None:
    robot = robot_from_text(BENDING, "bending")
    again = robot_from_text(to_toml(robot, schemas()), "again")
    assert [joint.passive for joint in again.joints] == [False, True]


def test_what_is_driven_is_not_passive() -> None:
    with pytest.raises(InputError, match="something that drives it") as caught:
        robot_from_text(BENDING.replace("passive = true", 'passive = true\nactuator = { gain = "2 N m/V" }'), "wrong")
    assert [problem.code for problem in caught.value.problems] == ["SD111"]
