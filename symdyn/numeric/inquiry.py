"""Where a diagnosis stands: what was found so far, and the case that it was found in."""

from __future__ import annotations

from dataclasses import dataclass, replace

from symdyn.numeric.candidates import Candidate
from symdyn.numeric.evidence import gaussian_gain
from symdyn.numeric.explanation import Case, Explanation, Revised, heldout_gain
from symdyn.numeric.findings import Alternative, Estimate, Finding
from symdyn.numeric.groups import rigid_group
from symdyn.numeric.noise_floor import independent_samples
from symdyn.numeric.setting import Setting


@dataclass(frozen=True, slots=True, eq=False)
class Inquiry:
    """Every step gives another one; ``origin``, ``first`` and ``given`` are setting, case and model as they came."""

    origin: Setting
    first: Case
    given: Explanation
    setting: Setting
    case: Case
    current: Explanation
    findings: tuple[Finding, ...] = ()
    alarms: tuple[str, ...] = ()
    motion: float | None = None  # Hz: band of the positions, where that of the efforts is wider

    @property
    def band(self) -> tuple[float, float | None]:
        """As ``Setting.case`` takes it."""
        return self.case.bench.edge, self.motion

    def noting(self, *alarms: str) -> Inquiry:
        return replace(self, alarms=(*self.alarms, *alarms))

    def settled(self) -> Inquiry:
        """Those of the findings that are still held, with their final values."""
        kept = {c.key: self.case.parameters(c, self.current) for c, _ in self.current.found}
        kept |= {(r.effect, r.place, 1): estimates(self.case, r, self.current) for r in self.case.revised}
        findings = [replace(f, parameters=kept[f.key]) for f in self.findings if f.key in kept]
        return replace(self, findings=tuple(findings))


def estimates(case: Case, revised: Revised, of: Explanation) -> dict[str, Estimate]:
    """What a revision found, by the names of a finding."""
    fitted = case.model_parameters(of)
    return {**revised.values, **{told: fitted[name] for told, name in revised.names.items()}}


def finding_of(
    case: Case, candidate: Candidate, before: Explanation, after: Explanation, others: tuple[Alternative, ...] = ()
) -> Finding:
    """An effect that explains more than what stood before it."""
    joint = case.robot.joints[case.joints.index(candidate.place.address)]
    parameters = case.parameters(candidate, after)
    group = rigid_group(joint, candidate.effect)
    found = _finding(
        case, before, after, candidate.effect, candidate.named, candidate.place.address, parameters, others, group
    )
    return replace(found, number=candidate.number)


def finding_of_revision(case: Case, revised: Revised, before: Explanation, after: Explanation) -> Finding:
    parameters = estimates(case, revised, after)
    return _finding(case, before, after, revised.effect, revised.title, revised.place, parameters, (), ())


def _finding(
    case: Case,
    before: Explanation,
    after: Explanation,
    effect: str,
    title: str,
    place: str,
    parameters: dict[str, Estimate],
    others: tuple[Alternative, ...],
    group: tuple[str, ...],
) -> Finding:
    old, new = case.errors(before).heldout, case.errors(after).heldout
    p_value = heldout_gain(before, after)[1]
    evidence = gaussian_gain(before.heldout, after.heldout, independent_samples(case.judge))
    return Finding(effect, title, place, parameters, old, new, p_value, (), others, group, evidence)
