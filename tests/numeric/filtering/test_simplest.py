"""Of a law and a special case of it, which is told."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from symdyn.numeric.filtering import judged
from symdyn.numeric.filtering.judged import Step, simplest
from symdyn.numeric.filtering.model import Model

SAMPLES, NOISE = 5000, 0.0286
MODEL = cast(Model, SimpleNamespace(training=SimpleNamespace(y=np.zeros((SAMPLES, 1)))))


def fitted(effect: str, size: int, gain: float, heldout: float, likelier: float = 0.0) -> Step:
    """An effect that gains so many nats, and ``likelier`` of them in each held-out sample."""
    rng = np.random.default_rng(size)
    score = likelier + 0.1 * rng.normal(size=SAMPLES)
    after = SimpleNamespace(heldout=heldout, score=score, off=heldout * np.ones((SAMPLES, 1)))
    candidate = SimpleNamespace(effect=effect, place="j1", size=size)
    return cast(Step, SimpleNamespace(score=SimpleNamespace(candidate=candidate), gain=gain, after=after))


def dahl(gain: float, heldout: float = 1.01 * NOISE) -> Step:
    return fitted("dahl_friction", 2, gain, heldout)


def lugre(gain: float, heldout: float = NOISE, likelier: float = 0.0) -> Step:
    return fitted("lugre_friction", 5, gain, heldout, likelier)


def chosen(monkeypatch: pytest.MonkeyPatch, wide: Step, less: Step) -> str:
    monkeypatch.setattr(judged, "floor", lambda *_: NOISE)
    monkeypatch.setattr(judged, "encompassing", lambda *_: (0.0, 1.0))  # free runs are as good in both
    return cast(Any, simplest(MODEL, wide, [less, wide])).score.candidate.effect


def test_at_the_noise_of_the_sensors_the_likelihood_decides(monkeypatch: pytest.MonkeyPatch) -> None:
    """LuGre's friction at the load of the seed's drive: 4552 nats, and Dahl's 2425, with free runs off by noise."""
    assert chosen(monkeypatch, lugre(4552.0, likelier=0.4), dahl(2425.0)) == "lugre_friction"


def test_where_the_wider_law_leaves_only_that_noise_too(monkeypatch: pytest.MonkeyPatch) -> None:
    """LuGre's friction at the motor of a rigid drive: free runs are off by 1.028 of the noise, and by 1.053."""
    wide, less = lugre(3993.0, 1.028 * NOISE, 0.4), dahl(2783.0, 1.053 * NOISE)
    assert chosen(monkeypatch, wide, less) == "lugre_friction"


@pytest.mark.parametrize(
    ("wide", "less"),
    [
        (lugre(4552.0, likelier=0.4), dahl(4200.0)),  # nearly as likely
        (lugre(4552.0), dahl(2425.0)),  # on the training data alone
        (lugre(4552.0, 1.19 * NOISE, 0.4), dahl(2425.0, 1.2 * NOISE)),  # free runs had room to tell
    ],
)
def test_else_the_simpler_law_is_told(monkeypatch: pytest.MonkeyPatch, wide: Step, less: Step) -> None:
    assert chosen(monkeypatch, wide, less) == "dahl_friction"


def test_what_earns_its_place_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    wide, less = lugre(2600.0, NOISE, 0.4), dahl(2425.0, 1.2 * NOISE)
    assert chosen(monkeypatch, wide, less) == "lugre_friction"


def test_a_correction_that_reaches_as_far_as_the_motion_is_the_law_that_it_corrects(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Coulomb friction at the load of the seed's drive, whose model has some at the motor: 59 nats of steps."""
    stribeck, coulomb = (
        fitted("stribeck_friction", 2, 5847.2, NOISE, 0.01),
        fitted("coulomb_friction", 1, 5788.3, NOISE),
    )
    assert chosen(monkeypatch, stribeck, coulomb) == "coulomb_friction"
    viscous = fitted("viscous_friction", 1, 5788.3, NOISE)
    assert chosen(monkeypatch, fitted("asymmetric_viscous_friction", 1, 5847.2, NOISE), viscous) != "viscous_friction"
