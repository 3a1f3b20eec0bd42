"""Runs with loads that are known: what a load needs is no question any more, and the gains of drives get a size."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

import numpy as np
import pytest

from symdyn.base.errors import InputError
from symdyn.compiler import robot_from_text
from symdyn.numeric.diagnose import diagnose
from symdyn.numeric.findings import Diagnosis, Verdict
from symdyn.numeric.identify import identify
from symdyn.numeric.recording import Recording, read_recording
from symdyn.numeric.setting import prepare
from symdyn.spec.records import Quantity, Robot, Side

from .arm_of_two import ARM_OF_TWO, run

LOAD = (Quantity.PARAMETER, "m_load", Side.LINK)
PLACE = 0.3  # m, of the load on the second link
TOOL = '\n[tool]\nplacement = { xyz = [0, 0, 0] }\nmass = "m_load"\ncom = ["x_load", 0, 0]\n'
LOADED = f"{ARM_OF_TWO}{TOOL}".replace("[dh]", f'm_load = "0 kg"\nx_load = "{PLACE} m"\n\n[dh]')
TIME = '\n[recording]\ntime = { column = "t", unit = "s" }\n\n[[recording.channel]]\n'


@pytest.fixture(scope="module")
def robot() -> Robot:
    return robot_from_text(LOADED, "loaded.toml")


def carrying(seed: int, mass: float, shown: tuple[float, float] = (1.0, 1.0)) -> Recording:
    plain = run(seed, carried=(mass, PLACE, 0.0), shown=shown)
    return with_column(plain, np.full(len(plain.time), mass))


def with_column(plain: Recording, column: np.ndarray) -> Recording:
    return replace(plain, channels=MappingProxyType({**plain.channels, LOAD: column}))


def told_of(robot: Robot, shown: tuple[float, float]) -> Diagnosis:
    pairs = [
        [carrying(seed, mass, shown) for seed, mass in runs] for runs in (((1, 0.0), (2, 2.0)), ((3, 0.0), (4, 2.0)))
    ]
    return diagnose(robot, *pairs, band=12.0)


def test_a_load_that_is_known_is_no_mismatch(robot: Robot) -> None:
    told = told_of(robot, (1.0, 1.0))
    assert (told.verdict, told.findings) == (Verdict.COMPLETE, ())
    assert not {"m_load", "x_load"} & set(told.model)
    assert told.model["b1"].value == pytest.approx(0.3, rel=0.01)


@pytest.mark.slow
def test_known_loads_tell_how_much_effort_there_is(robot: Robot) -> None:
    """Both efforts too small by the same factor: without a weight that is known, all masses would be smaller by it."""
    told = told_of(robot, (0.9, 0.9))
    gains = {f.place: f.parameters["gain"].value for f in told.findings if f.effect == "effort_gain"}
    assert gains == {"one": pytest.approx(1 / 0.9, rel=1e-3), "two": pytest.approx(1 / 0.9, rel=1e-3)}
    assert len(told.findings) == 2


def test_a_load_may_change_within_a_run(robot: Robot) -> None:
    bare, loaded = carrying(1, 0.0), carrying(1, 2.0)
    later = bare.time > 0.5 * bare.time[-1]
    mixed = {key: np.where(later, loaded.channels[key], values) for key, values in bare.channels.items()}
    found = identify(robot, replace(bare, channels=MappingProxyType(mixed)), band=12.0)
    assert found.error < 0.01
    assert found.parameters["b2"].value == pytest.approx(0.12, rel=0.02)


def test_a_load_that_never_stays_is_refused(robot: Robot) -> None:
    plain = run(1)
    with pytest.raises(InputError) as caught:
        identify(robot, with_column(plain, np.linspace(0.0, 1.0, len(plain.time))))
    assert [problem.code for problem in caught.value.problems] == ["SD537"]


def test_runs_that_are_fitted_together_all_tell_their_load(robot: Robot) -> None:
    with pytest.raises(InputError) as caught:
        diagnose(robot, [carrying(1, 2.0), run(2)], run(3))
    assert [problem.code for problem in caught.value.problems] == ["SD526"]
    assert "one alone tells m_load" in str(caught.value)


def test_a_load_whose_effort_depends_on_what_is_fitted_is_refused() -> None:
    text = LOADED.replace('mass = "m_load"\ncom = ["x_load", 0, 0]', 'mass = "m_load"\ncom = ["r2", 0, 0]')
    runs = carrying(1, 0.0), carrying(2, 2.0)
    with pytest.raises(InputError) as caught:
        prepare(robot_from_text(text, "loaded.toml"), runs[1], runs[0], lambda _: None, frozenset({"m_load"}))
    assert [problem.code for problem in caught.value.problems] == ["SD538"]


def test_a_column_of_a_file_tells_the_load(tmp_path: Path) -> None:
    """In its unit; that it is constant is no doubt of it."""
    rows = "".join(f"{0.01 * i:.2f},{np.sin(0.1 * i):.6f},{np.cos(0.1 * i):.6f},1500\n" for i in range(300))
    file = tmp_path / "run.csv"
    file.write_text(f"t,q,tau,load\n{rows}")
    channels = [
        'column = "q"\nquantity = "position"\njoint = "one"\nunit = "rad"',
        'column = "tau"\nquantity = "effort"\njoint = "one"\nunit = "N m"',
        'column = "load"\nquantity = "parameter"\nparameter = "m_load"\nunit = "g"',
    ]
    text = LOADED + TIME + "\n\n[[recording.channel]]\n".join(channels) + "\n"
    model = robot_from_text(text, "loaded.toml")
    assert model.channels is not None
    recording = read_recording(file, model.channels)
    np.testing.assert_allclose(recording.channels[LOAD], 1.5)
    assert recording.warnings == ()


@pytest.mark.parametrize(
    ("channel", "code", "message"),
    [
        ('quantity = "parameter"\nparameter = "m_laod"\nunit = "kg"', "SD104", "m_laod"),
        ('quantity = "parameter"\njoint = "one"\nparameter = "m_load"\nunit = "kg"', "SD203", "and has no joint"),
        ('quantity = "parameter"\nparameter = "m_load"\nunit = "m"', "SD221", "kg"),
        ('quantity = "position"\nunit = "rad"', "SD202", "`joint`: missing"),
        ('quantity = "position"\njoint = "one"\nparameter = "m_load"\nunit = "rad"', "SD203", "not of a parameter"),
    ],
)
def test_what_is_wrong_with_such_a_channel_is_told(channel: str, code: str, message: str) -> None:
    with pytest.raises(InputError) as caught:
        robot_from_text(f'{LOADED}{TIME}column = "x"\n{channel}\n', "loaded.toml")
    (problem,) = caught.value.problems
    assert (problem.code, message in problem.message) == (code, True)
