"""Effects that change what others feel: gears, loads, circuits, amplifiers, delays, bodies, sensors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from functools import cache

import control
import numpy as np
import pytest
import sympy as sp
from scipy import signal

from symdyn.base.errors import InputError
from symdyn.base.nonsmooth import clip, deadzone, pushing, quantise, sign_of
from symdyn.base.symbols import parameter
from symdyn.compiler import robot_from_text
from symdyn.derive.coordinates import coordinates
from symdyn.derive.equations import EquationsOfMotion, equations_of_motion
from symdyn.derive.lagrange import lagrange_coefficients, textbook_coefficients
from symdyn.program.evaluate import evaluate
from symdyn.program.functions import functions
from symdyn.program.ssa import Program
from symdyn.spec.records import ONE, ZERO, Actuator, Drive, EffectSpec, JointKind, Monomial, Motor, Robot

from .drives import BELT, RIGID, driven, letter
from .exact import required_efforts, same

N, J_m, c, d, K_T, K_E, R, L = map(parameter, ("N", "J_m", "c", "d", "K_T", "K_E", "R", "L"))
q1, q2, v1, v2, a1, a2, u1, z1, z2 = sp.symbols("q_1 q_2 qd_1 qd_2 qdd_1 qdd_2 u_1 z_1 z_2", real=True)
TWIST, SLIP = N * q2 - q1, N * v2 - v1
NO_COIL = Drive(
    BELT.ratio,
    BELT.rotors,
    BELT.shafts,
    Motor("circuit", "motor", letter("R"), ZERO, letter("K_T"), letter("K_E")),
)


def effect(identifier: str, at: str, **values: str | int) -> EffectSpec:
    numbers = {name: letter(v) if isinstance(v, str) else Monomial(Fraction(v)) for name, v in values.items()}
    return EffectSpec(identifier, at, tuple(numbers.items()))


def derived(*effects: EffectSpec, drive: Drive = BELT) -> EquationsOfMotion:
    return equations_of_motion(driven(drive, effects))


def residuals(equations: EquationsOfMotion) -> list[sp.Expr]:
    """Per coordinate: needed less supplied, zero along every motion."""
    return [a - b for a, b in zip(required_efforts(equations), equations.actuation(), strict=True)]


def extra(*effects: EffectSpec) -> list[sp.Expr]:
    return [sp.expand(a - b) for a, b in zip(residuals(derived(*effects)), residuals(derived()), strict=True)]


# --- gears and their loads ------------------------------------------------------------------------------------------


def pressed(law: sp.Expr) -> sp.Expr:
    """While the flanks of a clearance push."""
    return law.replace(pushing, lambda *_: sp.Integer(1))


def test_a_kinematic_error_is_felt_as_twist_and_gears_the_torque() -> None:
    """The spring feels twist less e(start); the start bears its torque times 1 + e', by virtual work."""
    wave = effect("kinematic_error", "arm.belt", cosine="A", sine="B", order="n")
    A, B, n = map(parameter, ("A", "B", "n"))
    e = A * sp.cos(n * q1) + B * sp.sin(n * q1)
    slope = sp.diff(e, q1)
    torque = c * (TWIST - e) + d * (SLIP - slope * v1)
    at_motor, at_joint = extra(wave)
    assert same(at_motor, -(1 + slope) * torque + c * TWIST + d * SLIP)
    assert same(at_joint, N * (torque - c * TWIST - d * SLIP))


def test_play_comes_behind_a_kinematic_error_however_they_are_declared() -> None:
    """In the gap nothing is transmitted, the wave neither."""
    wave = effect("kinematic_error", "arm.belt", cosine="A", sine="B", order="n")
    slack = effect("backlash", "arm.belt", clearance="S")
    e = parameter("A") * sp.cos(parameter("n") * q1) + parameter("B") * sp.sin(parameter("n") * q1)
    through = c * deadzone(TWIST - e, parameter("S"))
    for order in ((wave, slack), (slack, wave)):
        _, at_joint = (pressed(law.subs({v1: 0, v2: 0})) for law in residuals(derived(*order)))
        assert same(at_joint - a2 * parameter("I"), N * through)


