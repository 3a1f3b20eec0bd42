"""The whole page."""

from __future__ import annotations

from pathlib import Path

from symdyn.base.files import write_atomically
from symdyn.emit.templates import render
from symdyn.faces.report.equations import marked_equations
from symdyn.faces.report.plots import plots
from symdyn.faces.report.sections import (
    alarms_list,
    findings_table,
    headline,
    joints_table,
    located_table,
    model_table,
    next_experiment_text,
    provenance,
    remaining_text,
    rivals_table,
)
from symdyn.faces.report.specification import marked_specification
from symdyn.faces.words import VERDICT_MEANINGS, VERDICT_NAMES, leftover_words, verdict_words
from symdyn.numeric.findings import Diagnosis


def render_report(diagnosis: Diagnosis) -> str:
    """The report as one HTML document; the same diagnosis gives the same text."""
    return render(
        "report/report.html.j2",
        {
            "robot": diagnosis.robot.name,
            "verdict": str(diagnosis.verdict),
            "verdict_name": VERDICT_NAMES[diagnosis.verdict],
            "sentence": verdict_words(diagnosis),
            "headline": headline(diagnosis),
            "meaning": VERDICT_MEANINGS[diagnosis.verdict],
            "caveat": leftover_words(diagnosis),
            "located": located_table(diagnosis),
            "findings": findings_table(diagnosis),
            "rivals": rivals_table(diagnosis),
            "next": next_experiment_text(diagnosis),
            "joints": joints_table(diagnosis),
            "plots": plots(diagnosis),
            "equations": marked_equations(diagnosis.robot, diagnosis.diagnosed),
            "remaining": remaining_text(diagnosis),
            "model": model_table(diagnosis),
            "alarms": alarms_list(diagnosis),
            "provenance": provenance(diagnosis),
            "specification": marked_specification(diagnosis.robot, diagnosis.diagnosed),
        },
    )


def write_report(diagnosis: Diagnosis, path: Path) -> None:
    """Write the report, whole or not at all."""
    write_atomically(path, render_report(diagnosis))
