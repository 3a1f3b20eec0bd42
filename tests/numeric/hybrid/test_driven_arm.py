"""An arm with two whole drives and servo loops, 18 states, against scipy's DOP853 with events."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.drive.arms import driven_arm
from benchmarks.drive.event_solver import EventSolver
from benchmarks.drive.measure import error
from symdyn.numeric.hybrid.general_simulation import simulate_general
from symdyn.numeric.hybrid.signals import step


@pytest.mark.slow
def test_states_and_events_agree_with_another_integrator() -> None:
    machine, time = driven_arm(), np.linspace(0.0, 0.1, 101)
    reference = np.ones(2)
    solver = EventSolver(machine.kernel.module, lambda t: reference, "DOP853", 1e-9)
    states = solver.travel(np.zeros(len(machine.kernel.states)), time)
    found = simulate_general(machine, time, [step(1.0), step(1.0)], tolerance=1e-8)
    assert error(found.states, states) < 5e-7
    assert len(found.events) == solver.events == 19  # friction, contacts, limits
