"""Asks a tool about one case: in an empty folder that holds the model and the recordings, and nothing else.

The truth is in no file while the tool runs: it lives in this process and is written down after the answer is in.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

MODEL, TRAINING, HELDOUT = "model.toml", "a.csv", "b.csv"
SYMDYN = (sys.executable, "-c", "from symdyn.faces.cli import main; main()")
DIAGNOSE = (*SYMDYN, "diagnose", "{model}", "{training}", "--holdout", "{heldout}", "--json")
IDENTIFY = (*SYMDYN, "identify", "{model}", "{heldout}", "--json")


@dataclass(frozen=True)
class Answer:
    """What the tool printed, as JSON; or why there is nothing."""

    facts: dict[str, Any] | None
    error: str
    seconds: float


def ask(command: Sequence[str], model: str, training: str, heldout: str, limit: float) -> Answer:
    """Run the tool; ``{model}``, ``{training}`` and ``{heldout}`` in its command become file names."""
    with tempfile.TemporaryDirectory(prefix="case") as folder:
        for name, text in ((MODEL, model), (TRAINING, training), (HELDOUT, heldout)):
            (Path(folder) / name).write_text(text, encoding="utf-8")
        filled = [part.replace("{model}", MODEL).replace("{training}", TRAINING) for part in command]
        filled = [part.replace("{heldout}", HELDOUT) for part in filled]
        start = time.perf_counter()
        try:
            done = subprocess.run(filled, cwd=folder, capture_output=True, text=True, timeout=limit, check=False)
        except subprocess.TimeoutExpired:
            return Answer(None, f"no answer in {limit:.0f} s", time.perf_counter() - start)
        return _read(done, time.perf_counter() - start)


def _read(done: subprocess.CompletedProcess[str], seconds: float) -> Answer:
    try:
        facts = json.loads(done.stdout)
    except json.JSONDecodeError:
        lines = [line for line in done.stderr.splitlines() if "error" in line.lower()] or done.stderr.splitlines()
        return Answer(None, lines[0].strip() if lines else f"nothing printed, exit code {done.returncode}", seconds)
    if not isinstance(facts, dict):
        return Answer(None, "the answer is no JSON object", seconds)
    return Answer(facts, "", seconds)
