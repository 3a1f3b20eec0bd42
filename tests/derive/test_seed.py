"""The seed paper (van de Ven, 1986): what symdyn derives as printed, and each misprint that a derivation shows."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest
import sympy as sp

from symdyn.base.nonsmooth import deadzone, outside, pushing, sign_of
from symdyn.base.symbols import number, parameter
from symdyn.compiler import load_robot, robot_from_text
from symdyn.derive.bodies import body
from symdyn.derive.equations import EquationsOfMotion, equations_of_motion
from symdyn.derive.forces import totals
from symdyn.derive.joint_frames import joint_frames
from symdyn.derive.kinematics import base_transforms, frames, rotation_x
from symdyn.derive.lagrange import lagrange_coefficients
from symdyn.derive.linearize import without_nonsmooth

from .exact import required_efforts, same, substituted

PRINTED = (
    {"R": 1.6, "L": 87e-6, "K_T": 0.088, "K_E": 0.088, "K_Et": 0.029, "T_f": 0.025}
    | {"J_1": 34e-6, "J_2": 41e-6, "J_3": 196e-6, "J_4": 372e-6, "c_1": 789, "c_2": 1225, "c_3": 1.44}
    | {"d_1": 1200e-6, "d_2": 68000e-6, "d_3": 1600e-6, "d_4": 76e-6, "d_5": 12e-6, "d_6": 700e-6, "d_7": 0}
)
(R, L, K_T, K_E, K_Et, T_f, J1, J2, J3, J4, c1, c2, c3, d1, d2, d3, d4, d5, d6, d7) = map(parameter, PRINTED)
S, g, m, ell = map(parameter, ("S", "g", "m", "l"))
f1, f2, f3, f4 = sp.symbols("q_1:5", real=True)
f1d, f2d, f3d, f4d = sp.symbols("qd_1:5", real=True)
accelerations = sp.symbols("qdd_1:5", real=True)
current, voltage = sp.symbols("z_1 u_1", real=True)
theta, theta_d, theta_dd, phi_d = sp.symbols("theta thetad thetadd phid", real=True)


@cache
def drive(linear: bool = False) -> EquationsOfMotion:
    robot = load_robot("irb6-axis1")
    return equations_of_motion(without_nonsmooth(robot) if linear else robot)


def right_hand_sides(equations: EquationsOfMotion) -> tuple[sp.Expr, ...]:
    """Per coordinate of the drive, J_i phi_i'': the supplied effort less all that is not inertia."""
    sides = zip((J1, J2, J3, J4), accelerations, required_efforts(equations), equations.actuation(), strict=True)
    return tuple(sp.expand(J * qdd - effort + supplied) for J, qdd, effort, supplied in sides)


# --- the one-d.o.f. drive -------------------------------------------------------------------------------------------

T = K_T * current
EQUATION = {
    14: c1 * (f2 - f1) + d1 * (f2d - f1d) - d4 * f1d,
    15: T + c1 * (f1 - f2) + d1 * (f1d - f2d) - d5 * f2d + c2 * (f3 - f2) + d2 * (f3d - f2d),
    16: c2 * (f2 - f3) + d2 * (f2d - f3d) - d6 * f3d + c3 * (f4 - f3) + d3 * (f4d - f3d),
    17: c3 * (f3 - f4) + d3 * (f3d - f4d) - d7 * f4d,
}
ASSEMBLED_J2 = T - T_f * sign_of(f2d) + c1 * (f1 - f2) + d1 * (f1d - f2d) - d5 * f2d + c2 * (f3 - f2)  # as printed


def test_energies_and_rayleigh_function_of_equations_11_to_13() -> None:
    equations = drive(linear=True)
    kinetic, potential = substituted(equations.energy_steps, (equations.kinetic, equations.potential))
    *_, dissipated = totals(equations.attachments)
    assert same(kinetic, (J1 * f1d**2 + J2 * f2d**2 + J3 * f3d**2 + J4 * f4d**2) / 2)
    assert same(potential, (c1 * (f2 - f1) ** 2 + c2 * (f3 - f2) ** 2 + c3 * (f4 - f3) ** 2) / 2)
    twisting = d1 * (f2d - f1d) ** 2 + d2 * (f3d - f2d) ** 2 + d3 * (f4d - f3d) ** 2
    assert same(dissipated, (twisting + d4 * f1d**2 + d5 * f2d**2 + d6 * f3d**2 + d7 * f4d**2) / 2)


@pytest.mark.parametrize("which", EQUATION)
def test_equations_14_to_17(which: int) -> None:
    derived = right_hand_sides(drive(linear=True))[which - 14]
    assert sp.simplify(derived - EQUATION[which]) == 0


def test_the_assembled_model_loses_a_damper_on_one_side() -> None:
    derived = right_hand_sides(drive())
    assert sp.simplify(derived[1] - (EQUATION[15] - T_f * sign_of(f2d))) == 0
    assert sp.simplify(derived[1] - ASSEMBLED_J2 - d2 * (f3d - f2d)) == 0
    assert derived[2].has(d2)


def test_every_shaft_pulls_equally_on_both_its_ends() -> None:
    at_shafts = [c for c in drive().contributions if c.attachment.address.endswith(("shaft", "flexspline"))]
    assert len(at_shafts) == 6  # a spring and a damper each
    for contribution in at_shafts:
        assert sp.expand(sum(contribution.applied)) == 0
        assert sum(force != 0 for force in contribution.applied) == 2


@pytest.mark.parametrize(("lost", "mode_2", "mode_3"), [(0, 0.064, 0.105), (d2 * (f3d - f2d), 0.028, 0.018)])
def test_what_the_lost_damper_does_to_the_modes(lost: sp.Expr, mode_2: float, mode_3: float) -> None:
    """Damping ratios of the linear model by eigenvalues, with d_2 on both sides and as assembled in print."""
    (circuit,) = drive(linear=True).states
    forces = list(right_hand_sides(drive(linear=True)))
    forces[1] -= lost
    state = sp.Matrix([f1, f2, f3, f4, f1d, f2d, f3d, f4d, current])
    forced = [force / J for force, J in zip(forces, (J1, J2, J3, J4), strict=True)]
    rates = sp.Matrix([f1d, f2d, f3d, f4d, *forced, circuit.rate / circuit.storage])
    numbers = {parameter(name): value for name, value in PRINTED.items()}
    poles = np.linalg.eigvals(np.array(rates.jacobian(state).subs(numbers), dtype=float))
    pairs = sorted((abs(p) / (2 * math.pi), -p.real / abs(p)) for p in poles if p.imag > 1e-6)
    assert [damping for _, damping in pairs[1:]] == pytest.approx([mode_2, mode_3], abs=6e-4)
    if lost == 0:
        assert [frequency for frequency, _ in pairs] == pytest.approx([15.17, 623.6, 1261.1], rel=5e-4)


def test_motor_circuit_and_tachometer() -> None:
    equations = drive()
    (circuit,), (sensor,) = equations.states, equations.sensors
    assert same(circuit.storage, L)
    assert same(circuit.rate, voltage - R * current - K_E * f2d)
    assert same(sensor.value, K_Et * f1d)
    assert (circuit.unit, sensor.unit, [i.unit for i in equations.inputs]) == ("A", "V", ["V"])
    assert 2 * len(equations.axes) + len(equations.states) == 9  # "a model of the 9th order"


def test_the_parameters_are_those_that_are_printed() -> None:
    """22 are announced; 21 have a name; all but S have a number."""
    values = {p.name: p.value for p in load_robot("irb6-axis1").parameters}
    assert len(values) == 21
    assert values == {**PRINTED, "S": 0.0}


# --- backlash -------------------------------------------------------------------------------------------------------

TWIST = f4 - f3
CONTACT = c3 * (TWIST - S * sp.sign(TWIST)) + d3 * (f4d - f3d)  # eq. 19: what the flexspline does to J_3
FREE = {J3: c2 * (f2 - f3) + d2 * (f2d - f3d) - d6 * f3d, J4: -d7 * f4d}


def transmitted(twist: sp.Rational, clearance: sp.Expr) -> tuple[sp.Expr, sp.Expr]:
    """What J_3 and J_4 get through the flexspline at a twist: derived, less the terms that do not pass through it."""
    _, _, third, fourth = right_hand_sides(drive())
    at = {f3: sp.Rational(1, 7), f4: sp.Rational(1, 7) + twist, S: clearance}
    return tuple(sp.expand((side - FREE[J]).subs(at)) for side, J in ((third, J3), (fourth, J4)))


def law(where: sp.Basic, twist: sp.Rational, clearance: sp.Expr) -> sp.Expr:
    """Eq. 18 and 19 at a twist, with a condition for contact."""
    at = {f3: sp.Rational(1, 7), f4: sp.Rational(1, 7) + twist, S: clearance}
    return sp.expand(CONTACT.subs(at)) if bool(where.subs(at)) else sp.Integer(0)


def pressed(force: sp.Expr) -> sp.Expr:
    """While the flanks push, which the paper does not ask."""
    return force.replace(pushing, lambda *_: sp.Integer(1))


CLEARANCE = sp.Rational(1, 100)


@pytest.mark.parametrize("twist", [-30, -11, -10, -9, 0, 9, 10, 11, 30])
def test_contact_is_where_the_size_of_the_twist_exceeds_the_clearance(twist: int) -> None:
    on_j3, on_j4 = (pressed(force) for force in transmitted(sp.Rational(twist, 1000), CLEARANCE))
    assert sp.simplify(on_j3 + on_j4) == 0
    assert sp.simplify(on_j3 - law(sp.Abs(TWIST) > S, sp.Rational(twist, 1000), CLEARANCE)) == 0
    assert (on_j3 == 0) is (abs(twist) <= 10)
    as_printed = law(TWIST > S, sp.Rational(twist, 1000), CLEARANCE)
    assert (sp.simplify(on_j3 - as_printed) == 0) is (twist >= -10)  # the print closes the gap on one side only


def test_spring_and_damper_both_wait_for_contact() -> None:
    on_j3 = sp.expand(pressed(right_hand_sides(drive())[2] - FREE[J3]))
    assert on_j3.has(c3, d3)
    assert same(on_j3, c3 * deadzone(TWIST, S) + d3 * (f4d - f3d) * outside(TWIST, S))


@pytest.mark.parametrize("twist", [-30, 30])
def test_flanks_push_but_never_pull(twist: int) -> None:
    """Moving apart quickly, the damper alone would pull: the contact opens, although the spring is still deflected."""
    on_j3, _ = transmitted(sp.Rational(twist, 1000), CLEARANCE)
    numbers = {c3: 2, d3: 3, f3d: 0}
    for speed in (-10, -sp.Rational(1, 1000), sp.Rational(1, 1000), 10):
        force = on_j3.subs({**numbers, f4d: speed})
        if speed * twist < -1:
            assert force == 0
        else:
            assert force == pressed(on_j3).subs({**numbers, f4d: speed})
            assert force * twist > 0


def test_without_clearance_the_assembled_model_is_equations_16_and_17() -> None:
    closed = [side.subs(S, 0) for side in right_hand_sides(drive())[2:]]
    assert [sp.simplify(side - EQUATION[k]) for side, k in zip(closed, (16, 17), strict=True)] == [0, 0]


# --- the two-d.o.f. arm ---------------------------------------------------------------------------------------------

AS_COUNTED_IN_THE_PAPER = {f2: sp.pi / 2 - theta, f2d: -theta_d, f1d: phi_d}
CENTRIPETAL = m * phi_d**2 * ell**2 * sp.sin(2 * theta) / 8  # eq. 20
CORIOLIS = m * ell**2 * phi_d * theta_d * sp.sin(2 * theta) / 4
CORIOLIS_AS_PRINTED = m * phi_d * theta_d * sp.sin(2 * theta) / 8  # eq. 21
GRAVITY = m * g * ell * sp.sin(theta) / 2  # eq. 22


def arm_torques(name: str) -> tuple[sp.Expr, sp.Expr, sp.Expr, sp.Expr]:
    """(inertia about the column, centripetal on the arm, Coriolis on the column, gravity on the arm), theta upright."""
    derived = lagrange_coefficients(load_robot(name))
    centripetal = derived.C[1][0, 0] * f1d**2
    coriolis = (derived.C[0][0, 1] + derived.C[0][1, 0]) * f1d * f2d
    terms = (derived.B[0, 0], centripetal, coriolis, derived.D[1])
    inertia, centripetal, coriolis, gravity = (term.subs(AS_COUNTED_IN_THE_PAPER) for term in terms)
    return inertia, centripetal, coriolis, gravity


def test_equations_20_and_22_come_out_as_printed() -> None:
    inertia, centripetal, _, gravity = arm_torques("irb6-arm")
    assert sp.simplify(inertia - m * (ell / 2) ** 2 * sp.sin(theta) ** 2) == 0
    assert sp.simplify(centripetal - CENTRIPETAL) == 0
    assert sp.simplify(gravity - GRAVITY) == 0


def test_equation_21_lacks_a_factor_and_a_length() -> None:
    _, _, coriolis, _ = arm_torques("irb6-arm")
    assert sp.simplify(coriolis - CORIOLIS) == 0
    assert sp.simplify(coriolis / CORIOLIS_AS_PRINTED) == 2 * ell**2
    assert sp.simplify((coriolis - CORIOLIS_AS_PRINTED).subs(ell, 1)) != 0  # its number is wrong too


def test_only_the_derived_coriolis_torque_keeps_the_angular_momentum() -> None:
    """d/dt (I phi') = 0 with no torque on the column: I phi'' = - T_cor."""
    inertia, _, coriolis, _ = arm_torques("irb6-arm")

    def change(torque: sp.Expr) -> sp.Expr:
        return sp.simplify(sp.diff(inertia, theta) * theta_d * phi_d + inertia * (-torque / inertia))

    assert change(coriolis) == 0
    assert change(CORIOLIS_AS_PRINTED) != 0
    assert change(CORIOLIS_AS_PRINTED * ell**2) != 0


def test_there_is_no_coriolis_torque_on_the_second_axis() -> None:
    """The paper calls it "much smaller"; neither does an axis feel its own speed."""
    derived = lagrange_coefficients(load_robot("irb6-arm"))
    assert [sp.simplify(derived.C[1][j, k]) for j, k in ((0, 1), (1, 0), (1, 1))] == [0, 0, 0]
    assert [sp.simplify(derived.C[0][k, k]) for k in (0, 1)] == [0, 0]
    assert sp.simplify(derived.B[0, 1]) == 0
    assert sp.simplify(derived.D[0]) == 0


def test_a_rod_has_larger_torques_than_the_point_mass() -> None:
    inertia, centripetal, coriolis, gravity = arm_torques("irb6-arm-rod")
    assert sp.simplify(inertia - m * ell**2 * sp.sin(theta) ** 2 / 3) == 0
    assert sp.simplify(centripetal - sp.Rational(4, 3) * CENTRIPETAL) == 0
    assert sp.simplify(coriolis - sp.Rational(4, 3) * CORIOLIS) == 0
    assert sp.simplify(gravity - GRAVITY) == 0


def axis_drive(axis: int) -> str:
    rotor = f'{{ name = "harmonic_drive", inertia = "J_{axis}3" }}'
    shaft = f'from = "harmonic_drive", to = "joint", stiffness = "c_{axis}3", damping = "d_{axis}3"'
    return f'[joint.drive]\nratio = 1\nrotors = [{rotor}]\nshafts = [{{ name = "flexspline", {shaft} }}]\n'


UNITS = {"J_": "kg m^2", "c_": "N m/rad", "d_": "N m s/rad"}
LETTERS = [*(f"{x}{axis}3" for x in UNITS for axis in (1, 2)), "d_17", "d_27", "J_c"]
DRIVEN_ARM = f"""\
[robot]
name = "driven-arm"
gravity = [0, 0, "-g"]
[parameters]
g = {{ free = "m/s^2" }}
m = {{ free = "kg" }}
l = {{ free = "m" }}
{"".join(f'{x} = {{ free = "{UNITS[x[:2]]}" }}{chr(10)}' for x in LETTERS)}
[dh]
rows = [["q", 0, 0, "90 deg"], ["q", 0, "l", 0]]
[[joint]]
name = "column"
link = {{ inertia = {{ about = "joint", yy = "J_c" }} }}
{axis_drive(1)}
[[joint]]
name = "arm"
link = {{ mass = "m", com = ["-1/2 l", 0, 0] }}
{axis_drive(2)}
[[effect]]
type = "viscous_friction"
at = "column"
coefficient = "d_17"
[[effect]]
type = "viscous_friction"
at = "arm"
coefficient = "d_27"
"""


def test_the_last_pair_of_equations_carries_the_error_on() -> None:
    """Eq. 17 for each axis, enlarged by eq. 20 to 22; symdyn's q_4 is 90 degrees less theta, and so is q_3."""
    third, column, fourth, arm = required_efforts(equations_of_motion(robot_from_text(DRIVEN_ARM, "driven-arm.toml")))
    theta3, theta3d, phi3, phi4, phi3d, phi_dd = sp.symbols("theta3 theta3d phi3 phi4 phi3d phidd", real=True)
    names = {f1: phi3, f2: phi4, f1d: phi3d, f2d: phi_d, f3: sp.pi / 2 - theta3, f4: sp.pi / 2 - theta}
    names |= {f3d: -theta3d, f4d: -theta_d, accelerations[1]: phi_dd, accelerations[3]: -theta_dd}
    c13, d13, d17, c23, d23, d27, J_c = map(parameter, ("c_13", "d_13", "d_17", "c_23", "d_23", "d_27", "J_c"))
    J14, J24 = J_c + m * ell**2 / 4 * sp.sin(theta) ** 2, m * ell**2 / 4
    through_column = c13 * (phi3 - phi4) + d13 * (phi3d - phi_d) - d17 * phi_d
    through_arm = c23 * (theta3 - theta) + d23 * (theta3d - theta_d) - d27 * theta_d
    assert sp.simplify(column.subs(names) - (J14 * phi_dd - through_column + CORIOLIS)) == 0
    assert sp.simplify(column.subs(names) - (J14 * phi_dd - through_column + CORIOLIS_AS_PRINTED)) != 0
    assert sp.simplify(-arm.subs(names) - (J24 * theta_dd - through_arm - GRAVITY - CENTRIPETAL)) == 0
    assert not third.has(sp.sin, sp.cos)
    assert not fourth.has(sp.sin, sp.cos)


# --- section 2 ------------------------------------------------------------------------------------------------------

ONE_FRAME = """\
[robot]
name = "frame"
gravity = [0, 0, 0]
[parameters]
d = { free = "m" }
a = { free = "m" }
alpha = { free = "rad" }
[dh]
rows = [["q", "d", "a", "alpha"]]
[[joint]]
name = "j"
link = { mass = 1 }
"""


def test_entry_1_3_of_the_dh_matrix() -> None:
    d, a, alpha = (parameter(name) for name in ("d", "a", "alpha"))
    (derived,) = base_transforms(robot_from_text(ONE_FRAME, "frame.toml"))
    c, s, ca, sa = sp.cos(f1), sp.sin(f1), sp.cos(alpha), sp.sin(alpha)
    right = sp.Matrix([[c, -s * ca, s * sa, a * c], [s, c * ca, -c * sa, a * s], [0, sa, ca, d], [0, 0, 0, 1]])
    printed = right.copy()
    printed[0, 2] = s * ca
    assert (derived - right).applyfunc(sp.simplify).is_zero_matrix
    for matrix, is_rotation in ((derived, True), (printed, False)):
        product = (matrix[:3, :3].T * matrix[:3, :3] - sp.eye(3)).applyfunc(sp.simplify)
        assert (product == sp.zeros(3)) is is_rotation


def test_the_generalised_inertia_tensor_of_a_rod() -> None:
    """J_i of eq. 6: the integral of p p^T dm from x = -l to 0, in homogeneous coordinates whose last is 1, not 0."""
    x = sp.Symbol("x")
    point = sp.Matrix([x, 0, 0, 1])
    integral = (point * point.T).applyfunc(lambda e: sp.integrate(m / ell * e, (x, -ell, 0)))
    derived = body(load_robot("irb6-arm-rod").joints[1].link).pseudo_inertia
    assert (derived - integral).applyfunc(sp.simplify).is_zero_matrix


def test_a_resting_arm_feels_gravity_as_an_acceleration_of_its_base() -> None:
    """The paper prints g as a velocity of the base: a constant one would leave no torque at rest."""
    at_rest = {**dict.fromkeys((*accelerations, f1d, f2d), number(0)), f2: sp.pi / 2 - theta}
    column, arm = (effort.subs(at_rest) for effort in required_efforts(equations_of_motion(load_robot("irb6-arm"))))
    assert sp.simplify(column) == 0
    assert sp.simplify(arm - GRAVITY) == 0


def test_moment_and_axis_are_taken_in_one_frame() -> None:
    """The column's axis is y of its own frame, twisted by 90 degrees: the printed n_1 . z_0 mixes two frames."""
    frame, _ = frames(load_robot("irb6-arm"))
    z = sp.Matrix([0, 0, 1])
    assert frame.axis == frame.rotation.T * z == sp.Matrix([0, 1, 0])
    # symdyn's recursion stands on the joint axes: there z is the axis, and the moment along it is the effort.
    assert [f.axis for f in joint_frames(load_robot("irb6-arm"))] == [z, rotation_x(sp.pi / 2)[:, 2]]
