"""Effects of the electrical side: motors without inductance, amplifiers, delays, sensors."""

from __future__ import annotations

from dataclasses import replace

import control
import numpy as np
import pytest
import sympy as sp
from scipy import signal

from symdyn.base.errors import InputError
from symdyn.base.nonsmooth import clip, deadzone, quantise
from symdyn.base.symbols import parameter
from symdyn.compiler import robot_from_text
from symdyn.derive.equations import equations_of_motion
from symdyn.spec.records import Actuator, Drive, Robot

from .drives import BELT, RIGID, driven, letter
from .exact import same
from .more_effects import (
    K_E,
    K_T,
    NO_COIL,
    R,
    derived,
    effect,
    numbers,
    q1,
    q2,
    residuals,
    u1,
    v1,
    z1,
    z2,
)

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


SERVO = '[[effect]]\ntype = "position_servo"\nat = "axis.motor"\nproportional = 3\nderivative = 0.2\nlimit = 1e9\n'
LATE = '[[effect]]\ntype = "reference_delay"\nat = "axis.motor"\ndelay = 0.3\norder = 4\n'


@pytest.mark.parametrize("blocks", [SERVO + LATE, LATE + SERVO])
def test_a_late_reference_is_ahead_of_the_loop_wherever_it_is_declared(blocks: str) -> None:
    """exp(-s T) times the loop without it: dead time within the loop would change its poles."""
    system, plain = (linear(robot_from_text(ROTOR + text, "rotor")) for text in (blocks, SERVO))
    s = 1j * np.array([0.01, 0.3, 1.0, 3.0])
    np.testing.assert_allclose(system(s), plain(s) * np.exp(-0.3 * s), rtol=1e-4)
    assert equations_of_motion(robot_from_text(ROTOR + blocks, "rotor")).inputs[0].name == "axis.motor.reference"


def test_a_late_reference_needs_a_loop_that_follows_a_position() -> None:
    speed = '[[effect]]\ntype = "speed_loop"\nat = "axis.motor"\nproportional = 3\nlimit = 1e9\n'
    for loop in ("", speed):
        with pytest.raises(InputError, match="no servo loop of this joint follows a position"):
            equations_of_motion(robot_from_text(ROTOR + loop + LATE, "rotor"))


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
