"""Finds the channel map of a recording and reads both."""

from __future__ import annotations

from pathlib import Path

from symdyn.base.errors import InputError, Problem, Where
from symdyn.numeric.recording import Recording, read_recording
from symdyn.spec.records import Robot
from symdyn.spec.toml_reader import read_channel_map


def open_recording(path: Path, robot: Robot, channel_map: Path | None) -> Recording:
    """The recording through, in this order: the map given, FILE.toml beside it, the model's own map.

    Raises InputError (SD512) when there is none, and for everything wrong in either file.
    """
    beside = path.with_name(f"{path.name}.toml")
    if channel_map is not None:
        return read_recording(path, read_channel_map(channel_map, robot))
    if beside.is_file():
        return read_recording(path, read_channel_map(beside, robot))
    if robot.channels is not None:
        return read_recording(path, robot.channels)
    raise InputError(
        Problem(
            "SD512",
            "nothing says what the columns of this recording measure",
            Where(str(path)),
            f"write a [recording] table in the model or in {beside.name}, or name one with --map",
        )
    )
