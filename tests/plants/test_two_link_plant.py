"""The independent plant is right by itself: physics, convergence, and recordings that can be made again."""

from __future__ import annotations

import ast
import gzip
import importlib.util
import math
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

ROOT = Path(__file__).parents[2]
SOURCE = ROOT / "benchmarks" / "plants" / "two_link_plant.py"
DEMO = ROOT / "symdyn" / "demo"
SHIPPED = {"identification": 1, "holdout": 2}  # the file and the seed of its motion


def _load() -> ModuleType:
    specification = importlib.util.spec_from_file_location("two_link_plant", SOURCE)
    assert specification is not None
    assert specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


plant = _load()
DRY = ("coulomb", "stribeck")
ANGLES = st.floats(-math.pi, math.pi)
SPEEDS = st.floats(-5.0, 5.0)


def gravity_torques(q1: float, q2: float) -> tuple[float, float]:
    """The torques that hold the arm, from potential energy by central differences."""
    arm, h = plant.Plant(), 1e-6
    return tuple(
        (arm.energy((q1 + h * a, q2 + h * b, 0.0, 0.0)) - arm.energy((q1 - h * a, q2 - h * b, 0.0, 0.0))) / (2 * h)
        for a, b in ((1, 0), (0, 1))
    )


def test_imports_nothing_of_symdyn() -> None:
    found = set()
    for node in ast.walk(ast.parse(SOURCE.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name.partition(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0
            found.add((node.module or "").partition(".")[0])
        elif isinstance(node, ast.Name):
            assert node.id != "__import__"
    assert "numpy" in found
    assert found <= {"__future__", "argparse", "gzip", "io", "math", "numpy", "pathlib"}


def test_energy_is_conserved_without_friction_and_motors() -> None:
    arm = plant.Plant(viscous=(0.0, 0.0))
    state = (0.4, -0.9, 1.5, -2.0)
    start = arm.energy(state)
    fastest = 0.0
    for _ in range(20_000):
        state = arm.advance(state, (0.0, 0.0), plant.STEP)
        fastest = max(fastest, abs(state[3]))
    assert fastest > 5.0  # it moved: the check is not of an arm at rest
    assert arm.energy(state) == pytest.approx(start, abs=1e-9)


@pytest.mark.parametrize("joint", plant.JOINTS)
@pytest.mark.parametrize("conceal", ["none", *DRY, "asymmetric_viscous"])
def test_friction_only_takes_energy(conceal: str, joint: str) -> None:
    arm = plant.Plant(conceal, joint)
    state = (0.4, -0.9, 1.5, -2.0)
    energies = [arm.energy(state)]
    for _ in range(10_000):
        state = arm.advance(state, (0.0, 0.0), plant.STEP)
        energies.append(arm.energy(state))
    assert energies[-1] < energies[0] - 1.0
    assert np.max(np.diff(energies)) < 1e-9


@given(q1=ANGLES, q2=ANGLES, v1=SPEEDS, v2=SPEEDS, tau1=SPEEDS, tau2=SPEEDS)
def test_accelerations_agree_with_pinocchio(
    q1: float, q2: float, v1: float, v2: float, tau1: float, tau2: float
) -> None:
    pin = pytest.importorskip("pinocchio")
    model = pin.Model()
    model.gravity.linear = np.array([0.0, -9.81, 0.0])
    links = [(1.08, 0.25, 0.022644, 0.0), (0.864, 0.2, 0.0116352, 0.5)]  # mass, centre, inertia, start on its parent
    parent = 0
    for mass, centre, inertia, start in links:
        placement = pin.SE3(np.eye(3), np.array([start, 0.0, 0.0]))
        parent = model.addJoint(parent, pin.JointModelRZ(), placement, f"joint{parent}")
        body = pin.Inertia(mass, np.array([centre, 0.0, 0.0]), np.diag([inertia, inertia, inertia]))
        model.appendBodyToJoint(parent, body, pin.SE3.Identity())
    q, v = np.array([q1, q2]), np.array([v1, v2])
    torque = np.array([tau1, tau2]) - np.array([0.30, 0.12]) * v
    expected = pin.aba(model, model.createData(), q, v, torque)
    found = plant.Plant().accelerations((q1, q2, v1, v2), (tau1, tau2))
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize(
    ("conceal", "expected"),
    [
        ("none", lambda q, v: 0.0),
        ("coulomb", lambda q, v: -0.25 * math.copysign(1, v)),
        ("ripple", lambda q, v: 0.35 * math.sin(11 * q + 0.7)),
        ("offset", lambda q, v: 0.20),
        ("stribeck", lambda q, v: -(0.20 + 0.20 * math.exp(-((v / 0.15) ** 2))) * math.copysign(1, v)),
        ("asymmetric_viscous", lambda q, v: -(0.15 if v > 0 else 0.02) * v),
        ("spring", lambda q, v: -0.6 * (q - 0.3)),
    ],
)
@pytest.mark.parametrize("speed", [0.1, -0.1, 2.0])
def test_concealed_effect_acts_as_that_torque_at_the_elbow(conceal: str, expected: object, speed: float) -> None:
    assert callable(expected)
    state = (0.3, 0.8, -0.4, speed)
    torque = (1.0, 0.5)
    with_effect = plant.Plant(conceal, "elbow").accelerations(state, torque, math.copysign(1.0, speed))
    as_torque = plant.Plant().accelerations(state, (torque[0], torque[1] + expected(state[1], speed)))
    np.testing.assert_allclose(with_effect, as_torque, rtol=1e-12)


@pytest.mark.parametrize("joint", plant.JOINTS)
@pytest.mark.parametrize("conceal", DRY)
def test_joint_at_rest_stays_at_rest_below_the_level_and_breaks_away_above(conceal: str, joint: str) -> None:
    arm = plant.Plant(conceal, joint)
    index = plant.JOINTS.index(joint)
    level = arm.truth.get("static", arm.truth["level"])
    hold = gravity_torques(0.4, 0.7)
    for share in (0.99, -0.99, 1.01, -1.01):
        torque = list(hold)
        torque[index] += share * level
        state = (0.4, 0.7, 0.0, 0.0)
        for _ in range(200):
            state = arm.advance(state, tuple(torque), plant.STEP)
        if abs(share) < 1.0:
            assert state[2 + index] == 0.0
            assert state[index] == (0.4, 0.7)[index]
        else:
            assert state[2 + index] * share > 1e-4


@pytest.mark.parametrize("conceal", DRY)
def test_sliding_joint_comes_to_rest_and_is_caught(conceal: str) -> None:
    arm = plant.Plant(conceal, "elbow", viscous=(0.0, 0.0))
    hold = gravity_torques(-math.pi / 2, 0.0)
    state = (-math.pi / 2, 0.0, 0.0, 0.05)
    speeds = []
    for _ in range(400):
        state = arm.advance(state, hold, plant.STEP)
        speeds.append(state[3])
    rest = next(i for i, speed in enumerate(speeds) if speed == 0.0)
    assert 0 < rest < 100
    assert min(speeds[:rest], default=0.0) > 0.0
    assert set(speeds[rest:]) == {0.0}


@pytest.mark.parametrize("conceal", ["ripple", *DRY])
def test_halving_the_step_changes_nothing_visible(conceal: str) -> None:
    coarse, fine = (plant.simulate(conceal, "elbow", 3, 2.0, noise=False, steps_per_sample=n) for n in (10, 20))
    for name in ("q1", "q2"):
        assert np.max(np.abs(coarse[name] - fine[name])) < 1e-6
    coarsest = plant.simulate(conceal, "elbow", 3, 2.0, noise=False, steps_per_sample=1)
    assert np.max(np.abs(coarsest["q2"] - fine["q2"])) > 0.0  # the step is really another one


def test_recording_starts_at_the_reference_and_follows_it() -> None:
    recording = plant.simulate("ripple", "elbow", 1, 3.0)
    angles, speeds = plant.reference(1, 3.0)
    for joint, name in enumerate(("q1", "q2")):
        error = np.abs(recording[name] - angles[:, joint])
        assert error[0] < 3e-5
        assert error.max() < 0.03
    assert np.max(np.abs(speeds)) < 4.0


def test_sensors_are_quantised_and_noise_is_of_the_stated_size() -> None:
    noisy, perfect = (plant.simulate("none", "elbow", 1, 2.0, noise=noise) for noise in (True, False))
    turns = noisy["q2"] / (2 * math.pi / 2**19)
    np.testing.assert_allclose(turns, np.round(turns), atol=1e-6)
    assert np.std(np.diff(noisy["tau2"], 2)) == pytest.approx(math.sqrt(6) * 0.02, rel=0.4)
    assert np.std(np.diff(perfect["tau2"], 2)) < 0.005


def test_bristles_follow_their_law_to_second_order_and_give_no_energy() -> None:
    """At a constant speed they settle where stiffness times deflection is the sliding friction; a loop takes energy."""
    arm = plant.Plant("lugre", "elbow")
    for _ in range(20_000):
        arm._bend(0.4, plant.STEP)
    level = 0.25 + 0.12 * math.exp(-((0.4 / 0.25) ** 2))
    assert 8.0 * arm.deflection == pytest.approx(level, rel=1e-9)
    arm, work = plant.Plant("lugre", "elbow"), 0.0
    for k in range(20_000):
        v = 0.3 * math.cos(2 * math.pi * k * plant.STEP)
        work -= arm.smooth(0.0, v) * v * plant.STEP
        arm._bend(v, plant.STEP)
    assert work > 0.02  # of friction, against the motion

    def end(parts: int) -> float:
        arm, state = plant.Plant("lugre", "elbow"), (0.4, -0.9, 1.5, -2.0)
        for _ in range(100 * parts):
            state = arm.advance(state, (3.0, 1.0), 1e-3 / parts)
        return float(state[1])

    coarse, fine, finer = end(1), end(2), end(4)
    assert (coarse - fine) / (fine - finer) == pytest.approx(4.0, rel=0.2)


def test_ripple_is_clearly_there_and_does_not_dominate() -> None:
    recording = plant.simulate("ripple", "elbow", 1, 10.0)
    ripple = 0.35 * np.sin(11 * recording["q2"] + 0.7)
    share = np.sqrt(np.mean(ripple**2) / np.mean(recording["tau2"] ** 2))
    assert 0.10 < share < 0.25
    assert np.ptp(recording["q2"]) > 2 * math.pi / 11 * 3  # several waves are passed


def test_equal_recordings_are_equal_bytes(tmp_path: Path) -> None:
    recording = plant.simulate("ripple", "elbow", 1, 0.2)
    paths = [tmp_path / name for name in ("one.csv.gz", "other.csv.gz")]
    for path in paths:
        plant.write_csv(path, recording)
    assert paths[0].read_bytes() == paths[1].read_bytes()
    assert paths[0].read_bytes()[4:8] == b"\0\0\0\0"  # the date in a gzip header
    assert gzip.decompress(paths[0].read_bytes()).decode() == plant.csv_text(recording)


@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_recording_is_what_the_plant_makes(name: str) -> None:
    shipped = (DEMO / f"{name}.csv.gz").read_bytes()
    # compared unpacked: builds of zlib differ in what they compress to
    assert gzip.decompress(shipped).decode() == plant.csv_text(plant.simulate("lugre", "elbow", SHIPPED[name], 20.0))
    assert shipped[4:8] == b"\0\0\0\0"


def test_shipped_files_are_small() -> None:
    for name in SHIPPED:
        assert (DEMO / f"{name}.csv.gz").stat().st_size < 700_000
