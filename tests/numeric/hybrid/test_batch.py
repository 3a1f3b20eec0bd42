"""Batches of simulations: the numbers of each are those it has alone, and failures stay where they are."""

from __future__ import annotations

from dataclasses import replace

import numba
import numpy as np
import pytest

from benchmarks.drive.machine import seed_drive
from symdyn.base.errors import InputError
from symdyn.numeric.hybrid.affine_simulation import simulate_affine
from symdyn.numeric.hybrid.batch import simulate_batch
from symdyn.numeric.hybrid.general_simulation import simulate_general
from symdyn.numeric.hybrid.signals import constant, sine, step

from .machines import COULOMB, SLIDER, SPRING, effect, machine

TIME = np.linspace(0.0, 0.2, 21)


@pytest.mark.slow
def test_sets_of_parameters_give_what_each_gives_alone_bit_by_bit() -> None:
    drive = seed_drive()
    spread = 1.0 + 0.2 * np.random.default_rng(1).uniform(-1.0, 1.0, (7, len(drive.kernel.parameters)))
    parameters = drive.kernel.values * spread
    batch = simulate_batch(drive, TIME, [step(1.0, at=0.0133)], parameters=parameters)
    assert batch.failures == ("",) * 7
    for k, p in enumerate(parameters):
        alone = simulate_affine(replace(drive, p=p), TIME, [step(1.0, at=0.0133)])
        assert np.array_equal(alone.states, batch.states[k])
        assert (len(alone.events), alone.steps) == (batch.events[k], batch.steps[k])
    assert len(set(batch.states[:, -1, 1])) == 7
    assert batch.events.min() > 5


@pytest.mark.slow  # compiles the parallel loop
def test_numbers_do_not_depend_on_threads_or_chunks(monkeypatch: pytest.MonkeyPatch) -> None:
    drive = seed_drive()
    starts = np.random.default_rng(2).normal(0.0, 0.05, (9, len(drive.kernel.states)))
    many = simulate_batch(drive, TIME, [constant(0.5)], starts=starts)
    threads = numba.get_num_threads()
    monkeypatch.setattr("symdyn.numeric.hybrid.batch.CHUNK", 4)
    done: list[tuple[int, int]] = []
    numba.set_num_threads(1)
    try:
        one = simulate_batch(
            drive, TIME, [constant(0.5)], starts=starts, progress=lambda now, of: done.append((now, of))
        )
    finally:
        numba.set_num_threads(threads)
    assert np.array_equal(many.states, one.states)
    assert np.array_equal(many.events, one.events)
    assert done == [(4, 9), (8, 9), (9, 9)]


@pytest.mark.slow  # compiles the parallel loop
def test_inputs_may_differ_between_sets() -> None:
    slider = machine(SLIDER + COULOMB)
    inputs = [[sine(a, f)] for a, f in ((2.9, 5.0), (3.5, 5.0), (9.0, 7.0))]
    batch = simulate_batch(slider, TIME, inputs)
    assert np.all(batch.states[0] == 0.0)
    for k, signals in enumerate(inputs):
        assert np.array_equal(batch.states[k], simulate_affine(slider, TIME, signals).states)


@pytest.mark.slow  # compiles the parallel loop
def test_what_fails_says_so_and_leaves_the_others_alone() -> None:
    spring = machine(SLIDER + SPRING)
    time = np.linspace(0.0, 100.0, 201)
    values = spring.kernel.values
    stiff = np.flatnonzero(values == 18.0)
    parameters = np.tile(values, (4, 1))
    parameters[1, stiff], parameters[2, stiff] = -1e4, np.nan
    parameters[3, np.flatnonzero(values == 2.0)] = 0.0  # no mass
    start = np.array([[1.0, 0.0]] * 4)
    batch = simulate_batch(spring, time, [constant(0.0)], parameters=parameters, starts=start)
    assert batch.failures == ("", *["the state left the finite numbers"] * 3)
    assert np.allclose(batch.states[0, :, 0], np.cos(3.0 * time), atol=1e-9)
    assert np.all(np.isfinite(batch.states[1, 1]))
    assert np.all(np.isnan(batch.states[1:, -1]))


@pytest.mark.parametrize(
    "wrong",
    [{"parameters": np.zeros((2, 3))}, {"starts": np.zeros((2, 5))}, {"signals": [[constant(0.0)], [step(1.0, 0.1)]]},
     {"signals": [[constant(0.0)], [sine(1.0, 1.0)]]}, {"signals": [[constant(0.0)]] * 2, "starts": np.zeros((3, 2))},
     {"signals": []}],
)  # fmt: skip
def test_sets_that_do_not_fit_are_refused(wrong: dict) -> None:
    with pytest.raises(InputError, match="SD302"):
        simulate_batch(machine(SLIDER), TIME, **{"signals": [constant(0.0)], **wrong})


PENDULUM = """
[robot]
name = "pendulum"
gravity = [0, -9.81, 0]
[dh]
rows = [["q", 0, 1, 0]]
[[joint]]
name = "pivot"
link = { mass = 1, com = [0, 0, 0] }
"""


@pytest.mark.slow
def test_machines_that_are_not_affine_are_simulated_side_by_side() -> None:
    """Starts and inputs may differ; a set that fails says so, and the others are as they are alone."""
    swing = machine(PENDULUM + effect("coulomb_friction", "pivot", level=0.5))
    starts = np.array([[0.3, 0.0], [1.0, 0.0], [0.0, 1e200], [-2.0, 0.4]])
    inputs = [[sine(a, 1.0)] for a in (0.0, 3.0, 0.0, 9.0)]
    done: list[tuple[int, int]] = []
    batch = simulate_batch(swing, TIME, inputs, starts=starts, progress=lambda now, of: done.append((now, of)))
    assert done == [(k, 4) for k in (1, 2, 3, 4)]
    for k in (0, 1, 3):
        alone = simulate_general(swing, TIME, inputs[k], start=starts[k])
        assert np.array_equal(alone.states, batch.states[k])
        assert (len(alone.events), alone.steps, "") == (batch.events[k], batch.steps[k], batch.failures[k])
    assert batch.failures[2]
    assert np.all(np.isnan(batch.states[2]))


def test_numbers_that_stand_in_the_code_cannot_be_given() -> None:
    swing = machine(PENDULUM)
    with pytest.raises(InputError, match="SD302: this machine is not affine: its code holds its numbers"):
        simulate_batch(swing, TIME, [constant(0.0)], parameters=swing.kernel.values[None])
