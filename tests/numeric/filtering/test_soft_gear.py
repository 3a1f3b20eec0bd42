"""A gear that its load bends: nobody measures the arm, nor how far the gear was bent as the recording began."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from symdyn.compiler import robot_from_text
from symdyn.numeric.diagnose import diagnose
from symdyn.numeric.filtering.between import Between
from symdyn.numeric.filtering.graduated import graduated
from symdyn.numeric.filtering.likelihood import MLFit, fit
from symdyn.numeric.filtering.model import prepare, without_latent
from symdyn.numeric.findings import Verdict

from .soft_gear import RATIO, TOML, TRUE, run

ARM = robot_from_text(TOML, "arm.toml")


def test_the_bend_at_the_start_is_no_thousandth_of_the_travel() -> None:
    """The weight bends it by 2.4 rad of the motor; its travel is 80 rad."""
    model = prepare(ARM, run(1), run(2), only=("constant force offset at arm",))
    bench = model.bench(model.training, without_latent(model, model.training), between=Between.HELD)
    arm, motor = (model.kernel.coordinates.index(name) for name in ("arm", "arm.motor"))
    spread = bench._spread
    apart = np.sqrt(spread[arm, arm] - spread[arm, motor] ** 2 / spread[motor, motor])  # where the motor's is known
    bent = TRUE["m"] * 9.81 * TRUE["r"] * np.cos(-0.6) / TRUE["k"] / RATIO**2
    assert 0.5 * bent < apart < 5.0 * bent
    swing = 2.0 * np.pi / np.sqrt(RATIO**2 * TRUE["k"] / (TRUE["I"] + TRUE["m"] * TRUE["r"] ** 2))
    assert swing < bench.settling < 4.0 * swing


def test_many_unknown_forces_lead_near_the_truth() -> None:
    model = prepare(ARM, run(1), run(2), only=("constant force offset at arm",))
    bench = model.bench(model.training, without_latent(model, model.training), between=Between.HELD)
    _, near = graduated(model, bench, model.values, model.beliefs)
    for name in ("J", "k", "b"):
        assert near[bench.index[name]] == pytest.approx(TRUE[name], rel=0.05)
    weight = near[bench.index["m"]] * near[bench.index["r"]]
    assert weight == pytest.approx(TRUE["m"] * TRUE["r"], rel=0.02)


@pytest.mark.slow
def test_dry_friction_of_the_arm_is_told_by_the_motor() -> None:
    told = diagnose(ARM, run(1, dry=0.8), run(2, dry=0.8))
    assert told.verdict is Verdict.MISSING_PHYSICS
    (found,) = told.findings
    assert (found.effect, found.place) == ("coulomb_friction", "arm")
    level = found.parameters["level"]
    assert level.se is not None
    assert abs(level.value - 0.8) < 4.0 * level.se < 0.05
    assert all((other.effect, other.place) != ("coulomb_friction", "arm") for other in found.alternatives)
    assert found.heldout_after == told.after.heldout < 1e-3


@pytest.mark.slow
def test_nothing_missing() -> None:
    told = diagnose(ARM, run(1), run(2))
    assert told.verdict is Verdict.COMPLETE
    assert told.after.heldout < 2e-4
    assert told.model["k"].value == pytest.approx(TRUE["k"], rel=1e-3)


@pytest.mark.slow
def test_a_gear_that_hardens() -> None:
    told = diagnose(ARM, run(1, cubic=0.012), run(2, cubic=0.012))
    assert [(f.effect, f.place) for f in told.findings] == [("hardening_spring", "arm.gear")]
    stiffness = told.findings[0].parameters["stiffness"]
    assert stiffness.se is not None
    assert abs(stiffness.value - 0.012) < 4.0 * stiffness.se < 0.003


@pytest.mark.slow
def test_play_of_the_gear_is_told_by_the_motor() -> None:
    told = diagnose(ARM, run(1, play=0.5), run(2, play=0.5))
    assert [(f.effect, f.place) for f in told.findings] == [("backlash", "arm.gear")]
    clearance = told.findings[0].parameters["clearance"]
    assert clearance.se is not None
    assert abs(clearance.value - 0.5) < 4.0 * clearance.se < 0.02


@pytest.mark.slow
def test_a_law_of_no_catalogue_is_not_told_as_two_that_it_resembles() -> None:
    """A root of the speed is nearly Coulomb's friction and viscous; what is left of it follows the speed."""
    told = diagnose(ARM, run(1, root=0.002), run(2, root=0.002))
    assert told.verdict is Verdict.UNEXPLAINED
    assert any("does not hold: what is left follows the speed" in alarm for alarm in told.alarms)


def fitted_to_noisy_torque() -> MLFit:
    model = prepare(ARM, run(1), run(2), only=("constant force offset at arm",))
    torque = model.training.u
    noisy = torque + 0.01 * np.std(torque) * np.random.default_rng(3).standard_normal(torque.shape)
    bench = model.bench(replace(model.training, u=noisy), without_latent(model, model.training), between=Between.HELD)
    return fit(bench, model.values, model.beliefs)


def test_noise_of_an_input_comes_back_where_a_fit_begins_without_any() -> None:
    first = fitted_to_noisy_torque()
    bench, noise = first.bench, first.bench.noise
    gone = bench.with_noise(replace(noise, power=1e-9 * noise.power))
    assert gone.filtered(first.p).loss > first.loss + 100.0
    assert fit(gone, first.p, {}).loss < first.loss + 1.0


def test_noise_of_an_input_that_a_sensor_took_over_comes_back() -> None:
    """The gear swings to it; while something was missing, all of that was noise of the encoder."""
    first = fitted_to_noisy_torque()
    bench, noise = first.bench, first.bench.noise
    taken_over = bench.with_noise(replace(noise, r=1e6 * noise.r, power=1e-9 * noise.power))
    assert fit(taken_over, first.p, first.beliefs).loss < first.loss + 1.0
