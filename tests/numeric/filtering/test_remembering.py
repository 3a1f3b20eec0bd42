"""At which places laws with memory are asked, and when before all else."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from symdyn.compiler import load_robot
from symdyn.numeric.filtering import memory_fits, propose, remembering
from symdyn.numeric.filtering.hypotheses import HYSTERESIS, WARMING, memories
from symdyn.numeric.filtering.judged import Explanation, Step
from symdyn.numeric.filtering.memory import Lasting
from symdyn.numeric.filtering.model import Model
from symdyn.numeric.filtering.places import Latent
from symdyn.numeric.filtering.travel import Travel

SAMPLES = 5000
MODEL = cast(Model, SimpleNamespace(training=SimpleNamespace(y=np.zeros((SAMPLES, 1)))))
NOTHING = cast(Explanation, None)
PRICE = 10.0 + np.log(SAMPLES)
PRICE_OF_ONE = 0.5 * np.log(SAMPLES)


def loop(place: str, gain: float, beyond: float, laws: Any = HYSTERESIS) -> Lasting:
    return Lasting(Latent(place, np.ones(1), np.ones(1)), laws, gain, beyond, 0.1, (0.1,), (place,))


def asked(monkeypatch: pytest.MonkeyPatch, *found: Lasting, earns: str = "", best: Step | None = None) -> list[str]:
    """The places at which laws are fitted, of which those at ``earns`` earn theirs."""
    places: list[str] = []

    def with_memory(model: Model, current: Explanation, each: Lasting, least: float, *_: Any) -> Any:
        places.append(each.latent.place)
        assert least == pytest.approx(0.7 * (10.0 + (best.gain - PRICE_OF_ONE if best else 0.0)))
        return ((model, SimpleNamespace(place=each.latent.place, score=each)),)

    monkeypatch.setattr(remembering, "with_memory", with_memory)
    monkeypatch.setattr(remembering, "likelier", lambda laws, *_: tuple(x for x in laws if x[1].place == earns))
    monkeypatch.setattr(remembering, "simplest", lambda model, wide, tried: wide)
    laws = remembering.laws_with_memory(MODEL, NOTHING, best, found, cast(Any, ()), lambda _: None)
    assert [step.place for _, step in cast(Any, laws)] == ([earns] if earns else [])
    return places


def test_where_none_earns_its_place_the_next_place_is_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    found = loop("gear", 240.0, 160.0), loop("joint", 127.0, 127.0), loop("motor", 122.0, 121.0)
    assert asked(monkeypatch, *found) == ["gear", "joint"]
    assert asked(monkeypatch, *found, earns="gear") == ["gear"]
    assert asked(monkeypatch, *found, earns="joint") == ["gear", "joint"]


def test_each_kind_of_memory_is_asked_where_it_promises_most(monkeypatch: pytest.MonkeyPatch) -> None:
    warm = loop("gear", 500.0, 0.0, WARMING), loop("motor", 200.0, 50.0, WARMING)
    found = loop("gear", 240.0, 160.0), loop("joint", 127.0, 127.0), *warm
    assert asked(monkeypatch, *found) == ["gear", "motor", "joint"]  # a memory that tells nothing is not asked


def test_what_promises_less_than_half_of_an_effect_is_not_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    best = cast(Step, SimpleNamespace(gain=90.0, score=SimpleNamespace(gain=300.0, candidate=SimpleNamespace(size=1))))
    assert asked(monkeypatch, loop("gear", 160.0, 160.0), loop("joint", 140.0, 140.0), best=best) == ["gear"]


def test_a_promise_counts_from_its_price_on() -> None:
    few = loop("gear", 300.0, PRICE - 1.0)
    assert remembering.promised(MODEL, ()) == 0.0
    assert remembering.promised(MODEL, [few]) == 0.0
    assert remembering.promised(MODEL, [few, replace(few, beyond=PRICE + 1.0)]) == pytest.approx(PRICE + 1.0)


def test_a_machine_that_has_every_law_there_gets_none() -> None:
    robot = load_robot("irb6-axis1")
    model = cast(Model, SimpleNamespace(robot=robot))
    at_motor = loop("axis1.motor", 200.0, 200.0, {})
    assert memory_fits.with_memory(model, NOTHING, at_motor, 0.0, cast(Any, ()), lambda _: None) == ()


def test_others_are_compiled_only_where_the_simplest_law_is_worth_it(monkeypatch: pytest.MonkeyPatch) -> None:
    robot = load_robot("irb6-axis1")
    model = cast(Model, SimpleNamespace(robot=robot, training=SimpleNamespace(y=np.zeros((SAMPLES, 1)))))
    of = cast(Explanation, SimpleNamespace(found=(), fit=SimpleNamespace(loss=0.0)))
    told: list[str] = []
    fitted: list[tuple[str, float]] = []

    def rough(trial: Any, current: Any, kept: Any, law: Any, start: Any, speed: float, least: float, bare: Any) -> Any:
        """Dahl's loop brings 50 nats, and the others 60; all of them have their price."""
        fitted.append((law.effect, least))
        gain = 50.0 if law.effect == "dahl_friction" else 60.0
        names = {law.parameter(s): i for i, s in enumerate((*law.linear, *law.shapes))}
        done = SimpleNamespace(loss=-gain, p=np.ones(len(names)), bench=SimpleNamespace(index=names), beliefs={})
        return done if gain - memory_fits.price(model, law) >= least else None

    width = [3.0]
    monkeypatch.setattr(memory_fits, "travel", lambda *_: Travel(width[0], fastest=1.0, usual=1.0, stroke=1.0))
    monkeypatch.setattr(memory_fits, "prepare", lambda *_: model)
    monkeypatch.setattr(memory_fits, "_fitted", rough)
    monkeypatch.setattr(memory_fits, "explained", lambda own, found, beliefs, done: SimpleNamespace(fit=done))
    monkeypatch.setattr(memory_fits, "heldout_p_value", lambda *_: 0.0)

    def laws(least: float) -> list[str]:
        told.clear()
        fitted.clear()
        at_motor = loop("axis1.motor", 200.0, 200.0)
        found = memory_fits.with_memory(model, of, at_motor, least, cast(Any, ()), told.append)
        return [step.score.candidate.effect for _, step in found]

    worth = 50.0 - np.log(SAMPLES)
    assert laws(worth + 1.0) == []
    assert [name for name, _ in fitted] == ["dahl_friction"]
    assert len(told) == 2
    assert set(laws(worth - 1.0)) >= {"dahl_friction", "bouc_wen_hysteresis"}
    assert {least for _, least in fitted} == {worth - 1.0}
    assert len(told) == 6
    assert "hardening_hysteresis" not in [name for name, _ in fitted]
    width[0] = 0.5  # the loop of Bouc and Wen ends at a displacement of 1: it has no level that the motion shows
    assert "hardening_hysteresis" in laws(worth - 1.0)
    assert len(told) == 8


