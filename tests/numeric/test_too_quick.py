"""An oscillator that its samples hardly follow: derivatives over them are no accelerations any more."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest

from symdyn.compiler import robot_from_text
from symdyn.numeric import diagnose as module
from symdyn.numeric.diagnose import diagnose
from symdyn.numeric.findings import Verdict
from symdyn.numeric.identify import identify
from symdyn.numeric.recording import Recording

from .pendulum import recording
from .slide import SLIDE

RATE = 600.0
FINE = 20  # steps of Runge and Kutta per sample
MASS, STIFFNESS, DAMPING = 1.0e-3, 1.0e-3 * (2.0 * math.pi * 40.0) ** 2, 0.02  # 15 samples per period, 8 % damped
HARDENING = 5.0e6  # N/m^3
SPRING = '\n[[effect]]\ntype = "linear_spring"\nat = "arm"\nstiffness = "k"\n'
MODEL = (
    SLIDE.replace("2.5 kg", "1.2 g").replace("1.5 N s/m", "0.025 N s/m").replace("[dh]", 'k = "50 N/m"\n\n[dh]')
    + SPRING
)


@cache
def shaken(seed: int, hardening: float = 0.0, highest: float = 120.0) -> Recording:
    """Forces held over each sample, and the position, of which a thousandth is noise."""
    rng = np.random.default_rng(seed)
    time = np.arange(3000) / RATE
    frequency = np.arange(1.0, highest, 0.4)
    force = np.cos(2.0 * np.pi * np.outer(time, frequency) + rng.uniform(0.0, 2.0 * np.pi, len(frequency))).sum(axis=1)
    force *= 0.1 / force.std()
    x, v, h, shown = 0.0, 0.0, 1.0 / RATE / FINE, []

    def pull(x: float, v: float, f: float) -> float:
        return (f - DAMPING * v - STIFFNESS * x - hardening * x**3) / MASS

    for f in force.tolist():
        shown.append(x)
        for _ in range(FINE):
            a = pull(x, v, f)
            b = pull(x + h / 2 * v, v + h / 2 * a, f)
            c = pull(x + h / 2 * (v + h / 2 * a), v + h / 2 * b, f)
            d = pull(x + h * (v + h / 2 * b), v + h * c, f)
            x, v = x + h * (v + h / 6 * (a + b + c)), v + h / 6 * (a + 2 * b + 2 * c + d)
    noisy = np.array(shown)
    noisy += 1e-3 * noisy.std() * rng.standard_normal(len(noisy))
    return recording(time, noisy, force)


@pytest.mark.slow  # a whole diagnosis
def test_a_complete_model_is_told_complete_and_its_numbers_are_right() -> None:
    told = diagnose(robot_from_text(MODEL, "oscillator.toml"), shaken(1), shaken(2))
    assert (told.verdict, told.findings) == (Verdict.COMPLETE, ())
    assert told.after.heldout < 0.01
    for name, true in {"m": MASS, "k": STIFFNESS, "b": DAMPING}.items():
        assert told.model[name].value == pytest.approx(true, rel=0.02)


@pytest.mark.slow
def test_what_is_lacking_is_found() -> None:
    told = diagnose(robot_from_text(MODEL, "oscillator.toml"), shaken(1, HARDENING), shaken(2, HARDENING))
    assert [f.effect for f in told.findings] == ["hardening_spring"]
    assert told.findings[0].parameters["stiffness"].value == pytest.approx(HARDENING, rel=0.02)


@pytest.mark.slow
def test_where_no_filter_can_follow_doubts_are_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """The mass is 10 % and more off by inverse dynamics; without the alarm nothing would show it."""
    monkeypatch.setattr(module, "can_follow", lambda robot: False)
    told = diagnose(robot_from_text(MODEL, "oscillator.toml"), shaken(1), shaken(2))
    assert abs(told.model["m"].value / MASS - 1.0) > 0.1
    assert any(a.startswith("arm moves too quickly for its samples: derivatives alone leave") for a in told.alarms)


def test_a_fit_by_inverse_dynamics_alone_tells_its_doubts_too() -> None:
    robot = robot_from_text(MODEL, "oscillator.toml")
    assert any("too quickly for its samples" in alarm for alarm in identify(robot, shaken(1)).alarms)
    slow = identify(robot, shaken(1, 0.0, 8.0), band=10.0)
    assert slow.alarms == ()
    assert slow.parameters["k"].value == pytest.approx(STIFFNESS, rel=0.01)


def test_what_a_motion_leaves_is_told_beside_noise_that_is_as_loud() -> None:
    """So much noise of positions that what derivatives leave is within it: the mass would be 6 % off."""
    seen = identify(robot_from_text(MODEL, "oscillator.toml"), shaken(1, HARDENING))
    assert any("derivatives alone leave 3 % of its effort" in alarm for alarm in seen.alarms)


def test_a_motion_that_is_hardly_looked_at_is_told() -> None:
    """So stiff that its motion goes up to half the rate: what is slow in it is differentiated, and is little."""
    chaotic = identify(robot_from_text(MODEL, "oscillator.toml"), shaken(1, 1.0e9, 200.0))
    assert [alarm.partition(" is quicker than")[0] for alarm in chaotic.alarms] == [
        "at least 86 % of the motion's power"
    ]
