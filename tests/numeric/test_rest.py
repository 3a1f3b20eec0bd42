"""Standstills that are short and come often: what is counted beside them, and what is not."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from symdyn.compiler import robot_from_text
from symdyn.numeric.diagnose import diagnose
from symdyn.numeric.explanation import Case
from symdyn.numeric.position_spectrum import floor
from symdyn.numeric.recording import Recording
from symdyn.numeric.rest import TOUCHED, often_stands, resting
from symdyn.numeric.setting import Setting, prepare

from .pendulum import recording
from .slide import SLIDE

RATE, FINE, SECONDS = 500.0, 20, 20
MASS, VISCOUS, DRY = 2.1, 2.2, 12.0
STIFF, DAMPED = 2000.0, 30.0  # of the servo, in N/m and N s/m: too soft to turn back at once
STEP = 5e-5  # m, of the encoder


@cache
def softly_held(seed: int) -> Recording:
    """A slide that a soft servo leads, and that sticks some hundredths of a second wherever it turns back.

    Symplectic Euler, dry friction by projection: it sticks exactly.
    """
    rng = np.random.default_rng(seed)
    frequency = np.array([0.4, 0.9, 1.7, 2.6]) * (1.0 + 0.05 * rng.random(4))
    size, phase = np.array([0.08, 0.05, 0.03, 0.02]), rng.uniform(0.0, 2.0 * np.pi, 4)
    time = np.arange(int(SECONDS * RATE)) / RATE
    angle = 2.0 * np.pi * np.outer(time, frequency) + phase
    wanted, quickly = (size * np.sin(angle)).sum(axis=1), (size * 2.0 * np.pi * frequency * np.cos(angle)).sum(axis=1)
    x, v, h = float(wanted[0]), float(quickly[0]), 1.0 / RATE / FINE
    shown, pushed = np.zeros(len(time)), np.zeros(len(time))
    for k in range(len(time)):
        shown[k] = STEP * round(x / STEP)
        pushed[k] = STIFF * (wanted[k] - shown[k]) + DAMPED * (quickly[k] - v)
        for _ in range(FINE):
            v += h / MASS * (pushed[k] - VISCOUS * v)
            v = math.copysign(max(abs(v) - h / MASS * DRY, 0.0), v)
            x += h * v
    return recording(time, shown, pushed + 0.3 * rng.standard_normal(len(time)))


@cache
def setting() -> Setting:
    return prepare(robot_from_text(SLIDE, "slide.toml"), softly_held(1), softly_held(2), lambda _: None)


def case(sparing: bool) -> Case:
    held = setting().earlier(-0.5 / RATE)  # the servo holds its force over each sample
    return held.anew(sparing=sparing).case(20.0)


def test_of_a_joint_that_often_stands_for_a_moment_what_is_furthest_from_it_can_be_asked() -> None:
    assert np.all(case(False).bench.counted)
    bench = case(True).bench
    held = np.abs(bench.bring(resting(bench.observation).astype(float)))[:, 0]
    assert np.mean(held > TOUCHED) > 0.5
    assert often_stands(bench.observation, bench.bring)
    left_out = bench.counted[:, 0] == 0.0
    assert 0.45 < np.mean(left_out) <= 0.5
    assert np.min(held[left_out]) >= np.max(held[~left_out])


def test_dry_friction_that_sticks_at_every_reversal_is_told_as_it_is() -> None:
    """With all samples dry friction comes out 1 % too large, and viscous friction 8 % too small."""
    coulomb = next(c for c in setting().proposed if c.effect == "coulomb_friction")
    off = []
    for judged in (case(False), case(True)):
        told = judged.explain(((coulomb, ()),))
        model = judged.model_parameters(told)
        found = (
            judged.parameters(coulomb, told)["level"].value / DRY,
            model["b"].value / VISCOUS,
            model["m"].value / MASS,
        )
        off.append(np.abs(np.array(found) - 1.0))
    assert np.all(off[0] > (0.008, 0.05, 0.007))
    assert np.all(off[1] < (0.003, 0.03, 0.002))


@pytest.mark.slow  # a whole diagnosis
def test_a_joint_stands_though_its_motion_is_taken_below_the_steps_of_its_encoder() -> None:
    """Smoothed so far it hardly seems to: dry friction came out 2 % too small, and viscous friction 30 % too large."""
    observed = setting().below("arm", 34.0).case(34.0).bench.observation
    assert np.mean(resting(replace(observed, quick=None))) < 0.5 * np.mean(resting(observed))
    found = diagnose(robot_from_text(SLIDE, "slide.toml"), softly_held(1), softly_held(2))
    assert [f.effect for f in found.findings] == ["coulomb_friction", "encoder"]
    assert found.findings[0].parameters["level"].value == pytest.approx(DRY, rel=0.003)
    assert found.model["b"].value == pytest.approx(VISCOUS, rel=0.03)
    assert not found.remaining.structured


def test_a_coarse_encoder_is_not_asked_where_a_joint_stands_but_for_its_smoothed_motion() -> None:
    """Before it was smoothed its noise would hide most of the motion."""
    observed = setting().below("arm", 34.0).case(34.0).bench.observation
    steps = 1e-3 * np.round(observed.measured / 1e-3)
    coarse = replace(observed, noise=floor(steps, observed.segments, observed.rate))
    assert np.array_equal(resting(coarse), resting(replace(coarse, quick=None)))
