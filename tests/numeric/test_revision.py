"""What is no force at a joint, and which of it is told: gravity that is left out, sensors that show something else."""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType, SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from symdyn.compiler import compile_robot, load_robot, robot_from_text
from symdyn.numeric.candidates import candidates
from symdyn.numeric.diagnose import diagnose
from symdyn.numeric.findings import Estimate, Verdict
from symdyn.numeric.forward import _revised, _simplest, explains_more, forward
from symdyn.numeric.freed import GravityVector
from symdyn.numeric.inquiry import Inquiry
from symdyn.numeric.observation import observe
from symdyn.numeric.proof import proved
from symdyn.numeric.reading import Reading, declared
from symdyn.numeric.readings import read
from symdyn.numeric.recording import Recording
from symdyn.numeric.revision import revisions
from symdyn.numeric.search import Search
from symdyn.numeric.setting import prepare
from symdyn.spec.edit import add_effect, set_effect, set_gravity
from symdyn.spec.records import Quantity, Robot, Side

from .arm_of_two import ARM_OF_TWO, run
from .pendulum import ARM, GRAVITY, MASS, TOML, TURNING, VISCOUS, motion, pendulum, record

Array = NDArray[np.float64]


@pytest.mark.slow
def test_friction_by_load_is_told_from_coulomb_friction() -> None:
    """By hand: 12 % of what the links need, which the gravity model that is refitted beside it must not take up."""
    robot = robot_from_text(ARM_OF_TWO, "two.toml")
    found = diagnose(robot, run(1, by_load=0.12), run(2, by_load=0.12))
    assert [(f.effect, f.place) for f in found.findings] == [("load_dependent_friction", "one")]
    told = found.findings[0].parameters["coefficient"]
    assert told.se is not None
    assert told.value == pytest.approx(0.12, abs=max(4.0 * told.se, 1e-3))
    assert not found.remaining.structured
    again = diagnose(found.diagnosed, run(1, by_load=0.12), run(2, by_load=0.12))
    assert again.findings == ()  # its own kernel holds the law now
    assert again.after.heldout == pytest.approx(found.after.heldout, rel=0.01)


@pytest.mark.slow
def test_an_encoder_that_is_off_at_the_first_joint_is_a_tilted_base() -> None:
    """No motion of a flat arm tells them apart: the one number comes first, the other is its rival."""
    robot = robot_from_text(ARM_OF_TWO, "two.toml")
    found = diagnose(robot, run(1, first=0.09), run(2, first=0.09))
    assert [(f.effect, f.place) for f in found.findings] == [("encoder", "one")]
    assert found.findings[0].parameters["offset"].value == pytest.approx(0.09, abs=1e-3)
    assert [(r.effect, r.place) for r in found.findings[0].rivals] == [("gravity", "base")]
    assert found.verdict == "ambiguous"


@pytest.mark.slow
def test_gravity_that_the_model_leaves_out_is_found() -> None:
    robot = robot_from_text(set_gravity(ARM_OF_TWO, (0.0, 0.0, 0.0)), "two.toml")
    found = diagnose(robot, run(1), run(2))
    assert [(f.effect, f.place) for f in found.findings] == [("gravity", "base")]
    pull = found.findings[0].parameters
    assert pull["y"].value == pytest.approx(-GRAVITY, rel=0.01)
    assert abs(pull["x"].value) < 0.1
    assert not found.remaining.structured


@pytest.mark.parametrize(("share", "numbers"), [(0.01, 1), (0.02, 2), (0.05, 3)])
def test_a_revision_must_earn_each_number_that_it_has_more(share: float, numbers: int) -> None:
    """It leaves a share less of every error than an effect with one number does: beyond chance, yet worth so many."""
    case = prepare(pendulum(), record(1), record(2), lambda _: None).case(5.0)
    given = case.explain()
    (one,) = (c for c in candidates(pendulum()) if c.effect == "quadratic_drag")
    better = replace(given, training=(1.0 - share) * given.training)
    worth = [explains_more(case, one, given, better, size) for size in (1, 2, 3)]
    assert worth == [size <= numbers for size in (1, 2, 3)]


LIFT = f"""
[robot]
name = "lift"
gravity = [0, 0, -{GRAVITY}]

[parameters]
m = "2 kg"
b = "4 N s/m"

[dh]
convention = "modified"
rows = [[0, "q", 0, 0]]

[[joint]]
name = "lift"
link = {{ mass = "m", com = [0, 0, 0] }}

[[effect]]
type = "viscous_friction"
at = "lift"
coefficient = "b"
"""


