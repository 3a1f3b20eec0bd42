"""Effects that change what others feel: gears, loads, springs, bodies."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp

from symdyn.base.errors import InputError
from symdyn.base.nonsmooth import deadzone, pushing, sign_of
from symdyn.base.symbols import parameter
from symdyn.compiler import robot_from_text
from symdyn.derive.coordinates import coordinates
from symdyn.derive.equations import equations_of_motion
from symdyn.derive.lagrange import lagrange_coefficients, textbook_coefficients
from symdyn.spec.records import ONE, Drive, EffectSpec, JointKind

from .drives import driven, letter
from .exact import same
from .more_effects import (
    SLIP,
    TWIST,
    N,
    a2,
    c,
    d,
    derived,
    effect,
    extra,
    numbers,
    q1,
    q2,
    residuals,
    v1,
    v2,
    z2,
)

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
