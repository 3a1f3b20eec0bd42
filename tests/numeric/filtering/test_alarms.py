"""Numbers of findings that no recording can tell, or did not, are warned of."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from symdyn.numeric.filtering.alarms import out_of_reach, reach, without_interval
from symdyn.numeric.filtering.between import Between
from symdyn.numeric.filtering.judged import Explanation, explained
from symdyn.numeric.filtering.likelihood import fit
from symdyn.numeric.filtering.model import Model, prepare, without_latent
from symdyn.numeric.filtering.travel import Travel
from symdyn.numeric.findings import Estimate, Finding
from symdyn.physics import catalogue
from symdyn.spec.records import Robot
from tests.numeric.filtering.drive import record

LAW = "Stribeck friction at axis"
AT = Travel(width=0.4, fastest=3.0, usual=2.0, stroke=0.5)


@pytest.fixture
def told(robot: Robot, tmp_path: Path) -> tuple[Model, Explanation, str]:
    """A Stribeck effect that somebody found at the axis of a drive, and the name of its characteristic speed."""
    runs = [record(tmp_path / f"{seed}.csv", robot, seed) for seed in (1, 2)]
    model = prepare(robot, *runs, only=(LAW,))
    bench = model.bench(model.training, without_latent(model, model.training), Between.HELD)
    given = explained(model, (), model.beliefs, fit(bench, model.values, model.beliefs, most=0))
    (law,) = (c for c in model.proposed if c.label == LAW)
    (speed,) = law.shapes
    return model, replace(given, found=((law, None),)), law.parameter(speed)


def with_speed(of: Explanation, name: str, value: float) -> Explanation:
    p = of.fit.p.copy()
    p[of.fit.bench.index[name]] = value
    return replace(of, fit=replace(of.fit, p=p))


def test_a_law_that_bends_beyond_all_motion_is_told(told: tuple[Model, Explanation, str]) -> None:
    model, found, speed = told
    assert out_of_reach(model, with_speed(found, speed, 0.05)) == []
    (alarm,) = out_of_reach(model, with_speed(found, speed, 1e4))
    assert alarm.startswith(f"stribeck_velocity of {LAW} is 1e+04 rad/s, and what occurs there ends at ")


def test_each_kind_of_number_has_its_own_reach() -> None:
    schemas = {s.name: s for law in ("lugre_friction", "bouc_wen_hysteresis") for s in catalogue()[law].parameters}
    assert reach(schemas["stribeck_velocity"], AT) == 3.0
    assert reach(schemas["yield_displacement"], AT) == 0.4
    assert reach(schemas["level"], AT) == float("inf")
    growth = next(s for s in catalogue()["hardening_hysteresis"].parameters if s.name == "displacement")
    assert reach(growth, AT) == 0.8


def test_a_finding_whose_numbers_nothing_told_is_warned_of() -> None:
    def finding(**se: float | None) -> Finding:
        numbers = {name: Estimate(1.5, error, "N m/rad") for name, error in se.items()}
        return Finding("joint_compliance", "compliance", "arm", numbers, 0.5, 0.1, 0.0, ())

    assert without_interval([finding(stiffness=0.1, damping=None)]) == []
    (alarm,) = without_interval([finding(stiffness=None, damping=None)])
    assert alarm.startswith(
        "compliance at arm: these recordings do not tell its stiffness (about 1.5 N m/rad), damping"
    )
