"""The last finding, too, is taken out again where all that was fitted since made it nothing."""

from __future__ import annotations

from pathlib import Path

import pytest

from symdyn.numeric.filtering.between import Between
from symdyn.numeric.filtering.diagnose import _reexamined
from symdyn.numeric.filtering.judged import Step, explained
from symdyn.numeric.filtering.likelihood import fit
from symdyn.numeric.filtering.model import candidate_beliefs, prepare, without_latent
from symdyn.numeric.filtering.score import scores
from symdyn.numeric.filtering.telling import finding
from symdyn.spec.records import Robot
from tests.numeric.filtering.drive import record

LEVEL = 0.03  # N m


@pytest.mark.parametrize("level", [0.0, pytest.param(LEVEL, marks=pytest.mark.slow)])
def test_a_last_finding_stays_if_there_is_something(robot: Robot, tmp_path: Path, level: float) -> None:
    runs = [record(tmp_path / f"{seed}.csv", robot, seed, coulomb=level) for seed in (1, 2)]
    model = prepare(robot, *runs, only=("Coulomb friction at axis",))
    bench = model.bench(model.training, without_latent(model, model.training), Between.HELD)
    given = explained(model, (), model.beliefs, fit(bench, model.values, model.beliefs))
    (friction,) = (c for c in model.proposed if c.effect == "coulomb_friction")
    (score,) = scores(bench, given.fit.p, tuple(model.beliefs), [friction], lambda _: None)
    beliefs = dict(model.beliefs) | candidate_beliefs(friction, None)
    after = explained(model, ((friction, None),), beliefs, fit(given.fit.bench, given.fit.p, beliefs))
    told = finding(model, given, Step(score, after, given.fit.loss - after.fit.loss, 0.0), ())

    alarms: list[str] = []
    current, findings = _reexamined(model, after, [told], alarms)
    if level:
        (kept,) = findings
        value, se = kept.parameters["level"].value, kept.parameters["level"].se
        assert se is not None
        assert abs(value - LEVEL) < 3.0 * se < LEVEL
        assert current.found == after.found
        assert not alarms
    else:
        assert findings == []
        assert current.found == ()
        assert alarms == [f"{friction.label} was taken out again: the others explain as much without it"]
