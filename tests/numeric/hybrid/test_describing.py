"""Stepped sines and multisines: linear machines against their linear response, dry friction against closed forms."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from symdyn.base.errors import UsageError
from symdyn.compiler import linearise, robot_from_text
from symdyn.numeric.hybrid.fourier import listener, settle
from symdyn.numeric.hybrid.multisine import HIGHEST, multisine_response, odd_grid, random_phases
from symdyn.numeric.hybrid.signals import Signal, sine
from symdyn.numeric.hybrid.stepped_sine import SteppedSine, stepped_sine
from symdyn.numeric.linear.response import frequency_response

from .machines import COULOMB, PAIR, SLIDER, SPRING, effect, machine

MASS, LEVEL = 2.0, 3.0
SKEW = effect("asymmetric_coulomb_friction", "slide", level_positive=3.0, level_negative=2.0)
DAMPER = effect("viscous_friction", "slide", coefficient=2.0)
LINEAR = PAIR + effect("viscous_friction", "arm", coefficient=0.6)


def against(hertz: np.ndarray, output: str, text: str = LINEAR) -> np.ndarray:
    system = linearise(robot_from_text(text, "machine.toml")).nominal
    return frequency_response(system, hertz, None, output).values


def sliding(amplitude: float, hertz: float, harmonics: int = 7) -> np.ndarray:
    """Speed of a mass under dry friction that never sticks: amplitudes (7,) of exp(j k omega t), in closed form.

    The speed has period and odd symmetry, so that the force's integral over half a period from its zero t0 is zero:
    cos(omega t0) = pi F / (2 A). Friction is then the square wave from t0 on, and m dv/dt the rest.
    """
    omega = 2 * np.pi * hertz
    angle = np.arccos(np.pi * LEVEL / (2 * amplitude))
    assert amplitude * np.sin(angle) > LEVEL  # it does not stick
    k = np.arange(1, harmonics + 1)
    square = np.where(k % 2 == 1, -4j / (np.pi * k) * np.exp(-1j * k * angle), 0.0)
    force = np.where(k == 1, -1j * amplitude, 0.0)
    return (force - LEVEL * square) / (1j * k * omega * MASS)


def test_a_linear_machine_has_its_linear_response_at_any_amplitude() -> None:
    """Through the resonance and both decades beside it, from a sensorless machine, to 1e-9."""
    for amplitude, hertz in (
        (0.01, np.array([0.05, 0.7, 1.3, 2.73, 4.0, 30.0, 200.0])),
        (50.0, np.array([0.7, 2.73, 30.0])),
    ):
        exact = against(hertz, "arm.qd")
        found = stepped_sine(machine(LINEAR), hertz, amplitude, output="arm.qd")
        assert found.settled.all()
        assert np.all(np.abs(found.values - exact) < 1e-9 * np.abs(exact))
        assert np.all(found.odd < 1e-9)
        assert np.all(found.even < 1e-9)


def test_a_position_that_drifts_away_has_its_response_too() -> None:
    """A force from rest sets a free mass off with a mean speed; its position is a ramp with a sine on it."""
    found = stepped_sine(machine(SLIDER), np.array([0.5, 3.0]), 2.0, output="slide.q")
    assert found.values == pytest.approx(-1.0 / (MASS * (2 * np.pi * found.hertz) ** 2), rel=1e-10)


@pytest.mark.parametrize("amplitude", [6.0, 9.0, 40.0])
def test_dry_friction_that_never_sticks_is_its_describing_function(amplitude: float) -> None:
    found = stepped_sine(machine(SLIDER + COULOMB), np.array([0.3, 2.0]), amplitude, output="slide.qd", settled=1e-9)
    assert found.settled.all()
    assert np.all(found.events == 2)
    for i, f in enumerate(found.hertz):
        exact = sliding(amplitude, f)
        assert found.harmonics[i] == pytest.approx(exact, abs=1e-9 * abs(exact[0]))
        assert found.odd[i] == pytest.approx(np.linalg.norm(exact[2::2]) / abs(exact[0]), rel=1e-7)


@pytest.mark.parametrize("samples", [64, 256, 1024])
def test_samples_agree_with_resonators_to_the_square_of_their_number(samples: int) -> None:
    exact = sliding(9.0, 2.0)
    heard = listener(machine(SLIDER + COULOMB), "slide.qd", 7, exact=False, samples=samples, tolerance=1e-8)
    cycle = settle(heard, [sine(9.0, 2.0)], 0.5, np.zeros(2), 1e-9, 4096)
    assert np.abs(cycle.harmonics - exact).max() < 4.0 / samples**2 * abs(exact[0])


def test_friction_holds_what_is_weaker_than_its_limit() -> None:
    found = stepped_sine(machine(SLIDER + COULOMB), np.array([1.0]), 2.9, output="slide.qd")
    assert (found.values[0], found.odd[0], found.settled[0], found.periods[0]) == (0.0, 0.0, True, 4)


def test_even_distortion_is_that_of_unequal_directions() -> None:
    """They push like a constant force: a mean speed, so that the two halves of a period are not alike."""
    equal, skew = (stepped_sine(machine(SLIDER + DAMPER + friction), np.array([0.2, 1.0]), 9.0, output="slide.qd")
                   for friction in (COULOMB, SKEW))  # fmt: skip
    assert equal.settled.all()
    assert skew.settled.all()
    assert np.all(equal.odd > 1e-3)
    assert np.all(equal.even < 1e-9)
    assert np.all(skew.even > 1e-3)


def test_against_a_spring_unequal_directions_are_equal_ones_and_a_constant_force() -> None:
    found = stepped_sine(machine(SLIDER + SPRING + SKEW), np.array([0.2, 1.0]), 9.0, output="slide.qd")
    mean = COULOMB.replace("3.0", "2.5")
    centred = stepped_sine(machine(SLIDER + SPRING + mean), np.array([0.2, 1.0]), 9.0, output="slide.qd")
    assert np.all(found.even < 1e-9)
    assert found.harmonics[:, 0] == pytest.approx(centred.harmonics[:, 0], rel=1e-6)


def test_a_period_that_never_repeats_is_told() -> None:
    """Without a damper the free oscillation stays."""
    found = stepped_sine(machine(SLIDER + SPRING), np.array([0.31]), 1.0, output="slide.qd", most_periods=64)
    assert not found.settled[0]
    assert found.periods[0] <= 64


# --- multisines -----------------------------------------------------------------------------------------------------


def test_a_grid_is_odd_and_one_line_in_four_is_left_out() -> None:
    grid = odd_grid(0.1, 20.0, 40, seed=3)
    lines = np.sort(np.concatenate([grid.excited, grid.detection]))
    assert np.all(lines % 2 == 1)
    assert lines[0] == 1
    assert lines[-1] <= 200
    assert len(grid.detection) == len(lines) // 4
    assert all(np.isin(lines[k : k + 4], grid.detection).sum() == 1 for k in range(0, len(lines) - 3, 4))
    assert np.array_equal(grid.even, lines + 1)
    again, other = odd_grid(0.1, 20.0, 40, seed=3), odd_grid(0.1, 20.0, 40, seed=4)
    assert np.array_equal(again.excited, grid.excited)
    assert not np.array_equal(other.detection, grid.detection)


def test_its_power_is_that_of_the_sine() -> None:
    grid = odd_grid(1.0, 30.0, 12)
    t = np.arange(4096) / 4096
    values = Signal((random_phases(grid, 3.0, 0.5, 1, 0),)).at(t)
    assert np.mean((values - 0.5) ** 2) == pytest.approx(9.0 / 2)
    assert not np.allclose(values, Signal((random_phases(grid, 3.0, 0.5, 1, 1),)).at(t))


def test_a_linear_machine_shows_its_response_and_no_distortion() -> None:
    grid = odd_grid(0.5, 60.0, 12)
    found = multisine_response(machine(LINEAR), grid, 4.0, output="arm.qd", realisations=2, settled=1e-11)
    exact = against(found.hertz, "arm.qd")
    assert found.settled.all()
    assert np.all(np.abs(found.values - exact) < 1e-9 * np.abs(exact))
    assert found.deviation.max() < 1e-9 * np.abs(exact).max()
    assert max(found.odd.max(), found.even.max()) < 1e-9 * found.level.max()


def test_friction_distorts_oddly_and_unequal_directions_evenly_too() -> None:
    grid = odd_grid(0.2, 12.0, 12)
    equal, skew = (
        multisine_response(machine(SLIDER + DAMPER + friction), grid, 12.0, output="slide.qd", realisations=2)
        for friction in (COULOMB, SKEW)
    )
    assert equal.odd.max() > 1e-3 * equal.level.max()
    assert equal.even.max() < 1e-5 * equal.level.max()
    assert skew.even.max() > 1e-3 * skew.level.max()
    assert np.all(equal.deviation > 0.0)


def test_the_same_seed_gives_the_same_numbers_and_one_realisation_no_deviation() -> None:
    grid = odd_grid(0.5, 6.0, 8)
    slide = machine(SLIDER + SPRING + COULOMB)
    once, again, other = (
        multisine_response(slide, grid, 9.0, output="slide.qd", realisations=1, seed=seed) for seed in (5, 5, 6)
    )
    assert once.responses.tobytes() == again.responses.tobytes()
    assert not np.allclose(once.responses, other.responses)
    assert np.isnan(once.deviation).all()


# --- what is refused ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("amplitude", [0.0, -1.0, np.nan, np.inf])
def test_an_amplitude_is_positive(amplitude: float) -> None:
    with pytest.raises(UsageError, match="SD302"):
        stepped_sine(machine(SLIDER), np.array([1.0]), amplitude)
    with pytest.raises(UsageError, match="SD302"):
        multisine_response(machine(SLIDER), odd_grid(1.0, 9.0, 4), amplitude)


def test_frequencies_lines_and_names_are_looked_at() -> None:
    for hertz in ([0.0], [1.0, np.nan], [-1.0]):
        with pytest.raises(UsageError, match="SD302"):
            stepped_sine(machine(SLIDER), np.array(hertz), 1.0)
    for low, high, lines in ((0.0, 1.0, 8), (1.0, 1.0, 8), (1.0, np.inf, 8), (1.0, 1.01 * HIGHEST, 8), (1.0, 9.0, 3)):
        with pytest.raises(UsageError, match="SD302"):
            odd_grid(low, high, lines)
    for input, output in (("slide.qd", None), (None, "slider.q")):
        with pytest.raises(UsageError, match="SD305"):
            stepped_sine(machine(SLIDER), np.array([1.0]), 1.0, input, output)


def test_nothing_that_moves_has_no_distortion() -> None:
    harmonics = np.zeros((1, 7), np.complex128)
    still = SteppedSine("u", "y", 1.0, np.ones(1), harmonics, np.ones(1, np.int64), np.ones(1, np.bool_),
                        np.zeros(1, np.int64))  # fmt: skip
    assert (still.odd[0], still.even[0]) == (0.0, 0.0)
    moved = replace(still, harmonics=np.array([[2.0, 0.3, 0.6, 0.4, 0.8, 0.0, 0.0]], np.complex128))
    assert (moved.odd[0], moved.even[0]) == pytest.approx((0.5, 0.25))
