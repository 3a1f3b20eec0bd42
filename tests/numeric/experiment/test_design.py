"""Designed motions separate what other motions within the same limits do not, by as much as they promise."""

from __future__ import annotations

import numpy as np
import pytest

from symdyn.base.errors import InputError
from symdyn.compiler import load_robot
from symdyn.numeric.experiment.design import SEPARATES, Design, design
from symdyn.numeric.experiment.explanations import explained
from symdyn.numeric.experiment.limits import Limits
from symdyn.numeric.experiment.motions import Family, Motion
from symdyn.numeric.experiment.next_experiment import Plan, between_models
from symdyn.numeric.experiment.separation import Noise, refitted

from ..pendulum import ARM, GRAVITY, MASS, TURNING, VISCOUS
from .rods import NOISE, limits, rod

DURATION = 20.0


def designed(first: str, second: str, within: Limits, noise: Noise = NOISE, evaluations: int = 400) -> Design:
    return design((rod(first), rod(second)), within, noise, DURATION, evaluations=evaluations)


def random_motions(within: Limits, count: int = 16) -> list[Motion]:
    family = Family(within, DURATION)
    return [family.motion(np.random.default_rng(seed).random(family.size), 800) for seed in range(count)]


def by_hand(motion: Motion, law: np.ndarray, rival: list[np.ndarray], noise: Noise) -> float:
    """Expected nats that the rival loses: least squares on the pendulum's own terms and the rival's, written here."""
    q, v, a = (values[:, 0] for values in (motion.q, motion.qd, motion.qdd))
    effort = TURNING * a + VISCOUS * v + MASS * GRAVITY * ARM * np.cos(q) + law
    columns = np.column_stack([a, v, np.cos(q), *rival])
    left = effort - columns @ np.linalg.lstsq(columns, effort, rcond=None)[0]
    return float(0.5 * noise.rate * DURATION * np.mean((left / noise.sigma[0]) ** 2))


def test_spring_and_offset_are_separated_as_well_as_promised() -> None:
    within = limits(0.4)
    found = designed("offset", "spring", within)
    q = found.motion.q[:, 0]
    promised = by_hand(found.motion, 0.6 * q + 0.1, [np.ones_like(q)], NOISE)
    assert found.separation == pytest.approx(promised, rel=1e-6)
    assert found.separates
    usual = sorted(
        by_hand(m, 0.6 * m.q[:, 0] + 0.1, [np.ones(len(m.time))], NOISE) for m in random_motions(limits(0.04))
    )
    assert usual[len(usual) // 2] < SEPARATES < found.separation
    assert found.separation > 0.99 * usual[-1]


def test_offset_is_a_special_case_of_the_spring() -> None:
    found = designed("offset", "spring", limits(0.4), evaluations=64)
    assert [direction.nested for direction in found.directions] == [True, False]
    assert found.directions[0].nats == 0.0
    assert found.separation == found.directions[1].nats


@pytest.mark.slow
def test_friction_that_differs_by_direction_and_dry_friction() -> None:
    """Slowly, |v| looks like nothing, and fast motions are short: a motion of its own is needed."""
    within = limits(0.2)
    found = designed("asymmetric", "coulomb", within)
    v = found.motion.qd[:, 0]
    assert found.directions[0].nats == pytest.approx(
        by_hand(found.motion, 0.05 * np.abs(v), [np.sign(v)], NOISE), rel=1e-6
    )
    usual = [by_hand(m, 0.05 * np.abs(m.qd[:, 0]), [np.sign(m.qd[:, 0])], NOISE) for m in random_motions(within)]
    assert found.separates
    assert np.median(usual) < SEPARATES < found.separation
    assert found.usual == pytest.approx(np.median(usual), rel=5.0)


@pytest.mark.slow  # a whole design
def test_ripple_refits_its_order_before_it_loses() -> None:
    """A linear refit about order 11 would promise more than the spring's rival really loses."""
    found = designed("ripple", "spring", limits(0.5))
    nats, p = refitted(rod("spring"), rod("ripple"), found.motion, NOISE)
    order = p[rod("ripple").kernel.parameters.index("arm_torque_ripple_order")]
    assert found.directions[1].nats == pytest.approx(nats, rel=0.02)
    assert 5.5 <= order < 10.0
    q = found.motion.q[:, 0]
    for n in np.linspace(5.5, 22.0, 12):
        assert by_hand(found.motion, 0.6 * q + 0.1, [np.cos(n * q), np.sin(n * q)], NOISE) > 0.98 * nats


def test_same_seed_same_motion_and_another_seed_another() -> None:
    one, same, other = (
        design((rod("offset"), rod("spring")), limits(0.4), NOISE, DURATION, seed=seed, evaluations=64)
        for seed in (0, 0, 1)
    )
    assert one.motion.q.tobytes() == same.motion.q.tobytes()
    assert one.motion.q.tobytes() != other.motion.q.tobytes()


def test_same_law_with_other_numbers_is_never_separated() -> None:
    found = designed("spring", "stiffer", limits(1.0), evaluations=64)
    assert all(direction.nested for direction in found.directions)
    assert (found.separation, found.separates) == (0.0, False)
    told = between_models(rod("spring").robot, rod("stiffer").robot, limits(1.0), NOISE, Plan(evaluations=64)).told
    assert told.separation == 0.0
    assert "on every motion" in told.why
    assert "sensor" in told.why


def test_more_time_is_proposed_where_it_would_be_enough() -> None:
    found = designed("offset", "spring", limits(0.2), evaluations=64)
    assert not found.separates
    assert found.wider == "time"
    assert found.factor == pytest.approx(SEPARATES / found.separation)


def test_more_travel_is_proposed_where_time_is_not_enough() -> None:
    found = designed("ripple", "spring", limits(0.2), evaluations=64)
    assert not found.separates
    assert (found.wider, found.factor) == ("travel", 4.0)
    planned = between_models(rod("ripple").robot, rod("spring").robot, limits(0.2), NOISE, Plan(evaluations=64))
    assert "4 times the travel would" in planned.told.why


def test_effort_stays_within_its_limits() -> None:
    hold = MASS * GRAVITY * ARM  # at least 4.1 N m of it at 0.3 rad
    found = designed("ripple", "spring", limits(1.0, 8.0, 200.0, effort=1.1 * hold), evaluations=64)
    for name in ("ripple", "spring"):
        assert np.abs(rod(name).effort(found.motion)).max() <= 1.1 * hold
    assert np.abs(found.motion.qdd).max() < 60.0
    with pytest.raises(InputError, match="SD333"):
        designed("ripple", "spring", limits(0.1, effort=1.0), evaluations=64)


def test_drive_whose_joints_do_not_show_all_motion_is_refused() -> None:
    with pytest.raises(InputError, match="SD332"):
        explained(load_robot("irb6-axis1"))
