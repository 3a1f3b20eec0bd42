"""Friction, contacts and limits against closed forms; corner cases of event handling, by both ways of simulating."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Protocol

import numpy as np
import pytest
from numpy.typing import NDArray

from symdyn.base.errors import InputError, NumericalError
from symdyn.compiler import compile_hybrid, robot_from_text
from symdyn.numeric.hybrid.affine_simulation import simulate_affine
from symdyn.numeric.hybrid.general_simulation import simulate_general
from symdyn.numeric.hybrid.machine import Machine
from symdyn.numeric.hybrid.signals import Signal, constant, ramp, sampled, sine, step
from symdyn.numeric.hybrid.trajectory import HybridTrajectory

from .machines import COULOMB, GAP, PAIR, SLIDER, SPRING, effect, machine

Array = NDArray[np.float64]


class Way(Protocol):
    def __call__(
        self, machine: Machine, time: Array, signals: Sequence[Signal], *, start: Array | None = None
    ) -> HybridTrajectory: ...


ways = pytest.mark.parametrize(
    ("way", "close"),
    [
        pytest.param(simulate_affine, 1e-10, id="exact"),
        pytest.param(partial(simulate_general, tolerance=1e-10), 1e-8, id="general", marks=pytest.mark.slow),
    ],
)


def times(end: float, count: int = 201) -> Array:
    return np.linspace(0.0, end, count)


# --- friction -------------------------------------------------------------------------------------------------------


@ways
def test_a_body_at_rest_without_load_stays(way: Way, close: float) -> None:
    result = way(machine(SLIDER + COULOMB), times(100.0), [constant(0.0)], start=np.array([0.3, 0.0]))
    assert np.all(result.states == [0.3, 0.0])
    assert result.events == ()


@ways
def test_a_body_that_sticks_under_a_changing_load_does_not_drift(way: Way, close: float) -> None:
    """For a thousand turns of the load, up to 99.9 % of the limit: not by one bit."""
    result = way(machine(SLIDER + COULOMB), times(1000.0), [sine(2.997, 1.0)])
    assert np.all(result.states == 0.0)
    assert result.events == ()


@ways
def test_it_sets_off_when_the_load_exceeds_the_limit(way: Way, close: float) -> None:
    """The load 5 t reaches 3 N at 0.6 s; from there m x'' = 5 t - 3."""
    t = times(2.0)
    result = way(machine(SLIDER + COULOMB), t, [ramp(5.0)])
    (event,) = result.events
    assert (event.switch, event.kind, event.before, event.after) == ("slide", "friction", 0, 1)
    assert event.time == pytest.approx(0.6, abs=close)
    since = np.clip(t - 0.6, 0.0, None)
    assert np.allclose(result.states[:, 0], 5.0 * since**3 / 12.0, atol=close)
    assert np.allclose(result.states[:, 1], 5.0 * since**2 / 4.0, atol=close)


@ways
def test_what_a_jump_of_the_load_sets_off_is_an_event(way: Way, close: float) -> None:
    """At once, at 0.5 s; what the run begins with is none. At 1.25 s 1 N are not enough, and it stops 0.75 s later."""
    signal = sampled(np.array([0.0, 0.5, 1.25]), np.array([0.0, 5.0, 1.0]), hold=True)
    result = way(machine(SLIDER + COULOMB), times(3.0), [signal])
    assert [(e.before, e.after) for e in result.events] == [(0, 1), (1, 0)]
    assert [e.time for e in result.events] == pytest.approx([0.5, 2.0], abs=close * 100)
    assert way(machine(SLIDER + COULOMB), times(0.5), [constant(5.0)]).events == ()


@ways
@pytest.mark.parametrize("way_round", [1.0, -1.0])
def test_a_sliding_body_stops_and_stays(way: Way, close: float, way_round: float) -> None:
    """m v' = -3 N: from 2.4 m/s it stops after 1.6 s, and 1.92 m; both signs alike."""
    result = way(machine(SLIDER + COULOMB), times(1000.0, 11), [constant(0.0)], start=np.array([0.0, 2.4 * way_round]))
    (event,) = result.events
    assert (event.before, event.after) == (way_round, 0)
    assert event.time == pytest.approx(1.6, abs=close * 100)
    assert result.states[1, 0] == pytest.approx(1.92 * way_round, abs=close * 10)
    assert np.all(result.states[1:] == result.states[1])
    assert result.states[1, 1] == 0.0


@ways
def test_a_speed_that_is_never_zero_meets_no_event(way: Way, close: float) -> None:
    """Driven by more than its friction: m x'' = 5 - 3."""
    t = times(3.0)
    result = way(machine(SLIDER + COULOMB), t, [constant(5.0)], start=np.array([0.0, 1.0]))
    assert result.events == ()
    assert np.allclose(result.states[:, 0], t + 0.5 * t**2, rtol=close)


