"""The profile command: one task per parameter for the executor, a table, and a figure."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

from symdyn import compiler
from symdyn.base.errors import InputError, Problem, UsageError
from symdyn.base.files import check_writable, write_atomically
from symdyn.base.wording import did_you_mean
from symdyn.faces.console import err, out, print_json, print_table, print_warnings, status
from symdyn.faces.recordings import open_recording
from symdyn.faces.words import plain_number
from symdyn.numeric.candidates import bounds
from symdyn.numeric.cut import UNCUT
from symdyn.numeric.executor import Executor, Task
from symdyn.numeric.identify import Fitted, fitted
from symdyn.numeric.profile_likelihood import Identified, Profile, profile
from symdyn.numeric.torque_sensors import parts
from symdyn.spec.records import Robot
from symdyn.spec.urdf_chain import Chain

WORDS = {
    Identified.YES: "identified",
    Identified.PRACTICALLY_NOT: "practically not identified",
    Identified.NOT: "not identified: other parameters take its part",
}


def run(
    model: str,
    chain: Chain,
    recording: Path,
    parameters: Sequence[str],
    channel_map: Path | None,
    band: float | None,
    executor: Executor,
    plot: Path | None,
    json: bool,
) -> int:
    """Returns the exit code: 1 where a parameter is not identified."""
    if band is not None and not (math.isfinite(band) and band > 0.0):
        raise UsageError(Problem("SD010", f"--band is a frequency in Hz above zero, not {band}"))
    if plot is not None:
        check_writable(plot)
    robot = compiler.load_robot(model, chain)
    data = open_recording(recording, robot, channel_map)
    print_warnings(data.warnings)
    told = {
        "robot": compiler.robot_to_toml(robot),
        "recording": str(recording.resolve()),
        "sha256": data.sha256,
        "map": None if channel_map is None else str(channel_map.resolve()),
        "map_sha256": None if channel_map is None else hashlib.sha256(channel_map.read_bytes()).hexdigest(),
        "band": band,
    }
    with status(json) as progress:
        progress(f"fitting {robot.name} to {data.name}")
        names = _fitted(told["robot"], told["recording"], told["map"], band)[1].fit.names
        for name in parameters:
            if name not in names:
                hint = did_you_mean(name, names, "fitted")
                raise UsageError(Problem("SD305", f"no parameter `{name}` is fitted to this recording", hint=hint))
        tasks = [told | {"parameter": name} for name in parameters or names]
        found = [_read(facts) for facts in executor.map(profile_one, tasks, "profiles", progress)]
    if plot is not None:
        from symdyn.faces.report.profile_plots import profiles

        write_atomically(plot, profiles(found))
    if json:
        print_json({"robot": robot.name, "recording": data.name, "profiles": [p.to_json() for p in found]})
    else:
        _show(robot, data.name, found)
        if plot is not None:
            err.print(f"written: {plot}", markup=False)
    return 0 if all(p.identified is Identified.YES for p in found) else 1


def profile_one(task: Task, seed: int) -> dict[str, Any]:
    """The profile of one parameter, from the files that the task names; the same for every seed."""
    robot, done = _fitted(task["robot"], task["recording"], task["map"], task["band"])
    return profile(done, task["parameter"], bounds(robot)).to_json()


@lru_cache(maxsize=2)
def _fitted(text: str, recording: str, channel_map: str | None, band: float | None) -> tuple[Robot, Fitted]:
    """Fitted once in each process."""
    robot = compiler.robot_from_text(text, "model")
    data = open_recording(Path(recording), robot, None if channel_map is None else Path(channel_map))
    if parts(robot, [data])[0] != (UNCUT,):
        message = f"torque sensors cut '{robot.name}' in parts, and profiles are those of a whole"
        hint = "take the efforts of the motors, or of the sensors, out of the channel map"
        raise InputError(Problem("SD521", message, robot.channels.where if robot.channels else None, hint))
    return robot, fitted(robot, data, band=band)


def _read(facts: dict[str, Any]) -> Profile:
    lower, upper = facts["interval"]
    values, rise = facts["curve"]["values"], facts["curve"]["rise"]
    return Profile(
        facts["parameter"],
        facts["unit"],
        facts["estimate"],
        lower,
        upper,
        facts["threshold"],
        Identified(facts["identified"]),
        tuple(values),
        tuple(rise),
    )


def _show(robot: Robot, recording: str, found: Sequence[Profile]) -> None:
    rows = [
        (
            p.parameter,
            f"{plain_number(p.estimate)} {p.unit}",
            "open" if p.lower is None else plain_number(p.lower),
            "open" if p.upper is None else plain_number(p.upper),
            WORDS[p.identified],
        )
        for p in found
    ]
    title = f"{robot.name} on {recording}: 95 % intervals by profile likelihood"
    print_table(title, ("parameter", "estimate", "from", "to", ""), rows)
    if any(p.identified is not Identified.YES for p in found):
        out.print("whether another motion would tell the rest, `symdyn experiment MODEL` says", markup=False)
