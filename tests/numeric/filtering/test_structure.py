"""A shaft that explained what something else did is taken out again."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from symdyn.numeric.filtering.between import Between
from symdyn.numeric.filtering.diagnose import stiffened
from symdyn.numeric.filtering.explain import step
from symdyn.numeric.filtering.judged import explained
from symdyn.numeric.filtering.likelihood import fit
from symdyn.numeric.filtering.model import prepare, without_latent
from symdyn.numeric.filtering.stiff import resonance
from symdyn.numeric.filtering.structure import EFFECT, TITLE, with_shaft
from symdyn.numeric.filtering.telling import finding
from symdyn.numeric.findings import Finding
from symdyn.spec.records import Robot
from tests.numeric.filtering.drive import record


@pytest.mark.slow  # compiles the machine with a shaft in it, and without
def test_a_shaft_that_friction_explains_is_taken_out_again(robot: Robot, tmp_path: Path) -> None:
    runs = record(tmp_path / "1.csv", robot, 1, coulomb=0.03), record(tmp_path / "2.csv", robot, 2, coulomb=0.03)
    alarms: list[str] = []
    model = prepare(robot, *runs)
    bench = model.bench(model.training, without_latent(model, model.training), Between.HELD)
    given = explained(model, (), model.beliefs, fit(bench, model.values, model.beliefs))
    flexible, after = with_shaft(model.robot, model.robot.joints[0], (), (), given, runs, print)
    k, j_m, j_l = (after.fit.p[after.fit.bench.index[n]] for n in ("axis_transmission_stiffness", "J_m", "J_l"))
    free = math.sqrt(k * (1.0 / j_m + 1.0 / j_l)) / (2.0 * math.pi)
    assert resonance(flexible, after.fit, "axis", "axis.motor") == pytest.approx(free, rel=1e-9)
    told = Finding(EFFECT, TITLE, "axis", {}, given.heldout, after.heldout, 0.0, (), group=("axis", "axis.motor"))
    best, tried = step(flexible, after, alarms, print)
    assert best is not None
    friction = finding(flexible, after, best, tried)
    assert friction.effect == "coulomb_friction"
    assert stiffened(flexible, after, [told], alarms, runs, print)[2] == [told]  # nothing came after it
    rigid, current, findings = stiffened(flexible, best.after, [told, friction], alarms, runs, print)
    assert [f.effect for f in findings] == ["coulomb_friction"]
    assert set(findings[0].group) == {"axis", "axis.motor"}
    assert not rigid.freed
    assert rigid.kernel.coordinates == model.kernel.coordinates
    assert current.heldout == pytest.approx(best.after.heldout, rel=0.05)
    assert any(TITLE in alarm for alarm in alarms)
