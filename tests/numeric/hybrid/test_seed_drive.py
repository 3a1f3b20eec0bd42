"""The seed's drive with sticking, backlash and a saturated servo, against its equations written by hand and DOP853."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.drive.machine import seed_drive
from benchmarks.drive.reference import SINE, STEP, solve
from symdyn.numeric.hybrid.affine_simulation import simulate_affine
from symdyn.numeric.hybrid.general_simulation import simulate_general
from symdyn.numeric.hybrid.signals import Signal, sine, step
from symdyn.numeric.hybrid.trajectory import HybridTrajectory

CASES = pytest.mark.parametrize(
    ("case", "signal"),
    [pytest.param(STEP, step(1.0), id="step"), pytest.param(SINE, sine(1.0, 0.2), id="sine", marks=pytest.mark.slow)],
)


@CASES
def test_every_state_and_every_event_agrees_with_the_reference(case: tuple, signal: Signal) -> None:
    """All 1001 points of all nine states to 1e-9 of their size, and each change of friction and contact to 1e-9 s."""
    states, entered = solve(case)
    found = simulate_affine(seed_drive(), np.linspace(0.0, case[1], 1001), [signal])
    assert np.abs(found.states - states).max(axis=0) == pytest.approx(0.0, abs=1e-9 * np.abs(states).max())
    assert np.all(np.abs(found.states - states).max(axis=0) < 1e-9 * np.abs(states).max(axis=0))
    times = mechanical(found)
    assert len(times) == len(entered)
    assert np.allclose(times, [time for time, _ in entered], rtol=0.0, atol=1e-9)


@pytest.mark.slow  # compiles both methods
@CASES
def test_the_general_method_agrees_with_the_exact_one(case: tuple, signal: Signal) -> None:
    time = np.linspace(0.0, case[1], 501)
    exact = simulate_affine(seed_drive(), time, [signal])
    general = simulate_general(seed_drive(), time, [signal], tolerance=1e-9)
    assert np.all(np.abs(general.states - exact.states).max(axis=0) < 1e-7 * np.abs(exact.states).max(axis=0))
    assert [(e.switch, e.kind, e.after) for e in general.events] == [(e.switch, e.kind, e.after) for e in exact.events]


def mechanical(found: HybridTrajectory) -> list[float]:
    """Times at which friction or contact changes; an open contact that is still beyond its clearance is open."""
    return [
        e.time
        for e in found.events
        if e.kind != "limit" and not (e.kind == "contact" and abs(e.before) == 2 and e.after == 0)
    ]
