"""Functions that the tests of the executor map; in a module, so that worker processes find them."""

from __future__ import annotations

import os
import signal
from pathlib import Path
from typing import Any

import numpy as np

from symdyn.numeric.executor import Task


def draw(task: Task, seed: int) -> dict[str, Any]:
    """Random numbers by the task's own seed, of every bit."""
    rng = np.random.default_rng(seed)
    return {"x": task["x"], "drawn": rng.standard_normal(3).tolist(), "pair": (1, 2)}


def noted(task: Task, seed: int) -> int:
    """Leaves a note of having been done; kills its own process at the task that says so."""
    if task.get("kills") and not Path(task["notes"]).with_suffix(".killed").exists():
        Path(task["notes"]).with_suffix(".killed").touch()
        os.kill(os.getpid(), signal.SIGKILL)
    with Path(task["notes"]).open("a", encoding="utf-8") as notes:
        notes.write(f"{task['x']}\n")
    return int(task["x"]) ** 2


def fails(task: Task, seed: int) -> int:
    """Cannot be done for one task."""
    if task["x"] == 3:
        raise ValueError("three is too much")
    return int(task["x"])
