"""symdyn experiment, and --experiment of a diagnosis: what is told, and the trajectory file."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from unittest import mock

import numpy as np
import pandas as pd
import pytest

from symdyn.compiler import robot_from_text
from symdyn.faces.recordings import open_recording
from symdyn.numeric.diagnose import diagnose
from symdyn.numeric.experiment.next_experiment import Plan, after_diagnosis
from symdyn.numeric.findings import Diagnosis, Estimate, Rival
from symdyn.numeric.recording import Recording

from .command_line import PENDULUM, dry_friction, run, write_pair

LIMITS = ("--limits", "pivot:lower=-1.5,upper=1.5,velocity=2,acceleration=20")
NOISE = ("--noise", "0.02")


def effect(name: str, **values: str) -> str:
    lines = "".join(f'{key} = "{value}"\n' for key, value in values.items())
    block = f'[[effect]]\ntype = "{name}"\nat = "pivot"\n{lines}\n[recording]\n'
    return PENDULUM.replace("[recording]\n", block, 1)


@pytest.fixture(scope="module")
def models(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("models")
    for name, text in {
        "rod": PENDULUM,
        "offset": effect("force_offset", offset="0.2 N m"),
        "spring": effect("linear_spring", stiffness="0.6 N m/rad", preload="0.1 N m"),
        "free": PENDULUM.replace('m = "2 kg"', 'm = { free = "kg" }'),
        "elbow": PENDULUM.replace('name = "pivot"', 'name = "elbow"').replace('"pivot"', '"elbow"'),
    }.items():
        (folder / f"{name}.toml").write_text(text, encoding="utf-8")
    return folder


@pytest.fixture(scope="module")
def pair(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    return write_pair(tmp_path_factory.mktemp("pair"), dry_friction)


def test_two_models_get_a_motion_and_a_promise(models: Path, tmp_path: Path) -> None:
    path = tmp_path / "next.csv"
    arguments = (
        models / "offset.toml",
        models / "spring.toml",
        *NOISE,
        *LIMITS,
        "-o",
        path,
        "--rate",
        "100",
        "-t",
        "10",
    )
    told = run("experiment", *arguments, "--json").json()
    assert told["between"] == [
        {"effect": "force_offset", "place": "pivot"},
        {"effect": "linear_spring", "place": "pivot"},
    ]
    assert told["separation"] > 10.0
    assert told["separates"]
    assert told["file"] == str(path)
    assert [direction["nested"] for direction in told["directions"]] == [True, False]
    table = pd.read_csv(path)
    assert list(table.columns) == ["time [s]", "pivot.q [rad]", "pivot.qd [rad/s]", "pivot.qdd [rad/s^2]"]
    assert len(table) == 1001
    assert table["pivot.q [rad]"].abs().max() <= 1.5
    assert table["pivot.qd [rad/s]"].abs().max() <= 2.0
    first = path.read_bytes()
    done = run("experiment", *arguments)
    assert path.read_bytes() == first
    assert "nats" in done.out
    assert "fits as well" in done.out


def test_one_model_gets_a_motion_for_its_parameters(models: Path) -> None:
    done = run("experiment", models / "spring.toml", *NOISE, *LIMITS)
    assert done.code == 0
    assert "standard error to expect" in done.out
    assert "not by itself" in done.out
    told = run("experiment", models / "spring.toml", *NOISE, *LIMITS, "--json").json()
    assert told["separation"] is None
    assert told["standard_errors"]["m"] is None
    assert told["standard_errors"]["pivot_linear_spring_preload"] > 0.0
    assert told["gain"] > 1.0


def test_pair_that_no_motion_separates_ends_with_code_1(models: Path) -> None:
    close = ("--limits", "pivot:lower=-0.05,upper=0.05,velocity=0.2,acceleration=2", "-t", "10")
    done = run("experiment", models / "offset.toml", models / "spring.toml", *NOISE, *close)
    assert done.code == 1
    assert "no motion of 10 s within the limits separates" in done.out
    assert "16 times the travel, speed and effort would" in done.out


def test_limits_from_a_recording_are_told(models: Path, pair: tuple[Path, Path]) -> None:
    told = run(
        "experiment", models / "offset.toml", models / "spring.toml", *NOISE, "--recording", pair[0], "--json"
    ).json()
    assert "already visited stands for the lower, upper, velocity, acceleration, effort of pivot" in told["why"]


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (("offset", "spring", *LIMITS), 2, "noise of the effort is not given: pivot"),
        (("offset", "spring", *LIMITS, "--noise", "x"), 2, "SD330"),
        (("offset", "spring", *LIMITS, "--noise", "elbow=1"), 2, "no joint `elbow`"),
        (("offset", "spring", *NOISE), 3, "SD331"),
        (("offset", "spring", *NOISE, "--limits", "pivot:up=1"), 2, "SD330"),
        (("offset", "elbow", *NOISE, *LIMITS), 2, "the same joints"),
        (("free", *NOISE, *LIMITS), 2, "SD304"),
        (("offset", *NOISE, *LIMITS, "--duration", "0"), 2, "--duration"),
        (("offset", *NOISE, *LIMITS, "--rate", "1e6"), 2, "rows"),
        (("offset", *NOISE, *LIMITS, "--band", "-1"), 2, "--band"),
    ],
)
def test_bad_requests_are_refused(models: Path, arguments: tuple[str, ...], code: int, words: str) -> None:
    known = {path.stem for path in models.iterdir()}
    done = run("experiment", *(str(models / f"{a}.toml") if a in known else a for a in arguments))
    assert done.code == code
    assert words in done.err


@pytest.fixture(scope="module")
def found(pair: tuple[Path, Path]) -> tuple[Diagnosis, Recording]:
    robot = robot_from_text(PENDULUM, "rod.toml")
    training, judge = (open_recording(path, robot, None) for path in pair)
    return diagnose(robot, training, judge), training


def test_diagnosis_without_a_question_needs_no_experiment(found: tuple[Diagnosis, Recording]) -> None:
    diagnosis, training = found
    assert [f.effect for f in diagnosis.findings] == ["coulomb_friction"]
    assert after_diagnosis(diagnosis, training, {}, Plan()) is None


def test_rivals_of_a_diagnosis_get_a_motion(found: tuple[Diagnosis, Recording]) -> None:
    """As if the recording had not told dry friction from friction that differs by direction."""
    diagnosis, training = found
    finding = replace(diagnosis.findings[0], rivals=(Rival("asymmetric_viscous_friction", "pivot", 0.4),))
    unsure = replace(diagnosis, findings=(finding,))
    planned = after_diagnosis(unsure, training, {}, Plan(evaluations=64))
    assert planned is not None
    assert planned.told.between == (("coulomb_friction", "pivot"), ("asymmetric_viscous_friction", "pivot"))
    assert planned.told.separation > 100.0  # the recording itself tells them apart: so does the motion
    assert "already visited" in planned.told.why
    assert planned.motion is not None
    q = training.channels[next(iter(training.channels))]
    assert q.min() - 1e-6 <= planned.motion.q.min() < planned.motion.q.max() <= q.max() + 1e-6


def test_parameters_that_a_recording_left_open_get_a_motion(found: tuple[Diagnosis, Recording]) -> None:
    diagnosis, training = found
    finding = replace(diagnosis.findings[0], parameters={"level": Estimate(0.3, None, "N m")})
    planned = after_diagnosis(replace(diagnosis, findings=(finding,)), training, {}, Plan(evaluations=64))
    assert planned is not None
    assert planned.identifying is not None
    level = planned.identifying.standard_errors["pivot_coulomb_friction_level"]
    assert level is not None
    assert 0.0 < level < 0.01


def test_places_in_one_group_are_rivals(found: tuple[Diagnosis, Recording]) -> None:
    """A rotor's place, which the motion of the joint does not show: told, without a motion."""
    diagnosis, training = found
    finding = replace(diagnosis.findings[0], group=("pivot", "pivot.motor"))
    robot = diagnosis.diagnosed
    drive = '\n[joint.drive]\nratio = 1\nrotors = [ { name = "motor", inertia = 1e-4 } ]\n'
    drive += 'shafts = [ { name = "belt", from = "motor", to = "joint", stiffness = 1e3, damping = 0.1 } ]\n'
    text = robot.text.replace('inertia = { zz = "J" } }\n', f'inertia = {{ zz = "J" }} }}\n{drive}', 1)
    geared = replace(diagnosis, diagnosed=robot_from_text(text, "geared.toml"), findings=(finding,))
    planned = after_diagnosis(geared, training, {}, Plan(evaluations=64))
    assert planned is not None
    assert planned.motion is None
    assert planned.told.between == (("coulomb_friction", "pivot"), ("coulomb_friction", "pivot.motor"))
    assert "take the same efforts on every motion of the joints" in planned.told.why


