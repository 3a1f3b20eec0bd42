"""Scores one answer against the truth: name, place, values, alarms. Knows nothing of how either came about."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

ANGLES = ("phase", "dead_centre")  # compared around the circle, in rad
TWO_SIDED = 1.96  # standard errors to either side of a 95 % interval
SILENT, OPEN, REFUSED, NONE = "nothing", "unexplained", "bad_recording", "no answer"


@dataclass(frozen=True)
class Effect:
    """How one planted effect was answered."""

    kind: str
    place: str
    right: str  # the effect that would have been right
    named: bool
    placed: bool
    among_rivals: bool
    label: str  # the effect that was named, or nothing, unexplained, no answer
    errors: dict[str, float] = field(default_factory=dict)  # relative, of each value; angles in rad
    covered: dict[str, bool] = field(default_factory=dict)


@dataclass(frozen=True)
class Score:
    """How one case was answered."""

    answered: bool
    verdict: str
    found: int  # findings
    effects: tuple[Effect, ...]
    extra: int  # findings beyond one for each planted effect
    alarm: bool  # anything but "complete"
    told: bool  # said that something is left without a name
    before: float | None  # held-out error of the model as given, refitted, over the oracle's: how much there is to find
    heldout: float | None  # held-out error of the answer, over the oracle's
    seconds: float

    def to_json(self) -> dict[str, Any]:
        return asdict(self)


def score(
    planted: Sequence[Mapping[str, Any]], answer: Mapping[str, Any] | None, oracle: float | None, seconds: float
) -> Score:
    """``planted`` as in the record of a case; ``answer`` the tool's JSON, None where there is none.

    A blemish that the tool has to live with is no effect: the answer must be that of a sound recording.
    """
    planted = [plant for plant in planted if plant["problems"] or not plant["blemish"]]  # nothing to say of the others
    if answer is None:
        effects = tuple(_missed(plant, NONE) for plant in planted)
        return Score(False, NONE, 0, effects, 0, False, False, None, None, seconds)
    findings = list(answer.get("findings", []))
    verdict = str(answer.get("verdict", ""))
    if verdict == REFUSED:
        effects = tuple(_refused(plant, answer) for plant in planted)
        return Score(True, verdict, 0, effects, 0, True, False, None, None, seconds)
    matched = [_match(plant, findings) for plant in planted]
    used = [f for match in matched if match is not None for f in match.values()]
    open_ = [f for f in findings if not any(f is other for other in used)]
    structured = bool(answer.get("remaining", {}).get("structured")) or verdict == OPEN
    effects = tuple(
        _right(plant, match, _beside(i, planted, matched))
        if match is not None
        else _wrong(plant, open_, answer, structured)
        for i, (plant, match) in enumerate(zip(planted, matched, strict=True))
    )
    wrong = sum(match is None and not plant["blemish"] for plant, match in zip(planted, matched, strict=True))
    before, after = (_over(answer.get("fit", {}).get(when, {}).get("heldout"), oracle) for when in ("before", "after"))
    alarm = verdict != "complete" or bool(findings)
    extra = max(0, len(open_) - wrong)
    return Score(True, verdict, len(findings), effects, extra, alarm, structured, before, after, seconds)


def _over(error: float | None, oracle: float | None) -> float | None:
    return error / oracle if error is not None and oracle else None


def _places(finding: Mapping[str, Any]) -> set[str]:
    return {finding["place"], *finding.get("group", ())}


def _is_place(plant: Mapping[str, Any], finding: Mapping[str, Any]) -> bool:
    right = {plant["place"], *plant["also_at"]}
    return plant["place"] == "" or bool(right & _places(finding))


def _match(plant: Mapping[str, Any], findings: Sequence[Mapping[str, Any]]) -> dict[str, Mapping[str, Any]] | None:
    """The findings that make up one of the right forms, by effect; the right place first."""
    best: dict[str, Mapping[str, Any]] | None = None
    for form in plant["forms"]:
        found: dict[str, Mapping[str, Any]] = {}
        for effect in form:
            same = [f for f in findings if f["effect"] == effect]
            # Two faults of one sensor are two findings of one effect: the one that tells what was planted.
            same.sort(key=lambda f: (not _is_place(plant, f), not _tells(f, form[effect])))
            if same:
                found[effect] = same[0]
        if len(found) != len(form):
            continue
        if all(_is_place(plant, f) for f in found.values()):
            return found
        best = best or found
    return best


def _told(plant: Mapping[str, Any], finding: Mapping[str, Any]) -> Mapping[str, Any]:
    """Its numbers: those at the place where the effect was planted, where it tells them apart from its own."""
    own: Mapping[str, Any] = finding.get("parameters", {})
    right = (plant["place"], *plant["also_at"])
    elsewhere = finding.get("elsewhere", {})
    return own if finding["place"] in right else next((elsewhere[at] for at in right if at in elsewhere), own)


def _tells(finding: Mapping[str, Any], values: Mapping[str, float]) -> bool:
    told = finding.get("parameters", {})
    return all(part in told for name in values for part in name.split("*"))


def _headline(plant: Mapping[str, Any]) -> str:
    if plant["blemish"]:
        return REFUSED
    return list(plant["forms"][0])[-1] if plant["forms"] else OPEN


def _beside(
    i: int, planted: Sequence[Mapping[str, Any]], matched: Sequence[Mapping[str, Mapping[str, Any]] | None]
) -> dict[tuple[str, str], float]:
    """By effect and parameter, what the other plants add to it at this one's place: one law there is all of them."""
    mine, found = matched[i] or {}, {}
    for j, (plant, match) in enumerate(zip(planted, matched, strict=True)):
        if j == i or match is None or plant["place"] != planted[i]["place"]:
            continue
        for effect, values in _form(plant, match).items():
            if match[effect] is mine.get(effect) and len(values) == 1:
                for name, value in values.items():
                    found[effect, name] = found.get((effect, name), 0.0) + value
    return found


