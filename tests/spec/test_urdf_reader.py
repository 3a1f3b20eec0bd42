"""A URDF becomes the Robot that its text describes: names, limits, friction, merged links, chains of trees."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest

from symdyn.base.errors import InputError
from symdyn.spec.effect_schema import EffectSchema
from symdyn.spec.monomials import value_of
from symdyn.spec.records import JointKind, Limits, Monomial, Placement, Robot
from symdyn.spec.toml_reader import read_robot_text
from symdyn.spec.urdf_chain import Chain
from symdyn.spec.urdf_reader import read_urdf_text

from .urdfs import ARM, tree

Catalogue = Mapping[str, EffectSchema]


def number(robot: Robot, monomial: Monomial) -> float:
    value = value_of(monomial, {p.name: p.value for p in robot.parameters})
    assert value is not None
    return value


def test_arm(catalogue: Catalogue) -> None:
    robot, warnings = read_urdf_text(ARM, "f", catalogue)
    assert not warnings
    assert robot.name == "small-arm"
    assert [(j.name, j.kind) for j in robot.joints] == [
        ("shoulder_joint", JointKind.REVOLUTE),
        ("slide", JointKind.PRISMATIC),
    ]
    assert robot.joints[0].description == "moves upper-arm with camera"
    assert robot.joints[0].limits == Limits(-1.5, 1.5, 2.0, 40.0)
    assert [(e.type, e.at, number(robot, e.values[0][1])) for e in robot.effects] == [
        ("viscous_friction", "shoulder_joint", 0.7),
        ("coulomb_friction", "shoulder_joint", 0.2),
    ]
    assert number(robot, robot.joints[0].link.mass) == 2.75
    assert [number(robot, g) for g in robot.gravity] == [0, 0, -9.81]
    places = {p.name: (p.where.line, p.where.column) for p in robot.parameters if p.where is not None}
    assert places["shoulder_joint_viscous_friction_coefficient"] == (31, 24)
    assert places["slide_mass"][0] == 19


def test_axis_becomes_z_and_right_angles_are_exact(catalogue: Catalogue) -> None:
    robot, _ = read_urdf_text(ARM, "f", catalogue)
    placement = robot.joints[0].placement
    assert isinstance(placement, Placement)
    assert np.array_equal(np.array(placement.rotation)[:, 2], [-1.0, 0.0, 0.0])  # y, turned by 90 degrees about z
    assert {abs(entry) for row in placement.rotation for entry in row} == {0.0, 1.0}


def test_toml_of_a_urdf_reads_back_as_the_same_robot(catalogue: Catalogue) -> None:
    robot, _ = read_urdf_text(ARM, "f", catalogue)
    again = read_robot_text(robot.text, "f", catalogue)
    assert (again.joints, again.gravity, again.convention) == (robot.joints, robot.gravity, robot.convention)
    assert [(p.name, p.value, p.unit, p.latex, p.meaning) for p in again.parameters] == [
        (p.name, p.value, p.unit, p.latex, p.meaning) for p in robot.parameters
    ]
    assert "[parameters]" not in robot.text  # numbers stand in place


def test_chain_of_a_tree_with_its_branches_locked(catalogue: Catalogue) -> None:
    robot, warnings = read_urdf_text(tree(), "f", catalogue, Chain(tip="hand", lock_others=True))
    assert [joint.name for joint in robot.joints] == ["lift", "left_shoulder"]
    assert number(robot, robot.joints[0].link.mass) == 2.0  # torso and right arm
    assert number(robot, robot.joints[1].link.mass) == 4.0  # left, hand and fingers
    assert robot.tool is not None
    assert [number(robot, c) for c in robot.tool.placement.position] == [0.1, 0.2, 0.3]
    assert {w.code for w in warnings} == {"SD412"}
    assert "locked at zero, as parts of `hand`: `grip_1`" in " ".join(map(str, warnings))


def test_branches_on_the_base_do_not_matter(catalogue: Catalogue) -> None:
    robot, (warning,) = read_urdf_text(tree(), "f", catalogue, Chain(base="torso", tip="right"))
    assert [joint.name for joint in robot.joints] == ["right_shoulder"]
    assert "`left_shoulder`" in warning.message
    assert robot.tool is None  # the tip is the link's own frame


def test_a_chain_is_chosen_from_urdfs_alone(tmp_path: object, catalogue: Catalogue) -> None:
    from symdyn.spec.machines import machine_file
    from symdyn.spec.robot_reader import read_any

    with pytest.raises(InputError, match="SD415"):
        read_any(machine_file("two-link"), catalogue, Chain(tip="x"))
