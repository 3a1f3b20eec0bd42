"""Writes what a run came to: JSON for programs, Markdown and a plot of the confusion matrix for people."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from statistics import median
from typing import Any

from benchmarks.blind.plot import confusion_svg
from benchmarks.blind.sensors import LEVELS
from benchmarks.blind.summary import MEASURES, Scored, Share, confusion, kinds, measures

PLOT, SCORES = "results.svg", "results.json"


def write_report(cases: Sequence[Scored], folder: Path, command: Sequence[str]) -> str:
    """``results.json``, ``results.md`` and the plot in a folder; returns the Markdown."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / SCORES).write_text(json.dumps(facts(cases), indent=1) + "\n", encoding="utf-8")
    (folder / PLOT).write_text(confusion_svg(confusion(cases)), encoding="utf-8")
    text = markdown(cases, command)
    (folder / "results.md").write_text(text, encoding="utf-8")
    return text


def facts(cases: Sequence[Scored]) -> dict[str, Any]:
    by_level = {level: [case for case in cases if case.level == level] for level in LEVELS}
    return {
        "levels": {
            level: {title: share.to_json() for title, share in measures(part).items()}
            for level, part in by_level.items()
            if part
        },
        "confusion": [[true, named, count] for (true, named), count in sorted(confusion(cases).items())],
        "cases": [
            {
                "id": c.id,
                "machine": c.machine,
                "group": c.group,
                "level": c.level,
                "error": c.error,
                **c.score.to_json(),
            }
            for c in cases
        ],
    }


def markdown(cases: Sequence[Scored], command: Sequence[str]) -> str:
    levels = [level for level in LEVELS if any(case.level == level for case in cases)]
    parts = [
        f"{len(cases)} cases; intervals are Wilson's, 95 %. Tool: `{_shown(command)}`.",
        "## Scores by noise level",
        _score_table(cases, levels),
    ]
    for machine in sorted({case.machine for case in cases}):
        part = [case for case in cases if case.machine == machine]
        parts += [f"## {machine}", _score_table(part, [x for x in levels if any(c.level == x for c in part)])]
    parts += ["## By kind of effect", _kind_table(cases), f"![confusion matrix]({PLOT})" if cases else ""]
    parts += ["## Null cases and time", _time_table(cases), "## Answers that are not right", _wrong_table(cases)]
    parts += ["## No answer", _silent_table(cases)] if any(not case.score.answered for case in cases) else []
    return "\n\n".join(part for part in parts if part) + "\n"


def _shown(command: Sequence[str]) -> str:
    return "symdyn " + " ".join(command[3:]) if "symdyn" in " ".join(command[:3]) else " ".join(command)


def _wrong_table(cases: Sequence[Scored]) -> str:
    """Case by case; "to find" and "left" are held-out errors over the oracle's, before and after."""
    lines = ["| case | answer | to find | left |", "| --- | --- | ---: | ---: |"]
    for case in cases:
        one = case.score
        if not case.right and one.answered:
            labels = "; ".join(f"{effect.kind}: {effect.label}" for effect in one.effects)
            more = f"; {one.extra} more" if one.extra else ""
            lines.append(
                f"| {case.id} | {labels or one.verdict}{more} | {_ratio(one.before)} | {_ratio(one.heldout)} |"
            )
    return "\n".join(lines)


def _silent_table(cases: Sequence[Scored]) -> str:
    why = Counter((case.machine, case.error) for case in cases if not case.score.answered)
    lines = ["| machine | why | cases |", "| --- | --- | ---: |"]
    return "\n".join(
        [*lines, *(f"| {machine} | {error} | {count} |" for (machine, error), count in sorted(why.items()))]
    )


def _ratio(value: float | None) -> str:
    return "-" if value is None else f"{value:.2f}"


def _score_table(cases: Sequence[Scored], levels: Sequence[str]) -> str:
    columns = [measures([case for case in cases if case.level == level]) for level in levels]
    lines = [f"| | {' | '.join(levels)} | wanted at the middle |", "| --- |" + " ---: |" * (len(levels) + 1)]
    lines += [
        f"| {title} | {' | '.join(_text(column[title]) for column in columns)} | {wanted} |"
        for title, _, wanted in MEASURES
    ]
    return "\n".join(lines)


def _text(share: Share) -> str:
    if share.value is None:
        return "-"
    low, high = share.interval
    return f"{share.hits}/{share.count} = {100 * share.value:.0f} % ({100 * low:.0f} to {100 * high:.0f})"


def _kind_table(cases: Sequence[Scored]) -> str:
    lines = [
        "| concealed | right answer | named | placed | median error of values | intervals that hold | named instead |",
        "| --- | --- | ---: | ---: | ---: | ---: | --- |",
    ]
    for row in kinds(cases):
        error = "-" if row.error is None else f"{100 * row.error:.2g} %"
        covered = f"{row.covered.hits}/{row.covered.count}" if row.covered.count else "-"
        lines.append(
            f"| {row.kind} | {row.right} | {row.named}/{row.count} | {row.placed}/{row.count} | {error} | {covered} "
            f"| {row.instead} |"
        )
    return "\n".join(lines)


def _time_table(cases: Sequence[Scored]) -> str:
    lines = ["| machine | cases | median s | longest s | false alarms |", "| --- | ---: | ---: | ---: | --- |"]
    for machine in sorted({case.machine for case in cases}):
        part = [case for case in cases if case.machine == machine]
        times = [case.score.seconds for case in part]
        alarms = Share(
            sum(c.score.alarm for c in part if c.group == "null"),
            sum(c.group == "null" and c.score.answered for c in part),
        )
        lines.append(f"| {machine} | {len(part)} | {median(times):.0f} | {max(times):.0f} | {_text(alarms)} |")
    return "\n".join(lines)
