"""Placements, limits, base and tool in a robot's TOML: what is read, and what is refused where."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest

from symdyn.base.errors import InputError
from symdyn.spec.effect_schema import EffectSchema
from symdyn.spec.mass_matrix import mass_matrix
from symdyn.spec.records import Limits, Placement
from symdyn.spec.toml_reader import read_robot_text, text_with_warnings

Catalogue = Mapping[str, EffectSchema]

TEXT = """\
[robot]
name = "placed"
gravity = [0, 0, -9.81]
[base]
placement = { rpy = [0, 0, 0.5] }
[[joint]]
name = "turn"
placement = { xyz = [0, 0, 0.3], rpy = ["90 deg", 0, 0] }
limits = { lower = "-90 deg", upper = 1.5, velocity = 2, effort = 40 }
link = { mass = 2, com = [0.1, 0, 0] }
[[joint]]
name = "slide"
kind = "prismatic"
placement = { rotation = [[0, 0, 1], [0, 1, 0], [-1, 0, 0]] }
link = { mass = 1 }
[tool]
placement = { xyz = [0.1, 0, 0] }
mass = 0.5
"""
RPY = 'rpy = ["90 deg", 0, 0]'
MATRIX = "[[0, 0, 1], [0, 1, 0], [-1, 0, 0]]"

WRONG = [
    (RPY, "rpy = [90, 0, 0, 0]", "SD202", 8, "at most 3"),
    (RPY, 'rpy = ["90 mm", 0, 0]', "SD221", 8, "expected angle"),
    (RPY, "rpy = [nan, 0, 0]", "SD201", 8, "finite"),
    (RPY, f"rotation = {MATRIX}, {RPY}", "SD105", 8, "keep one of them"),
    (MATRIX, "[[0, 0, 1], [0, 1, 0], [1, 0, 0]]", "SD112", 14, "no rotation"),  # left-handed
    (MATRIX, "[[0, 0, 1], [0, 1, 0], [-1, 0, 0.1]]", "SD112", 14, "no rotation"),
    (f"placement = {{ rotation = {MATRIX} }}\n", "", "SD107", 11, "no `dh`, and joint `slide` no `placement`"),
    (
        "[base]",
        "[dh]\nrows = [['q', 0, 0, 0], [0, 'q', 0, 0]]\n[base]",
        "SD105",
        10,
        "the DH table tells the placement",
    ),
    ('kind = "prismatic"', 'kind = "fixed"', "SD202", 13, "'revolute' or 'prismatic'"),
    ("upper = 1.5", "upper = -2", "SD113", 9, "above the upper limit"),
    ("velocity = 2", "velocity = -2", "SD203", 9, "must not be negative"),
    ("effort = 40", 'effort = "40 N"', "SD221", 9, "expected torque"),
    ("mass = 0.5", "mass = -0.5", "SD203", 18, "must not be negative"),
    ("mass = 0.5", "mass = 0.5\ninertia = { xx = -9, yy = -9, zz = -9 }", "SD214", 10, "would move against every push"),
    ("[0.1, 0, 0] }\n[[joint]]", "[0, 0, 0] }\n[[joint]]", None, None, ""),
]


@pytest.mark.parametrize(("old", "new", "code", "line", "told"), WRONG, ids=[w[1][:40] for w in WRONG])
def test_wrong_placement(
    old: str, new: str, code: str | None, line: int | None, told: str, catalogue: Catalogue
) -> None:
    assert TEXT.count(old) == 1
    text = TEXT.replace(old, new)
    if code is None:
        read_robot_text(text, "f", catalogue)
        return
    with pytest.raises(InputError) as caught:
        read_robot_text(text, "f", catalogue)
    first = caught.value.problems[0]
    assert first.where is not None
    assert (first.code, first.where.line) == (code, line)
    assert told in str(first)


def test_what_is_read(catalogue: Catalogue) -> None:
    robot = read_robot_text(TEXT, "f", catalogue)
    assert robot.joints[0].limits == Limits(-np.pi / 2, 1.5, 2.0, 40.0)
    placement = robot.joints[0].placement
    assert isinstance(placement, Placement)
    assert placement.rotation == ((1.0, 0.0, 0.0), (0.0, 0.0, -1.0), (0.0, 1.0, 0.0))
    names = [p.name for p in robot.parameters]
    assert {"turn_offset_z", "tool_mass", "tool_offset_x"} <= set(names)


def test_more_than_a_turn_is_doubtful(catalogue: Catalogue) -> None:
    _, (warning,) = text_with_warnings(TEXT.replace('"90 deg"', "90"), "f", catalogue)
    assert (warning.code, warning.hint) == ("SD223", 'for degrees write "90 deg"')


def test_mass_matrix_of_a_pendulum_on_a_cart(catalogue: Catalogue) -> None:
    text = """\
robot = { name = "cart", gravity = [0, 0, -9.81] }
[[joint]]
name = "cart"
kind = "prismatic"
placement = { rpy = [0, "90 deg", 0] }
link = { mass = 3 }
[[joint]]
name = "pole"
placement = { rpy = ["-90 deg", 0, 0] }
link = { mass = 2, com = [0.5, 0, 0] }
"""
    robot = read_robot_text(text, "f", catalogue)
    values = {p.name: p.value for p in robot.parameters}
    found = mass_matrix(robot, np.array([0.0, 0.7]), values)  # z of the cart is along the pole's -y
    coupling = 2 * 0.5 * np.cos(0.7)
    np.testing.assert_allclose(np.abs(found), [[5, coupling], [coupling, 0.5]], rtol=1e-12)


@pytest.mark.parametrize(
    ("link", "code"),
    [
        ("{ mass = 1 }", "SD214"),  # a point on its own axis
        ("{ inertia = { xx = 1 } }", "SD214"),
        ("{ mass = 1 }\ndrive = { rotors = [ { name = 'm', inertia = 1e-4, fixed_to_joint = true } ] }", None),
        ("{ mass = 1, com = [0.1, 0, 0] }", None),
        ("{ inertia = { zz = 1e-9 } }", None),
    ],
)
def test_joint_without_inertia_is_refused(link: str, code: str | None, catalogue: Catalogue) -> None:
    text = f'robot = {{ name = "one", gravity = [0, 0, 0] }}\n[[joint]]\nname = "j"\nplacement = {{}}\nlink = {link}\n'
    if code is None:
        read_robot_text(text, "f", catalogue)
        return
    with pytest.raises(InputError, match=f"f:5:8: {code}: .*singular about joint `j`"):
        read_robot_text(text, "f", catalogue)
