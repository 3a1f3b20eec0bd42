"""One diagnosis of several: of the parts that torque sensors cut a machine into."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.cut import Part
from symdyn.numeric.findings import Diagnosis, Errors, Finding, NoiseFloor, Traces, Verdict
from symdyn.spec.records import Robot

Array = NDArray[np.float64]

WORST_FIRST = (Verdict.UNEXPLAINED, Verdict.AMBIGUOUS, Verdict.MISSING_PHYSICS, Verdict.COMPLETE)


def united(robot: Robot, parts: Sequence[Part], found: Sequence[Diagnosis], told: Sequence[str]) -> Diagnosis:
    """Of the parts of a ``robot``, each diagnosed after the one before it; with what else is to be ``told``.

    Errors are the root mean square over all joints and drives; a verdict is the least that may be said of any of them.
    """
    found = [_in_whole(part, one) for part, one in zip(parts, found, strict=True)]
    first = found[0]
    alarms = tuple(dict.fromkeys((*told, *(alarm for one in found for alarm in one.alarms))))
    if len(found) == 1:
        return replace(first, robot=robot, alarms=alarms)
    floors = [one.noise_floor for one in found]
    counts = [len(one.per_joint) for one in found]
    worst = max((one.remaining for one in found), key=lambda left: (left.structured, left.size))
    after = _over_all([one.after for one in found], counts)
    return replace(
        first,
        verdict=min((one.verdict for one in found), key=WORST_FIRST.index),
        robot=robot,
        diagnosed=found[-1].diagnosed,
        findings=tuple(_in_turn(found, counts)),
        model={name: value for one in found for name, value in one.model.items()},
        before=_over_all([one.before for one in found], counts),
        after=after,
        per_joint_before={at: errors for one in found for at, errors in one.per_joint_before.items()},
        per_joint={at: errors for one in found for at, errors in one.per_joint.items()},
        remaining=replace(worst, heldout=after.heldout),
        alarms=alarms,
        traces=_side_by_side([one.traces for one in found]),
        located=tuple(sorted((at for one in found for at in one.located), key=lambda at: -at.evidence)),
        noise_floor=NoiseFloor(
            _over_all([floor.errors for floor in floors if floor], counts),
            {at: errors for floor in floors if floor for at, errors in floor.per_joint.items()},
        )
        if all(floors)
        else None,
    )


def _in_turn(found: Sequence[Diagnosis], counts: Sequence[int]) -> Iterator[Finding]:
    """The findings of one part after the other, with what each left of the whole."""
    left = [one.before.heldout for one in found]
    for i, one in enumerate(found):
        for finding in one.findings:
            before, after, *others = (
                _root_mean([*left[:i], error, *left[i + 1 :]], counts)
                for error in (finding.heldout_before, finding.heldout_after, *(a.heldout for a in finding.alternatives))
            )
            alternatives = (replace(a, heldout=e) for a, e in zip(finding.alternatives, others, strict=True))
            yield replace(finding, heldout_before=before, heldout_after=after, alternatives=tuple(alternatives))
            left[i] = finding.heldout_after
        left[i] = one.after.heldout


def _over_all(errors: Sequence[Errors], counts: Sequence[int]) -> Errors:
    training, heldout = ([getattr(e, of) for e in errors] for of in ("training", "heldout"))
    return Errors(_root_mean(training, counts), _root_mean(heldout, counts))


def _root_mean(errors: Sequence[float], counts: Sequence[int]) -> float:
    return float(np.sqrt(np.average(np.square(errors), weights=counts)))


def _in_whole(part: Part, one: Diagnosis) -> Diagnosis:
    """With places called as they are in the whole robot."""
    left = one.remaining
    return replace(
        one,
        findings=tuple(_finding(part, finding) for finding in one.findings),
        per_joint_before={part.named(at): errors for at, errors in one.per_joint_before.items()},
        per_joint={part.named(at): errors for at, errors in one.per_joint.items()},
        remaining=replace(
            left,
            place=left.place and part.named(left.place),
            variable=left.variable and part.named(left.variable),
        ),
        alarms=tuple(map(part.named, one.alarms)),
        traces=replace(
            one.traces,
            joints=tuple(map(part.named, one.traces.joints)),
            missing=tuple(replace(force, place=part.named(force.place)) for force in one.traces.missing),
        ),
        located=tuple(
            replace(at, place=part.named(at.place), group=_once(map(part.named, at.group))) for at in one.located
        ),
        noise_floor=one.noise_floor
        and replace(
            one.noise_floor, per_joint={part.named(at): errors for at, errors in one.noise_floor.per_joint.items()}
        ),
    )


def _finding(part: Part, finding: Finding) -> Finding:
    return replace(
        finding,
        place=part.place(finding.effect, finding.place),
        group=_once(part.place(finding.effect, at) for at in finding.group),
        elsewhere={part.place(finding.effect, at): values for at, values in finding.elsewhere.items()},
        rivals=tuple(replace(r, place=part.place(r.effect, r.place)) for r in finding.rivals),
        same_as=tuple(replace(r, place=part.place(r.effect, r.place)) for r in finding.same_as),
        alternatives=tuple(
            replace(other, place=part.place(other.effect, other.place)) for other in finding.alternatives
        ),
    )


def _once(places: Iterable[str]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(places))


def _side_by_side(traces: Sequence[Traces]) -> Traces:
    """At the times of the one that has most, the others drawn straight between theirs."""
    time = max((each.time for each in traces), key=len)

    def all_of(name: str) -> Array:
        columns = [column for each in traces for column in _at(time, each.time, getattr(each, name))]
        return np.column_stack(columns)

    known = [each.noise for each in traces if each.noise is not None]
    return Traces(
        time, all_of("q"), all_of("qd"), all_of("effort"), all_of("before"), all_of("after"),
        tuple(joint for each in traces for joint in each.joints),
        tuple(unit for each in traces for unit in each.effort_units),
        np.concatenate(known) if len(known) == len(traces) else None,
        tuple(force for each in traces for force in each.missing),
    )  # fmt: skip


def _at(time: Array, of: Array, values: Array) -> list[Array]:
    return [np.interp(time, of, column) for column in values.T]
