"""From scores to numbers: proportions with Wilson intervals, the confusion matrix, what each kind of effect came to."""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from statistics import median
from typing import Any

from benchmarks.blind.score import OPEN, Effect, Score, score

Z = 1.959964  # of a 95 % interval


@dataclass(frozen=True)
class Scored:
    """A case and its score."""

    id: str
    machine: str
    group: str
    level: str
    score: Score
    error: str = ""  # why there is no answer

    @property
    def right(self) -> bool:
        """All that is concealed named and placed, and nothing else; silent where nothing is; told what is unknown."""
        one = self.score
        if self.group == "unknown":
            return one.told
        if not one.effects:
            return one.answered and not one.alarm
        return all(effect.named and effect.placed for effect in one.effects) and not one.extra


@dataclass(frozen=True)
class Share:
    """``hits`` of ``count``, with Wilson's 95 % interval."""

    hits: int
    count: int

    @property
    def value(self) -> float | None:
        return self.hits / self.count if self.count else None

    @property
    def interval(self) -> tuple[float, float]:
        if not self.count:
            return 0.0, 1.0
        p, n = self.hits / self.count, self.count
        middle = (p + Z * Z / (2 * n)) / (1 + Z * Z / n)
        half = Z / (1 + Z * Z / n) * math.sqrt(p * (1 - p) / n + Z * Z / (4 * n * n))
        return max(0.0, middle - half), min(1.0, middle + half)

    def to_json(self) -> dict[str, Any]:
        low, high = self.interval
        return {"hits": self.hits, "count": self.count, "value": self.value, "interval": [low, high]}


def scored(records: Iterable[Mapping[str, Any]]) -> list[Scored]:
    return [
        Scored(
            r["id"],
            r["machine"],
            r["group"],
            r["level"],
            score(r["planted"], r["answer"], r["oracle"], r["seconds"]),
            r["error"],
        )
        for r in records
    ]


def read_scores(text: str) -> list[Scored]:
    """What ``report.facts`` wrote of the cases of a run."""
    found = []
    for row in json.loads(text)["cases"]:
        of_case = {field.name: row.pop(field.name) for field in fields(Scored) if field.name != "score"}
        effects = tuple(Effect(**effect) for effect in row.pop("effects"))
        found.append(Scored(**of_case, score=Score(**row, effects=effects)))
    return found


def joined(earlier: Iterable[Scored], later: Iterable[Scored]) -> list[Scored]:
    """Cases of two runs, by their ids; of a case that is in both the later score."""
    cases = {case.id: case for case in (*earlier, *later)}
    return [cases[id_] for id_ in sorted(cases)]


def _share(values: Iterable[bool]) -> Share:
    found = list(values)
    return Share(sum(found), len(found))


def _effects(cases: Sequence[Scored], *groups: str) -> list[Effect]:
    return [effect for case in cases if case.group in groups for effect in case.score.effects]


def _of(cases: Sequence[Scored], group: str) -> list[Score]:
    return [case.score for case in cases if case.group == group]


def _concealed(cases: Sequence[Scored]) -> list[Effect]:
    return _effects(cases, "single", "pair")


def _named(cases: Sequence[Scored]) -> Share:
    return _share(effect.named for effect in _concealed(cases))


def _named_or_rival(cases: Sequence[Scored]) -> Share:
    return _share(effect.named or effect.among_rivals for effect in _concealed(cases))


def _placed(cases: Sequence[Scored]) -> Share:
    return _share(effect.placed for effect in _concealed(cases))


def _both(cases: Sequence[Scored]) -> Share:
    return _share(all(effect.named and effect.placed for effect in one.effects) for one in _of(cases, "pair"))


def _extra(cases: Sequence[Scored]) -> Share:
    return _share(one.extra > 0 for one in _of(cases, "single") + _of(cases, "pair"))


def _alarms(cases: Sequence[Scored]) -> Share:
    return _share(one.alarm for one in _of(cases, "null") if one.answered)


def _told(cases: Sequence[Scored]) -> Share:
    return _share(one.told for one in _of(cases, "unknown"))


def _told_alone(cases: Sequence[Scored]) -> Share:
    return _share(one.verdict == OPEN and not one.found for one in _of(cases, "unknown"))


def _recordings(cases: Sequence[Scored]) -> Share:
    return _share(case.right for case in cases if case.group == "recording")


def _covered(cases: Sequence[Scored]) -> Share:
    return _share(held for effect in _concealed(cases) for held in effect.covered.values())


def _near_oracle(cases: Sequence[Scored]) -> Share:
    return _share(case.score.heldout <= 1.1 for case in cases if case.score.heldout is not None)


# What is counted, and what is wanted of it at the middle level.
MEASURES: tuple[tuple[str, Callable[[Sequence[Scored]], Share], str], ...] = (
    ("answered", lambda cases: _share(case.score.answered for case in cases), ""),
    ("name right (single and pairs)", _named, ">= 95 %"),
    ("name right, or told among rivals", _named_or_rival, ""),
    ("place right, or its group", _placed, ">= 97 %"),
    ("pairs: both named and placed", _both, ">= 85 %"),
    ("something named that is not there", _extra, ""),
    ("false alarms, of the null cases answered", _alarms, "<= 1 %"),
    ("unknown effects told as unexplained", _told, ">= 90 %"),
    ("unknown effects, told and nothing named", _told_alone, ""),
    ("faults of the recording refused, or lived with", _recordings, ""),
    ("95 % intervals that hold the true value", _covered, ">= 90 %"),
    ("held-out error within 10 % of the oracle's", _near_oracle, "all"),
)


def measures(cases: Sequence[Scored]) -> dict[str, Share]:
    return {title: measure(cases) for title, measure, _ in MEASURES}


def confusion(cases: Sequence[Scored]) -> Counter[tuple[str, str]]:
    """(what was concealed, what was named) -> how often. Null cases name what they name falsely."""
    found: Counter[tuple[str, str]] = Counter()
    for case in cases:
        effects = case.score.effects
        if not effects:
            silent = case.score.answered and not case.score.alarm
            found["nothing", "nothing" if silent else case.score.verdict] += 1
        for effect in effects:
            found[effect.kind, effect.label] += 1
    return found


@dataclass(frozen=True)
class Kind:
    """What one kind of effect came to."""

    kind: str
    right: str
    count: int
    named: int
    placed: int
    error: float | None  # median of the relative errors of its values
    covered: Share
    instead: str


def kinds(cases: Sequence[Scored]) -> list[Kind]:
    by: dict[tuple[str, str], list[Effect]] = {}
    for effect in _effects(cases, "single", "pair", "unknown", "recording"):
        by.setdefault((effect.kind, effect.right), []).append(effect)
    rows = []
    for (kind, right), effects in sorted(by.items()):
        errors = [error for e in effects for error in e.errors.values()]
        wrong = Counter(e.label for e in effects if not e.named)
        rows.append(
            Kind(
                kind,
                right,
                len(effects),
                sum(e.named for e in effects),
                sum(e.placed for e in effects),
                median(errors) if errors else None,
                _share(v for e in effects for v in e.covered.values()),
                ", ".join(f"{label} {count}" for label, count in wrong.most_common()),
            )
        )
    return rows
