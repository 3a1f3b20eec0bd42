"""Drive trains: the order of coordinates, closed forms of the torque balance, where effects enter, energy."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from itertools import product

import pytest
import sympy as sp
from hypothesis import example, given, settings
from hypothesis import strategies as st
from mpmath import mpf, workdps

from symdyn.base.errors import InputError
from symdyn.base.nonsmooth import deadzone, outside, pushing, sign_of
from symdyn.base.symbols import parameter
from symdyn.compiler import robot_from_text
from symdyn.derive.coordinates import coordinates
from symdyn.derive.equations import equations_of_motion
from symdyn.program.evaluate import evaluate
from symdyn.program.functions import functions
from symdyn.program.ssa import Program
from symdyn.spec.records import JOINT_END, ONE, Drive, EffectSpec, JointKind, Motor, Robot, Rotor, Shaft

from .drives import BELT, RIGID, chain, driven, letter
from .evaluation import DIGITS, close
from .exact import required_efforts, same

N, J_m, c, d, M, K_T, K_E, R, L, S = map(parameter, ("N", "J_m", "c", "d", "M", "K_T", "K_E", "R", "L", "S"))
I_zz = parameter("I")  # of the link
q1, q2, q3 = sp.symbols("q_1:4", real=True)
v1, v2, v3 = sp.symbols("qd_1:4", real=True)
a1, a2, a3 = sp.symbols("qdd_1:4", real=True)
z1, u1 = sp.symbols("z_1 u_1", real=True)
MOTOR = Motor("circuit", "motor", letter("R"), letter("L"), letter("K_T"), letter("K_E"))
FIXED = Drive(letter("N"), (Rotor("motor", letter("J_m"), fixed_to_joint=True),), (), MOTOR)


def effect(identifier: str, at: str, **values: str) -> EffectSpec:
    return EffectSpec(identifier, at, tuple((name, letter(value)) for name, value in values.items()))


def residuals(robot: Robot) -> tuple[sp.Expr, ...]:
    """Per coordinate: needed less supplied, zero along every motion."""
    equations = equations_of_motion(robot)
    return tuple(a - b for a, b in zip(required_efforts(equations), equations.actuation(), strict=True))


def extra(*effects: EffectSpec, drive: Drive = BELT) -> list[sp.Expr]:
    """What effects add to the needed efforts, per coordinate."""
    with_them, without = residuals(driven(drive, effects)), residuals(driven(drive))
    return [sp.expand(a - b) for a, b in zip(with_them, without, strict=True)]


# --- coordinates ----------------------------------------------------------------------------------------------------


def test_coordinates_run_along_the_chain_joint_by_joint() -> None:
    """Rotors as declared, then their joint; one that is fixed to its joint has none; rotors turn on a slide too."""
    first = Drive(ONE, tuple(Rotor(name, letter(name)) for name in ("tacho", "motor")), (), None)
    second = Drive(ONE, (Rotor("motor", letter("a")), Rotor("gear", letter("b"), fixed_to_joint=True)), (), None)
    robot = chain(
        ("base", first, JointKind.REVOLUTE), ("bare", None, JointKind.PRISMATIC), ("rail", second, JointKind.PRISMATIC)
    )
    axes = coordinates(robot)
    assert [axis.address for axis in axes] == ["base.tacho", "base.motor", "base", "bare", "rail.motor", "rail"]
    assert [axis.joint for axis in axes] == ["base", "base", "base", "bare", "rail", "rail"]
    assert [axis.unit for axis in axes] == ["rad", "rad", "rad", "m", "rad", "m"]
    assert [axis.effort_unit for axis in axes] == ["N m", "N m", "N m", "N", "N m", "N"]
    assert [str(axis.q) for axis in axes] == [f"q_{i}" for i in range(1, 7)]


def test_a_shaft_may_be_declared_from_either_end() -> None:
    (belt,) = BELT.shafts
    turned = Drive(BELT.ratio, BELT.rotors, (Shaft("belt", JOINT_END, "motor", belt.stiffness, belt.damping),), MOTOR)
    for forth, back in zip(residuals(driven(BELT)), residuals(driven(turned)), strict=True):
        assert same(forth, back)


# --- torque balance -------------------------------------------------------------------------------------------------

TORQUE = c * (N * q2 - q1) + d * (N * v2 - v1)  # of the shaft on the motor; -N times that on the joint


@pytest.mark.parametrize(("kind", "moved"), [(JointKind.REVOLUTE, I_zz), (JointKind.PRISMATIC, M)])
def test_two_inertias_and_a_compliant_shaft(kind: JointKind, moved: sp.Expr) -> None:
    at_motor, at_joint = residuals(driven(BELT, kind=kind))
    assert sp.simplify(at_motor - (J_m * a1 - K_T * z1 - TORQUE)) == 0
    assert sp.simplify(at_joint - (moved * a2 + N * TORQUE)) == 0


@pytest.mark.parametrize(("kind", "moved"), [(JointKind.REVOLUTE, I_zz), (JointKind.PRISMATIC, M)])
def test_an_effort_behind_a_compliant_shaft(kind: JointKind, moved: sp.Expr) -> None:
    """Spong's elastic joint: the torque acts on the rotor alone, which is a turning one on a slide, too."""
    robot = driven(replace(BELT, motor=None, effort_at="motor"), kind=kind)
    at_motor, at_joint = residuals(robot)
    assert sp.simplify(at_motor - (J_m * a1 - u1 - TORQUE)) == 0
    assert sp.simplify(at_joint - (moved * a2 + N * TORQUE)) == 0
    assert [(i.name, i.unit) for i in equations_of_motion(robot).inputs] == [("arm.motor.effort", "N m")]


