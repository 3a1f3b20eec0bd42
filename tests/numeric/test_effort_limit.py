"""A drive that gives less than it was asked for, up to a limit: named, and no limit where there is none."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.typing import NDArray

from symdyn.numeric.diagnose import diagnose
from symdyn.numeric.explanation import Explanation
from symdyn.numeric.inquiry import Inquiry
from symdyn.numeric.misread import Misread
from symdyn.numeric.recording import Recording
from symdyn.numeric.revision import revisions
from symdyn.numeric.setting import prepare

from .arm_of_two import HARMONICS
from .pendulum import ARM, GRAVITY, MASS, TURNING, VISCOUS, pendulum, record, recording

Array = NDArray[np.float64]


def swung(seed: int, limit: float, dry: float = 0.0) -> Recording:
    """A pendulum under a controller whose drive gives no more than a limit; what it asked for is recorded.

    ``dry`` is the level of its Coulomb friction.
    """
    rng = np.random.default_rng(seed)
    step, substeps = 1 / 500.0, 4
    weight, phase = rng.uniform(0.4, 1.0, 5), rng.uniform(0, 2 * np.pi, 5)
    weight *= 1.2 / weight.sum()
    q, v, rows = float(np.sin(phase) @ weight), 0.0, []
    for k in range(10_000):
        angle = HARMONICS * (k * step) + phase
        wanted, speed = float(np.sin(angle) @ weight), float(np.cos(angle) @ (weight * HARMONICS))
        asked = 60.0 * (wanted - q) + 6.0 * (speed - v)
        rows.append((q, asked))
        for _ in range(substeps):
            given = min(max(asked, -limit), limit)
            h = step / substeps
            given -= dry * math.tanh(v / 0.01)
            a = (given - VISCOUS * v - MASS * GRAVITY * ARM * math.cos(q)) / TURNING
            v_half = v + 0.5 * h * a
            q += h * v_half
            a = (given - VISCOUS * v_half - MASS * GRAVITY * ARM * math.cos(q)) / TURNING
            v = v_half + 0.5 * h * a
    shown = np.array(rows)
    noise = rng.standard_normal((2, len(shown)))
    # Held over the next sample: what the arm felt around an instant is the mean of two.
    effort = 0.5 * (np.clip(shown[:, 1], -9e9, 9e9) + np.concatenate([shown[:1, 1], shown[:-1, 1]]))
    return recording(np.arange(len(shown)) * step, shown[:, 0] + 5e-6 * noise[0], effort + 0.01 * noise[1])


# Reached in 25 % and in 90 % of the samples.
@pytest.mark.slow
@pytest.mark.parametrize("limit", [5.0, 3.5])
def test_a_drive_that_gives_less_than_asked_is_named(limit: float) -> None:
    found = diagnose(pendulum(), swung(1, limit), swung(2, limit))
    assert [f.effect for f in found.findings] == ["effort_saturation"]
    assert found.findings[0].parameters["limit"].value == pytest.approx(limit, rel=0.02)


@pytest.mark.slow
def test_a_limit_is_fitted_again_beside_the_friction_that_is_found_after_it() -> None:
    found = diagnose(pendulum(), swung(1, 6.0, 0.8), swung(2, 6.0, 0.8))
    assert [f.effect for f in found.findings] == ["effort_saturation", "coulomb_friction"]
    for finding, name, true in zip(found.findings, ("limit", "level"), (6.0, 0.8), strict=True):
        told = finding.parameters[name]
        assert told.se is not None
        assert abs(told.value - true) < 4.0 * told.se < 0.02 * true


@pytest.mark.slow
def test_a_limit_that_the_judging_run_does_not_reach_was_not_seen() -> None:
    """Pushes that were asked for and not given, in training alone: a limit there lets the parameters go where they
    belong, and so helps everywhere.
    """
    pushed = record(1, lambda t, q, v, a: 25.0 * (np.mod(t, 4.0) < 0.4))
    found = diagnose(pendulum(), pushed, record(2, amplitude=0.1))
    assert "effort_saturation" not in [f.effect for f in found.findings]
    there = diagnose(pendulum(), pushed, record(2, lambda t, q, v, a: 25.0 * (np.mod(t, 4.0) < 0.4)))
    assert "effort_saturation" in [f.effect for f in there.findings]


def test_what_a_limit_takes_off_the_residual_is_what_the_drive_does_not_give() -> None:
    setting = prepare(pendulum(), swung(1, 5.0, 0.5), swung(2, 5.0, 0.5), lambda _: None)
    case = setting.case(20.0)
    given = case.explain()
    inquiry = Inquiry(setting, case, given, setting, case, given)
    (limit,) = (r for r in revisions(setting) if isinstance(r, Misread) and r.what == "limit")
    for column, value in zip(limit.columns(inquiry), limit._limits(inquiry), strict=True):
        readings = (replace(setting.readings[0], limit=value),)
        limited = case.residual(replace(setting, readings=readings).training_laws(20.0), given)
        assert column[:, :, 0] == pytest.approx(given.training - limited, abs=1e-9)


def test_a_limit_that_most_efforts_are_beyond_is_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each fit has it go down, from half of the efforts on: where all but two in a hundred are beyond, it ends."""
    setting = prepare(pendulum(), record(1), record(2), lambda _: None)
    case = setting.case(setting.given())
    given = case.explain()
    inquiry = Inquiry(setting, case, given, setting, case, given)
    (limit,) = (r for r in revisions(setting) if isinstance(r, Misread) and r.what == "limit")
    efforts = np.abs(setting.seen.tau)
    limits = [float(np.quantile(efforts, beyond)) for beyond in (0.5, 0.4, 0.35, 0.3, 0.02, 0.0)]
    fits: list[float] = []

    def lower(self: Misread, inquiry: Inquiry, current: Explanation, value: float) -> SimpleNamespace:
        fits.append(value)
        step = limits[len(fits)] - value
        return SimpleNamespace(estimate=[step], standard_error=[1e-6], identifiable=[True])

    monkeypatch.setattr(Misread, "_joint_fit", lower)
    monkeypatch.setattr(Misread, "_stands", lambda self, setting: limits[0])
    assert limit.refitted(inquiry) is None
    assert fits == pytest.approx(limits[:4])
