"""What has no size any more once intervals are as wide as they should be is taken out again."""

from __future__ import annotations

from dataclasses import replace

import pytest

from symdyn.compiler import robot_from_text
from symdyn.numeric.explanation import Revised
from symdyn.numeric.findings import Estimate
from symdyn.numeric.inquiry import Inquiry, finding_of
from symdyn.numeric.misread import Misread
from symdyn.numeric.proof import sized
from symdyn.numeric.setting import prepare
from symdyn.spec.places import places

from .arm_of_two import ARM_OF_TWO, rubbing


@pytest.fixture(scope="module")
def inquiry() -> Inquiry:
    """With Coulomb friction found at the second joint."""
    setting = prepare(robot_from_text(ARM_OF_TWO, "two.toml"), rubbing(1, 0.4), rubbing(2, 0.4), lambda _: None)
    case = setting.case(5.0)
    (law,) = (c for c in setting.proposed if (c.effect, c.place.address) == ("coulomb_friction", "two"))
    given = case.explain()
    dry = case.explain(((law, ()),), given)
    return Inquiry(setting, case, given, setting, case, dry, findings=(finding_of(case, law, given, dry),))


def widened(inquiry: Inquiry, times: float) -> Inquiry:
    fit = inquiry.current.fit
    last = replace(fit.last, covariance=times**2 * fit.last.covariance)
    return replace(inquiry, current=replace(inquiry.current, fit=replace(fit, last=last)))


def test_a_finding_stays_as_long_as_it_has_a_size(inquiry: Inquiry) -> None:
    estimate = inquiry.findings[0].parameters["level"]
    assert estimate.se is not None
    certain = estimate.value / (2.6 * estimate.se)  # so many times wider, it is just told from zero at 1 %
    assert certain > 2.0
    assert sized(widened(inquiry, 0.9 * certain)).findings
    less = sized(widened(inquiry, 1.1 * certain))
    assert less.findings == ()
    assert less.current.found == ()
    assert "Coulomb friction at two was taken out again" in less.alarms[-1]


def test_a_sensor_is_misread_only_where_that_has_a_size(inquiry: Inquiry, monkeypatch: pytest.MonkeyPatch) -> None:
    """As far as noise goes an encoder may show nothing wrong: then no gain is told, however much it takes off."""
    (place,) = (p for p in places(inquiry.case.robot) if p.address == "two")
    gain = Misread(1, place, "encoder", "gain")

    def told(se: float) -> Inquiry:
        revised = Revised("encoder", "encoder gain", "two", {"gain": Estimate(1.1, se, "1")})
        return replace(inquiry, setting=inquiry.setting.with_revision(revised))

    for se, has_a_size in ((0.03, True), (0.05, False)):
        after = told(se)
        monkeypatch.setattr(Misread, "_from", lambda *_, found=after: found)
        assert (gain.revised(inquiry, 0) is not None) == has_a_size