def test_a_limit_of_the_joint_is_none_of_an_effort_at_its_rotor() -> None:
    limit = effect("effort_saturation", "arm", limit="S")
    with pytest.raises(InputError, match="no input is the effort of this joint"):
        equations_of_motion(driven(replace(BELT, motor=None, effort_at="motor"), (limit,)))


@pytest.mark.parametrize("kind", JointKind)
def test_a_rotor_that_is_fixed_to_its_joint(kind: JointKind) -> None:
    moved = I_zz if kind is JointKind.REVOLUTE else M
    (at_joint,) = residuals(driven(FIXED, kind=kind))
    assert sp.simplify(at_joint - ((moved + N**2 * J_m) * a1 - N * K_T * z1)) == 0


def test_a_shaft_that_does_not_twist_is_a_rigid_one() -> None:
    """On motor = N joint the shaft's torque is internal: virtual work leaves the equation of the rigid drive."""
    at_motor, at_joint = residuals(driven(BELT))
    rigid = {q1: N * q2, v1: N * v2, a1: N * a2}
    (expected,) = residuals(driven(FIXED))
    assert sp.simplify((N * at_motor + at_joint).subs(rigid) - expected.subs({q1: q2, v1: v2, a1: a2})) == 0


@pytest.mark.parametrize("count", [1, 2, 5])
def test_a_chain_of_any_number_of_inertias(count: int) -> None:
    """Each inertia is pulled by the shafts to its neighbours alone; the last one is the joint."""
    names = [*(f"r{i}" for i in range(1, count + 1)), JOINT_END]
    rotors = tuple(Rotor(name, letter(f"J_{i}")) for i, name in enumerate(names[:-1], start=1))
    shafts = tuple(
        Shaft(f"s{i}", names[i - 1], names[i], letter(f"c_{i}"), letter(f"d_{i}")) for i in range(1, count + 1)
    )
    found = residuals(driven(Drive(ONE, rotors, shafts, None)))
    n = count + 1
    q, v, a = (sp.symbols(f"{x}_1:{n + 1}", real=True) for x in ("q", "qd", "qdd"))
    inertias = [*(parameter(f"J_{i}") for i in range(1, n)), I_zz]
    assert len(found) == n
    for i in range(n):
        expected = inertias[i] * a[i] - (sp.Symbol("u_1", real=True) if i == n - 1 else 0)
        for shaft, other in ((i, i - 1), (i + 1, i + 1)):
            if 0 <= other < n:
                stiffness, damping = parameter(f"c_{shaft}"), parameter(f"d_{shaft}")
                expected -= stiffness * (q[other] - q[i]) + damping * (v[other] - v[i])
        assert sp.simplify(found[i] - expected) == 0


