"""What the steps of a filter do to a fit."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from symdyn.compiler import robot_from_text
from symdyn.numeric.filtering.between import Between
from symdyn.numeric.filtering.discretisation import FINER, REST, with_discretisation
from symdyn.numeric.filtering.likelihood import fit
from symdyn.numeric.filtering.model import prepare, without_latent
from tests.numeric.filtering.drive import MODEL, record

DRY = """[[effect]]
type = "coulomb_friction"
at = "axis"
level = "0.03 N m"

[recording]
"""


@pytest.mark.slow
def test_an_interval_counts_what_finer_steps_would_change(tmp_path: Path) -> None:
    robot = robot_from_text(MODEL.replace("[recording]\n", DRY), "dry.toml")
    run = record(tmp_path / "a.csv", robot, 1, coulomb=0.03)
    model = prepare(robot, run, run)
    bench = model.bench(model.training, without_latent(model, model.training), Between.HELD)
    told = with_discretisation(fit(bench, model.values, model.beliefs, settled=1e-4))
    finer = fit(told.bench.in_steps(FINER), told.p, model.beliefs, settled=1e-4)

    assert told.discretisation is not None
    change = (finer.p - told.p)[[bench.index[name] for name in told.names]]
    random = np.sqrt(np.diag(replace(told, discretisation=None).covariance))
    assert np.max(np.abs(change) / random) > 0.1  # there is something to tell
    assert np.max(np.abs(told.discretisation / REST - change) / random) < 0.01  # however far that fit is taken
    assert np.diag(told.covariance) == pytest.approx(random**2 + told.discretisation**2, rel=1e-9)
