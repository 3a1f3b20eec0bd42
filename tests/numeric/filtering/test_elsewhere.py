"""Beyond a gear an effect has other numbers; where a recording would have it at either end, both are told."""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType

import pytest

from symdyn.compiler import robot_from_text
from symdyn.numeric.filtering.between import Between
from symdyn.numeric.filtering.elsewhere import with_elsewhere
from symdyn.numeric.filtering.explain import fitted
from symdyn.numeric.filtering.judged import Explanation, explained
from symdyn.numeric.filtering.likelihood import fit
from symdyn.numeric.filtering.model import Model, prepare, without_latent
from symdyn.numeric.filtering.score import scores
from symdyn.numeric.filtering.telling import finding
from symdyn.numeric.findings import Finding
from symdyn.numeric.recording import Recording
from symdyn.spec.records import Quantity, Side
from tests.numeric.filtering.soft_gear import RATIO, TOML, run

ARM = robot_from_text(TOML, "arm.toml")
PUSH = 0.004  # N m, at the motor
BOTH = ("arm", "arm.motor")
LABELS = tuple(f"{name} at {at}" for name in ("Coulomb friction", "constant force offset") for at in BOTH)


def pushed(seed: int) -> Recording:
    """A motor whose torque is less than was recorded, always by the same."""
    whole, key = run(seed), (Quantity.EFFORT, "arm", Side.MOTOR)
    return replace(whole, channels=MappingProxyType({**whole.channels, key: whole.channels[key] + PUSH}))


def found(effect: str, *runs: Recording) -> tuple[Model, Explanation, Finding]:
    """An effect at the arm, which is told as if it might as well be at the motor."""
    model = prepare(ARM, *runs, only=LABELS)
    bench = model.bench(model.training, without_latent(model, model.training), Between.HELD)
    none = explained(model, (), model.beliefs, fit(bench, model.values, model.beliefs))
    (law,) = (c for c in model.proposed if (c.effect, c.place.address) == (effect, "arm"))
    ranked = scores(bench, none.fit.p, tuple(none.beliefs), (law,))
    (step,) = fitted(model, none, ranked, lambda _: None)
    told = finding(model, none, step, (step,))
    return model, step.after, replace(told, group=BOTH)


def test_an_offset_has_its_numbers_at_both_ends_of_a_soft_gear() -> None:
    model, after, told = found("force_offset", pushed(1), pushed(2))
    values = with_elsewhere(model, after, told).elsewhere
    assert list(values) == ["arm.motor"]
    offset = values["arm.motor"]["offset"]
    assert offset.unit == "N m"
    assert offset.se is not None
    assert abs(offset.value - PUSH) < 3.0 * offset.se < 0.5 * PUSH
    assert offset.value == pytest.approx(told.parameters["offset"].value / RATIO, rel=0.2)


@pytest.mark.slow  # a whole diagnosis
def test_friction_of_the_arm_is_none_of_the_motor() -> None:
    """The gear between them shows: no number there would do as well."""
    model, after, told = found("coulomb_friction", run(1, dry=0.8), run(2, dry=0.8))
    assert told.parameters["level"].value == pytest.approx(0.8, rel=0.02)
    assert with_elsewhere(model, after, told).elsewhere == {}
    shaft = replace(told, effect="joint_compliance")  # a part that the machine got is where it is
    assert with_elsewhere(model, after, shaft) is shaft
