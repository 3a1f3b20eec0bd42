from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from fractions import Fraction
from pathlib import Path

import pytest

import symdyn
from symdyn.base.errors import InputError
from symdyn.base.names import identifier_problem
from symdyn.spec.effect_schema import EffectSchema
from symdyn.spec.places import places
from symdyn.spec.records import (
    ONE,
    ZERO,
    Convention,
    InertiaAbout,
    JointKind,
    Monomial,
    Motion,
    Place,
    PlaceKind,
    Quantity,
    Robot,
    Side,
)
from symdyn.spec.toml_reader import read_channel_map, read_robot, read_robot_text, read_with_warnings

Catalogue = Mapping[str, EffectSchema]
MACHINES = sorted((Path(symdyn.__file__).parent / "machines").glob("*.toml"))


def machine(name: str, catalogue: Catalogue) -> Robot:
    return read_robot(next(path for path in MACHINES if path.stem == name), catalogue)


def of(name: str, coefficient: Fraction | int = 1) -> Monomial:
    return Monomial(Fraction(coefficient), ((name, 1),))


@pytest.mark.parametrize("path", MACHINES, ids=[path.stem for path in MACHINES])
def test_bundled_machines_read(path: Path, catalogue: Catalogue) -> None:
    robot = read_robot(path, catalogue)
    assert robot.name == path.stem
    assert robot.text == path.read_text(encoding="utf-8")
    names = [parameter.name for parameter in robot.parameters]
    assert len({name.casefold() for name in names}) == len(names)
    assert all(identifier_problem(name) is None for name in names)
    assert all(p.where is not None and p.where.line for p in robot.parameters)


def test_bundled_machines_were_found() -> None:
    assert {"emps", "irb6-arm", "irb6-arm-rod", "irb6-axis1", "two-link"} <= {path.stem for path in MACHINES}


def test_axis1_is_read_as_printed(catalogue: Catalogue) -> None:
    robot = machine("irb6-axis1", catalogue)
    values = {parameter.name: (parameter.value, parameter.unit) for parameter in robot.parameters}
    assert values["L"] == (87e-6, "H")
    assert values["J_4"] == (372e-6, "kg m^2")
    assert values["S"] == (0.0, "rad")
    (joint,) = robot.joints
    assert joint.kind is JointKind.REVOLUTE
    assert joint.link.about is InertiaAbout.JOINT
    assert joint.link.inertia == (ZERO, ZERO, of("J_4"), ZERO, ZERO, ZERO)
    assert joint.drive is not None
    assert joint.drive.ratio == ONE
    assert [(rotor.name, rotor.inertia) for rotor in joint.drive.rotors] == [
        ("tachometer", of("J_1")),
        ("motor", of("J_2")),
        ("harmonic_drive", of("J_3")),
    ]
    assert [(shaft.start, shaft.end, shaft.stiffness) for shaft in joint.drive.shafts] == [
        ("tachometer", "motor", of("c_1")),
        ("motor", "harmonic_drive", of("c_2")),
        ("harmonic_drive", "joint", of("c_3")),
    ]
    assert joint.drive.motor is not None
    assert joint.drive.motor.torque_constant == of("K_T")
    backlash = robot.effects[-1]
    assert (backlash.type, backlash.at, backlash.values) == ("backlash", "axis1.flexspline", (("clearance", of("S")),))


def test_places_of_a_drive(catalogue: Catalogue) -> None:
    found = places(machine("irb6-axis1", catalogue))
    assert [(place.address, place.kind.value) for place in found] == [
        ("axis1", "joint"),
        ("axis1.tachometer", "inertia"),
        ("axis1.motor", "inertia"),
        ("axis1.harmonic_drive", "inertia"),
        ("axis1.tachometer_shaft", "shaft"),
        ("axis1.motor_shaft", "shaft"),
        ("axis1.flexspline", "shaft"),
        ("axis1.circuit", "circuit"),
    ]
    assert found[-1].motion is Motion.ELECTRICAL
    assert places(machine("emps", catalogue)) == (Place("carriage", PlaceKind.JOINT, Motion.TRANSLATIONAL),)