@pytest.mark.slow
def test_friction_that_depends_on_the_load_asks_for_another_load(tmp_path: Path) -> None:
    drive = '\n[joint.drive]\nratio = 1\nrotors = [ { name = "motor", inertia = 1e-4 } ]\n'
    drive += 'shafts = [ { name = "belt", from = "motor", to = "joint", stiffness = 1e3, damping = 0.1 } ]\n'
    geared = PENDULUM.replace("\n[recording]", f"{drive}\n[recording]", 1)
    for name, line in (("coulomb_friction", 'level = "0.1 N m"'), ("load_dependent_friction", "coefficient = 0.1")):
        block = f'[[effect]]\ntype = "{name}"\nat = "pivot.belt"\n{line}\n\n[recording]\n'
        (tmp_path / f"{name}.toml").write_text(geared.replace("[recording]\n", block, 1), encoding="utf-8")
    models = [tmp_path / "coulomb_friction.toml", tmp_path / "load_dependent_friction.toml"]
    done = run("experiment", *models, *NOISE, *LIMITS)
    assert done.code == 1
    assert "another load is needed" in done.out
    for name in ("coulomb_friction", "load_dependent_friction"):  # the load of a joint follows from its motion
        text = (tmp_path / f"{name}.toml").read_text(encoding="utf-8").replace(drive, "").replace("pivot.belt", "pivot")
        (tmp_path / f"rigid_{name}.toml").write_text(text, encoding="utf-8")
    rigid = [tmp_path / f"rigid_{model.name}" for model in models]
    assert run("experiment", *rigid, *NOISE, *LIMITS, "-t", "10", "--json").json()["separation"] > 1.0
    drives = run("experiment", models[0], models[0], *NOISE, *LIMITS)
    assert drives.code == 3
    assert "SD332" in drives.err


