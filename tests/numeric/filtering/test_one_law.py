"""Two effects on one drive give way to a law of fewer numbers that does what both do, and to no other."""

from __future__ import annotations

from pathlib import Path

import pytest

from symdyn.numeric.filtering.between import Between
from symdyn.numeric.filtering.explain import fitted
from symdyn.numeric.filtering.judged import Explanation, explained
from symdyn.numeric.filtering.likelihood import fit
from symdyn.numeric.filtering.model import Model, prepare, without_latent
from symdyn.numeric.filtering.one_law import in_one_law
from symdyn.numeric.filtering.score import scores
from symdyn.numeric.filtering.telling import finding
from symdyn.numeric.findings import Finding
from symdyn.spec.records import Robot
from tests.numeric.filtering.drive import record

HARDENING = 5e-4  # N m/rad^3
TOLD = ("linear_spring", "unbalance")


def quiet(_: str) -> None:
    return None


def told_as_two(robot: Robot, folder: Path, **concealed: float) -> tuple[Model, Explanation, list[Finding]]:
    """What a drive lacks, told as a linear spring and an unbalance."""
    runs = [record(folder / f"{seed}.csv", robot, seed, **concealed) for seed in (1, 2)]
    asked = ("linear spring at axis", "unbalance at axis", "hardening spring at axis")
    model = prepare(robot, *runs, only=asked)
    bench = model.bench(model.training, without_latent(model, model.training), Between.HELD)
    current = explained(model, (), model.beliefs, fit(bench, model.values, model.beliefs))
    findings = []
    for effect in TOLD:
        (law,) = (c for c in model.proposed if c.effect == effect)
        ranked = scores(current.fit.bench, current.fit.p, tuple(current.beliefs), [law])
        (step,) = fitted(model, current, ranked, quiet)
        findings.append(finding(model, current, step, ()))
        current = step.after
    return model, current, findings


@pytest.mark.slow  # a whole diagnosis
def test_a_spring_and_an_unbalance_that_look_like_a_hardening_spring_are_one(robot: Robot, tmp_path: Path) -> None:
    model, current, findings = told_as_two(robot, tmp_path, hardening=HARDENING)
    after, (one,), merged = in_one_law(model, current, findings, quiet)
    assert merged
    assert [c.effect for c, _ in after.found] == [one.effect] == ["hardening_spring"]
    stiffness = one.parameters["stiffness"]
    assert stiffness.se is not None
    assert (
        abs(stiffness.value - HARDENING) < 4.0 * stiffness.se < 0.25 * HARDENING
    )  # the scale of all forces is as doubtful
    assert after.fit.loss < current.fit.loss + 20.0
    assert one.heldout_after == after.heldout < 0.1 * one.heldout_before
    assert one.p_value < 1e-6


def test_two_effects_stay_two(robot: Robot, tmp_path: Path) -> None:
    model, current, findings = told_as_two(robot, tmp_path, spring=0.004, unbalance=0.03)
    after, same, merged = in_one_law(model, current, findings, quiet)
    assert not merged
    assert after is current
    assert same == findings
    assert tuple(f.effect for f in same) == TOLD
