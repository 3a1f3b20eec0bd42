"""Parts on stiff shafts are one place, as far as samples show."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from symdyn.compiler import compile_robot, load_robot
from symdyn.numeric.filtering.between import Between
from symdyn.numeric.filtering.gears import per_joint
from symdyn.numeric.filtering.hypotheses import hypotheses
from symdyn.numeric.filtering.judged import Explanation
from symdyn.numeric.filtering.likelihood import MLFit
from symdyn.numeric.filtering.model import Model, without_latent
from symdyn.numeric.filtering.signals import Signals, stretch
from symdyn.numeric.filtering.stiff import resonance, rigid_with, that_show

TACHOMETER, MOTOR, WHEEL, LOAD = 34e-6, 41e-6, 196e-6, 372e-6  # kg m^2, as in the paper


def signals_of(model_coordinates: Sequence[str], turns: np.ndarray, shown: Sequence[str], step: float) -> Signals:
    n, count = len(model_coordinates), 50
    index = np.array([list(model_coordinates).index(at) for at in shown], dtype=np.int64)
    time = step * np.arange(count)
    y = np.sin(np.outer(time, np.arange(1, len(shown) + 1)))
    steps = np.append(np.full(count - 1, step), np.nan)
    names = tuple(f"{at}.q" for at in shown)
    return Signals(time, np.zeros((count, 1)), y, index, names, steps, np.zeros(len(shown)), turns, np.ones(n))


def seen(shown: Sequence[str], rate: float, play: bool = False) -> tuple[Model, Explanation]:
    """The paper's drive, positions of some parts recorded, and what is known of it before any fit.

    With its play in the flexspline, or without.
    """
    robot = load_robot("irb6-axis1")
    kernel = compile_robot(robot).kernel()
    robot = replace(robot, effects=tuple(e for e in robot.effects if play or e.type != "backlash"))
    signals = signals_of(kernel.coordinates, per_joint(robot, kernel.coordinates), shown, 1.0 / rate)
    model = Model(robot, kernel, (), (), {}, signals, signals)
    none = np.zeros(0)
    fitted = MLFit({}, model.values, model.bench(signals, without_latent(model, signals), Between.HELD), 0.0)
    return model, Explanation((), {}, fitted, none, (none, none), none, none)


def test_two_parts_swing_as_if_nothing_else_held_them() -> None:
    model, of = seen(["axis1.motor"], 1000.0)
    values = dict(zip(model.kernel.parameters, model.kernel.values, strict=True))
    for one, other, spring, masses in (
        ("axis1.tachometer", "axis1.motor", "c_1", (TACHOMETER, MOTOR)),
        ("axis1.harmonic_drive", "axis1", "c_3", (WHEEL, LOAD)),
    ):
        free = np.sqrt(values[spring] * sum(1.0 / mass for mass in masses)) / (2.0 * np.pi)
        assert resonance(model, of.fit, one, other) == pytest.approx(free, rel=1e-6)


@pytest.mark.parametrize(
    ("rate", "shown", "others"),
    [
        (1000.0, ["axis1.motor"], {"axis1.tachometer", "axis1.harmonic_drive"}),  # rigid to each other below 600 Hz
        (1000.0, ["axis1.motor", "axis1.harmonic_drive"], {"axis1.tachometer"}),  # what twists between them shows
        (10000.0, ["axis1.motor"], set()),
        (10.0, ["axis1.motor"], {"axis1.tachometer", "axis1.harmonic_drive", "axis1"}),
    ],
)
def test_what_samples_do_not_show_is_one_place(rate: float, shown: Sequence[str], others: set[str]) -> None:
    model, of = seen(shown, rate)
    assert set(rigid_with(model, of, "axis1.motor", "coulomb_friction")) == others


def test_play_is_not_stiff_and_a_law_stays_where_it_may_be() -> None:
    model, of = seen(["axis1.motor"], 10.0, play=True)
    assert "axis1" not in rigid_with(model, of, "axis1.motor", "coulomb_friction")
    model, of = seen(["axis1.motor"], 10.0)
    assert rigid_with(model, of, "axis1.motor", "payload") == ("axis1",)


@pytest.mark.parametrize(
    ("rate", "shown", "silent"),
    [
        (1000.0, ["axis1.motor"], ["d_1", "d_2"]),  # the tachometer's shaft, and the wave generator's
        (1000.0, ["axis1.motor", "axis1.harmonic_drive"], ["d_1"]),
        (10000.0, ["axis1.motor"], []),
    ],
)
def test_laws_of_a_twist_that_no_sample_shows_are_not_asked(
    rate: float, shown: Sequence[str], silent: Sequence[str]
) -> None:
    model, of = seen(shown, rate)
    shafts = {s.damping.factors[0][0]: f"axis1.{s.name}" for s in model.robot.joints[0].drive.shafts}
    asked = hypotheses(model.robot)
    left_out = {(c.effect, c.place.address) for c in asked} - {
        (c.effect, c.place.address) for c in that_show(model, of, asked)
    }
    assert {at for _, at in left_out} == {shafts[name] for name in silent}
    assert not {effect for effect, _ in left_out} & {"backlash", "kinematic_error", "load_dependent_friction"}
    assert all(("coulomb_friction", shafts[name]) in left_out for name in silent)


def test_a_stretch_is_where_most_moves() -> None:
    time = np.arange(100) * 1e-2
    y = np.where(time < 0.6, 1e-3, 1.0)[:, None] * np.sin(40.0 * time)[:, None]
    steps = np.append(np.full(99, 1e-2), np.nan)
    whole = Signals(time, y, y, np.zeros(1, np.int64), ("q",), steps, np.zeros(1), np.ones(1), np.ones(1))
    part = stretch(whole, 30)
    assert len(part.y) == 30
    assert part.time[0] >= 0.58
    assert np.isnan(part.steps[-1])
    assert np.all(np.isfinite(part.steps[:-1]))
    assert stretch(whole, 60) is whole  # hardly shorter
    np.testing.assert_array_equal(whole.steps[:-1], 1e-2)  # untouched
