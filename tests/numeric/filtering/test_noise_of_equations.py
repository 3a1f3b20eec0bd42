"""White noise of an equation: a little belongs to every step of a filter, more would be something that is missing."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from symdyn.numeric.filtering.between import Between
from symdyn.numeric.filtering.likelihood import fit
from symdyn.numeric.filtering.model import prepare, without_latent
from symdyn.spec.records import Robot
from tests.numeric.filtering.drive import record


def test_noise_of_an_equation_takes_up_no_force_that_is_missing(robot: Robot, tmp_path: Path) -> None:
    run = record(tmp_path / "a.csv", robot, 1, gusts=0.03)
    model = prepare(robot, run, run)
    noise = without_latent(model, model.training)
    most = noise.most[np.isfinite(noise.most)]
    assert len(most) == 1  # the joint's; the circuit's noise is that of its input

    bounded = fit(model.bench(model.training, noise, Between.HELD), model.values, model.beliefs, most=4)
    boundless = replace(noise, most=np.full_like(noise.most, np.inf))
    free = fit(model.bench(model.training, boundless, Between.HELD), model.values, model.beliefs, most=4)

    assert bounded.bench.noise.power[-1] <= most[0] * (1 + 1e-9)
    assert free.bench.noise.power[-1] > 10.0 * most[0]
    assert free.loss < bounded.loss - 100.0  # the gusts are in the recording, and have nowhere to go