@ways
def test_a_spring_against_friction_swings_half_by_half(way: Way, close: float) -> None:
    """Each half swing is a cosine about +-F/k, and loses 2 F/k of amplitude, until friction holds the spring."""
    omega, loss = math.sqrt(18.0 / 2.0), 3.0 / 18.0
    t = times(6.0, 601)
    result = way(machine(SLIDER + COULOMB + SPRING), t, [constant(0.0)], start=np.array([1.0, 0.0]))
    expected, at, since, sign = np.empty_like(t), 1.0, 0.0, 1.0
    half = math.pi / omega
    for k, now in enumerate(t):
        while now - since > half and abs(at) > loss:
            at, since, sign = -(at - 2.0 * loss * sign), since + half, -sign
        center = loss * sign
        expected[k] = center + (at - center) * math.cos(omega * (now - since)) if abs(at) > loss else at
    assert np.allclose(result.states[:, 0], expected, atol=close * 10)
    assert [e.after for e in result.events] == [1, -1, 0]
    assert np.allclose([e.time for e in result.events], half * np.arange(1, 4), atol=close * 100)


@ways
def test_two_frictions_on_one_shaft_are_one_of_their_sum(way: Way, close: float) -> None:
    both = machine(SLIDER + COULOMB + effect("coulomb_friction", "slide", level=1.0))
    assert both.switches == ("slide",)
    t = times(2.0)
    one = machine(SLIDER + effect("coulomb_friction", "slide", level=4.0))
    a, b = (way(m, t, [sine(9.0, 1.0)]).states for m in (both, one))
    assert np.allclose(a, b, atol=1e-12)


@ways
def test_friction_within_a_shaft_holds_its_ends_together(way: Way, close: float) -> None:
    """Driven by less than it can transmit, both ends turn as one body; the twist stays zero."""
    clutch = machine(PAIR.replace("stiffness = 40, damping = 0.3", "stiffness = 0")
                     + effect("coulomb_friction", "arm.shaft", level=2.0))  # fmt: skip
    t = times(4.0)
    result = way(clutch, t, [constant(0.7)])
    assert np.allclose(result.states[:, :2], 0.5 * t[:, None] ** 2, atol=close * 10)
    assert np.ptp(result.states[:, :2], axis=1).max() < 1e-12
    slipping = way(clutch, t, [constant(14.0)])  # the motor feels no more than 2 N m: 10 rad/s^2; the arm 24
    assert np.allclose(slipping.states[:, 2:], t[:, None] * [10.0, 24.0], rtol=close * 10)


def test_asymmetric_friction_holds_by_direction() -> None:
    m = machine(SLIDER + effect("asymmetric_coulomb_friction", "slide", level_positive=3.0, level_negative=1.0))
    up = simulate_affine(m, times(2.0), [ramp(2.0)]).events[0]
    down = simulate_affine(m, times(2.0), [ramp(-2.0)]).events[0]
    assert (up.time, up.after) == (pytest.approx(1.5, abs=1e-9), 1)
    assert (down.time, down.after) == (pytest.approx(0.5, abs=1e-9), -1)


@pytest.mark.slow
def test_static_friction_above_coulomb_lets_go_at_its_peak() -> None:
    """Stribeck's excess counts in full at rest: 3 + 1.5 N."""
    m = machine(SLIDER + COULOMB + effect("stribeck_friction", "slide", excess=1.5, stribeck_velocity=0.1))
    assert not m.affine
    result = simulate_general(m, times(2.0), [ramp(3.0)], tolerance=1e-9)
    assert result.events[0].time == pytest.approx(1.5, abs=1e-8)
    assert np.all(result.states[result.time < 1.5] == 0.0)


# --- contact --------------------------------------------------------------------------------------------------------


@ways
def test_backlash_at_rest_within_the_gap_transmits_nothing(way: Way, close: float) -> None:
    result = way(machine(PAIR + GAP), times(50.0), [constant(0.0)], start=np.array([0.0, 0.05, 0.0, 0.0]))
    assert np.all(result.states == [0.0, 0.05, 0.0, 0.0])
    assert result.events == ()


@ways
def test_the_gap_is_crossed_freely_and_closed_at_its_edge(way: Way, close: float) -> None:
    result = way(machine(PAIR + GAP), times(0.5), [constant(0.0)], start=np.array([0.0, 0.0, 0.8, 0.0]))
    first = result.events[0]
    assert (first.kind, first.before, first.after) == ("contact", 0, 1)
    assert first.time == pytest.approx(0.1 / 0.8, abs=close)
    momentum = 0.2 * result.states[:, 2] + 0.5 * result.states[:, 3]
    assert np.allclose(momentum, 0.16, atol=close * 10)


@ways
@pytest.mark.parametrize("ulp", [-1, 0, 1])
def test_a_force_that_friction_can_just_hold(way: Way, close: float, ulp: int) -> None:
    """The limit itself, and a rounding error either side of it: at rest, and soon done."""
    force = 3.0 + ulp * np.spacing(3.0)
    found = way(machine(SLIDER + COULOMB), times(1.0, 11), [constant(force)])
    assert np.allclose(found.states, 0.0, atol=1e-12)
    assert found.steps < 100


