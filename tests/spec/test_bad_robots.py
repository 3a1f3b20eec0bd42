"""Every wrong input gets its code, its place in the file, and a word on what to do."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import pytest

from symdyn.base.errors import InputError, Problem
from symdyn.spec.effect_schema import EffectSchema
from symdyn.spec.toml_reader import read_robot_text, text_with_warnings

Catalogue = Mapping[str, EffectSchema]

CODE = "__import__('os').system('touch canary')"
MASS = "mass = 4"
M_2 = 'm_2 = "3 kg"'
SHOULDER = 'name = "shoulder"'
ROW = '["q", 0, 0.5, 0]'
LEVEL = "coefficient = 1e-5"
VISCOUS = f'type = "viscous_friction"\nat = "elbow.motor"\n{LEVEL}'
ZZ = 'zz = "0.08 kg m^2"'

# (what is replaced, by what, code, line, column, a word of the message or hint)
WRONG = [
    # numbers
    (MASS, "mass = -4", "SD203", 15, 17, "must not be negative"),
    (MASS, 'mass = "-4 kg"', "SD203", 15, 17, "must not be negative"),
    (MASS, 'mass = "heavy"', "SD104", 15, 17, "no parameter `heavy`"),
    (MASS, "mass = true", "SD202", 15, 17, "a boolean"),
    (MASS, "mass = [1]", "SD202", 15, 17, "an array"),
    (MASS, "mass = 1979-05-27", "SD202", 15, 17, "a date"),
    (MASS, "mass = nan", "SD201", 15, 17, "finite"),
    (MASS, "mass = inf", "SD201", 15, 17, "finite"),
    (MASS, "mass = 1e400", "SD201", 15, 17, "finite"),
    (MASS, "mass = " + "9" * 400, "SD201", 15, 17, "finite"),
    (MASS, 'mass = "1e400 kg"', "SD201", 15, 17, "finite"),
    (MASS, 'mass = "5 furlong"', "SD222", 15, 17, "`furlong` is not a unit"),
    (MASS, 'mass = "3,5 mm"', "SD222", 15, 17, "decimal point"),
    (MASS, 'mass = "10**10**8"', "SD222", 15, 17, "a number, a space and a unit"),
    (MASS, f'mass = "{CODE}"', "SD222", 15, 17, "number unit"),
    (MASS, 'mass = "12"', "SD221", 15, 17, 'give it a unit: "12 kg"'),
    (MASS, 'mass = "5 Nm"', "SD221", 15, 17, "dimension torque (Nm), expected mass (kg)"),
    (MASS, 'mass = "2 m_2 l_2"', "SD221", 15, 17, "m_2 is in kg; l_2 is in m"),
    (MASS, 'mass = "1/2 m_3"', "SD104", 15, 17, "did you mean `m_2`?"),
    (MASS, "mass = 1,5", "SD001", 15, 20, "decimal point"),
    (M_2, "m_2 = 3", "SD221", 19, 17, "m_2 has no unit"),
    ("l_2 = { value = 400", "l_2 = { value = 1e300", "SD201", 19, 67, "finite"),
    ("com = [-0.25, 0, 0]", 'com = [-0.25, "1 s", 0]', "SD221", 15, 34, "expected length"),
    ("com = [-0.25, 0, 0]", "com = [1, 2]", "SD202", 15, 26, "at least 3"),
    # parameters
    (M_2, 'm_2 = "heavy"', "SD222", 6, 7, "number unit"),
    (M_2, 'm_2 = { value = 3, unt = "kg" }', "SD104", 6, 20, "did you mean `unit`?"),
    (M_2, 'm_2 = { free = "kg", value = 1 }', "SD202", 6, 30, "`free` stands alone"),
    (M_2, 'm_2 = { meaning = "a mass" }', "SD107", 6, 7, "a value or a unit"),
    (M_2, 'm_2 = { value = "3 kg", unit = "m" }', "SD221", 6, 17, "but its unit is length (m)"),
    (M_2, 'm_2 = { value = 3, unit = "stone" }', "SD222", 6, 17, "`stone` is not a unit"),
    (M_2, r'm_2 = { value = "3 kg", latex = "\\input{/etc/passwd}" }', "SD108", 6, 33, "not allowed"),
    (M_2, r'm_2 = { value = "3 kg", meaning = "a\nb" }', "SD202", 6, 35, "one line"),
    (M_2, f'{M_2}\nm_2 = "4 kg"', "SD001", 7, 1, "`parameters.m_2` is defined twice, first at f:6:1"),
    (M_2, f'{M_2}\nM_2 = "4 kg"', "SD103", 7, 1, "`m_2` (f:6:1)"),
    (M_2, f'{M_2}\n"a b" = "4 kg"', "SD101", 7, 1, "is not a name"),
    (M_2, f"{M_2}\n\"{CODE}\" = '4 kg'", "SD101", 7, 1, "is not a name"),
    (M_2, f'{M_2}\ntau = "4 kg"', "SD102", 7, 1, "write `tau_`"),
    # names
    ('name = "arm"', 'name = "Arm!"', "SD101", 2, 8, "irb6-axis1"),
    ('name = "arm"', 'name = "../x"', "SD101", 2, 8, "is not a robot's name"),
    (SHOULDER, f'name = "{CODE}"', "SD101", 14, 8, "is not a name"),
    (SHOULDER, r'name = "\\input{/etc/passwd}"', "SD101", 14, 8, "is not a name"),
    (SHOULDER, f'name = "{"a" * 10_000}"', "SD101", 14, 8, "longer than 64"),
    (SHOULDER, 'name = "lambda"', "SD102", 14, 8, "write `lambda_`"),
    (SHOULDER, 'name = "elbow"', "SD106", 18, 8, "first at f:14:8"),
    (SHOULDER, 'name = "Elbow"', "SD103", 18, 8, "`Elbow` (f:14:8)"),
    (SHOULDER, "name = 3", "SD202", 14, 8, "expected a text"),
    ('name = "belt"', 'name = "motor"', "SD106", 24, 21, "first at f:23:21"),
    # keys and tables
    (MASS, "mas = 4", "SD104", 15, 10, "did you mean `mass`?"),
    ("[robot]", "[rbot]", "SD104", 1, 2, "did you mean `robot`?"),
    ('name = "arm"\n', "", "SD107", 1, 2, "the table `robot` has no `name`"),
    ("gravity = [0, 0, -9.81]", "gravity = 9.81", "SD202", 3, 11, "must be an array"),
    ("[[effect]]", "[effect]", "SD202", 27, 2, "write [[effect]]"),
    ('"com", zz', '"cm", zz', "SD202", 15, 61, "expected 'com' or 'joint'"),
    ("stiffness = 12, ", "", "SD107", 24, 12, "has no `stiffness`"),
    # DH
    (f"rows = [ {ROW},\n        ", "rows = [\n", "SD105", 10, 8, "1 DH rows for 2 joints"),
    (ROW, '["q", 0, 0.5]', "SD105", 10, 10, "four columns, this one 3"),
    (ROW, "[0, 0, 0.5, 0]", "SD105", 10, 10, "here: none"),
    (ROW, '["q", "q", 0.5, 0]', "SD105", 10, 10, "here: theta, d"),
    (ROW, '[0, 0, "q", 0]', "SD105", 10, 10, "here: a"),
    (ROW, '["q + x", 0, 0.5, 0]', "SD104", 10, 11, "no parameter `x`"),
    (ROW, '["q", 0, true, 0]', "SD202", 10, 19, "a boolean"),
    (ROW, '["q", 0, 0.5, "90 mm"]', "SD221", 10, 24, "expected angle (rad)"),
    ("[dh]", '[dh]\nconvention = "craig"', "SD202", 10, 14, "'standard' or 'modified'"),
    # drive
    ("ratio = 100", "ratio = 0", "SD231", 22, 9, "gear ratio is 0"),
    ('from = "motor"', 'from = "mtor"', "SD104", 24, 36, "did you mean `motor`?"),
    (', at = "motor"', ', at = "gear"', "SD104", 25, 34, "rotors: motor, joint"),
    ("shafts = [ {", "shafts = [] # [ {", "SD111", 23, 12, "is not connected to the joint"),
    ("stiffness = 12", "stiffness = -12", "SD203", 24, 71, "must not be negative"),
    ('stiffness = 12, damping = "0.1 mNms/rad"', "stiffness = 0, damping = 0", "SD203", 24, 71, "nothing holds"),
    ('inertia = "5e-5 kg m^2"', "inertia = -1", "SD203", 23, 40, "must not be negative"),
    ('resistance = "1.6 Ohm"', "resistance = -1", "SD203", 25, 56, "must not be negative"),
    ("[joint.drive]", "actuator = { gain = 3 }\n[joint.drive]", "SD221", 21, 21, '"3 N m/V" or "3 N m/A"'),
    ("[joint.drive]", 'actuator = { gain = "3 N/V" }\n[joint.drive]', "SD221", 21, 21, "torque per voltage (N m/V)"),
    ("ratio = 100", 'ratio = 100\neffort_at = "mtor"', "SD104", 23, 13, "did you mean `motor`?"),
    ("ratio = 100", 'ratio = 100\neffort_at = "motor"', "SD111", 23, 13, "leave out `effort_at`, or the motor"),
    # inertia
    (ZZ, "zz = -90", "SD214", 15, 8, "negative about joint `shoulder` in every pose"),
    # effects
    ('type = "viscous_friction"', 'type = "viscus_friction"', "SD104", 28, 8, "did you mean `viscous_friction`?"),
    ('at = "elbow.motor"', 'at = "elbow.moter"', "SD104", 29, 6, "shoulder, elbow, elbow.motor, elbow.belt"),
    ('at = "elbow.motor"', 'at = "elbow.circuit"', "SD109", 29, 6, "a circuit"),
    (LEVEL, "coeficient = 1e-5", "SD104", 30, 1, "did you mean `coefficient`?"),
    (LEVEL, "", "SD107", 27, 3, "needs `coefficient`"),
    (LEVEL, "coefficient = -1e-5", "SD203", 30, 15, "at least 0"),
    (
        VISCOUS,
        'type = "tachometer"\nat = "elbow.motor"\nconstant = 0',
        "SD203",
        30,
        12,
        "must not be zero: tachometer con",
    ),
    (LEVEL, 'coefficient = "1 N m"', "SD221", 30, 15, "expected rotational damping"),
    (LEVEL, "coefficient = {}", "SD202", 30, 15, "a table"),
    # syntax
    ("[robot]", "[robot", "SD001", 1, 7, "']'"),
    (ROW, "[" * 3000, "SD002", 10, 73, "nested deeper"),
]


def changed(valid: str, old: str, new: str) -> str:
    assert valid.count(old) == 1, old
    return valid.replace(old, new)


def problems_of(text: str, catalogue: Catalogue) -> tuple[Problem, ...]:
    with pytest.raises(InputError) as caught:
        read_robot_text(text, "f", catalogue)
    assert caught.value.exit_code == 3
    return caught.value.problems


@pytest.mark.parametrize(("old", "new", "code", "line", "column", "told"), WRONG, ids=[w[1][:40] for w in WRONG])
def test_wrong_input(
    old: str, new: str, code: str, line: int, column: int, told: str, valid: str, catalogue: Catalogue,
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    monkeypatch.chdir(tmp_path)
    first = problems_of(changed(valid, old, new), catalogue)[0]
    assert first.where is not None
    assert (first.code, first.where.file, first.where.line, first.where.column) == (code, "f", line, column)
    assert told in str(first)
    assert not list(tmp_path.iterdir())  # nothing in a file is ever run


DOUBTFUL = [
    ('"l_2", "90 deg"]', '"l_2", 90]', "SD223", 11, 26, 'for degrees write "90 deg"'),
    ('["q", 0, "l_2"', '["q + 90", 0, "l_2"', "SD223", 11, 11, "more than a turn"),
    ("ratio = 100", "ratio = 0.01", "SD231", 22, 9, "turns faster than its motor"),
    ('back_emf_constant = "0.05 ', 'back_emf_constant = "0.5 ', "SD232", 25, 140, "90 % apart"),
    (ZZ, "zz = -0.01", "SD212", 15, 51, "negative principal moment, -0.01"),
    (ZZ, "xx = 1, yy = 1, zz = 1, xy = 2", "SD212", 15, 51, "negative principal moment, -1"),
    (ZZ, "xx = 1, yy = 1, zz = 3", "SD211", 15, 51, "1 + 1 < 3 kg m^2, by 33 %"),
    ('"com", zz = "0.08 kg m^2"', '"joint", xx = 1e-3, yy = 0.1, zz = 0.1', "SD213", 15, 51, "too far out"),
]


@pytest.mark.parametrize(("old", "new", "code", "line", "column", "told"), DOUBTFUL, ids=[d[1][:40] for d in DOUBTFUL])
def test_doubtful_input_is_read_with_a_warning(
    old: str, new: str, code: str, line: int, column: int, told: str, valid: str, catalogue: Catalogue
) -> None:
    _, (warning,) = text_with_warnings(changed(valid, old, new), "f", catalogue)
    assert warning.where is not None
    assert (warning.code, warning.where.line, warning.where.column) == (code, line, column)
    assert told in str(warning)


def test_all_problems_are_told_at_once_in_file_order(valid: str, catalogue: Catalogue) -> None:
    text = changed(valid, 'name = "arm"', 'name = "Arm!"')
    text = changed(text, MASS, "mas = 4, mass = nan")
    text = changed(text, "stiffness = 12", 'stiffness = "1 kg"')
    text = changed(text, LEVEL, 'coefficient = "1 N m"')
    told = [(p.code, p.where.line if p.where else None) for p in problems_of(text, catalogue)]
    assert told == [("SD101", 2), ("SD104", 15), ("SD201", 15), ("SD221", 24), ("SD221", 30)]


def test_what_follows_from_an_error_is_not_told(valid: str, catalogue: Catalogue) -> None:
    (only,) = problems_of(changed(valid, M_2, 'm_2 = "3 kgg"'), catalogue)  # used in three places
    assert only.code == "SD222"
    (only,) = problems_of(changed(valid, "ratio = 100", "ratio = true"), catalogue)  # its stand-in is 0
    assert only.code == "SD202"


def test_empty_file_lacks_its_tables(catalogue: Catalogue) -> None:
    assert [problem.message for problem in problems_of("", catalogue)] == [
        f"the file has no `{table}`" for table in ("robot", "joint")
    ]


def test_number_that_may_be_unit_or_parameter(valid: str, catalogue: Catalogue) -> None:
    text = changed(valid, M_2, f'{M_2}\nm = "2 m"\ns = "1 kg"')
    ambiguous = changed(text, 'com = ["-1/2 l_2"', 'com = ["3 m"')
    assert "for the parameter" in str(problems_of(ambiguous, catalogue)[0])
    starred = read_robot_text(changed(text, 'com = ["-1/2 l_2"', 'com = ["3 * m"'), "f", catalogue)
    assert starred.joints[1].link.com[0].factors == (("m", 1),)
    by_dimension = read_robot_text(changed(text, MASS, 'mass = "3 s"'), "f", catalogue)  # three times s, not seconds
    assert by_dimension.joints[0].link.mass.factors == (("s", 1),)
