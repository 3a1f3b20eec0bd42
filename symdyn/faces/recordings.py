"""Finds the channel maps of recordings and reads both."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from symdyn.base.errors import BadRecording, InputError, Problem, UsageError, Where
from symdyn.numeric.recording import Recording, read_recording
from symdyn.physics import schemas
from symdyn.spec.records import Robot
from symdyn.spec.toml_reader import read_channel_map


def open_recording(path: Path, robot: Robot, channel_map: Path | None) -> Recording:
    """The recording through, in this order: the map given, FILE.toml beside it, the model's own map.

    Raises InputError (SD512) when there is none, and for everything wrong in either file.
    """
    beside = path.with_name(f"{path.name}.toml")
    if channel_map is not None:
        return read_recording(path, read_channel_map(channel_map, robot, schemas()))
    if beside.is_file():
        return read_recording(path, read_channel_map(beside, robot, schemas()))
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


def open_recordings(
    training: Sequence[Path], heldout: Sequence[Path], robot: Robot, channel_map: Path | None
) -> tuple[list[Recording], list[Recording]]:
    """All of them, each a file of its own.

    Raises BadRecording with the problems of every file that fails its checks, InputError for what is
    not there, and UsageError (SD010) where the same recording is given twice.
    """
    problems: list[Problem] = []
    opened: list[Recording] = []
    for path in (*training, *heldout):
        try:
            opened.append(open_recording(path, robot, channel_map))
        except BadRecording as bad:
            problems += bad.problems
    if problems:
        raise BadRecording(problems)
    if len({recording.sha256 for recording in opened}) < len(opened):
        fitted = {recording.sha256 for recording in opened[: len(training)]}
        judged = any(recording.sha256 in fitted for recording in opened[len(training) :])
        message = (
            "the held-out recording must not be the one that is fitted" if judged else "a recording is given twice"
        )
        raise UsageError(Problem("SD010", message))
    return opened[: len(training)], opened[len(training) :]
