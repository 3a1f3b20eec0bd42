"""What an unknown force hides is asked without it, also where nothing earned its place beside the force."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from symdyn.numeric.filtering import afresh
from symdyn.numeric.filtering.judged import Step

MODEL: Any = SimpleNamespace(training=SimpleNamespace(y=np.zeros((1000, 1))))
CURRENT: Any = SimpleNamespace(fit=SimpleNamespace(loss=0.0))


def fitted(gain: float, size: int = 1, place: str = "j1", error: float = 1.0) -> Step:
    score: Any = SimpleNamespace(candidate=SimpleNamespace(size=size, place=place))
    after: Any = SimpleNamespace(fit=SimpleNamespace(loss=-gain), alone=False, heldout=error)
    return Step(score, after, gain, 1.0)


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[Step]:
    """Steps that were fitted without the force: each gains ten times as much there, which earns it its place."""
    steps: list[Step] = []

    def let_go(_: Any, __: Any, step: Step) -> Step:
        steps.append(step)
        alone: Any = SimpleNamespace(fit=SimpleNamespace(loss=-10.0 * step.gain), alone=True)
        return replace(step, after=alone, gain=10.0 * step.gain)

    def that_earns(_: Any, __: Any, tried: tuple[Step, ...], ___: Any) -> Step | None:
        done = [s for s in tried if cast("Any", s.after).alone]
        return max(done, key=lambda s: s.gain, default=None)

    monkeypatch.setattr(afresh, "_let_go", let_go)
    monkeypatch.setattr(afresh, "that_earns", that_earns)
    return steps


def test_what_was_worth_its_price_is_asked_without_the_force(asked: list[Step]) -> None:
    good, near, poor = fitted(200.0), fitted(150.0), fitted(1.0)
    best, tried = afresh.unburdened(MODEL, CURRENT, None, (poor, near, good), [])
    assert best is not None
    assert best.gain == 2000.0
    assert asked == [good, near]
    assert [s.gain for s in tried] == [1.0, 1500.0, 2000.0]


def test_what_is_not_worth_its_price_is_not_asked(asked: list[Step]) -> None:
    poor = fitted(1.0)
    assert afresh.unburdened(MODEL, CURRENT, None, (poor,), []) == (None, (poor,))
    assert asked == []


def test_the_best_of_all_is_asked_first(asked: list[Step]) -> None:
    best, other = fitted(100.0), fitted(300.0)
    chosen, _ = afresh.unburdened(MODEL, CURRENT, best, (best, other), [])
    assert asked == [best, other]
    assert chosen is not None
    assert chosen.gain == 3000.0


@pytest.mark.parametrize(
    ("size", "place", "error", "hidden"),
    [(1, "j1", 1.0, True), (2, "j1", 1.0, False), (1, "j2", 1.0, False), (1, "j1", 1.1, False)],
)
def test_fewer_numbers_with_free_runs_as_good_are_asked_without_the_force(
    asked: list[Step], monkeypatch: pytest.MonkeyPatch, size: int, place: str, error: float, hidden: bool
) -> None:
    """An unbalance beside a force that hides it, and a ripple of one wave per turn that let go by itself."""
    within = afresh._let_go
    monkeypatch.setattr(afresh, "_let_go", lambda m, c, s: s if s is ripple else within(m, c, s))
    monkeypatch.setattr(afresh, "improves", lambda before, after: before.heldout > 1.03 * after.heldout)
    ripple, unbalance = fitted(3000.0, size=2), fitted(600.0, size, place, error)
    chosen, _ = afresh.unburdened(MODEL, CURRENT, ripple, (ripple, unbalance), [])
    assert asked == ([unbalance] if hidden else [])
    assert chosen is not None
    assert chosen.score is (unbalance if hidden else ripple).score
