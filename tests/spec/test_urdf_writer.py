"""Numbers go back into a URDF and leave every other byte as it was."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from difflib import SequenceMatcher

import numpy as np
import pytest

from symdyn.base.errors import InputError
from symdyn.spec.edit import add_effect
from symdyn.spec.effect_schema import EffectSchema
from symdyn.spec.records import Robot
from symdyn.spec.toml_reader import read_robot_text
from symdyn.spec.urdf_reader import read_urdf_text
from symdyn.spec.urdf_writer import write_back

from .urdfs import ARM

Catalogue = Mapping[str, EffectSchema]


def with_values(robot: Robot, **values: float) -> Robot:
    assert set(values) <= {p.name for p in robot.parameters}
    return replace(robot, parameters=tuple(replace(p, value=values.get(p.name, p.value)) for p in robot.parameters))


def differences(before: str, after: str) -> list[tuple[str, str]]:
    """(old, new) for each stretch of lines that differs."""
    a, b = before.splitlines(keepends=True), after.splitlines(keepends=True)
    codes = SequenceMatcher(None, a, b, autojunk=False).get_opcodes()
    return [("".join(a[i:j]).strip(), "".join(b[k:m]).strip()) for kind, i, j, k, m in codes if kind != "equal"]


@pytest.mark.parametrize("text", [ARM, ARM.replace("\n", "\r\n"), "\ufeff" + ARM])
def test_nothing_changed_is_the_same_text(text: str, catalogue: Catalogue) -> None:
    robot, _ = read_urdf_text(text, "f", catalogue)
    assert write_back(text, "f", robot, catalogue) == text


def test_changed_numbers_alone_are_changed(catalogue: Catalogue) -> None:
    robot, _ = read_urdf_text(ARM, "f", catalogue)
    other = with_values(robot, slide_mass=1.75, shoulder_joint_viscous_friction_coefficient=0.9)
    assert differences(ARM, write_back(ARM, "f", other, catalogue)) == [
        ('<mass value="1.5"/>', '<mass value="1.75"/>'),
        ('<dynamics damping="0.7" friction="0.2"/>', '<dynamics damping="0.9" friction="0.2"/>'),
    ]


def test_change_of_merged_links_goes_to_the_first(catalogue: Catalogue) -> None:
    robot, _ = read_urdf_text(ARM, "f", catalogue)
    other = with_values(
        robot, shoulder_joint_mass=3.0, shoulder_joint_com_x=0.13, shoulder_joint_inertia_yz=0.004, slide_com_y=0.07
    )
    text = write_back(ARM, "f", other, catalogue)
    again, _ = read_urdf_text(text, "f", catalogue)
    np.testing.assert_allclose(
        [p.value for p in again.parameters], [p.value for p in other.parameters], rtol=0, atol=1e-14
    )
    assert '<mass value="0.25"/> <!-- weighed -->' in text
    assert 'rpy="0.3 0 0"/>' in text


def test_friction_that_was_found_is_added(catalogue: Catalogue) -> None:
    robot, _ = read_urdf_text(ARM, "f", catalogue)
    toml = add_effect(robot.text, "coulomb_friction", "slide", {"level": "3.5 N"}, "found by symdyn diagnose")
    text = write_back(ARM, "f", read_robot_text(toml, "f", catalogue), catalogue)
    assert text == ARM.replace(
        '<limit lower="0" upper="0.2" effort="10" velocity="1"/>',
        '<limit lower="0" upper="0.2" effort="10" velocity="1"/>\n    <dynamics friction="3.5"/>',
    )


def test_inertial_that_was_not_there_is_added(catalogue: Catalogue) -> None:
    start = ARM.index('    <inertial>\n      <origin xyz="0 0.05 0"/>')
    end = ARM.index("  </link>\n  <joint")
    bare = (
        ARM[:start].rstrip()[: -len('<link name="slider">')] + '<link name="slider"/>' + ARM[end + len("  </link>") :]
    )
    robot, _ = read_urdf_text(ARM, "f", catalogue)
    with pytest.raises(InputError, match="SD214"):
        read_urdf_text(bare, "f", catalogue)
    again, _ = read_urdf_text(write_back(bare, "f", robot, catalogue), "f", catalogue)
    np.testing.assert_allclose(
        [p.value for p in again.parameters], [p.value for p in robot.parameters], rtol=0, atol=1e-15
    )


@pytest.mark.parametrize(
    ("type", "at", "values", "told"),
    [("stribeck_friction", "slide", {"level": "1 N"}, "cannot say `stribeck_friction` at `slide`")],
)
def test_what_a_urdf_cannot_say(type: str, at: str, values: dict[str, str], told: str, catalogue: Catalogue) -> None:
    robot, _ = read_urdf_text(ARM, "f", catalogue)
    other = read_robot_text(add_effect(robot.text, type, at, values), "f", catalogue)
    with pytest.raises(InputError) as caught:
        write_back(ARM, "f", other, catalogue)
    (problem,) = caught.value.problems
    assert problem.code == "SD421"
    assert told in problem.message
    assert "robot.toml" in problem.hint


def test_another_robot_is_refused(valid: str, catalogue: Catalogue) -> None:
    robot, _ = read_urdf_text(ARM, "f", catalogue)
    with pytest.raises(InputError, match="are not those of this URDF"):
        write_back(ARM, "f", replace(robot, joints=robot.joints[:1], effects=()), catalogue)
    with pytest.raises(InputError, match="only inertials and friction are written"):
        write_back(ARM, "f", with_values(robot, shoulder_joint_offset_z=0.5), catalogue)
    with pytest.raises(InputError, match="the drive of `elbow`"):
        write_back(ARM, "f", read_robot_text(valid, "f", catalogue), catalogue)
    free = replace(robot, parameters=tuple(replace(p, value=None) for p in robot.parameters))
    with pytest.raises(InputError, match="left free"):
        write_back(ARM, "f", free, catalogue)
