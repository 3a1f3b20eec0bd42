"""Friction with memory against closed forms: presliding, steady sliding, loops, warming up."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st

from symdyn.base import symbols
from symdyn.physics import effect as find_effect
from symdyn.physics.effect import PORT

Motion = Callable[[float], tuple[float, float]]  # time -> displacement, velocity
LUGRE = {"stiffness": 40.0, "damping": 1.5, "level": 2.0, "excess": 1.0, "stribeck_velocity": 0.1}
DAHL = {"stiffness": 40.0, "level": 2.0}
BOUC_WEN = {"level": 2.0, "yield_displacement": 0.05, "shape": 0.8, "exponent": 3.0}
HARDENING = {"stiffness": 40.0, "displacement": 0.1, "ratio": 4.0}
WARM_UP = {"coefficient": 2.0, "temperature_scale": 10.0, "heat_capacity": 0.5, "thermal_resistance": 4.0}
LAWS = {
    "lugre_friction": LUGRE,
    "dahl_friction": DAHL,
    "bouc_wen_hysteresis": BOUC_WEN,
    "hardening_hysteresis": HARDENING,
    "warm_up_friction": WARM_UP,
}


class Law:
    """An effect with one hidden state, its numbers put in."""

    def __init__(self, identifier: str, numbers: dict[str, float]) -> None:
        item, z = find_effect(identifier), symbols.hidden(1)
        p = {name: symbols.number(value) for name, value in numbers.items()}
        (rate,) = item.rates(PORT, p, (z,), sp.Integer(0))
        self.rate = sp.lambdify((PORT.v, z), rate.change / rate.storage, "math")
        self.force = sp.lambdify((PORT.v, z), item.state_force(PORT, p, (z,), sp.Integer(0)), "math")
        self.stored = sp.lambdify(z, item.stored_energy(p, (z,)), "math")

    def along(self, motion: Motion, duration: float, count: int = 4000) -> list[tuple[float, float, float, float]]:
        """(displacement, speed, state, force) at ``count`` times, by the classical Runge-Kutta method."""
        h, z, rows = duration / count, 0.0, []
        for k in range(count + 1):
            x, v = motion(k * h)
            rows.append((x, v, z, self.force(v, z)))
            half, later = motion((k + 0.5) * h)[1], motion((k + 1) * h)[1]
            a = self.rate(v, z)
            b = self.rate(half, z + h * a / 2)
            c = self.rate(half, z + h * b / 2)
            z += h * (a + 2 * b + 2 * c + self.rate(later, z + h * c)) / 6
        return rows


def steadily(speed: float) -> Motion:
    return lambda t: (speed * t, speed)


@pytest.mark.parametrize("speed", [-0.5, -0.05, 0.02, 0.1, 3.0])
def test_lugre_slides_on_the_stribeck_curve(speed: float) -> None:
    *_, force = Law("lugre_friction", LUGRE).along(steadily(speed), 2.0 / abs(speed))[-1]
    assert force == pytest.approx(-math.copysign(2.0 + math.exp(-((speed / 0.1) ** 2)), speed), rel=1e-6)


def test_lugre_sticks_as_a_spring_with_a_damper() -> None:
    """Before it slides: force -(s0 x + s1 v), to first order in the displacement."""
    size, omega = 1e-5, 3.0
    law = Law("lugre_friction", LUGRE)
    rows = law.along(lambda t: (size * math.sin(omega * t), size * omega * math.cos(omega * t)), 2.0)
    for x, v, _, force in rows[1:]:
        assert force == pytest.approx(-(40.0 * x + 1.5 * v), abs=3e-4 * 40.0 * size)


def test_lugre_does_not_push_however_strongly_its_bristles_are_damped() -> None:
    """Where damping that does not fall with speed would: s1 |v| > 4 g."""
    stiff, damping = LUGRE["stiffness"], 50.0
    law = Law("lugre_friction", {**LUGRE, "damping": damping})
    given, would_be = [], []
    for v in (-10.0, -0.4, 0.01, 0.5, 10.0):
        for z in np.linspace(-0.1, 0.1, 41):
            kept = stiff * z * law.rate(v, z)
            given.append(law.force(v, z) * v + kept)
            would_be.append(-(stiff * z + damping * law.rate(v, z)) * v + kept)
    assert max(given) <= 1e-12
    assert max(would_be) > 1.0


def test_dahl_approaches_its_level_over_a_distance() -> None:
    """z = F_c / s (1 - exp(-s x / F_c)) from rest, at any speed."""
    for speed in (0.01, 2.0):
        for x, _, z, force in Law("dahl_friction", DAHL).along(steadily(speed), 0.3 / speed):
            assert z == pytest.approx(2.0 / 40.0 * -math.expm1(-40.0 * x / 2.0), abs=1e-9)
            assert force == -40.0 * z


def test_bouc_wen_of_exponent_one_is_dahl() -> None:
    def wave(t: float) -> tuple[float, float]:
        return 0.2 * math.sin(t), 0.2 * math.cos(t)

    numbers = {"level": 2.0, "yield_displacement": 2.0 / 40.0, "shape": 1.0, "exponent": 1.0}
    one = Law("bouc_wen_hysteresis", numbers).along(wave, 10.0)
    other = Law("dahl_friction", DAHL).along(wave, 10.0)
    np.testing.assert_allclose([row[3] for row in one], [row[3] for row in other], rtol=0, atol=1e-12)


def test_bouc_wen_stays_within_its_level_and_comes_back_on_a_loop() -> None:
    """The second round of a motion repeats the first from its first reversal on; the loop's area is what is lost."""
    rows = Law("bouc_wen_hysteresis", BOUC_WEN).along(
        lambda t: (0.2 * math.sin(t), 0.2 * math.cos(t)), 6 * math.pi, 6000
    )
    force = np.array([row[3] for row in rows])
    assert np.abs(force).max() <= 2.0
    np.testing.assert_allclose(force[2000:4000], force[4000:6000], atol=1e-6)
    work = float(np.sum(force[4000:6000] * np.array([row[1] for row in rows[4000:6000]]))) * 6 * math.pi / 6000
    assert -4 * 2.0 * 0.2 < work < -0.5 * 4 * 2.0 * 0.2


