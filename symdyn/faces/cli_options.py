"""Arguments that many commands share."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from symdyn.numeric.executor import Executor
    from symdyn.spec.urdf_chain import Chain

Model = Annotated[str, typer.Argument(help="A robot.toml, a URDF, or the name of a bundled machine (`symdyn check`).")]
Json = Annotated[bool, typer.Option("--json", help="Print the facts as JSON on stdout.")]
Base = Annotated[str | None, typer.Option("--base", help="Of a URDF: the link to begin at; default: its root.")]
Tip = Annotated[str | None, typer.Option("--tip", help="Of a URDF that branches: the link to end at.")]
Lock = Annotated[
    bool, typer.Option("--lock-others", help="Of a URDF that branches: fix other branches on the chain at zero.")
]
Jobs = Annotated[int, typer.Option("--jobs", "-j", help="Processes on this machine; 0: one per core.")]
Scheduler = Annotated[
    str | None, typer.Option("--scheduler", help="tcp://HOST:PORT of a dask cluster that does the work instead.")
]  # fmt: skip
Resume = Annotated[
    Path | None, typer.Option("--resume", help="Keep results in this folder; a run that was killed goes on from there.")
]  # fmt: skip

Map = Annotated[
    Path | None,
    typer.Option("--map", help="Channel map (TOML); default: FILE.toml beside the recording, else the model's own."),
]  # fmt: skip
Limits = Annotated[
    list[str] | None,
    typer.Option(
        "--limits",
        help="JOINT:lower=..,upper=..,velocity=..,acceleration=..,effort=..,input=.. in SI units, for --experiment; "
        "repeatable. Default: the model's; else what the recording visited.",
    ),
]  # fmt: skip
Duration = Annotated[float, typer.Option("--duration", "-t", help="Seconds of the experiment.")]
Rate = Annotated[float, typer.Option("--rate", help="Rows a second of the trajectory.")]


def executor_of(jobs: int, scheduler: str | None, resume: Path | None) -> Executor:
    """Where the work is done."""
    from symdyn.numeric.executor import Executor

    return Executor(jobs, scheduler, resume)


def chain_of(base: str | None, tip: str | None, lock_others: bool) -> Chain:
    """The part of a URDF that --base, --tip and --lock-others choose."""
    from symdyn.spec.urdf_chain import Chain

    return Chain(base, tip, lock_others)