def lifted(seed: int) -> Recording:
    """A lift of 2.1 kg with 4.4 N s/m, and 3 N more than these explain."""
    rng = np.random.default_rng([seed, 2])
    time = np.arange(5000) / 250.0
    q, v, a = motion(seed, time, 0.3)
    force = 2.1 * (a + GRAVITY) + 4.4 * v + 3.0 + 0.05 * rng.standard_normal(len(time))
    angle = q + 1e-6 * rng.standard_normal(len(time))
    channels = {(Quantity.POSITION, "lift", Side.LINK): angle, (Quantity.EFFORT, "lift", Side.LINK): force}
    return Recording(f"run-{seed}", time, MappingProxyType(channels), 0.004, (slice(0, len(time)),), (), "0" * 64)


@pytest.mark.slow  # a whole diagnosis
def test_what_a_vertical_axis_lifts_is_told_by_one_number_with_gravity_as_its_rival() -> None:
    """Its own mass is known by the acceleration: more weight is a force, or a stronger gravity, and nothing tells."""
    found = diagnose(robot_from_text(LIFT, "lift.toml"), lifted(1), lifted(2))
    (finding,) = found.findings
    assert finding.effect == "force_offset"
    assert finding.parameters["offset"].value == pytest.approx(3.0, abs=0.05)
    assert "gravity" in {r.effect for r in finding.rivals}
    assert found.verdict is Verdict.AMBIGUOUS


def pull(value: float) -> Estimate:
    return Estimate(value, 0.01, "m/s^2")


def test_gravity_that_no_place_on_earth_has_is_refused() -> None:
    """Three times that of Earth may stand for masses given too small; more takes up something else."""
    told = {y: {"x": pull(0.3), "y": pull(y), "z": pull(0.1)} for y in (-GRAVITY, -1.62, -25.0, -26.0 * GRAVITY)}
    assert [GravityVector().credible(numbers) for numbers in told.values()] == [True, True, True, False]
    vague = {axis: Estimate(-GRAVITY, 2.0 * GRAVITY, "m/s^2") for axis in "xyz"}
    assert not GravityVector().credible(vague)


@pytest.mark.slow
def test_gravity_of_no_place_on_earth_is_told_with_a_doubt() -> None:
    """A forearm hung 10 % too near is one whose weight pulls less: no motion tells the two apart."""
    short = robot_from_text(ARM_OF_TWO.replace('["q", 0, 0.4, 0]', '["q", 0, 0.3, 0]'), "two.toml")
    told = diagnose(short, run(1), run(2))
    (gravity,) = told.findings
    assert gravity.effect == "gravity"
    assert gravity.parameters["y"].value == pytest.approx(-GRAVITY * 0.3 / 0.4, rel=0.01)
    assert any("no place on Earth has a gravity of 7.3" in alarm for alarm in told.alarms)


@pytest.mark.slow
def test_gravity_that_grew_out_of_bounds_beside_later_findings_is_taken_out_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    robot = robot_from_text(set_gravity(ARM_OF_TWO, (0.0, 0.0, 0.0)), "two.toml")
    setting = prepare(robot, run(1), run(2), lambda _: None)
    case = setting.case(setting.given())
    given = case.explain()
    found = forward(Inquiry(setting, case, given, setting, case, given), revisions(setting), lambda _: None)
    assert [r.effect for r in found.setting.revised] == ["gravity"]
    assert proved(found).setting.revised == found.setting.revised
    monkeypatch.setattr("symdyn.numeric.freed.STRONGEST", 5.0)
    assert proved(found).setting.revised == ()
    assert "gravity at base was taken out again" in proved(found).alarms[-1]


@pytest.mark.slow
def test_a_revision_that_is_not_credible_is_no_finding(monkeypatch: pytest.MonkeyPatch) -> None:
    """The same recordings as above, with the limit below what they need."""
    monkeypatch.setattr("symdyn.numeric.freed.STRONGEST", 5.0)
    robot = robot_from_text(set_gravity(ARM_OF_TWO, (0.0, 0.0, 0.0)), "two.toml")
    found = diagnose(robot, run(1), run(2))
    assert "gravity" not in {f.effect for f in found.findings}


@pytest.mark.slow
def test_efforts_that_are_late_are_named_beside_gravity() -> None:
    runs = []
    for seed in (1, 2):
        shown = run(seed)
        late = {
            k: np.concatenate([v[:1].repeat(8), v[:-8]]) for k, v in shown.channels.items() if k[0] is Quantity.EFFORT
        }
        runs.append(replace(shown, channels={**shown.channels, **late}))
    robot = robot_from_text(set_gravity(ARM_OF_TWO, (0.0, 0.0, 0.0)), "two.toml")
    found = diagnose(robot, *runs)
    assert [(f.effect, f.place) for f in found.findings] == [("gravity", "base"), ("channel_skew", "recording")]
    delay = found.findings[1].parameters["delay"]
    assert delay.se is not None
    assert delay.value == pytest.approx(0.016, abs=max(4.0 * delay.se, 2e-4))