def test_a_hardening_loop_goes_out_and_back_by_exponentials() -> None:
    """Out: k D (exp(x / D) - 1); back from x_0: k D / r ((1 + r w_0) exp(-r (x_0 - x) / D) - 1)."""
    k, d, r = HARDENING.values()
    far, law = 0.15, Law("hardening_hysteresis", HARDENING)
    rows = law.along(lambda t: (far - abs(t - far), 1.0 if t < far else -1.0), 2 * far)
    most = math.expm1(far / d)
    for i, (x, _, w, force) in enumerate(rows):
        assert force == pytest.approx(-k * d * w)
        back = ((1 + r * most) * math.exp(-r * (far - x) / d) - 1) / r
        if i <= len(rows) // 2 or back > 0.0:
            assert w == pytest.approx(math.expm1(x / d) if i <= len(rows) // 2 else back, abs=5e-3)


def test_a_hardening_loop_is_bouc_and_wens_law_with_numbers_that_its_own_has_not() -> None:
    """dz/dt = alpha v - beta |v| z - gamma v |z| with beta + gamma < 0, as it is written with a unit."""
    k, d, r = HARDENING.values()
    law = Law("hardening_hysteresis", HARDENING)
    beta, gamma = (r - 1) / (2 * d), -(r + 1) / (2 * d)
    assert beta + gamma == pytest.approx(-1 / d)
    for v in (-0.7, 0.2):
        for z in (-3.0, 0.5, 8.0):
            rate = k * d * law.rate(v, z / (k * d))
            assert rate == pytest.approx(k * v - beta * abs(v) * z - gamma * v * abs(z))


def test_what_warms_up_settles_where_heat_flows_off_as_it_comes() -> None:
    """T / R = F v^2 exp(-T / T_0), and before, all the friction's work is in the heat."""
    speed = 1.5
    law = Law("warm_up_friction", WARM_UP)
    rows = law.along(steadily(speed), 40.0)
    first, last = rows[0], rows[-1]
    assert first[3] == -2.0 * speed
    assert last[2] / 4.0 == pytest.approx(2.0 * speed**2 * math.exp(-last[2] / 10.0), rel=1e-5)
    assert abs(last[3]) < abs(first[3])
    assert (law.rate(speed, 0.0) * 0.5) == pytest.approx(-first[3] * speed)


@pytest.mark.parametrize("identifier", LAWS)
@settings(max_examples=15, deadline=None)
@given(waves=st.lists(st.tuples(st.floats(-0.3, 0.3), st.floats(0.2, 8.0)), min_size=1, max_size=4))
def test_no_motion_gets_more_out_than_was_put_in(identifier: str, waves: Sequence[tuple[float, float]]) -> None:
    law, duration, count = Law(identifier, LAWS[identifier]), 4.0, 2000

    def motion(t: float) -> tuple[float, float]:
        return (
            sum(a * math.sin(w * t) for a, w in waves),
            sum(a * w * math.cos(w * t) for a, w in waves),
        )

    rows = law.along(motion, duration, count)
    power = np.array([-force * v for _, v, _, force in rows])
    put_in = np.concatenate([[0.0], np.cumsum((power[1:] + power[:-1]) / 2)]) * duration / count
    lost = put_in - np.array([law.stored(row[2]) for row in rows])
    scale = max(float(np.abs(put_in).max()), 1e-9)
    assert lost.min() >= -1e-3 * scale
    assert np.diff(lost).min() >= -1e-3 * scale
