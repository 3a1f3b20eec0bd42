"""White noise of an equation: a little belongs to every step of a filter, more would be something that is missing."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from symdyn.numeric.filtering.likelihood import fit
from symdyn.numeric.filtering.model import prepare, without_latent
from symdyn.numeric.filtering.noise_step import LONGEST, _within
from symdyn.spec.records import Robot
from tests.numeric.filtering.drive import record


def test_noise_of_an_equation_takes_up_no_force_that_is_missing(robot: Robot, tmp_path: Path) -> None:
    run = record(tmp_path / "a.csv", robot, 1, gusts=0.03)
    model = prepare(robot, run, run)
    noise = without_latent(model, model.training)
    most = noise.most[np.isfinite(noise.most)]
    assert len(most) == 1  # the joint's; the circuit's noise is that of its input

    bounded = fit(model.bench(model.training, noise, True), model.values, model.beliefs, most=4)
    boundless = replace(noise, most=np.full_like(noise.most, np.inf))
    free = fit(model.bench(model.training, boundless, True), model.values, model.beliefs, most=4)

    assert bounded.bench.noise.power[-1] <= most[0] * (1 + 1e-9)
    assert free.bench.noise.power[-1] > 10.0 * most[0]
    assert free.loss < bounded.loss - 100.0  # the gusts are in the recording, and have nowhere to go


def test_a_step_of_noise_that_meets_its_longest_leads_downhill() -> None:
    """Variances make up for each other, and for a decay that may not go as far: the free step, cut off, rises."""
    root = np.array([[1.45, 0.0, 0.0], [-0.83, 1.07, 0.0], [-0.07, 0.07, 0.02]])
    sides, slope = root @ root.T, np.array([0.29, 0.03, 0.55])
    limits = np.full(3, -50.0), np.full(3, 50.0)

    def promised(step: np.ndarray) -> float:
        return float(slope @ step + 0.5 * step @ sides @ step)

    cut_off = np.clip(-np.linalg.solve(sides, slope), -LONGEST, LONGEST)
    step = _within(sides, slope, *limits)
    assert promised(cut_off) > 0.0 > promised(step)
    assert np.all(np.abs(step) <= LONGEST)
    grid = np.stack(np.meshgrid(*[np.linspace(-LONGEST, LONGEST, 41)] * 3), axis=-1).reshape(-1, 3)
    assert promised(step) <= min(promised(each) for each in grid)
    below = _within(sides, slope, np.array([-0.5, 0.0, -1.0]), np.array([0.0, 0.5, 1.0]))
    assert np.all((below >= [-0.5, 0.0, -1.0]) & (below <= [0.0, 0.5, 1.0]))