def test_load_dependent_friction_acts_on_the_start_alone() -> None:
    """With all springs of the shaft, what backlash lets through of them, and the speed of the start."""
    mu, c_3, S = map(parameter, ("mu", "c_3", "S"))
    friction = effect("load_dependent_friction", "arm.belt", coefficient="mu")
    cubic = effect("hardening_spring", "arm.belt", stiffness="c_3")
    slack = effect("backlash", "arm.belt", clearance="S")
    at_motor, at_joint = extra(friction)
    assert (same(at_motor, mu * sp.Abs(c * TWIST) * sign_of(v1)), at_joint) == (True, 0)
    both = [a - b for a, b in zip(residuals(derived(friction, cubic)), residuals(derived(cubic)), strict=True)]
    assert same(both[0], mu * sp.Abs(c * TWIST + c_3 * TWIST**3) * sign_of(v1))
    both = [a - b for a, b in zip(residuals(derived(friction, slack)), residuals(derived(slack)), strict=True)]
    assert same(pressed(both[0]), mu * sp.Abs(c * deadzone(TWIST, S)) * sign_of(v1))


def test_a_hardening_shaft() -> None:
    at_motor, at_joint = extra(effect("hardening_spring", "arm.belt", stiffness="k"))
    assert same(at_motor, -parameter("k") * TWIST**3)
    assert same(at_joint, N * parameter("k") * TWIST**3)


def test_hysteresis_of_a_shaft_acts_on_both_ends() -> None:
    loop = effect("bouc_wen_hysteresis", "arm.belt", level="F", yield_displacement="D", shape="s", exponent=2)
    equations = derived(loop)
    force = parameter("F") * z2
    at_motor, at_joint = (a - b for a, b in zip(residuals(equations), residuals(derived()), strict=True))
    assert (same(at_motor, -force), same(at_joint, N * force)) == (True, True)
    state = equations.states[1]
    assert (state.name, state.unit) == ("arm.belt.hysteresis", "1")
    shape = parameter("s")
    assert same(state.rate, SLIP - shape * sp.Abs(SLIP) * sp.Abs(z2) * z2 + (shape - 1) * SLIP * z2**2)


@pytest.mark.parametrize(("kind", "unit"), [(JointKind.REVOLUTE, "rad"), (JointKind.PRISMATIC, "m")])
def test_units_of_states_follow_the_joint(kind: JointKind, unit: str) -> None:
    values = {name: letter(name) for name in ("stiffness", "level")}
    friction = EffectSpec("dahl_friction", "arm", tuple(values.items()))
    (state,) = equations_of_motion(driven(Drive(ONE, (), (), None), (friction,), kind)).states
    assert state.unit == unit


# --- springs and bodies -------------------------------------------------------------------------------------------


def test_a_counterbalance_without_free_length_is_a_sine() -> None:
    spring = effect("counterbalance_spring", "arm", stiffness="k", anchor="a", arm="r", free_length=0, dead_centre="f")
    k, a, r, f = map(parameter, ("k", "a", "r", "f"))
    assert same(sp.trigsimp(extra(spring)[1]), k * a * r * sp.sin(q2 - f))


def test_a_torsion_spring_rests_where_it_says() -> None:
    at_motor, at_joint = extra(effect("torsion_spring", "arm.motor", stiffness="k", rest_position="x"))
    assert (same(at_motor, parameter("k") * (q1 - parameter("x"))), at_joint) == (True, 0)


PENDULUM = """\
[robot]
name = "pendulum"
gravity = [0, -9.81, 0]
[dh]
rows = [["q", 0, 0, 0], ["q", 0.1, 0.3, "90 deg"]]
[[joint]]
name = "first"
link = { mass = 1, com = [0.1, 0, 0], inertia = { zz = 0.2 } }
[[joint]]
name = "second"
link = { mass = 0.7, inertia = { xx = 0.1, yy = 0.2, zz = 0.2 } }
"""


@cache
def programs(robot: Robot) -> dict[str, Program]:
    return {f.name: f.program for f in functions(equations_of_motion(robot))}


def numbers(robot: Robot, name: str, **arguments: Sequence[float]) -> np.ndarray:
    """A function of the kernel by the reference evaluator."""
    program = programs(robot)[name]
    p = [value for value in (p.value for p in robot.parameters) if value is not None]
    found = evaluate(program, {**arguments, "p": p})
    return np.array(found, dtype=float).reshape(program.shape)


