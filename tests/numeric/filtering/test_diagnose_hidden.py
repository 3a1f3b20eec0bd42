"""Concealed effects in a drive of which the load is not measured."""

from __future__ import annotations

from pathlib import Path

import pytest

from symdyn.numeric.diagnose import diagnose
from symdyn.numeric.findings import Diagnosis, Verdict
from symdyn.spec.records import Robot
from tests.numeric.filtering.drive import J_L, J_M, record


def diagnosed(robot: Robot, folder: Path, **concealed: float) -> Diagnosis:
    runs = [record(folder / f"{seed}.csv", robot, seed, **concealed) for seed in (1, 2)]
    return diagnose(robot, *runs)


def test_nothing_missing_is_complete(robot: Robot, tmp_path: Path) -> None:
    found = diagnosed(robot, tmp_path)
    assert found.verdict is Verdict.COMPLETE
    assert not found.findings
    assert not found.located
    assert found.noise_floor is not None
    assert found.after.heldout < 1.1 * found.noise_floor.errors.heldout
    assert found.model["R"].value == pytest.approx(1.6, rel=0.01)  # the model said 1.8


def test_coulomb_friction_is_named_placed_and_written_down(robot: Robot, tmp_path: Path) -> None:
    found = diagnosed(robot, tmp_path, coulomb=0.03)
    assert [f.effect for f in found.findings] == ["coulomb_friction"]
    (finding,) = found.findings
    assert set(finding.group) == {"axis", "axis.motor"}  # rigid to each other
    level, se = finding.parameters["level"].value, finding.parameters["level"].se
    # the torque constant is only known as well as the model says: friction in units of the inertia is told sharply
    inertia = found.model["J_m"].value + found.model["J_l"].value
    assert level / inertia == pytest.approx(0.03 / (J_M + J_L), rel=0.03)
    assert se is not None
    assert abs(level - 0.03) < 3.0 * se
    assert finding.evidence > 100.0
    assert found.located[0].place == "axis"
    assert found.after.heldout < 0.5 * found.before.heldout
    assert 'type = "coulomb_friction"' in found.diagnosed.text


@pytest.mark.slow  # compiles the machine with a shaft in it
def test_a_transmission_taken_for_rigid_gets_its_shaft(robot: Robot, tmp_path: Path) -> None:
    found = diagnosed(robot, tmp_path, stiffness=1.0)
    assert [f.effect for f in found.findings] == ["joint_compliance"]
    stiffness = found.findings[0].parameters["stiffness"]
    assert stiffness.se is not None
    assert abs(stiffness.value - 1.0) < 3.0 * stiffness.se
    drive = found.diagnosed.joints[0].drive
    assert drive is not None
    assert not drive.rotors[0].fixed_to_joint
    assert [s.name for s in drive.shafts] == ["transmission"]