def _form(plant: Mapping[str, Any], match: Mapping[str, Any]) -> Mapping[str, Mapping[str, float]]:
    """The right answer that the findings make up."""
    form: Mapping[str, Mapping[str, float]] = next(form for form in plant["forms"] if set(form) == set(match))
    return form


def _right(
    plant: Mapping[str, Any], match: Mapping[str, Mapping[str, Any]], beside: Mapping[tuple[str, str], float]
) -> Effect:
    form = _form(plant, match)
    errors, covered = {}, {}
    for effect, finding in match.items():
        true = {name: value + beside.get((effect, name), 0.0) for name, value in form[effect].items()}
        if plant["scored"] is not None and form is plant["forms"][0]:
            true = plant["scored"]
        told = _told(plant, finding)
        size = _sizes(true)
        for name, value in true.items():
            parts = [told.get(part) for part in name.split("*")]
            if any(part is None or part.get("value") is None for part in parts):
                continue
            off = math.prod(part["value"] for part in parts) - value
            if name in ANGLES:
                off = (off + math.pi) % (2 * math.pi) - math.pi
            errors[f"{effect}.{name}"] = abs(off) / size[name]
            if len(parts) == 1 and parts[0].get("se") is not None:
                covered[f"{effect}.{name}"] = abs(off) <= TWO_SIDED * parts[0]["se"]
    placed = all(_is_place(plant, finding) for finding in match.values())
    right = _headline(plant)
    return Effect(plant["kind"], plant["place"], right, True, placed, False, right, errors, covered)


def _sizes(true: Mapping[str, float]) -> dict[str, float]:
    """What an error is relative to: the value; the amplitude for the two halves of a wave; 1 rad for an angle."""
    sizes = {name: 1.0 if name in ANGLES else abs(value) for name, value in true.items()}
    if {"cosine", "sine"} <= set(true):
        sizes["cosine"] = sizes["sine"] = math.hypot(true["cosine"], true["sine"])
    return {name: size or 1.0 for name, size in sizes.items()}


def _missed(plant: Mapping[str, Any], label: str) -> Effect:
    return Effect(plant["kind"], plant["place"], _headline(plant), False, False, False, label)


def _refused(plant: Mapping[str, Any], answer: Mapping[str, Any]) -> Effect:
    """The recording was refused: right where that is for what was planted."""
    codes = {problem["code"] for problem in answer.get("problems", ())}
    if not codes & set(plant["problems"]):
        return _missed(plant, REFUSED)
    right = _headline(plant)
    return Effect(plant["kind"], plant["place"], right, True, plant["place"] == "", False, right)


def _wrong(
    plant: Mapping[str, Any], open_: Sequence[Mapping[str, Any]], answer: Mapping[str, Any], structured: bool
) -> Effect:
    """The finding that stands where this effect should: the largest at its place, else the largest of all."""
    right = _headline(plant)
    if plant["blemish"]:
        return _missed(plant, str(answer.get("verdict", "")))
    wanted = {effect for form in plant["forms"] for effect in form}
    here = sorted(open_, key=lambda f: (not _is_place(plant, f), -float(f.get("heldout_gain") or 0.0)))
    if here:
        rivals = {rival["effect"] for rival in here[0].get("rivals", ())}
        among = right in rivals or (len(wanted) == 1 and bool(wanted & rivals))
        return Effect(plant["kind"], plant["place"], right, False, _is_place(plant, here[0]), among, here[0]["effect"])
    located = list(answer.get("located") or ())
    placed = bool(located) and _is_place(plant, located[0])
    return Effect(plant["kind"], plant["place"], right, False, placed, False, OPEN if structured else SILENT)
