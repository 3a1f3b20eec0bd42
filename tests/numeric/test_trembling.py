"""What the noise of positions does to a fit, and how its intervals allow for that."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from symdyn.numeric.cut import UNCUT
from symdyn.numeric.diagnose import _begun
from symdyn.numeric.explanation import Explanation
from symdyn.numeric.inquiry import Inquiry
from symdyn.numeric.recording import Recording
from symdyn.numeric.trembling import with_trembling
from symdyn.spec.records import Quantity

from .pendulum import TURNING, pendulum, record, recording

BAND = 40.0  # Hz: far above the motion
TREMBLES = 3e-5  # rad


def quiet(_: str) -> None:
    return None


def measured(seed: int, tremble: float) -> Recording:
    """With dry friction of 0.3 N m, and an encoder that trembles."""
    shown = record(seed, lambda t, q, v, a: 0.3 * np.sign(v))
    q, tau = (shown.channel(of, "arm") for of in (Quantity.POSITION, Quantity.EFFORT))
    return recording(shown.time, q + tremble * np.random.default_rng(seed).standard_normal(len(q)), tau)


def found(tremble: float) -> Inquiry:
    """The friction found, by what a trembling encoder shows."""
    begun = _begun(UNCUT, pendulum(), (measured(1, tremble), measured(2, tremble)), BAND, frozenset(), quiet)
    law = next(c for c in begun.setting.proposed if c.effect == "coulomb_friction")
    return replace(begun, current=begun.case.explain(((law, ()),), begun.given))


def inertia(inquiry: Inquiry, of: Explanation) -> tuple[float, float]:
    """Estimate of the moment of inertia about the axis, which is I and m r^2 together, and its standard error."""
    kernel, names = inquiry.case.bench.kernel, of.fit.names
    value = float(kernel.mass_matrix_p(np.zeros(1), of.fit.p)[0, 0])
    slope = np.zeros(len(names))
    for i, name in enumerate(names):
        if name in inquiry.case.own:
            at, step = kernel.parameters.index(name), 1e-6
            moved = of.fit.p.copy()
            moved[at] += step
            slope[i] = (float(kernel.mass_matrix_p(np.zeros(1), moved)[0, 0]) - value) / step
    return value, float(np.sqrt(slope @ of.fit.last.covariance @ slope))


def test_an_inertia_that_trembling_accelerations_make_smaller_says_so() -> None:
    inquiry = found(TREMBLES)
    before, after = (inertia(inquiry, each.current) for each in (inquiry, with_trembling(inquiry, quiet)))
    assert before[0] == after[0] < TURNING
    assert TURNING - before[0] > 4.0 * before[1]  # an interval that does not hold what it should
    assert TURNING - after[0] < 2.0 * after[1]
    assert after[1] < 2.0 * (TURNING - after[0])


def test_what_does_not_tremble_stays_as_it_was() -> None:
    inquiry = found(0.0)
    before, after = (inertia(inquiry, each.current) for each in (inquiry, with_trembling(inquiry, quiet)))
    assert after[1] == pytest.approx(before[1], rel=0.1)
    assert with_trembling(replace(inquiry, current=inquiry.given), quiet).current is inquiry.given


def test_a_clock_that_is_put_right_has_other_samples() -> None:
    """An observation at even steps may have one less than the recording, to which the noise is added."""
    begun = found(TREMBLES)
    seen = begun.setting.seen
    less = len(seen.measured) - 1
    fewer = replace(seen, measured=seen.measured[:less], segments=(slice(0, less),))
    whole, short = (
        inertia(each, with_trembling(each, quiet).current)
        for each in (begun, replace(begun, setting=replace(begun.setting, seen=fewer)))
    )
    assert short == pytest.approx(whole, rel=0.05)
