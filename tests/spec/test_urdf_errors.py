"""Every wrong URDF gets its code, its place in the file, and a word on what to do."""

from __future__ import annotations

import importlib.util
from collections.abc import Mapping
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from symdyn.base.errors import InputError, Problem
from symdyn.spec import robot_reader
from symdyn.spec.effect_schema import EffectSchema
from symdyn.spec.toml_reader import text_with_warnings
from symdyn.spec.urdf_chain import Chain
from symdyn.spec.urdf_reader import read_urdf_text

from .urdfs import ARM, TREE_JOINTS, tree

Catalogue = Mapping[str, EffectSchema]

MASS = 'value="2.5"'
SLIDER = '<link name="slider">'
DTD = '<!DOCTYPE robot [<!ENTITY a "b"><!ENTITY c "&a;&a;"><!ENTITY x SYSTEM "file:///etc/passwd">]>'
CHILD = '<child link="slider"/>'
LOOSE = '<link name="loose"/>\n  '

# (what is replaced, by what, code, line, column, a word of the message or hint)
WRONG = [
    # the file
    (ARM, "", "SD401", 1, 1, "empty"),
    (ARM, "   \n", "SD401", None, None, "empty"),
    (ARM, ARM[:700], "SD401", None, None, "cut off"),
    (MASS, 'value="2.5', "SD401", None, None, "not well-formed"),
    (MASS, 'value="2\0"', "SD401", 8, 21, "NUL"),
    ("<robot", f"{DTD}\n<robot", "SD402", 3, 1, "remove the <!DOCTYPE"),
    (MASS, 'value="&m;"', "SD402", 8, None, "entities are not allowed"),
    (SLIDER, "<a>" * 70 + "</a>" * 70 + SLIDER, "SD002", 18, 192, "64 levels"),
    ('<robot name="Small Arm">', "<sdf>", "SD401", None, None, "not well-formed"),
    (ARM, '<sdf version="1.6"/>', "SD416", 1, 1, "SDF are not read"),
    # numbers
    (MASS, 'value="1kg"', "SD403", 8, 20, "plain, in SI units: 1"),
    (MASS, 'value="1,5"', "SD403", 8, 20, "decimal point: 1.5"),
    (MASS, 'value="nan"', "SD403", 8, 20, "finite"),
    (MASS, 'value="1e999"', "SD403", 8, 20, "finite"),
    (MASS, 'value=""', "SD403", 8, 20, "plain decimal"),
    (MASS, 'value="0x10"', "SD403", 8, 20, "not a finite number"),
    (MASS, 'value="-1"', "SD203", 8, 20, "must not be negative"),
    ('xyz="0.1 0 0.02"', 'xyz="0.1 0"', "SD403", 7, 20, "three numbers"),
    ('xyz="0.1 0 0.02"', 'xyz="0.1, 0, 0.02"', "SD403", 7, 20, "without commas"),
    ('damping="0.7"', 'damping="-0.7"', "SD203", 31, 24, "must not be negative"),
    (MASS, 'value="${m}"', "SD405", 8, 20, "symdyn[xacro]"),
    (SLIDER, f"<xacro:arm/>{SLIDER}", "SD405", 18, 3, "symdyn[xacro]"),
    # what is missing
    ('<mass value="2.5"/>', "", "SD411", 6, 5, "has no <mass>"),
    (MASS, "", "SD411", 8, 7, "no attribute `value`"),
    ('ixx="0.02" ', "", "SD411", 9, 7, "no attribute `ixx`"),
    ('<parent link="upper-arm"/>\n    <child link="slider"/>', CHILD, "SD411", 38, 3, "has no <parent>"),
    ('<link name="base"/>', "<link/>", "SD411", 4, 3, "no attribute `name`"),
    # joints
    ('"prismatic"', '"prismatik"', "SD407", 38, 29, "did you mean `prismatic`?"),
    ('"prismatic"', '"floating"', "SD407", 38, 29, "not supported"),
    ('"prismatic"', '"planar"', "SD407", 38, 29, "not supported"),
    (CHILD, f'{CHILD}<mimic joint="shoulder joint"/>', "SD407", 38, 3, "mimics `shoulder joint`"),
    ('xyz="1 0 1"', 'xyz="0 0 0"', "SD408", 42, 16, "axis is zero"),
    ('lower="0"', 'lower="1"', "SD409", 43, 19, "above the upper limit"),
    ('effort="10"', 'effort="-10"', "SD409", 43, 42, "must not be negative"),
    ('name="slide"', 'name="shoulder-joint"', "SD103", 38, 16, "both be called `shoulder_joint`"),
    ('name="slide"', f'name="{"a" * 65}"', "SD101", 38, 16, "longer than 64"),
    (CHILD, f"{CHILD}{CHILD}", "SD406", 41, 27, "has two <child>"),
    # the tree
    (CHILD, '<child link="base"/>', "SD406", None, None, "make a loop"),
    (CHILD, '<child link="camera"/>', "SD406", 38, 3, "two parents: joints `camera_mount` and `slide`"),
    (CHILD, '<child link="slidr"/>', "SD406", 41, 18, "did you mean `slider`?"),
    (CHILD, '<child link="upper-arm"/>', "SD406", 38, 3, "to itself"),
    ('name="slide"', 'name="camera_mount"', "SD406", 38, 16, "there twice, first at f:33:16"),
    (SLIDER, '<link name="camera">', "SD406", 18, 15, "there twice, first at f:12:15"),
    (SLIDER, f"{LOOSE}{SLIDER}", "SD406", 18, 3, "several links have no parent: base, loose"),
    ('"prismatic"', '"revolute"', None, None, None, ""),
    # what cannot move
    ('mass value="1.5"', 'mass value="0"', "SD214", 19, 5, "singular about joint `slide`"),
]  # fmt: skip