def test_arms(catalogue: Catalogue) -> None:
    rod = machine("irb6-arm-rod", catalogue)
    assert rod.gravity == (ZERO, ZERO, of("g", -1))
    assert rod.joints[0].placement.alpha == Monomial(math.pi / 2)
    assert rod.joints[1].placement.a == of("l")
    assert rod.joints[1].link.com == (of("l", Fraction(-1, 2)), ZERO, ZERO)
    assert rod.joints[1].link.inertia[1] == Monomial(Fraction(1, 12), (("m", 1), ("l", 2)))
    assert machine("two-link", catalogue).convention is Convention.MODIFIED


def test_emps_and_its_recording(catalogue: Catalogue) -> None:
    robot = machine("emps", catalogue)
    (carriage,) = robot.joints
    assert carriage.kind is JointKind.PRISMATIC
    assert carriage.actuator is not None
    assert (carriage.actuator.gain, carriage.actuator.input_unit) == (of("G_tau"), "V")
    assert robot.channels is not None
    assert (robot.channels.time_column, robot.channels.time_factor) == ("t", 1.0)
    told = [(c.column, c.quantity, c.joint, c.side, c.factor, c.scale, c.sign) for c in robot.channels.channels]
    assert told == [
        ("q", Quantity.POSITION, "carriage", Side.MOTOR, 1.0, 1.0, 1),
        ("u", Quantity.VOLTAGE, "carriage", Side.LINK, 1.0, 1.0, 1),
    ]


def test_literals_become_parameters(valid: str, catalogue: Catalogue) -> None:
    robot = read_robot_text(valid, "f", catalogue)
    assert [(p.name, p.value, p.unit, p.latex) for p in robot.parameters] == [
        ("m_2", 3.0, "kg", "m_{2}"),
        ("l_2", 0.4, "m", "l_{2}"),
        ("gravity_z", -9.81, "m/s^2", "g_{z}"),
        ("shoulder_dh_a", 0.5, "m", r"a_{\mathrm{shoulder}}"),
        ("shoulder_mass", 4.0, "kg", r"m_{\mathrm{shoulder}}"),
        ("shoulder_com_x", -0.25, "m", r"r_{x,\mathrm{shoulder}}"),
        ("shoulder_inertia_zz", 0.08, "kg m^2", r"I_{zz,\mathrm{shoulder}}"),
        ("elbow_drive_ratio", 100.0, "1", r"N_{\mathrm{elbow}}"),
        ("elbow_motor_inertia", 5e-5, "kg m^2", r"J_{\mathrm{elbow},\mathrm{motor}}"),
        ("elbow_belt_stiffness", 12.0, "N m/rad", r"c_{\mathrm{elbow},\mathrm{belt}}"),
        ("elbow_belt_damping", 1e-4, "N m s/rad", r"d_{\mathrm{elbow},\mathrm{belt}}"),
        ("elbow_circuit_resistance", 1.6, "Ohm", r"R_{\mathrm{elbow},\mathrm{circuit}}"),
        ("elbow_circuit_inductance", 87e-6, "H", r"L_{\mathrm{elbow},\mathrm{circuit}}"),
        ("elbow_circuit_torque_constant", 0.05, "N m/A", r"K_{T,\mathrm{elbow},\mathrm{circuit}}"),
        ("elbow_circuit_back_emf_constant", 0.05, "V s/rad", r"K_{E,\mathrm{elbow},\mathrm{circuit}}"),
        ("elbow_motor_viscous_friction_coefficient", 1e-5, "N m s/rad", r"F_{v,\mathrm{elbow},\mathrm{motor}}"),
    ]
    mass = next(p for p in robot.parameters if p.name == "shoulder_mass")
    assert mass.where is not None
    assert (mass.where.line, mass.where.column) == (15, 17)


def test_zeros_are_structural_except_in_effects(valid: str, catalogue: Catalogue) -> None:
    robot = read_robot_text(
        valid.replace("mass = 4", 'mass = "0 kg"').replace("coefficient = 1e-5", "coefficient = 0"), "f", catalogue
    )
    assert robot.joints[0].link.mass == ZERO
    name = "elbow_motor_viscous_friction_coefficient"
    assert robot.effects[0].values == (("coefficient", of(name)),)
    assert next(p.value for p in robot.parameters if p.name == name) == 0.0