def test_shafts_may_branch() -> None:
    """Two rotors on one joint, each by its own shaft: the joint feels both, the rotors not each other."""
    rotors = (Rotor("left", letter("J_1")), Rotor("right", letter("J_2")))
    shafts = tuple(
        Shaft(f"of_{r.name}", r.name, JOINT_END, letter(f"c_{i}"), letter(f"d_{i}"))
        for i, r in enumerate(rotors, start=1)
    )
    left, right, joint = residuals(driven(Drive(letter("N"), rotors, shafts, None)))
    J_1, J_2, c_1, c_2, d_1, d_2 = map(parameter, ("J_1", "J_2", "c_1", "c_2", "d_1", "d_2"))
    pull_left = c_1 * (N * q3 - q1) + d_1 * (N * v3 - v1)
    pull_right = c_2 * (N * q3 - q2) + d_2 * (N * v3 - v2)
    assert sp.simplify(left - (J_1 * a1 - pull_left)) == 0
    assert sp.simplify(right - (J_2 * a2 - pull_right)) == 0
    assert sp.simplify(joint - (I_zz * a3 + N * (pull_left + pull_right) - u1)) == 0


# --- where an effect enters -----------------------------------------------------------------------------------------

F, k, preload = map(parameter, ("F", "k", "p"))
TWIST, SLIP = N * q2 - q1, N * v2 - v1
PLACES = {
    "arm.motor": (q1, v1, a1, 1, 0),
    "arm": (q2, v2, a2, 0, 1),
    f"arm.{JOINT_END}": (N * q2, N * v2, N * a2, 0, N),
    "arm.belt": (TWIST, SLIP, None, -1, N),
}


@pytest.mark.parametrize("address", PLACES)
def test_an_effect_acts_at_its_place_alone(address: str) -> None:
    """By virtual work: felt x, v, and a lever per coordinate; the joint's place on the motor side counts N joint."""
    x, v, a, *levers = PLACES[address]
    cases = [
        (effect("coulomb_friction", address, level="F"), F * sign_of(v)),
        (effect("viscous_friction", address, coefficient="F"), F * v),
        (effect("linear_spring", address, stiffness="k", preload="p"), k * x - preload),
        (effect("quadratic_drag", address, coefficient="F"), F * v * sp.Abs(v)),
    ]
    if a is not None:
        cases.append((effect("added_inertia", address, inertia="F"), F * a))
    for item, force in cases:
        for found, lever in zip(extra(item), levers, strict=True):
            assert sp.expand(found - lever * force) == 0


def test_friction_of_a_fixed_rotor_is_geared_in_force_and_in_speed() -> None:
    viscous = effect("viscous_friction", "arm.motor", coefficient="F")
    coulomb = effect("coulomb_friction", "arm.motor", level="F")
    assert same(extra(viscous, drive=FIXED)[0], N**2 * F * v1)
    assert same(extra(coulomb, drive=FIXED)[0], N * F * sign_of(N * v1))


def test_effects_at_one_place_add_up() -> None:
    friction = effect("viscous_friction", "arm.motor", coefficient="F")
    at_motor, at_joint = extra(friction, friction)
    assert same(at_motor, 2 * F * v1)
    assert at_joint == 0


def test_backlash_stands_between_all_that_a_shaft_transmits() -> None:
    """Declared last or first, it lets spring, damper and friction of its shaft act in contact only, no others."""
    friction = effect("viscous_friction", "arm.belt", coefficient="F")
    elsewhere = effect("viscous_friction", "arm", coefficient="k")
    slack = effect("backlash", "arm.belt", clearance="S")
    for order in ((friction, slack, elsewhere), (slack, elsewhere, friction)):
        at_motor, at_joint = residuals(driven(BELT, order))
        engaged = c * deadzone(TWIST, S) + (d + F) * SLIP * outside(TWIST, S)
        through = engaged * pushing(-sp.expand(engaged, deep=False), deadzone(TWIST, S), S)
        needed = J_m * a1 - K_T * z1, I_zz * a2 + k * v2
        for numbers in product((-2, 2), (-1, 1), (-3, 0, 3), (-4, 0.2, 4)):
            at = {c: 5, d: 0.3, F: 0.4, N: 2, S: 1.5, **dict(zip((q1, q2, v1, v2), numbers, strict=True))}
            force = through.subs(at)
            assert sp.expand((at_motor - needed[0]).subs(at) + force) == 0
            assert sp.expand((at_joint - needed[1]).subs(at) - 2 * force) == 0
            assert force == 0 or force * TWIST.subs(at) > 0  # it pushes the two apart


