from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import pytest

import symdyn
from symdyn.base.errors import InputError
from symdyn.spec.edit import add_effect, set_effect, set_parameter
from symdyn.spec.effect_schema import EffectSchema
from symdyn.spec.toml_reader import read_robot_text

Catalogue = Mapping[str, EffectSchema]
MACHINES = sorted((Path(symdyn.__file__).parent / "machines").glob("*.toml"))

FORMS = """\
effect = [ { type = "viscous_friction", at = "a", coefficient = "1 N m s/rad" }, # inline
]

[robot]
name = "forms"
gravity = [0, 0, -9.81] # down

[dh]
rows = [["q - 10 deg", 0, 1, 0],
        [0, "q - 0.1 m", "N_1 l", 0]] # the slide

[[joint]]
name = "a"
link.mass = 3 # heavy
link.com = [1, 2, # here
            3]
actuator.gain = "2 Nm/A"

[[joint]]
name = "b"

[parameters]
l.free = "m"                # a dotted key
N_1 = { value = "3/2", meaning = "a ratio", latex = "N" }
z = { unit = "kg", meaning = "left free" }
r = { value = 250, unit = "mm" }
"""


def values(text: str, catalogue: Catalogue) -> dict[str, float | None]:
    return {p.name: p.value for p in read_robot_text(text, "f", catalogue).parameters}


def comments(text: str) -> list[str]:
    return [line[line.index("#") :] for line in text.splitlines() if "#" in line]


@pytest.mark.parametrize("text", [*(path.read_text(encoding="utf-8") for path in MACHINES), FORMS])
def test_every_parameter_can_be_set_and_nothing_else_changes(text: str, catalogue: Catalogue) -> None:
    robot = read_robot_text(text, "f", catalogue)
    before = values(text, catalogue)
    assert before
    for parameter in robot.parameters:
        value = 1.01 * parameter.value if parameter.value else 0.123  # near enough that a tensor stays a body's
        edited = set_parameter(text, robot, parameter.name, f"{value!r} {parameter.unit}".removesuffix(" 1"))
        assert values(edited, catalogue) == {**before, parameter.name: value}
        assert comments(edited) == comments(text)
        assert len(edited.splitlines()) == len(text.splitlines())


def test_successive_edits_with_the_first_robot(valid: str, catalogue: Catalogue) -> None:
    robot = read_robot_text(valid, "f", catalogue)
    text = valid
    for parameter in robot.parameters:
        text = set_parameter(text, robot, parameter.name, f"7 {parameter.unit}")
    assert set(values(text, catalogue).values()) == {7.0}


@pytest.mark.parametrize(
    ("name", "value", "line"),
    [
        ("r", "0.3 m", 'r = { value = 0.3, unit = "m" }'),
        ("r", "1/3 m", 'r = { value = "1/3", unit = "m" }'),
        ("N_1", "2.5", 'N_1 = { value = 2.5, meaning = "a ratio", latex = "N" }'),
        ("z", "2 kg", 'z = {value = "2 kg", meaning = "left free"}'),
        ("l", "2 m", 'l.value = "2 m"                # a dotted key'),
        ("a_mass", "250 g", 'link.mass = "250 g" # heavy'),
        ("b_dh_d", "0.2 m", '        [0, "q + 0.2 m", "N_1 l", 0]] # the slide'),
        ("b_dh_d", "-20 cm", '        [0, "q - 20 cm", "N_1 l", 0]] # the slide'),
        ("a_dh_a", "2 m", 'rows = [["q - 10 deg", 0, "2 m", 0],'),
    ],
)
def test_form_is_kept(name: str, value: str, line: str, catalogue: Catalogue) -> None:
    robot = read_robot_text(FORMS, "f", catalogue)
    assert line in set_parameter(FORMS, robot, name, value).splitlines()