def test_experiment_of_a_diagnosis_is_written_and_told(
    models: Path, pair: tuple[Path, Path], found: tuple[Diagnosis, Recording], tmp_path: Path
) -> None:
    diagnosis, _ = found
    rivals = (Rival("asymmetric_viscous_friction", "pivot", 0.4),)
    unsure = replace(diagnosis, findings=(replace(diagnosis.findings[0], rivals=rivals),))
    path = tmp_path / "next.csv"
    with mock.patch("symdyn.numeric.diagnose.diagnose", return_value=unsure):
        done = run(
            "diagnose", models / "rod.toml", pair[0], "--holdout", pair[1], "--experiment", path, "-t", "10", "--json"
        )
    told = done.json()["next_experiment"]
    assert told["file"] == str(path)
    assert told["separation"] > 10.0
    assert f"experiment: {path}" in done.err
    table = pd.read_csv(path)
    assert table["time [s]"].iloc[-1] == pytest.approx(10.0)
    assert np.all(np.isfinite(table.to_numpy()))


@pytest.mark.parametrize(
    ("more", "words"),
    [
        (("--limits", "elbow:velocity=2", "--experiment", "next.csv"), "no joint `elbow`"),
        (("--limits", "pivot:velocity=2"), "add --experiment FILE"),
    ],
)
def test_limits_that_nothing_can_use_are_refused_before_the_diagnosis(
    models: Path, pair: tuple[Path, Path], more: tuple[str, ...], words: str
) -> None:
    with mock.patch("symdyn.numeric.diagnose.diagnose", side_effect=AssertionError("it was started")):
        done = run("diagnose", models / "rod.toml", pair[0], *more)
    assert done.code == 2
    assert "SD330" in done.err
    assert words in done.err
