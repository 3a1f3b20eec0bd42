"""A designed motion on the hand-written plant: it tells apart what a motion of the same limits does not."""

from __future__ import annotations

from pathlib import Path
from types import MappingProxyType

import numpy as np
import pytest

from symdyn.compiler import load_robot, robot_from_text
from symdyn.numeric.band import band_of
from symdyn.numeric.diagnose import diagnose
from symdyn.numeric.experiment.design import SEPARATES, design
from symdyn.numeric.experiment.explanations import Explained, best_refit, explained
from symdyn.numeric.experiment.limits import JointLimits, Limits
from symdyn.numeric.experiment.motions import Family, Motion
from symdyn.numeric.experiment.separation import Noise
from symdyn.numeric.observation import observe
from symdyn.numeric.recording import Recording
from symdyn.numeric.workbench import Workbench
from symdyn.spec.records import Quantity, Side

from .test_two_link_plant import DEMO, plant

DURATION = 20.0
BAND = 10.0  # Hz
TORQUE_NOISE = 0.4  # N m: a poor sensor, so that the motion has to make up for it
NOISE = Noise(np.full(2, TORQUE_NOISE * np.sqrt(2 * BAND * plant.SAMPLE_TIME)), 2 * BAND)
LIMITS = Limits((JointLimits(-0.9, -0.7, 1.0, 10.0), JointLimits(0.2, 0.4, 1.0, 10.0)))
COUNT = round(DURATION / plant.SAMPLE_TIME) + 1


def with_effect(block: str) -> Explained:
    text = (DEMO / "two-link.toml").read_text(encoding="utf-8")
    block = f'[[effect]]\nat = "elbow"\n{block}\n\n[recording]\n'
    return explained(robot_from_text(text.replace("[recording]\n", block, 1), "model.toml"))


def recorded(motion: Motion, seed: int, conceal: str = "asymmetric_viscous") -> Recording:
    """The plant with something concealed at the elbow: friction that differs by direction."""
    made = plant.simulate(conceal, "elbow", seed, DURATION, follow=(motion.q, motion.qd))
    channels = {}
    for number, joint in enumerate(("shoulder", "elbow"), 1):
        channels[Quantity.POSITION, joint, Side.LINK] = np.asarray(made[f"q{number}"])
        channels[Quantity.EFFORT, joint, Side.LINK] = np.asarray(made[f"tau{number}"])
    time = np.asarray(made["t"])
    whole = (slice(0, len(time)),)
    return Recording("run", time, MappingProxyType(channels), plant.SAMPLE_TIME, whole, (), "0" * 64)


def nats_between(pair: tuple[Explained, Explained], motion: Motion, seed: int) -> float:
    """Log-likelihood by which the first explanation predicts a second run better, both fitted to a first run."""
    fitted, judge = recorded(motion, seed), recorded(motion, seed + 100)
    cost = []
    for model in pair:
        band = band_of(BAND, 1.0 / plant.SAMPLE_TIME)
        benches = [
            Workbench(model.kernel, observe(model.robot, model.kernel, r, 5 * BAND), band) for r in (fitted, judge)
        ]
        p = best_refit(model, benches[0], NOISE.weight)
        cost.append(NOISE.nats(benches[1].residual(p) * NOISE.weight, DURATION))
    return cost[1] - cost[0]


@pytest.mark.slow
def test_designed_motion_separates_and_others_do_not(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(plant, "TORQUE_NOISE", TORQUE_NOISE)
    pair = (
        with_effect('type = "asymmetric_viscous_friction"\ndifference = "0.065 N m s/rad"'),
        with_effect('type = "coulomb_friction"\nlevel = "0.02 N m"'),
    )
    found = design(pair, LIMITS, NOISE, DURATION)
    family = Family(LIMITS, DURATION)
    assert found.usual < 1.0 < SEPARATES < found.separation
    separated = nats_between(pair, family.motion(found.point, COUNT), 7)
    assert separated == pytest.approx(found.directions[0].nats, rel=0.6)  # one draw of the noise
    assert separated > SEPARATES
    for seed in range(1, 4):
        point = np.random.default_rng(seed).random(family.size)
        assert abs(nats_between(pair, family.motion(point, COUNT), seed)) < 0.5 * SEPARATES


@pytest.mark.slow
def test_diagnosis_of_a_designed_motion_names_what_a_small_one_took_for_a_spring() -> None:
    """Cogging over half a wave is a spring; its order is not given, and found."""
    pair = (
        with_effect('type = "linear_spring"\nstiffness = "2.87 N m/rad"\npreload = "0.593 N m"'),
        with_effect('type = "torque_ripple"\ncosine = "0.2 N m"\nsine = "0.2 N m"\norder = 8'),
    )
    limits = Limits((JointLimits(-1.6, 0.0, 2.0, 20.0), JointLimits(-0.5, 1.2, 2.0, 20.0)))
    found = design(pair, limits, Noise(np.full(2, 0.02), 2 * BAND), DURATION, evaluations=300)
    assert found.separates
    motion = Family(limits, DURATION).motion(found.point, COUNT)
    model = load_robot(DEMO / "two-link.toml")
    told = diagnose(model, recorded(motion, 3, "ripple"), recorded(motion, 4, "ripple"))
    assert [(f.effect, f.place) for f in told.findings] == [("torque_ripple", "elbow")]
    order = told.findings[0].parameters["order"]
    assert order.se is not None
    assert abs(order.value - 11.0) < 3 * order.se < 0.1


def test_plant_follows_a_trajectory_file(tmp_path: Path) -> None:
    motion = Family(LIMITS, 2.0).motion(np.full(Family(LIMITS, 2.0).size, 0.6), 401)
    path = tmp_path / "next.csv"
    table = motion.table(("shoulder", "elbow"), ("rad", "rad"))
    rows = np.column_stack(list(table.values()))
    path.write_text(",".join(table) + "\n" + "\n".join(",".join(map(repr, row)) for row in rows.tolist()) + "\n")
    follow = plant.trajectory(path)
    assert follow[0].shape == follow[1].shape == (2001, 2)
    made = plant.simulate("none", "elbow", 1, 2.0, follow=follow)
    assert np.abs(np.asarray(made["q2"])[::5] - motion.q[:, 1]).max() < 0.02
