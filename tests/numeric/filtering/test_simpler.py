"""A law that tells no more than one that it contains gives way to it."""

from __future__ import annotations

from pathlib import Path

import pytest

from symdyn.numeric.filtering.between import Between
from symdyn.numeric.filtering.explain import fitted
from symdyn.numeric.filtering.judged import Explanation, explained
from symdyn.numeric.filtering.likelihood import fit
from symdyn.numeric.filtering.model import Model, prepare, without_latent
from symdyn.numeric.filtering.score import scores
from symdyn.numeric.filtering.simpler import simpler
from symdyn.spec.records import Robot
from tests.numeric.filtering.drive import record

PUSH, SPRING = 0.02, 0.004


def quiet(_: str) -> None:
    return None


def as_a_spring(robot: Robot, folder: Path, **concealed: float) -> tuple[Model, Explanation]:
    """What a drive lacks, told as a linear spring."""
    runs = [record(folder / f"{seed}.csv", robot, seed, **concealed) for seed in (1, 2)]
    model = prepare(robot, *runs, only=("linear spring at axis", "constant force offset at axis"))
    bench = model.bench(model.training, without_latent(model, model.training), Between.HELD)
    none = explained(model, (), model.beliefs, fit(bench, model.values, model.beliefs))
    spring = [c for c in model.proposed if c.effect == "linear_spring"]
    (step,) = fitted(model, none, scores(bench, none.fit.p, tuple(none.beliefs), spring), quiet)
    return model, step.after


def test_a_push_that_was_told_as_a_spring_is_an_offset(robot: Robot, tmp_path: Path) -> None:
    model, spring = as_a_spring(robot, tmp_path, push=PUSH)
    instead = simpler(model, spring, spring.found[0], quiet)
    assert instead is not None
    without, offset = instead
    assert without.found == ()
    assert [candidate.effect for candidate, _ in offset.after.found] == ["force_offset"]
    (schema,) = offset.score.candidate.linear
    value = offset.after.fit.p[offset.after.fit.bench.index[offset.score.candidate.parameter(schema)]]
    assert abs(value) == pytest.approx(PUSH, rel=0.1)
    assert offset.after.heldout < 0.2 * without.heldout


@pytest.mark.parametrize("push", [0.0, PUSH])
def test_a_spring_stays_one(robot: Robot, tmp_path: Path, push: float) -> None:
    model, spring = as_a_spring(robot, tmp_path, spring=SPRING, push=push)
    assert simpler(model, spring, spring.found[0], quiet) is None