def test_a_revision_that_was_refused_is_fitted_again_when_it_promises_more() -> None:
    """The recording lacks nothing: no revision is confirmed."""
    setting = prepare(pendulum(), record(1), record(2), lambda _: None)
    case = setting.case(setting.given())
    given = case.explain()
    inquiry = Inquiry(setting, case, given, setting, case, given)
    search = Search(case.laws, given.fit.p, given.training, given.design, given.weight)
    asked: list[int] = []

    class Hopeful:
        """Promises to take off half of what is left, and comes to nothing."""

        key, label = ("encoder", "arm"), "hopeful"

        def columns(self, inquiry: Inquiry) -> list[Array]:
            half = np.where(np.arange(len(given.training)) % 2, given.training[:, 0], 0.0)
            return [half[:, None, None]]

        def revised(self, inquiry: Inquiry, tried: int) -> None:
            asked.append(tried)

        def refitted(self, inquiry: Inquiry) -> None:
            return None

    promised: dict[str, float] = {}
    for times in (1, 1):
        assert _revised(inquiry, search, [Hopeful()], [], None, promised, lambda _: None) is None
        assert len(asked) == times
    promised["hopeful"] *= 0.9  # when there was less to take off
    assert _revised(inquiry, search, [Hopeful()], [], None, promised, lambda _: None) is None
    assert len(asked) == 2


@pytest.mark.parametrize(("independent", "told"), [(400, "encoder"), (20_000, "gravity")])
def test_numbers_more_must_be_worth_it(monkeypatch: pytest.MonkeyPatch, independent: int, told: str) -> None:
    """Gravity is likelier than the encoder's offset by a quarter of a percent: beyond chance, for two numbers more."""
    rng = np.random.default_rng(0)
    noise, more = rng.normal(size=(2, 20_000, 1))
    monkeypatch.setattr("symdyn.numeric.forward.independent_samples", lambda bench: independent)

    def fitted(effect: str, size: int, training: Array) -> Any:
        after = SimpleNamespace(case=SimpleNamespace(bench=None), current=SimpleNamespace(training=training))
        return SimpleNamespace(revision=SimpleNamespace(key=(effect, "at")), size=size), after

    chosen, _, rivals = _simplest([fitted("encoder", 1, noise + 0.05 * more), fitted("gravity", 3, noise)])
    assert chosen.revision.key[0] == told
    assert [r.effect for r in rivals] == (["gravity"] if told == "encoder" else [])


def test_readings_are_taken_back_and_those_of_the_model_are_known() -> None:
    robot: Robot = load_robot("two-link")
    text = add_effect(robot.text, "encoder", "elbow", {"gain": "1.1", "offset": "0.2 rad"})
    assert declared(robot_from_text(text, "two-link.toml")) == (Reading(), Reading(1.1, 0.2))
    swing = pendulum(add_effect(TOML, "effort_saturation", "arm", {"limit": "3 N m"}))
    assert declared(swing) == (Reading(limit=3.0),)
    seen = observe(swing, compile_robot(swing).kernel(), record(1))
    shown = replace(seen, q=1.1 * seen.q + 0.2, qd=1.1 * seen.qd, qdd=1.1 * seen.qdd)
    back = read(shown, (Reading(1.1, 0.2, 3.0),))
    for name in ("q", "qd", "qdd"):
        np.testing.assert_allclose(getattr(back, name), getattr(seen, name), rtol=0, atol=1e-12)
    assert np.abs(back.tau).max() == 3.0


def test_an_effect_is_edited_where_it_stands() -> None:
    once = set_effect(TOML, "encoder", "arm", {"offset": "0.1 rad"})
    twice = set_effect(once, "encoder", "arm", {"offset": "0.2 rad", "gain": "1.1"})
    assert once.count("encoder") == twice.count("encoder") == 1
    assert declared(pendulum(twice)) == (Reading(1.1, 0.2),)


def test_where_no_effort_acts_nothing_is_set_right() -> None:
    """Gravity and inertia could both be nothing there, and would leave no error at all."""
    idle = record(1, lambda t, q, v, a: -(TURNING * a + VISCOUS * v + MASS * GRAVITY * ARM * np.cos(q)), noise=False)
    assert not np.any(np.abs(idle.channel(Quantity.EFFORT, "arm")) > 1e-12)
    free = Recording(
        idle.name,
        idle.time,
        {k: 0.0 * x if k[0] is Quantity.EFFORT else x for k, x in idle.channels.items()},
        idle.sample_time,
        idle.segments,
        (),
        idle.sha256,
    )
    assert revisions(prepare(pendulum(), free, free, lambda _: None)) == ()
    assert revisions(prepare(pendulum(), record(1), record(2), lambda _: None))
