"""Forward selection: cross-validation by taking shares away is that of refitting; high orders are found."""

from __future__ import annotations

from types import MappingProxyType

import numpy as np
import pytest

from symdyn.compiler import robot_from_text
from symdyn.numeric.candidates import candidates
from symdyn.numeric.diagnose import diagnose
from symdyn.numeric.explanation import Case
from symdyn.numeric.findings import Verdict
from symdyn.numeric.recording import Recording
from symdyn.numeric.regression import solve_linear
from symdyn.numeric.scan import grid, peaks, periodogram
from symdyn.numeric.search import FOLDS, Search
from symdyn.numeric.setting import Setting, prepare
from symdyn.spec.records import Quantity, Robot, Side

from .arm_of_two import ARM_OF_TWO, run
from .pendulum import ANGLE_NOISE, ARM, GRAVITY, MASS, TOML, TURNING, VISCOUS, Array, pendulum, record

HELDOUT = 100


@pytest.fixture(scope="module")
def robot() -> Robot:
    return pendulum()


@pytest.fixture(scope="module")
def setting(robot: Robot) -> Setting:
    def missing(t: Array, q: Array, v: Array, a: Array) -> Array:
        return 0.3 * np.sign(v) + 0.1 * np.sin(9 * q)

    return prepare(robot, record(1, missing), record(1 + HELDOUT, missing), lambda _: None)


@pytest.fixture(scope="module")
def case(setting: Setting) -> Case:
    return setting.case(5.0)


def refitted(design: Array, target: Array) -> Array:
    """Errors of each block under a fit to the others, by least squares on all rows."""
    errors = np.empty_like(target)
    for block in np.array_split(np.arange(len(target)), FOLDS):
        rest = np.setdiff1d(np.arange(len(target)), block)
        errors[block] = target[block] - design[block] @ solve_linear(design[rest], target[rest])
    return errors


def test_what_grows_by_itself_is_tried_with_distances_like_the_travel(robot: Robot, case: Case) -> None:
    """Over ten times its own a loop that stiffens would be twenty thousand times as stiff."""
    (law,) = (c for c in candidates(robot) if c.effect == "hardening_hysteresis")
    travel = float(np.ptp(case.bench.observation.q))
    shapes = grid(law, 0, case.bench)
    assert sorted({d / travel for d, _ in shapes}) == pytest.approx([0.25, 0.5, 1.0, 2.0])
    assert {ratio for _, ratio in shapes} == {1.0, 2.0, 5.0}
    p = case.bench.kernel.values
    for shape in shapes:
        assert 0.0 < np.abs(case.laws.columns(law, shape, p)).max() < 100.0 * travel


@pytest.mark.parametrize(
    "effect", ["coulomb_friction", "linear_spring", "stribeck_friction", "torque_ripple", "dahl_friction"]
)
def test_errors_of_a_trial_are_those_of_refitting(setting: Setting, case: Case, effect: str) -> None:
    given = case.explain()
    search = Search(case.laws, given.fit.p, given.training, given.design, given.weight)
    target = given.training * given.weight
    scale = np.abs(target).max()
    np.testing.assert_allclose(search.errors, refitted(given.design * given.weight[:, None], target), atol=1e-6 * scale)
    (candidate,) = (c for c in setting.proposed if c.effect == effect)
    trial = search.trial(candidate)
    columns = case.laws.spread(candidate, case.laws.columns(candidate, trial.shapes, given.fit.p))
    design = np.concatenate([given.design, columns], axis=2) * given.weight[:, None]
    np.testing.assert_allclose(trial.errors, refitted(design, target), atol=1e-5 * scale)
    estimate = solve_linear(design, target)[-columns.shape[2] :]
    np.testing.assert_allclose(trial.estimate, estimate, rtol=1e-5, atol=1e-8)


def test_periodogram_peaks_at_the_order_that_is_there() -> None:
    rng = np.random.default_rng(0)
    angle = np.cumsum(rng.uniform(0.0, 0.01, 5000))
    left = np.sin(37.3 * angle + 0.4) + rng.standard_normal(5000)
    tried = np.arange(1.0, 60.0, 0.1)
    power = periodogram(left, angle, np.ones(5000), tried, 100.0)
    assert tried[peaks(power)[0]] == pytest.approx(37.3, abs=0.11)