def test_automatic_names_give_way_to_written_ones(valid: str, catalogue: Catalogue) -> None:
    text = valid.replace('m_2 = "3 kg"', 'm_2 = "3 kg"\nShoulder_Mass = "1 kg"')
    robot = read_robot_text(text, "f", catalogue)
    assert robot.joints[0].link.mass == of("shoulder_mass_2")
    long = "a" * 60
    robot = read_robot_text(valid.replace('"shoulder"', f'"{long}"'), "f", catalogue)
    names = [parameter.name for parameter in robot.parameters]
    assert all(identifier_problem(name) is None for name in names)
    assert len(set(names)) == len(names)


def test_a_file_cannot_refer_to_automatic_names(valid: str, catalogue: Catalogue) -> None:
    with pytest.raises(InputError, match="no parameter `shoulder_mass`"):
        read_robot_text(valid.replace('mass = "m_2"', 'mass = "shoulder_mass"'), "f", catalogue)


@pytest.mark.parametrize(
    ("entry", "value", "unit"),
    [
        ('"12 kg"', 12.0, "kg"),
        ("12", 12.0, "1"),
        ('"1/12"', 1 / 12, "1"),
        ('{ value = 12, unit = "g" }', 0.012, "kg"),
        ('{ value = 1.2, unit = "mm" }', 0.0012, "m"),
        ('{ value = "1/12", unit = "mNm/A" }', 1 / 12000, "N m/A"),
        ('{ value = "12 kg", meaning = "a mass" }', 12.0, "kg"),
        ('{ value = "12 kg", unit = "g" }', 12.0, "kg"),
        ('{ free = "kg" }', None, "kg"),
        ('{ unit = "uH" }', None, "H"),
        ('"90 deg"', math.pi / 2, "rad"),
    ],
)
def test_forms_of_a_parameter(entry: str, value: float | None, unit: str, valid: str, catalogue: Catalogue) -> None:
    robot = read_robot_text(valid.replace("[parameters]", f"[parameters]\nunused = {entry}"), "f", catalogue)
    parameter = robot.parameters[0]
    assert (parameter.name, parameter.value, parameter.unit) == ("unused", value, unit)


def test_parameter_tells_its_latex_and_meaning(valid: str, catalogue: Catalogue) -> None:
    entry = r'm_2 = { value = 3, unit = "kg", latex = "\\hat{m}_{2}", meaning = "mass of the µ-arm" }'
    robot = read_robot_text(valid.replace('m_2 = "3 kg"', entry), "f", catalogue)
    assert (robot.parameters[0].latex, robot.parameters[0].meaning) == (r"\hat{m}_{2}", "mass of the µ-arm")


def test_free_parameters_switch_checks_off(valid: str, catalogue: Catalogue) -> None:
    text = valid.replace('m_2 = "3 kg"', 'm_2 = { free = "kg" }')
    assert read_robot_text(text, "f", catalogue).joints[1].link.mass == of("m_2")


@pytest.mark.parametrize(
    ("row", "kind", "theta", "d"),
    [
        ('["q", 0, 0, 0]', JointKind.REVOLUTE, ZERO, ZERO),
        ('["q + 90 deg", "l_2", 0, 0]', JointKind.REVOLUTE, Monomial(math.pi / 2), of("l_2")),
        ('["q - 1", 0, 0, 0]', JointKind.REVOLUTE, Monomial(Fraction(-1)), ZERO),
        ('[0, "q", 0, 0]', JointKind.PRISMATIC, ZERO, ZERO),
        ('[0.5, "q - 1/2 l_2", 0, 0]', JointKind.PRISMATIC, Monomial(0.5), of("l_2", Fraction(-1, 2))),
        ('[0, "q-0.1 m", 0, 0]', JointKind.PRISMATIC, ZERO, of("shoulder_dh_d")),
    ],
)
def test_joint_variable(
    row: str, kind: JointKind, theta: Monomial, d: Monomial, valid: str, catalogue: Catalogue
) -> None:
    text = valid.replace('["q", 0, 0.5, 0]', row)
    joint = read_robot_text(text, "f", catalogue).joints[0]
    assert (joint.kind, joint.placement.theta, joint.placement.d) == (kind, theta, d)