@pytest.mark.parametrize(("gain", "first"), [(None, True), (90.0, True), (110.0, False)])
def test_memory_comes_first_where_it_promises_more_than_the_best(
    monkeypatch: pytest.MonkeyPatch, gain: float | None, first: bool
) -> None:
    best = None if gain is None else cast(Step, SimpleNamespace(gain=gain))
    for late, expected in (((), first), ((99.0,), first), ((101.0,), False)):
        monkeypatch.setattr(propose, "late_sensors", lambda *_, late=late: [SimpleNamespace(gain=x) for x in late])
        assert propose.promises_most(MODEL, NOTHING, best, [loop("joint", 150.0, 100.0)]) is expected


@pytest.mark.parametrize(("stroke", "warms"), [(0.2, True), (4.0, False)])
def test_heat_that_is_gone_before_a_stroke_ends_is_none(
    monkeypatch: pytest.MonkeyPatch, stroke: float, warms: bool
) -> None:
    (law,) = memories(load_robot("irb6-axis1"), "axis1.motor", WARMING)
    names = {law.parameter(s): i for i, s in enumerate((*law.linear, *law.shapes))}
    numbers = {"coefficient": 0.01, "heat_capacity": 0.05, "thermal_resistance": 20.0}  # a second
    p = np.array([numbers[s.name] for s in (*law.linear, *law.shapes)])
    fit = SimpleNamespace(p=p, bench=SimpleNamespace(index=names))
    of = cast(Explanation, SimpleNamespace(found=((law, None),), fit=fit))
    model = cast(Model, SimpleNamespace(latents=(Latent("axis1.motor", np.ones(1), np.ones(1)),)))
    monkeypatch.setattr(remembering, "travel", lambda *_: Travel(1.0, 1.0, 1.0, stroke))
    assert remembering.warms_slowly(model, of) is warms