def changed(old: str, new: str) -> str:
    assert ARM.count(old) == 1, old
    return ARM.replace(old, new)


def problems_of(text: str, catalogue: Catalogue, chain: Chain = Chain()) -> tuple[Problem, ...]:  # noqa: B008
    with pytest.raises(InputError) as caught:
        read_urdf_text(text, "f", catalogue, chain)
    return caught.value.problems


@pytest.mark.parametrize(("old", "new", "code", "line", "column", "told"), WRONG, ids=[w[1][:40] for w in WRONG])
def test_wrong_urdf(
    old: str, new: str, code: str | None, line: int | None, column: int | None, told: str, catalogue: Catalogue
) -> None:
    if code is None:
        read_urdf_text(changed(old, new), "f", catalogue)
        return
    first = problems_of(changed(old, new), catalogue)[0]
    assert first.where is not None
    assert (first.code, first.where.file) == (code, "f")
    assert first.where.line is not None
    assert first.where.column is not None
    assert line in (None, first.where.line)
    assert column in (None, first.where.column)
    assert told in str(first)


DOUBTFUL = [
    (SLIDER, '<link name="slider" drake:color="1">', "SD404", 18, "ignored"),
    ("<mujoco>", "<drake:x/><mujoco>", "SD404", 47, "ignored"),
    ('rpy="0 0.5 0"', 'rpy="0 1.5708 0"', "SD413", 34, "1.5707963267948966"),
    ('ixx="0.02"', 'ixx="0.2"', "SD211", 6, "no body has"),
    ('ixy="0.001"', 'ixy="0.2"', "SD212", 6, "negative principal moment"),
    ('<inertia ixx="1e-4" ixy="0" ixz="0" iyy="1e-4" iyz="0" izz="1e-4"/>', "", "SD410", 13, "a point mass"),
]


@pytest.mark.parametrize(("old", "new", "code", "line", "told"), DOUBTFUL, ids=[d[1][:40] for d in DOUBTFUL])
def test_doubtful_urdf_is_read_with_a_warning(
    old: str, new: str, code: str, line: int, told: str, catalogue: Catalogue
) -> None:
    _, (warning,) = read_urdf_text(changed(old, new), "f", catalogue)
    assert warning.where is not None
    assert (warning.code, warning.where.line) == (code, line)
    assert told in str(warning)


def without_inertial(link: str) -> str:
    start = ARM.index("<inertial>", ARM.index(f'<link name="{link}">'))
    return ARM[start : ARM.index("</inertial>", start) + len("</inertial>")]


def test_link_without_inertial_is_massless_and_told(catalogue: Catalogue) -> None:
    text = ARM.replace(without_inertial("upper-arm"), "")
    robot, warnings = read_urdf_text(text, "f", catalogue)
    assert not warnings  # the camera on it has one
    robot, (warning,) = read_urdf_text(text.replace(without_inertial("camera"), ""), "f", catalogue)
    assert robot.joints[0].link.mass.is_zero
    assert (warning.code, warning.message) == ("SD410", "link `upper-arm` has no <inertial>: taken as massless")


def test_urdf_for_display_only_is_refused(catalogue: Catalogue) -> None:
    (problem,) = problems_of(ARM.replace("inertial>", "visual>"), catalogue)
    assert problem.code == "SD214"
    assert "for display only" in problem.hint


def test_all_problems_are_told_at_once_in_file_order(catalogue: Catalogue) -> None:
    text = changed(MASS, 'value="1kg"').replace('xyz="1 0 1"', 'xyz="0 0 0"').replace('lower="-1.5"', 'lower="1,5"')
    told = [(p.code, p.where.line if p.where else None) for p in problems_of(text, catalogue)]
    assert told == [("SD403", 8), ("SD403", 30), ("SD408", 42)]