@pytest.mark.parametrize("twist", [-7, -5, -4, 0, 4, 5, 7])
def test_two_clearances_of_one_shaft_add_up(twist: int) -> None:
    both = driven(BELT, (effect("backlash", "arm.belt", clearance="S"), effect("backlash", "arm.belt", clearance="k")))
    at = {q1: -twist, q2: 0, S: 3, k: 2}
    force = c * deadzone(twist, 5) + d * SLIP * outside(twist, 5)
    expected = force * pushing(-force, deadzone(twist, 5), 5)
    assert sp.expand((residuals(both)[0] - J_m * a1 + K_T * z1).subs(at) + expected) == 0


# --- motors, inputs, sensors ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(("drive", "speed"), [(BELT, v1), (FIXED, N * v1)])
def test_the_circuit_of_a_motor_feels_its_own_rotor(drive: Drive, speed: sp.Expr) -> None:
    equations = equations_of_motion(driven(drive))
    (circuit,), (control,) = equations.states, equations.inputs
    assert same(circuit.storage, L)
    assert same(circuit.rate, u1 - R * z1 - K_E * speed)
    assert (circuit.name, circuit.unit) == ("arm.motor.current", "A")
    assert (control.name, control.unit, control.symbol) == ("arm.motor.voltage", "V", u1)
    assert set(control.force) == {0}  # a voltage exerts nothing by itself


def test_inputs_are_numbered_by_joint_and_currents_by_motor() -> None:
    robot = chain(
        ("free", None, JointKind.PRISMATIC), ("one", FIXED, JointKind.REVOLUTE), ("two", BELT, JointKind.REVOLUTE)
    )
    equations = equations_of_motion(robot)
    z2, u2, u3 = sp.symbols("z_2 u_2 u_3", real=True)
    assert [(i.name, i.unit) for i in equations.inputs] == [
        ("free.effort", "N"),
        ("one.motor.voltage", "V"),
        ("two.motor.voltage", "V"),
    ]
    axes = [axis.address for axis in equations.axes]
    assert axes == ["free", "one", "two.motor", "two"]
    assert all(same(a, b) for a, b in zip(equations.actuation(), (u1, N * K_T * z1, K_T * z2, 0), strict=True))
    assert same(equations.states[0].rate, u2 - R * z1 - K_E * N * v2)
    assert same(equations.states[1].rate, u3 - R * z2 - K_E * v3)


def test_without_a_motor_the_input_is_the_effort_of_the_joint() -> None:
    torque = equations_of_motion(driven(RIGID))
    assert [(i.name, i.unit, i.force) for i in torque.inputs] == [("arm.effort", "N m", (u1,))]
    force = equations_of_motion(driven(RIGID, kind=JointKind.PRISMATIC))
    assert [(i.name, i.unit, i.force) for i in force.inputs] == [("arm.effort", "N", (u1,))]


@pytest.mark.parametrize(("address", "speed"), [("arm.motor", v1), ("arm", v2), (f"arm.{JOINT_END}", N * v2)])
def test_a_tachometer_shows_the_speed_of_its_place_and_loads_nothing(address: str, speed: sp.Expr) -> None:
    tachometer = effect("tachometer", address, constant="k")
    (sensor,) = equations_of_motion(driven(BELT, (tachometer,))).sensors
    assert (sensor.name, sensor.unit) == (f"{address}.voltage", "V")
    assert same(sensor.value, k * speed)
    assert extra(tachometer) == [0, 0]


# --- energy ---------------------------------------------------------------------------------------------------------