@pytest.mark.parametrize(
    ("name", "value", "code"),
    [
        ("a_mas", "2 kg", "SD104"),
        ("a_mass", "2 m", "SD221"),
        ("a_mass", "2", "SD222"),
        ("a_mass", '2 kg" # ', "SD222"),
        ("a_mass", "__import__('os')", "SD222"),
    ],
)
def test_wrong_edits(name: str, value: str, code: str, catalogue: Catalogue) -> None:
    robot = read_robot_text(FORMS, "f", catalogue)
    with pytest.raises(InputError) as caught:
        set_parameter(FORMS, robot, name, value)
    assert caught.value.problems[0].code == code


def test_text_of_another_robot_is_refused(valid: str, catalogue: Catalogue) -> None:
    robot = read_robot_text(FORMS, "f", catalogue)
    with pytest.raises(InputError, match="does not define `r`"):
        set_parameter(valid, robot, "r", "1 m")


@pytest.mark.parametrize("text", [*(path.read_text(encoding="utf-8") for path in MACHINES), FORMS])
def test_added_effect_reads_back(text: str, catalogue: Catalogue) -> None:
    robot = read_robot_text(text, "f", catalogue)
    joint = robot.joints[0]
    level = "20.4 N" if joint.kind.value == "prismatic" else "20.4 N m"
    edited = add_effect(text, "coulomb_friction", joint.name, {"level": level})
    again = read_robot_text(edited, "f", catalogue)
    assert again.effects[:-1] == robot.effects or text is FORMS
    assert [effect.type for effect in again.effects] == [*(e.type for e in robot.effects), "coulomb_friction"]
    assert again.parameters[-1].name == f"{joint.name}_coulomb_friction_level"
    assert again.parameters[-1].value == 20.4
    assert comments(edited) == comments(text)


def test_added_block_as_written(valid: str) -> None:
    edited = add_effect(valid, "coulomb_friction", "elbow", {"level": '1 "N" m'}, "found by\na diagnosis")
    assert edited == (
        valid + '\n[[effect]]\n# found by a diagnosis\ntype = "coulomb_friction"\nat = "elbow"\nlevel = "1 \\"N\\" m"\n'
    )


def test_set_parameter_of_an_added_effect_and_of_its_default(valid: str, catalogue: Catalogue) -> None:
    text = add_effect(valid, "stribeck_friction", "elbow", {"level": "1 N m"})
    robot = read_robot_text(text, "f", catalogue)
    text = set_parameter(text, robot, "elbow_stribeck_friction_exponent", "1.5")
    text = set_parameter(text, robot, "elbow_stribeck_friction_level", "2 N m")
    assert text.endswith('level = "2 N m"\nexponent = 1.5\n')
    assert values(text, catalogue)["elbow_stribeck_friction_exponent"] == 1.5


@pytest.mark.parametrize(("type_", "key"), [("a b", "level"), ("coulomb_friction", 'x"\n[robot]')])
def test_names_that_are_none_are_refused(type_: str, key: str, valid: str) -> None:
    with pytest.raises(InputError) as caught:
        add_effect(valid, type_, "elbow", {key: "1 N m"})
    assert caught.value.problems[0].code == "SD101"


def test_a_value_more_of_an_effect(catalogue: Catalogue) -> None:
    """The one at that place, its other values and all comments kept; what is there already gets another value."""
    tachometer = '\n[[effect]] # the sensor\ntype = "tachometer"\nat = "{}"\nconstant = "0.03 V s/rad"\n'
    text = FORMS.partition("\n")[2].removeprefix("]\n") + tachometer.format("a") + tachometer.format("b")
    once = set_effect(text, "tachometer", "b", {"time_constant": "8 ms"})
    assert comments(once) == comments(text)
    assert once.splitlines()[:-1] == text.splitlines()
    assert once.splitlines()[-1] == 'time_constant = "8 ms"'
    twice = set_effect(once, "tachometer", "b", {"time_constant": "0.009 s"})
    assert twice == once.replace("8 ms", "0.009 s")
    assert set_effect(text, "ammeter", "a", {"offset": "1 A"}) == add_effect(text, "ammeter", "a", {"offset": "1 A"})
