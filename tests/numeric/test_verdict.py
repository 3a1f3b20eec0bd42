"""The rules of the verdict, one by one."""

from __future__ import annotations

from dataclasses import replace

import pytest

from symdyn.numeric.findings import Errors, Finding, Remaining, Rival, Verdict
from symdyn.numeric.verdict import ALL, EXPLAINED, HOLDS, explained_share, that_matters, verdict_of

BEFORE, AFTER = Errors(0.1, 0.1), Errors(0.01, 0.01)
SURE = Finding("coulomb_friction", "Coulomb friction", "arm", {}, 0.1, 0.01, 1e-9, ())
UNSURE = Finding("coulomb_friction", "Coulomb friction", "arm", {}, 0.1, 0.01, 1e-9, (Rival("spring", "arm", 0.4),))


def left(share: float, structured: bool = True) -> Remaining:
    return Remaining(0.01, structured, share, "speed of arm" if structured else None, 1e-6, 0.009)


@pytest.mark.parametrize(
    ("findings", "remaining", "needed", "verdict"),
    [
        ((), left(0.0, False), EXPLAINED, Verdict.COMPLETE),
        ((), left(0.4), EXPLAINED, Verdict.UNEXPLAINED),
        ((SURE,), left(0.0, False), EXPLAINED, Verdict.MISSING_PHYSICS),
        ((SURE,), left(0.4), EXPLAINED, Verdict.MISSING_PHYSICS),
        ((SURE,), left(0.4), HOLDS, Verdict.MISSING_PHYSICS),
        ((SURE,), left(0.9), HOLDS, Verdict.UNEXPLAINED),
        ((SURE,), left(0.4), ALL, Verdict.UNEXPLAINED),
        ((SURE,), left(0.0, False), ALL, Verdict.MISSING_PHYSICS),
        ((SURE, UNSURE), left(0.0, False), EXPLAINED, Verdict.AMBIGUOUS),
        ((UNSURE,), left(0.4), EXPLAINED, Verdict.AMBIGUOUS),
        ((UNSURE,), left(0.9), HOLDS, Verdict.UNEXPLAINED),
    ],
)
def test_rules(findings: tuple[Finding, ...], remaining: Remaining, needed: float, verdict: Verdict) -> None:
    assert verdict_of(findings, remaining, BEFORE, AFTER, needed) is verdict


def test_a_finding_that_tells_a_small_part_is_no_explanation() -> None:
    after = Errors(0.09, 0.09)
    rest = Remaining(0.09, True, 0.9, "speed of arm", 1e-6, 0.08)
    assert explained_share(0.9, rest, BEFORE, after) == pytest.approx(0.0019 / (0.0019 + 0.9 * 0.0081))
    assert verdict_of((SURE,), rest, BEFORE, after) is Verdict.UNEXPLAINED


def test_what_is_slow_counts_beside_a_little_that_follows_a_variable() -> None:
    before, after = Errors(1.15, 1.15), Errors(1.05, 1.05)
    rest = Remaining(1.05, True, 0.06, "position of elbow", 1e-6, 0.3)
    assert verdict_of((SURE,), rest, before, after) is Verdict.MISSING_PHYSICS
    assert verdict_of((SURE,), replace(rest, slow=0.9), before, after) is Verdict.UNEXPLAINED


def test_what_is_left_without_structure_counts_for_nothing() -> None:
    assert explained_share(0.05, Remaining(0.09, False, 0.05, None, 0.5, 0.0), BEFORE, Errors(0.09, 0.09)) == 1.0
    assert explained_share(0.0, Remaining(0.1, False, 0.0, None, 1.0, 0.0), BEFORE, BEFORE) == 0.0


def test_a_trace_that_no_sensor_tells_is_no_structure_that_matters() -> None:
    told = Remaining(0.0049, True, 0.1, "speed of arm", 1e-9, size=0.0009, place="arm")
    assert that_matters(replace(told, size=0.0011), (), {}).structured
    assert that_matters(told, (SURE,), {}).structured  # it may be much, beside what the finding took off
    steps = Finding("encoder", "encoder resolution", "arm", {}, 0.0049, 0.0049, 0.0, ())
    for findings, verdict in (((), Verdict.COMPLETE), ((steps,), Verdict.MISSING_PHYSICS)):
        trace = that_matters(told, findings, {})
        assert (trace.structured, trace.variable, trace.place, trace.heldout) == (False, None, None, 0.0049)
        assert verdict_of(findings, trace, BEFORE, AFTER) is verdict


def test_structure_that_samples_and_steps_leave_is_nothing_that_is_missing() -> None:
    told = Remaining(0.02, True, 0.3, "speed of arm", 1e-9, size=0.011, place="arm")
    for findings in ((), (SURE,)):
        assert that_matters(told, findings, {"arm": 0.01, "hand": 0.1}).structured
        assert not that_matters(told, findings, {"arm": 0.012, "hand": 0.0}).structured