def test_a_payload_is_a_point_mass_of_the_tool() -> None:
    """In both formulations, the mass matrix, the energy, and the centre of mass."""
    payload = '[[effect]]\ntype = "payload"\nat = "second"\nmass = 0.6\ncom_x = 0.2\ncom_z = -0.1\n'
    tool = "[tool]\nmass = 0.6\ncom = [0.2, 0, -0.1]\n"
    one, other, bare = (robot_from_text(PENDULUM + block, "pendulum") for block in (payload, tool, ""))
    q, qd, qdd = [0.3, -0.8], [1.1, 0.4], [-0.2, 2.0]
    for name, arguments in (
        ("inverse_dynamics", {"q": q, "qd": qd, "qdd": qdd}),
        ("mass_matrix", {"q": q}),
        ("energy", {"q": q, "qd": qd}),
        ("center_of_mass", {"q": q}),
    ):
        first, second, without = (numbers(robot, name, **arguments) for robot in (one, other, bare))
        np.testing.assert_allclose(first, second, rtol=1e-13, atol=1e-13)
        assert np.abs(first - without).max() > 0.01
    known = {parameter(p.name): p.value for p in one.parameters}
    moving = zip(coordinates(one), zip(q, qd, qdd, strict=True), strict=True)
    state = {s: x for axis, at in moving for s, x in zip((axis.q, axis.qd, axis.qdd), at, strict=True)}
    by_lagrange = [float(effort.subs(known | state)) for effort in lagrange_coefficients(one).efforts()]
    np.testing.assert_allclose(numbers(one, "inverse_dynamics", q=q, qd=qd, qdd=qdd), by_lagrange, rtol=1e-12)


def test_a_link_may_be_nothing_but_its_payload() -> None:
    bare = PENDULUM.replace("link = { mass = 0.7, inertia = { xx = 0.1, yy = 0.2, zz = 0.2 } }", "")
    payload = '[[effect]]\ntype = "payload"\nat = "second"\nmass = 0.6\ncom_x = 0.2\n'
    assert robot_from_text(bare + payload, "pendulum").joints
    with pytest.raises(InputError, match="nothing there has inertia"):
        robot_from_text(bare, "pendulum")


def test_an_unbalance_is_a_payload_of_a_joint_that_gravity_crosses() -> None:
    payload = '[[effect]]\ntype = "payload"\nat = "first"\nmass = 0.6\ncom_x = 0.2\n'
    unbalance = '[[effect]]\ntype = "unbalance"\nat = "first"\nmass = 0.6\neccentricity = 0.2\nphase = "-90 deg"\n'
    one, other = (
        numbers(
            robot_from_text(PENDULUM + block, "pendulum"),
            "inverse_dynamics",
            q=[0.3, -0.8],
            qd=[1.1, 0.4],
            qdd=[0.7, 2],
        )
        for block in (payload, unbalance)
    )
    np.testing.assert_allclose(one, other, rtol=1e-13)


def test_the_printed_coefficients_know_a_payload() -> None:
    payload = '[[effect]]\ntype = "payload"\nat = "first"\nmass = 0.6\ncom_x = 0.2\n'
    shown = textbook_coefficients(robot_from_text(PENDULUM + payload, "pendulum")).D[0]
    assert parameter("first_payload_mass") in shown.free_symbols


# --- circuits -----------------------------------------------------------------------------------------------------


def test_a_circuit_without_inductance_has_no_state() -> None:
    """Exactly: the current follows voltage and speed at once."""
    equations = derived(drive=NO_COIL)
    assert equations.states == ()
    at_motor, _ = equations.actuation()
    assert same(at_motor, K_T * (u1 - K_E * v1) / R)
    assert (equations.inputs[0].name, equations.inputs[0].unit) == ("arm.motor.voltage", "V")


def test_it_is_the_limit_of_small_inductances() -> None:
    full, short = residuals(derived()), residuals(derived(drive=NO_COIL))
    (circuit,) = derived().states
    (settled,) = sp.solve(circuit.rate, z1)
    for one, other in zip(full, short, strict=True):
        assert same(one.subs(z1, settled), other)


@pytest.mark.parametrize("drive", [BELT, NO_COIL])
def test_an_ammeter_shows_the_current(drive: Drive) -> None:
    (shown,) = derived(effect("ammeter", "arm.circuit", gain="G", offset="O"), drive=drive).sensors
    current = z1 if drive is BELT else (u1 - K_E * v1) / R
    assert (shown.name, shown.unit) == ("arm.circuit.ammeter", "A")
    assert same(shown.value, parameter("G") * current + parameter("O"))