@ways
def test_a_swing_that_ends_where_friction_can_just_hold(way: Way, close: float) -> None:
    """Turning points 2, -14/9, 10/9, -6/9, 2/9: there the spring pulls with the limit."""
    friction = effect("coulomb_friction", "slide", level=4.0)
    found = way(machine(SLIDER + SPRING + friction), times(6.0, 61), [constant(0.0)], start=np.array([2.0, 0.0]))
    assert np.allclose(found.states[-1], [2.0 / 9.0, 0.0], atol=max(close, 1e-7))


@ways
def test_flanks_never_pull_and_energy_never_grows(way: Way, close: float) -> None:
    t = times(6.0, 6001)
    states = way(machine(PAIR + GAP), t, [constant(0.0)], start=np.array([0.0, 0.0, 3.0, 0.0])).states
    twist, rate = states[:, 1] - states[:, 0], states[:, 3] - states[:, 2]
    pressed = np.clip(np.abs(twist) - 0.1, 0.0, None)
    energy = 0.1 * states[:, 2] ** 2 + 0.25 * states[:, 3] ** 2
    stored = 20.0 * pressed**2
    pulls = (40.0 * pressed + 0.3 * rate * np.sign(twist) < 0.0) & (pressed > 0.0)
    assert pulls.any()  # the case is met: there the spring's energy is lost, because nothing holds the flanks
    assert np.all(np.diff(energy + np.where(pulls, 0.0, stored))[~pulls[1:]] <= 1e-9)
    moved = np.abs(np.diff(states[:, 2]))
    assert moved[pulls[1:] & pulls[:-1]].max() < 1e-9  # no force while they would pull


def test_clearances_that_stand_in_one_another_are_refused() -> None:
    text = PAIR + GAP + effect("backlash", "arm.shaft", clearance=0.2)
    with pytest.raises(InputError, match="SD451"):
        compile_hybrid(robot_from_text(text, "machine.toml"))


# --- inputs, reports, refusals --------------------------------------------------------------------------------------


@ways
def test_inputs_may_jump_between_reports(way: Way, close: float) -> None:
    """A force of 5 N from 0.123 s on, 0 from 0.777 s on, reported every 0.05 s: m x'' = u, no friction."""
    force = Signal((*step(5.0, 0.123).pieces, *step(0.0, 0.777).pieces[1:]))
    t = times(1.0, 21)
    states = way(machine(SLIDER), t, [force]).states
    speed = 2.5 * np.clip(t - 0.123, 0.0, 0.777 - 0.123)
    assert np.allclose(states[:, 1], speed, atol=close)


@ways
def test_a_recorded_input_is_followed_from_point_to_point(way: Way, close: float) -> None:
    points = np.array([0.0, 0.3, 0.7, 1.0])
    values = np.array([0.0, 4.0, -2.0, 1.0])
    t = times(1.0, 11)
    states = way(machine(SLIDER), t, [sampled(points, values)]).states
    fine = np.linspace(0.0, 1.0, 1_000_001)
    force = np.interp(fine, points, values)
    impulse = np.concatenate([[0.0], np.cumsum(0.5 * (force[1:] + force[:-1])) * 1e-6])
    assert np.allclose(states[:, 1], np.interp(t, fine, impulse) / 2.0, atol=max(close, 1e-9))


@ways
@pytest.mark.parametrize(
    ("time", "signals", "start"),
    [
        (np.array([0.0]), [constant(0.0)], None),
        (np.array([0.0, 0.1, 0.3]), [constant(0.0)], None),
        (np.array([0.0, np.nan]), [constant(0.0)], None),
        (times(1.0), [], None),
        (times(1.0), [constant(0.0)], np.zeros(3)),
        (times(1.0), [constant(0.0)], np.array([0.0, np.inf])),
    ],
)
def test_bad_times_signals_and_starts_are_refused(
    way: Way, close: float, time: Array, signals: list[Signal], start: Array | None
) -> None:
    with pytest.raises(InputError, match="SD302"):
        way(machine(SLIDER + COULOMB), time, signals, start=start)


def test_an_unstable_machine_ends_with_the_time_and_the_state_reached() -> None:
    stable = machine(SLIDER + SPRING)
    unstable = replace(stable, p=np.where(stable.kernel.values == 18.0, -1e4, stable.kernel.values))
    told = r"SD303: the state left the finite numbers at t = \d.* s; slide.qd was -?\d.*e\+2\d\d before"
    with pytest.raises(NumericalError, match=told):
        simulate_affine(unstable, times(100.0), [constant(0.0)], start=np.array([1.0, 0.0]))
    with pytest.raises(InputError, match="SD302"):  # its code has the parameters of the file folded in
        simulate_general(unstable, times(1.0), [constant(0.0)])