@pytest.mark.parametrize(
    ("chain", "code", "told"),
    [
        (Chain(), "SD412", "ends here: finger_1, finger_2, right"),
        (Chain(tip="hand"), "SD412", "right_shoulder"),
        (Chain(tip="nose"), "SD415", "no link `nose`"),
        (Chain(base="nose"), "SD415", "no link `nose`"),
        (Chain(base="left", tip="right"), "SD415", "is not behind the base `left`"),
        (Chain(tip="finger_2", lock_others=True), "SD407", "mimics `grip_1`"),
        (Chain(tip="base"), "SD414", "no joint of the chain moves"),
    ],
)
def test_tree_that_is_no_chain(chain: Chain, code: str, told: str, catalogue: Catalogue) -> None:
    problems = problems_of(tree(), catalogue, chain)
    assert problems[0].code == code
    assert told in " ".join(map(str, problems))


def test_floating_base_names_the_way_out(catalogue: Catalogue) -> None:
    text = tree((("free", "floating", "base", "torso", ""), *TREE_JOINTS[1:2], ("x", "fixed", "left", "right", ""),
                 ("y", "fixed", "right", "hand", ""), ("z", "fixed", "hand", "finger_1", ""),
                 ("w", "fixed", "finger_1", "finger_2", "")))  # fmt: skip
    (problem,) = problems_of(text, catalogue)
    assert (problem.code, problem.hint) == ("SD407", "begin the chain behind it: --base torso")
    robot, _ = read_urdf_text(text, "f", catalogue, Chain(base="torso"))
    assert [joint.name for joint in robot.joints] == ["left_shoulder"]


@settings(deadline=None, max_examples=60)
@given(st.data())
def test_random_edits_end_in_a_robot_or_an_input_error(catalogue: Catalogue, data: st.DataObject) -> None:
    start = data.draw(st.integers(0, len(ARM)))
    length = data.draw(st.integers(0, 30))
    new = data.draw(st.text(alphabet="<>/=\"'& \n\t0123456789.-abcxyz:![]é$${", max_size=8))
    problems: tuple[Problem, ...] = ()
    try:
        read_urdf_text(ARM[:start] + new + ARM[start + length :], "f", catalogue)
    except InputError as error:
        problems = error.problems or (Problem("", ""),)
    assert all(problem.code.startswith("SD") and problem.message for problem in problems)


def test_xacro_without_its_extra_says_how_to_get_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, catalogue: Catalogue
) -> None:
    file = tmp_path / "arm.urdf.xacro"
    file.write_text(ARM)
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(InputError, match=r"pip install 'symdyn\[xacro\]'"):
        robot_reader.read_any(file, catalogue)


def test_xacro_is_expanded_where_the_extra_is_there(tmp_path: Path, catalogue: Catalogue) -> None:
    pytest.importorskip("xacrodoc")
    file = tmp_path / "arm.urdf.xacro"
    opened = (
        '<robot name="Small Arm" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:property name="m" value="1.25"/>'
    )
    text = changed(MASS, 'value="${2*m}"').replace('<robot name="Small Arm">', opened)
    file.write_text(text)
    robot, _ = robot_reader.read_any(file, catalogue)
    plain, _ = read_urdf_text(ARM, "f", catalogue)
    assert [p.value for p in robot.parameters] == [p.value for p in plain.parameters]
    file.write_text(text.replace("${2*m}", "${2*n}"))
    with pytest.raises(InputError, match="SD405: xacro failed"):
        robot_reader.read_any(file, catalogue)


def test_what_is_doubtful_in_a_urdf_is_as_doubtful_in_its_toml(catalogue: Catalogue) -> None:
    """No body has these inertias; a robot that one file format may hold, the other may too."""
    for old, new, code in (('ixx="0.02"', 'ixx="0.2"', "SD211"), ('ixy="0.001"', 'ixy="0.2"', "SD212")):
        robot, (told,) = read_urdf_text(changed(old, new), "f", catalogue)
        again, (same,) = text_with_warnings(robot.text, "f.toml", catalogue)
        assert (told.code, same.code) == (code, code)
        assert [j.name for j in again.joints] == [j.name for j in robot.joints]


def test_a_negative_mass_matrix_is_refused(catalogue: Catalogue) -> None:
    negative = changed(
        '<inertia ixx="0.02" ixy="0.001" ixz="0" iyy="0.03"', '<inertia ixx="-9" ixy="0" ixz="0" iyy="-9"'
    )
    (problem,) = problems_of(negative, catalogue)
    assert problem.code == "SD214"
    assert "negative about joint" in problem.message