def test_offset_keeps_its_sign(valid: str, catalogue: Catalogue) -> None:
    robot = read_robot_text(valid.replace('["q", 0, 0.5, 0]', '[0, "q - 0.1 m", 0.5, 0]'), "f", catalogue)
    assert next(p.value for p in robot.parameters if p.name == "shoulder_dh_d") == -0.1


def test_the_drive_of_a_prismatic_joint_turns(valid: str, catalogue: Catalogue) -> None:
    text = valid.replace('["q", 0, "l_2", "90 deg"]', '[0, "q", 0, 0]') + (
        '\n[[effect]]\ntype = "viscous_friction"\nat = "elbow"\ncoefficient = "3 N s/m"\n'
    )
    robot = read_robot_text(text, "f", catalogue)
    units = {parameter.name: parameter.unit for parameter in robot.parameters}
    assert units["elbow_belt_stiffness"] == "N m/rad"
    assert units["elbow_motor_viscous_friction_coefficient"] == "N m s/rad"
    assert units["elbow_viscous_friction_coefficient"] == "N s/m"


def test_the_motors_side_of_a_prismatic_joint_turns(valid: str, catalogue: Catalogue, tmp_path: Path) -> None:
    robot = read_robot_text(valid.replace('["q", 0, "l_2", "90 deg"]', '[0, "q", 0, 0]'), "f", catalogue)
    path = tmp_path / "channels.toml"
    path.write_text(CHANNELS, encoding="utf-8")
    assert read_channel_map(path, robot, catalogue).channels[0].factor == math.pi / 180
    path.write_text(CHANNELS.replace('side = "motor"', 'side = "link"'), encoding="utf-8")
    with pytest.raises(InputError) as caught:
        read_channel_map(path, robot, catalogue)
    assert [p.code for p in caught.value.problems] == ["SD221"]


def test_a_reference_is_in_the_unit_of_its_loop(valid: str, catalogue: Catalogue, tmp_path: Path) -> None:
    loop = '\n[[effect]]\ntype = "position_servo"\nat = "elbow.motor"\nproportional = 50\nlimit = 24\n'
    path = tmp_path / "channels.toml"
    map_ = '[recording]\ntime = { column = "t", unit = "s" }\n[[recording.channel]]\ncolumn = "r"\n'
    told = f'{map_}quantity = "reference"\njoint = "elbow"\nunit = "deg"\n'
    servo, loose = (read_robot_text(valid + more, "f", catalogue) for more in (loop, ""))
    path.write_text(told, encoding="utf-8")
    (reference,) = read_channel_map(path, servo, catalogue).channels
    assert (reference.quantity, reference.joint, reference.factor) == (Quantity.REFERENCE, "elbow", math.pi / 180)
    for robot, text, code, message in (
        (loose, told, "SD203", "no servo loop at `elbow` follows a reference"),
        (servo, f'{told}side = "motor"\n', "SD203", "a reference has no side"),
        (servo, told.replace("deg", "V"), "SD221", "expected angle"),
        (servo, told.replace("elbow", "shoulder"), "SD203", "no servo loop at `shoulder`"),
    ):
        path.write_text(text, encoding="utf-8")
        with pytest.raises(InputError) as caught:
            read_channel_map(path, robot, catalogue)
        assert [p.code for p in caught.value.problems] == [code]
        assert message in str(caught.value)


def test_gain_tells_the_input(valid: str, catalogue: Catalogue) -> None:
    for unit, gain in [("V", '"2 N m/V"'), ("A", '"2 mNm/mA"')]:
        text = valid.replace('[[joint]]\nname = "elbow"', f'actuator = {{ gain = {gain} }}\n[[joint]]\nname = "elbow"')
        actuator = read_robot_text(text, "f", catalogue).joints[0].actuator
        assert actuator is not None
        assert (actuator.gain, actuator.input_unit) == (of("shoulder_actuator_gain"), unit)


