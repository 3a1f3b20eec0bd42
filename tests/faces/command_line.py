"""The command line called as a person calls it; a rod on a pivot, and recordings of it by formulas written here."""

from __future__ import annotations

import io
import json
import os
import re
import sys
from collections.abc import Callable
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np

from symdyn.faces import cli

PENDULUM = """\
[robot]
name = "swinging-rod"
gravity = ["9.81 m/s^2", 0, 0]  # the base frame's x axis points down

[parameters]
m = "2 kg"
J = "0.04 kg m^2"

[dh]
rows = [ ["q", 0, "0.5 m", 0] ]

[[joint]]
name = "pivot"
link = { mass = "m", com = ["-0.25 m", 0, 0], inertia = { zz = "J" } }

[recording]
time = { column = "t", unit = "s" }

[[recording.channel]]
column = "q"
quantity = "position"
joint = "pivot"
unit = "rad"

[[recording.channel]]
column = "tau"
quantity = "effort"
joint = "pivot"
unit = "N m"
"""

# The rod by hand, hanging at q = 0: m c and J + m c^2, with the centre of mass c below the pivot.
MOMENT, INERTIA, GRAVITY = 2 * 0.25, 0.04 + 2 * 0.25**2, 9.81
FRICTION = 0.3  # N m, of the machine alone: the model has none

Array = np.ndarray[Any, np.dtype[np.float64]]
Hidden = Callable[[Array, Array], Array]

_STYLE = re.compile(r"\x1b\[[0-9;]*m")


def torque(q: Any, qdd: Any) -> Any:
    return INERTIA * qdd + MOMENT * GRAVITY * np.sin(q)


def dry_friction(q: Array, qd: Array) -> Array:
    return FRICTION * np.sign(qd)


def nothing(q: Array, qd: Array) -> Array:
    return np.zeros_like(q)


def bump(q: Array, qd: Array) -> Array:
    """A hump over the angle, such as a cable that is pushed aside: no effect of the catalogue."""
    return 0.5 * np.exp(-(((q - 0.3) / 0.1) ** 2))


def recording_text(seed: int, hidden: Hidden, count: int = 4000, rate: float = 200.0) -> str:
    """A CSV of the rod under a smooth motion, with the noise of an encoder and of a torque sensor."""
    rng = np.random.default_rng(seed)
    t = np.arange(count) / rate
    w = 2 * np.pi * np.array([0.11, 0.37, 0.83]) * (1 + 0.07 * seed)
    size = np.array([1.2, 0.5, 0.15])
    angle = np.outer(t, w) + rng.uniform(0, 2 * np.pi, 3)
    q, qd, qdd = np.sin(angle) @ size, np.cos(angle) @ (size * w), -np.sin(angle) @ (size * w**2)
    tau = torque(q, qdd) + hidden(q, qd) + 0.01 * rng.standard_normal(count)
    rows = zip(t, q + 1e-5 * rng.standard_normal(count), tau, strict=True)
    return "t,q,tau\n" + "".join(f"{a:.9g},{b:.9g},{c:.9g}\n" for a, b, c in rows)


@dataclass(frozen=True)
class Done:
    """How a command ended."""

    code: int
    out: str
    err: str

    def json(self) -> Any:
        return json.loads(self.out)


def run(*arguments: str | Path) -> Done:
    """The installed command, in this process; anything but a clean exit is raised."""
    out, err = io.StringIO(), io.StringIO()
    code: object = 0
    with (
        mock.patch.object(sys, "argv", ["symdyn", *map(str, arguments)]),
        mock.patch.dict(os.environ, {"FORCE_COLOR": "", "COLUMNS": "100"}),
        redirect_stdout(out),
        redirect_stderr(err),
    ):
        try:
            cli.main()
        except SystemExit as end:
            code = end.code or 0
    assert isinstance(code, int)
    return Done(code, _STYLE.sub("", out.getvalue()), _STYLE.sub("", err.getvalue()))


def contents(folder: Path) -> dict[str, bytes]:
    """Every file below a folder; a folder without files stands as one with a slash."""
    found = {}
    for path in sorted(folder.rglob("*")):
        name = str(path.relative_to(folder))
        if path.is_file():
            found[name] = path.read_bytes()
        elif not any(path.iterdir()):
            found[f"{name}/"] = b""
    return found


def write_pair(folder: Path, hidden: Hidden, *, count: int = 4000) -> tuple[Path, Path]:
    """Two recordings of one machine: one to fit, one to judge."""
    paths = folder / "monday.csv", folder / "tuesday.csv"
    for seed, path in enumerate(paths, 1):
        path.write_text(recording_text(seed, hidden, count), encoding="utf-8")
    return paths