def test_stages_of_an_amplifier_act_in_the_order_of_declaration() -> None:
    gain = effect("amplifier_gain", "arm.circuit", gain="G")
    limit = effect("amplifier_saturation", "arm.circuit", limit="U")
    offset = effect("amplifier_offset", "arm.circuit", offset="O")
    dead = effect("amplifier_dead_zone", "arm.circuit", half_width="W")
    G, U, U_0, W = map(parameter, ("G", "U", "O", "W"))
    for stages, volts in (
        ((gain, limit), clip(G * u1, -U, U)),
        ((limit, gain), G * clip(u1, -U, U)),
        ((offset, dead, limit), clip(deadzone(u1 + U_0, W), -U, U)),
    ):
        (circuit,) = derived(*stages).states
        assert same(circuit.rate, volts - R * z1 - K_E * v1)
        assert same(derived(*stages, drive=NO_COIL).actuation()[0], K_T * (volts - K_E * v1) / R)


def test_an_effort_is_limited_behind_the_gain_of_its_actuator() -> None:
    limit = effect("effort_saturation", "arm", limit="T")
    (plain,) = derived(limit, drive=RIGID).inputs
    T, G = parameter("T"), parameter("G")
    assert plain.force == (clip(u1, -T, T),)
    robot = driven(RIGID, (limit,))
    joint = replace(robot.joints[0], actuator=Actuator(letter("G"), "V"))
    (geared,) = equations_of_motion(replace(robot, joints=(joint,))).inputs
    assert (geared.force, geared.unit) == ((clip(G * u1, -T, T),), "V")


def test_an_effort_that_no_input_gives_cannot_be_limited() -> None:
    limit = effect("effort_saturation", "arm", limit="T")
    with pytest.raises(InputError, match="no input is the effort of this joint") as caught:
        derived(limit)
    assert [problem.code for problem in caught.value.problems] == ["SD109"]
    robot = driven(RIGID, (limit,))
    with pytest.raises(InputError, match="no input is the effort"):
        equations_of_motion(replace(robot, joints=(replace(robot.joints[0], passive=True),)))


ROTOR = """\
[robot]
name = "rotor"
gravity = [0, 0, 0]
[dh]
rows = [["q", 0, 0, 0]]
[[joint]]
name = "axis"
link = { inertia = { zz = 1 } }
[joint.drive]
rotors = [{ name = "motor", inertia = 1, fixed_to_joint = true }]
motor = { name = "circuit", at = "motor", resistance = 1, torque_constant = 1, back_emf_constant = 1 }
"""


def linear(robot: Robot) -> control.StateSpace:
    """From the voltage to the speed, at rest."""
    count = len(equations_of_motion(robot).states) + 2
    at = {"x": [0.0] * count, "u": [0.0]}
    a, b = (numbers(robot, f"state_derivative_{of}_jacobian", **at) for of in ("state", "input"))
    return control.ss(a, b, np.eye(count)[1:2], 0)


@pytest.mark.parametrize("order", [1, 2, 4])
def test_a_delay_is_the_pade_approximant_of_its_order(order: int) -> None:
    """Against the quotient whose Taylor series is that of exp(-s T), up to the power that its coefficients can fix."""
    delay = f'[[effect]]\ntype = "input_delay"\nat = "axis.circuit"\ndelay = 0.3\norder = {order}\n'
    system, plain = (linear(robot_from_text(ROTOR + block, "rotor")) for block in (delay, ""))
    assert system.nstates == plain.nstates + order
    s = 1j * np.array([0.01, 0.3, 1.0, 3.0, 10.0])
    ratio = system(s) / plain(s)
    taylor = [(-0.3) ** k / sp.factorial(k) for k in range(2 * order)]
    below, above = _pade([float(t) for t in taylor], order)
    np.testing.assert_allclose(ratio, np.polyval(above, s) / np.polyval(below, s), rtol=1e-9)
    assert abs(ratio[0] - np.exp(-0.3 * s[0])) < 1e-5


def _pade(taylor: list[float], n: int) -> tuple[np.ndarray, np.ndarray]:
    """(below, above), highest power first, degrees n and n - 1, by solving for the coefficients."""
    rows = [[taylor[k - j] if k >= j else 0.0 for j in range(1, n + 1)] for k in range(n, 2 * n)]
    below = np.array([1.0, *np.linalg.solve(np.array(rows), -np.array(taylor[n : 2 * n]))])
    above = [sum(below[j] * taylor[k - j] for j in range(k + 1)) for k in range(n)]
    return below[::-1], np.array(above)[::-1]