def test_effect_defaults_become_parameters(valid: str, catalogue: Catalogue) -> None:
    text = valid + '\n[[effect]]\ntype = "stribeck_friction"\nat = "elbow"\nlevel = "0.1 N m"\n'
    robot = read_robot_text(text, "f", catalogue)
    assert robot.effects[1].values == (
        ("level", of("elbow_stribeck_friction_level")),
        ("exponent", of("elbow_stribeck_friction_exponent")),
    )
    assert robot.parameters[-1].value == 2.0


def test_one_effect_twice_at_a_place(valid: str, catalogue: Catalogue) -> None:
    block = valid[valid.index("[[effect]]") :]
    robot = read_robot_text(valid + block, "f", catalogue)
    assert robot.effects[1].values == (("coefficient", of("elbow_motor_viscous_friction_coefficient_2")),)


def test_reading_is_deterministic_and_takes_windows_line_ends(valid: str, catalogue: Catalogue) -> None:
    robot = read_robot_text(valid, "f", catalogue)
    assert read_robot_text(valid, "f", catalogue) == robot
    windows = read_robot_text("\ufeff" + valid.replace("\n", "\r\n"), "f", catalogue)
    assert dataclasses.replace(windows, text=robot.text) == robot


def test_file_and_text_read_alike(valid: str, catalogue: Catalogue, tmp_path: Path) -> None:
    path = tmp_path / "arm.toml"
    path.write_text(valid, encoding="utf-8")
    robot, warnings = read_with_warnings(path, catalogue)
    assert robot == read_robot(str(path), catalogue) == read_robot_text(valid, str(path), catalogue)
    assert warnings == ()


CHANNELS = """\
[recording]
time = { column = "t", unit = "ms" }
[[recording.channel]]
column = "angle [deg]"
quantity = "position"
joint = "elbow"
side = "motor"
unit = "deg"
scale = 0.5
sign = -1
[[recording.channel]]
column = "i"
quantity = "current"
joint = "elbow"
unit = "mA"
"""


def test_channel_map_in_its_own_file(valid: str, catalogue: Catalogue, tmp_path: Path) -> None:
    path = tmp_path / "channels.toml"
    path.write_text(CHANNELS, encoding="utf-8")
    channels = read_channel_map(path, read_robot_text(valid, "f", catalogue), catalogue)
    assert channels.time_factor == 1e-3
    angle, current = channels.channels
    assert (angle.side, angle.factor, angle.scale, angle.sign) == (Side.MOTOR, math.pi / 180, 0.5, -1)
    assert (current.quantity, current.factor, current.sign) == (Quantity.CURRENT, 1e-3, 1)


@pytest.mark.parametrize(
    ("old", "new", "code", "line", "column"),
    [
        ('unit = "ms"', 'unit = "mm"', "SD221", 2, 31),
        ('unit = "deg"', 'unit = "mm"', "SD221", 8, 8),
        ('unit = "deg"', 'unit = "grad"', "SD222", 8, 8),
        ('joint = "elbow"\nside', 'joint = "elbo"\nside', "SD104", 6, 9),
        ('"position"', '"postion"', "SD202", 5, 12),
        ('"motor"', '"moter"', "SD202", 7, 8),
        ("sign = -1", "sign = 2", "SD202", 10, 8),
        ("sign = -1", "sign = true", "SD202", 10, 8),
        ("scale = 0.5", "scale = 0", "SD203", 9, 9),
        ("scale = 0.5", "scale = inf", "SD201", 9, 9),
        ("scale = 0.5", 'scale = "2"', "SD202", 9, 9),
        ('column = "i"', 'column = "t"', "SD106", 12, 10),
        ('"current"', '"position"\nside = "motor"', "SD106", 11, 3),
        ("scale", "scal", "SD104", 9, 1),
        ("[recording]\n", "[robot]\n[recording]\n", "SD104", 1, 2),
    ],
)
def test_wrong_channel_map(
    old: str, new: str, code: str, line: int, column: int, valid: str, catalogue: Catalogue, tmp_path: Path
) -> None:
    path = tmp_path / "channels.toml"
    path.write_text(CHANNELS.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(InputError) as caught:
        read_channel_map(path, read_robot_text(valid, "f", catalogue), catalogue)
    told = [(p.code, p.where.line, p.where.column) for p in caught.value.problems if p.where is not None]
    assert (code, line, column) in told
