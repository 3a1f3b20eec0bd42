"""A fit of an explanation: joints weighed by what is left there, and begun anew where the one before went astray."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.blind.cases import case_of, model, recordings
from symdyn.base.errors import NumericalError, Problem
from symdyn.compiler import robot_from_text
from symdyn.numeric.explanation import EVEN, Case, Explanation
from symdyn.numeric.findings import Estimate
from symdyn.numeric.fitting import joint_weight
from symdyn.numeric.recording import read_recording
from symdyn.numeric.setting import Setting, prepare

from .arm_of_two import ARM_OF_TWO, rubbing

LEVEL = 0.4


@pytest.fixture(scope="module")
def setting() -> Setting:
    return prepare(robot_from_text(ARM_OF_TWO, "two.toml"), rubbing(1, LEVEL), rubbing(2, LEVEL), lambda _: None)


@pytest.fixture(scope="module")
def case(setting: Setting) -> Case:
    return setting.case(5.0)


@pytest.fixture(scope="module")
def dry(setting: Setting, case: Case) -> Explanation:
    (law,) = (c for c in setting.proposed if (c.effect, c.place.address) == ("coulomb_friction", "two"))
    return case.explain(((law, ()),), case.explain())


def astray(case: Case, of: Explanation, name: str, value: float) -> Explanation:
    p = of.fit.p.copy()
    p[case.bench.index[name]] = value
    return replace(of, fit=replace(of.fit, p=p))


def told(case: Case, of: Explanation) -> dict[str, Estimate]:
    return case.parameters(of.found[0][0], of)


def test_weights_are_those_of_what_is_left(case: Case, dry: Explanation) -> None:
    """At the second joint a hundredth of the residual is left: two weighings do not tell how well it is known then."""
    given = case.explain()
    before, after = (np.sqrt(np.mean(e.training**2, axis=0)) for e in (given, dry))
    assert after[1] < 0.2 * before[1]
    for each in (given, dry):
        even = np.log(each.weight / joint_weight(each.training, case.bench.reference))
        assert np.abs(even).max() < 1e-9
    again = case.explain(dry.found, dry)
    assert np.abs(np.log(again.weight / dry.weight)).max() < EVEN
    assert told(case, dry)["level"].value == pytest.approx(LEVEL, rel=0.02)


def test_parameters_at_a_bound_or_far_are_told(case: Case, dry: Explanation) -> None:
    assert case.far(dry.fit) == []
    assert case.far(astray(case, dry, "m2", 0.7 * 4.1).fit) == ["m2"]
    assert case.far(astray(case, dry, "m2", 0.7 * 3.9).fit) == []
    assert case.far(astray(case, dry, "I1", 0.0).fit) == ["I1"]


def test_a_fit_beside_one_that_went_astray_begins_with_the_model_as_given_too(
    case: Case, dry: Explanation, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun: list[Explanation | None] = []
    worse = replace(dry, training=2.0 * dry.training, weight=0.5 * dry.weight, ended=False)
    answers: dict[bool, Explanation | NumericalError] = {True: dry, False: worse}

    def explained(self: Case, found: object, near: Explanation | None) -> Explanation:
        begun.append(near)
        answer = answers[near is None]
        if isinstance(answer, NumericalError):
            raise answer
        return answer

    monkeypatch.setattr(Case, "one_fit", explained)
    far = replace(astray(case, dry, "m2", 5.0), weight=0.2 * dry.weight)
    assert case.explain(dry.found, dry) is worse
    assert begun == [dry]
    assert case.explain(dry.found, far) is dry
    assert begun == [dry, far, None]
    answers = {True: worse, False: dry}
    assert case.explain(dry.found, far) is dry
    little = replace(far, weight=0.6 * dry.weight)  # what is found is none of what they took up
    assert case.explain(dry.found, little) is dry
    assert begun[-1] is little
    answers = {True: dry, False: replace(worse, ended=True)}  # it did not creep
    assert case.explain(dry.found, far) is answers[False]
    assert begun[-1] is far
    answers = {True: worse, False: NumericalError(Problem("SD612", "the fit did not settle"))}
    assert case.explain(dry.found, far) is worse
    with pytest.raises(NumericalError):
        case.explain(dry.found, dry)


@pytest.mark.slow  # six joints in MuJoCo, and every law that may be missing
def test_a_spring_that_masses_stood_for_is_found_from_the_model_as_given(tmp_path: Path) -> None:
    """Without it an inertia had gone to nothing and a mass doubled; from there the spring came out 12 % soft."""
    concealed = case_of("six-joint_single_hardening@j3_middle_1000")
    robot = robot_from_text(model(concealed), "machine.toml")
    runs = []
    for i, text in enumerate(recordings(concealed)):
        (tmp_path / f"{i}.csv").write_text(text, encoding="utf-8")
        runs.append(read_recording(tmp_path / f"{i}.csv", robot.channels))
    setting = prepare(robot, *runs, lambda _: None)
    case = setting.case(setting.given())
    (law,) = (c for c in setting.proposed if (c.effect, c.place.address) == ("hardening_spring", "j3"))
    found = case.explain(((law, ()),), case.explain())
    (planted,) = concealed.planted
    stiffness = told(case, found)["stiffness"]
    assert stiffness.se is not None
    assert abs(stiffness.value - planted.row["cubic"]) < 3.0 * stiffness.se < 0.01 * planted.row["cubic"]