@pytest.mark.parametrize("count", [1, 2, 500])
def test_periodogram_is_the_power_of_each_wave_where_it_is_slow(count: int) -> None:
    rng = np.random.default_rng(1)
    angle, left = np.cumsum(rng.uniform(0.0, 0.01, 2000)), rng.standard_normal(2000)
    speed, tried = rng.uniform(-3.0, 3.0, 2000), 2.0 + 0.25 * np.arange(count)
    expected = []
    for order in tried:
        slow = order * np.abs(speed) < 2.0 * np.pi * 10.0
        wave = np.exp(1j * order * angle[slow])
        expected.append(np.abs(np.vdot(wave, left[slow])) ** 2 / max(int(np.sum(slow)), 1))
    found = periodogram(left, angle, speed, tried, 10.0)
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-12 * max(expected))


def test_what_a_shape_leaves_is_as_large_folded() -> None:
    """At one joint of two, beside the parameters of the model: least squares on all rows leaves as much."""
    arm = robot_from_text(ARM_OF_TWO, "two.toml")
    case = prepare(arm, run(1), run(1 + HELDOUT), lambda _: None).case(5.0)
    given = case.explain()
    search = Search(case.laws, given.fit.p, given.training, given.design, given.weight)
    for place in ("one", "two"):
        (law,) = (c for c in candidates(arm) if (c.effect, c.place.address) == ("stribeck_friction", place))
        columns = case.laws.spread(law, case.laws.columns(law, (0.3,), given.fit.p))
        design = np.concatenate([given.design, columns], axis=2) * given.weight[:, None]
        target = given.training * given.weight
        expected = target - design @ solve_linear(design, target)
        folded = search._unexplained(law, (0.3,))
        assert len(folded) < expected.size
        assert np.sum(folded**2) == pytest.approx(np.sum(expected**2), rel=1e-9)


@pytest.mark.slow  # whole diagnoses
@pytest.mark.parametrize("level", [0.5, 0.0])
def test_ripple_of_a_high_order_is_found(robot: Robot, level: float) -> None:
    """A harmonic drive has two waves per turn of its generator: an order no short grid holds.

    Friction hides it; and where nothing else is missing, it is as even as noise in the band of the motion.
    """

    def missing(t: Array, q: Array, v: Array, a: Array) -> Array:
        return level * np.sign(v) - 0.15 * np.sin(150 * q)

    found = diagnose(robot, record(1, missing), record(1 + HELDOUT, missing))
    assert found.verdict is Verdict.MISSING_PHYSICS
    effects = {f.effect: f for f in found.findings}
    assert set(effects) == ({"coulomb_friction", "torque_ripple"} if level else {"torque_ripple"})
    order = effects["torque_ripple"].parameters["order"]
    assert order.value == pytest.approx(150.0, abs=0.2)
    amplitude = np.hypot(*(effects["torque_ripple"].parameters[name].value for name in ("sine", "cosine")))
    assert amplitude == pytest.approx(0.15, rel=0.05)


@pytest.mark.slow
def test_a_ripple_that_goes_round_once_takes_the_place_of_springs(robot: Robot) -> None:
    """Six waves per turn in a travel of 1.5 rad: springs come first, then the wave; whether it repeats is open."""

    def missing(t: Array, q: Array, v: Array, a: Array) -> Array:
        return 0.3 * np.sign(v) + 0.4 * np.sin(6 * q + 0.6)

    found = diagnose(robot, record(1, missing), record(1 + HELDOUT, missing))
    assert {f.effect for f in found.findings} == {"coulomb_friction", "torque_ripple"}
    ripple = found.findings[-1].parameters
    assert ripple["order"].value == pytest.approx(6.0, abs=0.02)
    for name, size in (("cosine", 0.4 * np.sin(0.6)), ("sine", 0.4 * np.cos(0.6))):
        assert -ripple[name].value == pytest.approx(size, rel=0.01)
    assert any("would show whether it repeats" in alarm for alarm in found.alarms)


