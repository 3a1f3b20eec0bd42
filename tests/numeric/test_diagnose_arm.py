"""Diagnosis of the two-link arm: recordings of an independent plant, simulated under its controller."""

from __future__ import annotations

import importlib.util
import math
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType, ModuleType

import numpy as np
import pytest

from symdyn.compiler import load_robot
from symdyn.numeric.diagnose import diagnose
from symdyn.numeric.findings import Verdict
from symdyn.numeric.recording import Recording
from symdyn.spec.records import Quantity, Robot, Side

ROOT = Path(__file__).parents[2]
DURATION = 4.0  # s; friction at low speed and springs need more to be told from the rest
HELDOUT = 100  # added to the seed

COLUMNS = {
    "q1": (Quantity.POSITION, "shoulder", Side.LINK),
    "q2": (Quantity.POSITION, "elbow", Side.LINK),
    "tau1": (Quantity.EFFORT, "shoulder", Side.LINK),
    "tau2": (Quantity.EFFORT, "elbow", Side.LINK),
}


def _load() -> ModuleType:
    source = ROOT / "benchmarks" / "plants" / "two_link_plant.py"
    specification = importlib.util.spec_from_file_location("two_link_plant", source)
    assert specification is not None
    assert specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


plant = _load()


@pytest.fixture(scope="module")
def robot() -> Robot:
    return load_robot(ROOT / "symdyn" / "demo" / "two-link.toml")


def record(conceal: str, joint: str, seed: int, duration: float) -> Recording:
    columns = plant.simulate(conceal, joint, seed, duration)
    time = columns["t"]
    channels = MappingProxyType({key: columns[name] for name, key in COLUMNS.items()})
    step = float(np.median(np.diff(time)))
    return Recording(f"run-{seed}", time, channels, step, (slice(0, len(time)),), (), "0" * 64)


def truth_of(conceal: str, joint: str) -> Mapping[str, Mapping[str, float]]:
    """What the plant conceals there, in the words and signs of the effects."""
    true = plant.CONCEALED[conceal][plant.JOINTS.index(joint)]
    if conceal == "coulomb":
        return {"coulomb_friction": {"level": true["level"]}}
    if conceal == "offset":
        return {"force_offset": {"offset": -true["torque"]}}
    if conceal == "spring":
        stiffness, rest = true["stiffness"], true["rest"]
        return {"linear_spring": {"stiffness": stiffness, "preload": stiffness * rest}}
    if conceal == "asymmetric_viscous":
        return {"asymmetric_viscous_friction": {"difference": (true["forward"] - true["backward"]) / 2}}
    if conceal == "ripple":
        size, phase = true["amplitude"], true["phase"]
        parts = {"cosine": size * math.sin(phase), "sine": size * math.cos(phase)}
        return {"torque_ripple": {**parts, "order": true["order"]}}
    if conceal == "lugre":
        values = {"level": true["level"], "excess": true["excess"], "stribeck_velocity": true["speed"]}
        return {"lugre_friction": {**values, "stiffness": true["stiffness"]}}
    friction = {"coulomb_friction": {"level": true["level"]}}
    excess = true["static"] - true["level"]
    return {**friction, "stribeck_friction": {"excess": excess, "stribeck_velocity": true["speed"]}}


CORE = (("coulomb", "shoulder"),)
CASES = [
    pytest.param(conceal, joint, marks=() if (conceal, joint) in CORE else pytest.mark.slow)
    for conceal in plant.CONCEALED
    for joint in plant.JOINTS
    if conceal != "none"
]


@pytest.mark.parametrize(("conceal", "joint"), CASES)
def test_concealed_effect_is_named_placed_and_measured(robot: Robot, conceal: str, joint: str) -> None:
    duration = 10.0 if conceal in ("stribeck", "spring", "lugre") else DURATION
    found = diagnose(robot, *(record(conceal, joint, seed, duration) for seed in (3, 3 + HELDOUT)))
    expected = truth_of(conceal, joint)
    assert found.verdict is Verdict.MISSING_PHYSICS
    assert {finding.effect: finding.place for finding in found.findings} == dict.fromkeys(expected, joint)
    for finding in found.findings:
        assert finding.heldout_gain > 0
        for name, truth in expected[finding.effect].items():
            estimate = finding.parameters[name]
            assert estimate.se is not None
            assert estimate.se < 0.1 * abs(truth)
            assert abs(estimate.value - truth) < max(3.0 * estimate.se, 0.03 * abs(truth)), name
    assert found.after.heldout < 0.7 * found.before.heldout
    assert not found.remaining.structured


@pytest.mark.parametrize("seed", [3, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (4, 5, 6, 7))])
def test_complete_model_of_the_arm_is_called_complete(robot: Robot, seed: int) -> None:
    found = diagnose(robot, *(record("none", "elbow", s, DURATION) for s in (seed, seed + HELDOUT)))
    assert (found.verdict, found.findings) == (Verdict.COMPLETE, ())
    assert found.after.heldout < 0.01
    for name, truth in zip(("b_1", "b_2"), plant.VISCOUS, strict=True):
        estimate = found.model[name]
        assert estimate.se is not None
        assert abs(estimate.value - truth) < max(4.0 * estimate.se, 0.02 * truth)


@pytest.mark.slow
def test_a_short_recording_does_not_stop_the_discovery(robot: Robot) -> None:
    """The model without the spring is fitted first, and needs more than Gauss-Newton to settle."""
    found = diagnose(robot, *(record("spring", "shoulder", seed, 4.0) for seed in (3, 3 + HELDOUT)))
    assert [(f.effect, f.place) for f in found.findings] == [("linear_spring", "shoulder")]
    shown = found.traces  # at a reversal, too, where nothing is counted as a residual
    assert np.all(shown.before != shown.effort)
    assert np.all(shown.after != shown.effort)