# Everything at once. K_T and K_E differ, as they do in no motor: so each must be where it belongs.
MACHINE = """\
[robot]
name = "machine"
gravity = [0, -9.81, 0]
[dh]
convention = "modified"
rows = [["q", 0, 0, 0], ["q", 0, 0.5, 0]]
[[joint]]
name = "shoulder"
link = { mass = 2, com = [0.2, 0.1, 0], inertia = { zz = 0.3 } }
[joint.drive]
ratio = 2
rotors = [{ name = "motor", inertia = 0.05 }]
shafts = [{ name = "belt", from = "motor", to = "joint", stiffness = 7, damping = 0.6 }]
[joint.drive.motor]
name = "circuit"
at = "motor"
resistance = 1.5
inductance = 0.2
torque_constant = 0.9
back_emf_constant = 0.8
[[joint]]
name = "elbow"
link = { mass = 1, com = [0.3, 0, 0], inertia = { zz = 0.1 } }
actuator = { gain = "3 N m/V" }
[joint.drive]
ratio = -2.5
rotors = [{ name = "rotor", inertia = 0.02, fixed_to_joint = true }]
"""
EFFECTS = {
    "backlash": ("shoulder.belt", {"clearance": 2}),
    "coulomb_friction": ("shoulder.motor", {"level": 0.7}),
    "torque_ripple": ("shoulder.motor", {"cosine": 0.4, "sine": -0.3, "order": 6}),
    "viscous_friction": ("shoulder", {"coefficient": 1.1}),
    "linear_spring": ("shoulder", {"stiffness": 5, "preload": 1.3}),
    "quadratic_drag": ("elbow.rotor", {"coefficient": 0.2}),
    "stribeck_friction": ("elbow", {"excess": 0.9, "stribeck_velocity": 1.5}),
    "force_offset": ("elbow", {"offset": 0.25}),
    "added_inertia": ("elbow", {"inertia": 0.15}),
}


@cache
def machine() -> tuple[dict[str, Program], list[float]]:
    """The programs that the balance needs, and the values of the parameters."""
    blocks = [
        f'[[effect]]\ntype = "{name}"\nat = "{at}"\n' + "".join(f"{key} = {value}\n" for key, value in values.items())
        for name, (at, values) in EFFECTS.items()
    ]
    robot = robot_from_text(MACHINE + "".join(blocks), "machine.toml")
    programs = {f.name: f.program for f in functions(equations_of_motion(robot))}
    return programs, [float(p.value) for p in robot.parameters if p.value is not None]


def stored(x: list[mpf]) -> mpf:
    """Kinetic and potential energy, and that of the motor's inductance."""
    programs, values = machine()
    kinetic, potential = evaluate(programs["energy"], {"q": x[:3], "qd": x[3:6], "p": values}, dps=DIGITS)
    return kinetic + potential + mpf(0.2) * x[6] ** 2 / 2


def power(x: list[float], u: list[float]) -> float:
    """What the inputs put in less what effects take out, by hand; x = [q, qd, current], q of motor, shoulder, elbow."""
    motor, shoulder, _, at_motor, at_shoulder, at_elbow, current = x
    supplied = u[0] * current + 3 * u[1] * at_elbow
    heat = 1.5 * current**2 + 0.7 * abs(at_motor) + 1.1 * at_shoulder**2 + 0.2 * abs(-2.5 * at_elbow) ** 3
    heat += 0.9 * float(sp.exp(-((at_elbow / 1.5) ** 2))) * abs(at_elbow)
    twist, rate = 2 * shoulder - motor, 2 * at_shoulder - at_motor
    beyond = twist - math.copysign(2.0, twist)
    if abs(twist) > 2 and (7 * beyond + 0.6 * rate) * beyond > 0:  # flanks push and never pull
        heat += 0.6 * rate**2
    return supplied - heat - 0.25 * at_elbow + (0.9 - 0.8) * current * at_motor


NUMBER = st.floats(-3, 3).map(lambda value: round(value, 6))
IN_CONTACT = [-1.0, 0.7, 0.4, 1.2, -0.8, 0.9, 1.6]
FREE_PLAY = [1.0, 0.7, 0.4, 1.2, -0.8, -0.9, -1.6]
LETTING_GO = [1.5, -0.5, 0.0, -2.0, 2.0, 0.0, 0.0]


@settings(max_examples=25, deadline=None)
@given(st.lists(NUMBER, min_size=7, max_size=7), st.lists(NUMBER, min_size=2, max_size=2))
@example(IN_CONTACT, [2.0, -1.0])
@example(FREE_PLAY, [2.0, -1.0])
@example(LETTING_GO, [0.0, 0.0])
def test_stored_energy_grows_by_what_goes_in_less_what_is_lost(x: list[float], u: list[float]) -> None:
    """By a central difference along the motion, in forty digits."""
    programs, values = machine()
    rates = evaluate(programs["state_derivative"], {"x": x, "u": u, "p": values}, dps=DIGITS)
    with workdps(DIGITS):
        h = mpf(10) ** -16
        later, earlier = ([a + sign * h * rate for a, rate in zip(x, rates, strict=True)] for sign in (1, -1))
        change = (stored(later) - stored(earlier)) / (2 * h)
    assert close([float(change)], [power(x, u)], 1e-12)