@pytest.mark.slow
def test_part_of_a_wave_may_be_a_spring(robot: Robot) -> None:
    """Over a third of a wave, a spring with more numbers does as well: which it is, the recording does not tell."""

    def missing(t: Array, q: Array, v: Array, a: Array) -> Array:
        return 0.3 * np.sin(1.6 * q + 0.4)

    found = diagnose(robot, record(1, missing), record(1 + HELDOUT, missing))
    assert found.verdict is Verdict.AMBIGUOUS
    (spring,) = found.findings
    assert {spring.effect, *(r.effect for r in spring.rivals)} == {"counterbalance_spring", "torque_ripple"}


@pytest.mark.slow
def test_a_spring_is_told_by_its_own_law(robot: Robot) -> None:
    """And by none of more numbers that comes as near."""

    def missing(t: Array, q: Array, v: Array, a: Array) -> Array:
        return 1.5 * q

    found = diagnose(robot, record(1, missing), record(1 + HELDOUT, missing))
    assert [f.effect for f in found.findings] == ["linear_spring"]
    assert found.verdict is Verdict.MISSING_PHYSICS


@pytest.mark.slow
def test_presliding_friction_is_told_from_coulomb_friction(robot: Robot) -> None:
    stiffness, level = 4.0, 0.4  # reached over a tenth of a radian

    def missing(t: Array, q: Array, v: Array, a: Array) -> Array:
        force = np.zeros_like(q)
        for k in range(len(q) - 1):  # Dahl's law, exactly, from one sample to the next
            way = q[k + 1] - q[k]
            end = level * np.sign(way)
            force[k + 1] = end + (force[k] - end) * np.exp(-stiffness * abs(way) / level)
        return force

    found = diagnose(robot, record(1, missing), record(1 + HELDOUT, missing))
    assert [f.effect for f in found.findings] == ["dahl_friction"]
    values = found.findings[0].parameters
    assert values["level"].value == pytest.approx(level, rel=0.02)
    assert values["stiffness"].value == pytest.approx(stiffness, rel=0.05)
    assert values["stiffness"].se is not None


def swing(seed: int, level: float) -> Recording:
    """The arm let go, with viscous friction and Coulomb friction of a level; no effort acts. Runge-Kutta, 10 kHz."""
    rng = np.random.default_rng([seed, 2])
    step, thin, count = 1e-4, 20, 60_000

    def rate(q: float, v: float) -> float:
        friction = VISCOUS * 0.1 * v + level * np.tanh(v / 1e-4)
        return float(-(MASS * GRAVITY * ARM * np.cos(q) + friction) / TURNING)

    q, v, angles = -0.5 - 0.3 * rng.uniform(), 0.0, []
    for k in range(count):
        if k % thin == 0:
            angles.append(q)
        a = rate(q, v)
        middle = rate(q + 0.5 * step * v, v + 0.5 * step * a)
        q, v = q + step * v + 0.5 * step**2 * middle, v + step * middle
    angle = np.array(angles) + ANGLE_NOISE * rng.standard_normal(len(angles))
    time = np.arange(len(angle)) * step * thin
    channels = {(Quantity.POSITION, "arm", Side.LINK): angle}
    return Recording(
        f"swing-{seed}", time, MappingProxyType(channels), step * thin, (slice(0, len(time)),), (), "0" * 64
    )


@pytest.mark.slow
@pytest.mark.parametrize("level", [0.0, 0.05])
def test_a_free_swing_tells_its_friction(level: float) -> None:
    text = TOML.replace('name = "arm"\n', 'name = "arm"\npassive = true\n')
    text = text.replace(f'b = "{VISCOUS} N', f'b = "{0.1 * VISCOUS} N')
    found = diagnose(pendulum(text), swing(1, level), swing(1 + HELDOUT, level))
    assert [f.effect for f in found.findings] == (["coulomb_friction"] if level else [])
    for finding in found.findings:
        assert finding.parameters["level"].value == pytest.approx(level, rel=0.05)
        assert 0 < finding.heldout_after < finding.heldout_before