def test_nothing_of_a_step_comes_through_a_delay_at_once() -> None:
    delay = '[[effect]]\ntype = "input_delay"\nat = "axis.circuit"\ndelay = 0.3\norder = 5\n'
    time = np.linspace(0, 3, 600)
    _, shown = control.step_response(linear(robot_from_text(ROTOR + delay, "rotor")), time)
    _, exact, _ = signal.lsim(([0.5], [1, 0.5]), np.where(time >= 0.3, 1.0, 0.0), time)
    assert np.abs(shown[time < 0.15]).max() < 0.004
    assert np.abs(shown - exact).max() < 0.008


def test_without_delay_there_is_no_state() -> None:
    delay = '[[effect]]\ntype = "input_delay"\nat = "axis.circuit"\ndelay = 0\n'
    assert equations_of_motion(robot_from_text(ROTOR + delay, "rotor")).states == ()


@pytest.mark.parametrize(
    ("old", "new", "code", "word"),
    [
        ("", '[[effect]]\ntype="input_delay"\nat="axis.circuit"\ndelay=1\norder=1.5\n', "SD202", "whole number"),
        ("", '[[effect]]\ntype="input_delay"\nat="axis.circuit"\ndelay=1\norder=12\n', "SD203", "at most 9"),
        ("", '[[effect]]\ntype="input_delay"\nat="axis.circuit"\ndelay=1\norder="m"\n', "SD202", "not a parameter"),
        ("", '[[effect]]\ntype="input_delay"\nat="axis.circuit"\ndelay="none"\n', "SD203", "write 0 itself"),
        ("", '[[effect]]\ntype="amplifier_gain"\nat="axis.motor"\ngain=2\n', "SD109", "axis.circuit"),
        ("resistance = 1,", "resistance = 0,", "SD203", "resistance or an inductance"),
        ("resistance = 1,", 'resistance = 1, inductance = "l",', "SD203", "write 0 itself"),
    ],
)
def test_what_would_break_the_structure_is_refused(old: str, new: str, code: str, word: str) -> None:
    given = '[parameters]\nm = 2\nnone = "0 s"\nl = "0 H"\n'
    text = ROTOR.replace("[dh]", f"{given}[dh]")
    with pytest.raises(InputError) as caught:
        robot_from_text(text.replace(old, new) if old else text + new, "rotor")
    assert [problem.code for problem in caught.value.problems] == [code]
    assert word in str(caught.value)


# --- sensors ------------------------------------------------------------------------------------------------------


def test_an_encoder_shows_steps_and_a_resolver_lags() -> None:
    encoder = effect("encoder", "arm.motor", gain="G", offset="O", resolution="D")
    resolver = effect("resolver", "arm", gain=1, offset=0, time_constant="T")
    at_once = effect("resolver", "arm.motor", gain="G", offset="O", time_constant=0)
    equations = derived(encoder, resolver, at_once)
    shown = {s.name: (s.unit, s.value) for s in equations.sensors}
    wanted = parameter("G") * q1 + parameter("O")
    assert shown["arm.motor.encoder"] == ("rad", quantise(wanted, parameter("D")))
    assert shown["arm.motor.resolver"] == ("rad", wanted)
    assert shown["arm.resolver"] == ("rad", z2)
    lag = equations.states[1]
    assert (lag.storage, sp.expand(lag.rate), lag.unit) == (parameter("T"), q2 - z2, "rad")


def test_an_ideal_encoder_shows_the_position() -> None:
    (shown,) = derived(effect("encoder", "arm.motor")).sensors
    assert shown.value == q1


def test_a_tachometer_may_lag() -> None:
    equations = derived(effect("tachometer", "arm.motor", constant="K", time_constant="T"))
    assert equations.sensors[0].value == z2
    assert same(equations.states[1].rate, parameter("K") * v1 - z2)


def test_two_alike_at_one_place_have_names_of_their_own() -> None:
    encoders = [effect("encoder", "arm.motor", gain=1, offset=0, resolution=r) for r in ("D", "E")]
    frictions = [effect("dahl_friction", "arm", stiffness=s, level="F") for s in ("s", "t")]
    equations = derived(*encoders, *frictions)
    assert [s.name for s in equations.sensors] == ["arm.motor.encoder", "arm.motor.encoder_2"]
    assert [s.name for s in equations.states[1:]] == ["arm.elastic_deflection", "arm.elastic_deflection_2"]
    assert same(equations.actuation()[1], -parameter("s") * z2 - parameter("t") * sp.Symbol("z_3", real=True))
