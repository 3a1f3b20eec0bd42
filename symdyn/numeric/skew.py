"""Efforts that were recorded later or earlier than the motion: told from missing physics, if it can be."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from symdyn.base.errors import BadRecording, Problem
from symdyn.numeric.explanation import LEVEL, Case, Explanation, heldout_gain
from symdyn.numeric.findings import Estimate, Finding
from symdyn.numeric.free_form import FreeForm, fitted_of
from symdyn.numeric.inquiry import Inquiry
from symdyn.numeric.misread import NEAR, ROUNDS
from symdyn.numeric.observation import derivative
from symdyn.numeric.regression import encompassing, fit_linear
from symdyn.numeric.workbench import Workbench

Array = NDArray[np.float64]

# Of the residual's power on held-out data, what makes a skew the cause:
MOST = 0.8  # if it tells more than any one effect
HALF = 0.5  # if it tells more than all effects together
SOME = 0.1  # worth naming
STEPS = 1.0  # samples: up to here skews are those of any sampled system, whose efforts are held from one to the next
LITTLE = 0.25  # samples: less does no harm
CERTAIN = 4.0  # standard errors

CHANNEL_SKEW, RECORDING = "channel_skew", "recording"  # of a finding: effect and place


@dataclass(frozen=True, slots=True, eq=False)
class Skew:
    """All efforts late by ``delay`` (s) against the motion; ``heldout`` (K, n) is the weighted residual without it."""

    delay: float
    se: float
    share: float  # of the residual's power on held-out data that it tells
    heldout: Array
    p_value: float  # of "it tells nothing" there

    @property
    def text(self) -> str:
        way = "late" if self.delay > 0.0 else "early"
        return f"efforts {abs(self.delay):.3g} +- {self.se:.1g} s {way} against the motion"


def effort_skew(case: Case, of: Explanation) -> Skew:
    """The skew that suits the residual best, the model's parameters fitted together with it.

    Effort that is late by d misses -d times its own derivative, to first order.
    """
    training, heldout = (_derivative(w) * of.weight for w in (case.bench, case.judge))
    columns = FreeForm(fitted_of(case, of)).forces(-training, -heldout)
    target, before = of.training * of.weight, of.heldout * of.weight
    found = fit_linear(columns.training, target)
    delay = float(found.estimate[0])
    after = before - columns.heldout[:, :, 0] * delay
    share = 1.0 - float(np.sum(after**2)) / max(float(np.sum(before**2)), 1e-300)
    return Skew(delay, float(found.standard_error[0]), share, after, encompassing(before, after)[1])


def check_skew(first: Case, given: Explanation, final: Explanation) -> None:
    """Raise BadRecording (SD529) where what was found is a skew in disguise.

    That is where one number, the skew, tells half of the residual of the model as given, and more than all findings
    together.
    """
    skew = effort_skew(first, given)
    if certain(first, skew) and beyond_a_sample(first, skew) and skew.share > HALF:
        gain, p_value = encompassing(final.heldout * given.weight, skew.heldout)
        if gain > 0.0 and p_value < LEVEL:
            message = f"{skew.text}: that alone tells {100 * skew.share:.0f} % of the mismatch, more than known physics"
            hint = "align the clocks of the channels (a filter in the effort's sensor delays, too), and diagnose again"
            raise BadRecording(Problem("SD529", message, hint=hint))


def held(inquiry: Inquiry) -> Inquiry:
    """With the efforts put right by up to a sample, where that alone tells half of what the model as given leaves.

    An effort that a controller holds over a sample is logged where the hold begins (half a sample early) or where it
    ends. That is how it was recorded, and nothing that the machine lacks.
    """
    skew = effort_skew(inquiry.case, inquiry.given)
    if not certain(inquiry.case, skew) or beyond_a_sample(inquiry.case, skew) or skew.share <= HALF:
        return inquiry
    begun = aligned(inquiry)
    return replace(begun, origin=begun.setting, first=begun.case, given=begun.current)


def aligned(inquiry: Inquiry) -> Inquiry:
    """With the efforts put right by the skew that suits them best, and everything found fitted beside it."""
    for _ in range(ROUNDS):
        skew = effort_skew(inquiry.case, inquiry.current)
        if abs(skew.delay) <= NEAR * skew.se:
            break
        inquiry = earlier(inquiry, skew.delay)
    return inquiry.settled()


def with_skew(inquiry: Inquiry, before: Inquiry) -> Inquiry:
    """With a finding for the skew put right since ``before``; or without either, if later findings made it needless."""
    delay = inquiry.setting.readings[0].late
    if not delay:
        return inquiry
    skew = replace(effort_skew(inquiry.case, inquiry.current), delay=delay)
    if not certain(inquiry.case, skew):
        return earlier(inquiry, -delay).settled()
    told_so = f"{skew.text}: their clock was put right by that, and all else fitted beside it"
    if not beyond_a_sample(inquiry.case, skew):
        return inquiry.noting(f"{told_so}; so little is that of efforts that are held from sample to sample")
    was, now = (i.case.errors(i.current).heldout for i in (before, inquiry))
    told, p_value = {"delay": Estimate(delay, skew.se, "s")}, heldout_gain(before.current, inquiry.current)[1]
    found = Finding(CHANNEL_SKEW, "skew of the efforts' channels", RECORDING, told, was, now, p_value, ())
    return replace(inquiry, findings=(*inquiry.findings, found)).noting(told_so)


def earlier(inquiry: Inquiry, delay: float) -> Inquiry:
    """With the efforts taken for those of ``delay`` seconds before, and everything found fitted again."""
    setting = inquiry.setting.earlier(delay)
    case = setting.case(*inquiry.band)
    return replace(inquiry, setting=setting, case=case, current=case.explain(inquiry.current.found, inquiry.current))


def a_little_late(case: Case, of: Explanation) -> bool:
    """Whether clocks are to be aligned by up to a sample, however little that tells.

    Beside viscous friction b efforts that are late by d make an inertia smaller by b d, and gravity is told from that.
    """
    left = effort_skew(case, of)
    return certain(case, left) and not beyond_a_sample(case, left)


def tells_nearly_all(case: Case, skew: Skew) -> bool:
    """Whether it may be the one cause of the mismatch, before effects were searched."""
    return certain(case, skew) and beyond_a_sample(case, skew) and skew.share > MOST


def skew_left(case: Case, of: Explanation) -> Skew | None:
    """The skew that would tell a part worth naming of what an explanation leaves, if there is one."""
    left = effort_skew(case, of)
    return left if certain(case, left) and left.share > SOME else None


def certain(case: Case, skew: Skew) -> bool:
    """Whether it is more than chance, and enough to matter."""
    return abs(skew.delay) > max(LITTLE * case.bench.observation.sample_time, CERTAIN * skew.se)


def beyond_a_sample(case: Case, skew: Skew) -> bool:
    """Whether it is more than any sampled system has."""
    return abs(skew.delay) > STEPS * case.bench.observation.sample_time


def _derivative(workbench: Workbench) -> Array:
    """(K, n) of the measured effort, in the analysis band."""
    o = workbench.observation
    slope = np.zeros_like(o.tau)
    for part in o.segments:
        slope[part] = derivative(o.tau[part], o.time[part])
    return np.asarray(workbench.bring(slope) * workbench.counted)
