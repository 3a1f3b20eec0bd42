"""Several waves at one joint: each is told by its order, and one whose size changes stays one."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from symdyn.faces.report.sections import _symbols
from symdyn.numeric.diagnose import diagnose
from symdyn.numeric.findings import Finding, Verdict
from symdyn.numeric.kinship import ready
from symdyn.numeric.setting import prepare

from .pendulum import pendulum, record

Array = NDArray[np.float64]
RIPPLE = "torque_ripple"
WAVES = {20.0: 0.25, 33.0: 0.15}  # N m, by their order


def told(finding: Finding) -> tuple[float, float]:
    values = {name: estimate.value for name, estimate in finding.parameters.items()}
    return values["order"], math.hypot(values["cosine"], values["sine"])


@pytest.mark.slow  # a whole diagnosis
def test_waves_of_two_orders_are_told_each_by_its_own() -> None:
    def missing(t: Array, q: Array, v: Array, a: Array) -> Array:
        return 0.3 * np.sign(v) - sum(size * np.sin(order * q + order) for order, size in WAVES.items())

    found = diagnose(pendulum(), record(1, missing), record(101, missing))
    assert found.verdict is Verdict.MISSING_PHYSICS
    assert not found.remaining.structured
    waves = [f for f in found.findings if f.effect == RIPPLE]
    assert {f.effect for f in found.findings} == {"coulomb_friction", RIPPLE}
    assert sorted(map(told, waves)) == [pytest.approx(item, rel=0.02) for item in WAVES.items()]
    assert [f.number for f in waves] == [1, 2]
    assert "no. 2" in waves[1].title
    assert waves[0].heldout_gain > waves[1].heldout_gain > 0.0

    values = {p.name: p.value for p in found.diagnosed.parameters}
    for wave in waves:  # each in a block of its own
        order = _symbols(wave, found)["order"]
        assert values[order.name] == pytest.approx(wave.parameters["order"].value)
    assert len({_symbols(wave, found)["order"].latex for wave in waves}) == len(waves)
    assert sum(e.type == RIPPLE for e in found.diagnosed.effects) == len(waves)
    assert found.diagnosed.text.count(f'type = "{RIPPLE}"') == len(waves)


@pytest.mark.slow
def test_a_wave_whose_size_is_not_the_same_everywhere_is_no_two_waves() -> None:
    """It is several, whose orders the travel does not tell apart."""

    def missing(t: Array, q: Array, v: Array, a: Array) -> Array:
        return -0.25 * (1.0 + 0.9 * np.sin(q)) * np.sin(30.0 * q)

    found = diagnose(pendulum(), record(1, missing), record(101, missing))
    (wave,) = (f for f in found.findings if f.effect == RIPPLE)
    assert wave.parameters["order"].value == pytest.approx(30.0, abs=0.5)
    assert any("may be the one that was found" in alarm for alarm in found.alarms)
    assert found.remaining.structured


def test_after_a_wave_that_was_found_the_next_is_asked_and_nothing_else_twice() -> None:
    setting = prepare(pendulum(), record(1), record(101), lambda _: None)
    once = ready(setting.proposed, setting.robot, frozenset())
    assert {c.number for c in once} == {1}
    found = frozenset({("coulomb_friction", "arm", 1), (RIPPLE, "arm", 1), (RIPPLE, "arm", 3)})
    twice = ready(setting.proposed, setting.robot, found)
    assert {(c.effect, c.number) for c in twice if c.effect in ("coulomb_friction", RIPPLE)} == {(RIPPLE, 4)}
    names = {c.parameter(c.shapes[0]) for each in (once, twice) for c in each if c.effect == RIPPLE}
    assert names == {"arm_torque_ripple_order", "arm_torque_ripple_order_4"}
