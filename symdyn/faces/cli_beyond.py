"""The commands beyond one diagnosis: experiment, profile, fleet; imports stay lazy so that --help is quick."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from symdyn.faces.cli_options import (
    Base,
    Duration,
    Jobs,
    Json,
    Limits,
    Lock,
    Map,
    Model,
    Rate,
    Resume,
    Scheduler,
    Tip,
    chain_of,
    executor_of,
)


def experiment(
    model: Model,
    rival: Annotated[
        str | None, typer.Argument(help="The other explanation; none: the motion that tells the model's parameters.")
    ] = None,
    base: Base = None,
    tip: Tip = None,
    lock_others: Lock = False,
    noise: Annotated[
        list[str] | None,
        typer.Option("--noise", help="Of the effort, r.m.s. in the band: VALUE for all joints or JOINT=VALUE."),
    ] = None,
    limits: Limits = None,
    recording: Annotated[
        Path | None, typer.Option("--recording", help="What it visited stands for limits that nobody gives.")
    ] = None,
    channel_map: Map = None,
    band: Annotated[float, typer.Option("--band", help="In Hz: explanations are compared below it.")] = 10.0,
    duration: Duration = 20.0,
    rate: Rate = 500.0,
    seed: Annotated[int, typer.Option("--seed", help="Of the search; the same seed gives the same motion.")] = 0,
    out: Annotated[Path | None, typer.Option("--out", "-o", help="Write the trajectory (CSV) here.")] = None,
    json: Json = False,
) -> None:
    """Design the motion that would tell two explanations apart, within limits, as a trajectory file."""
    from symdyn.faces import experiment_command

    chain = chain_of(base, tip, lock_others)
    raise typer.Exit(
        experiment_command.run(
            model, rival, chain, noise or [], limits or [], recording, channel_map, band, duration, rate, seed, out,
            json,
        )
    )  # fmt: skip


def profile(
    model: Model,
    recording: Path,
    base: Base = None,
    tip: Tip = None,
    lock_others: Lock = False,
    parameter: Annotated[
        list[str] | None,
        typer.Option("--parameter", "-p", help="Only this one; repeatable. Default: all that are fitted."),
    ] = None,
    channel_map: Map = None,
    band: Annotated[
        float | None, typer.Option("--band", help="Analysis band in Hz; default: found from the residual.")
    ] = None,
    jobs: Jobs = 1,
    scheduler: Scheduler = None,
    resume: Resume = None,
    plot: Annotated[Path | None, typer.Option("--plot", help="Write the curves (SVG) here.")] = None,
    json: Json = False,
) -> None:
    """Show how far each parameter can be moved, all others fitted anew, before the recording speaks against it."""
    from symdyn.faces import profile_command

    raise typer.Exit(
        profile_command.run(
            model, chain_of(base, tip, lock_others), recording, parameter or [], channel_map, band,
            executor_of(jobs, scheduler, resume), plot, json,
        )
    )  # fmt: skip


def fleet(
    cases: Annotated[
        list[str], typer.Argument(help="A list of cases (TOML or CSV), or with --model recordings (names or patterns).")
    ],
    model: Annotated[str | None, typer.Option("--model", help="The model of all recordings.")] = None,
    base: Base = None,
    tip: Tip = None,
    lock_others: Lock = False,
    holdout: Annotated[
        str | None, typer.Option("--holdout", help="What judges: one file for all, or a name beside each recording.")
    ] = None,
    channel_map: Map = None,
    jobs: Jobs = 0,
    scheduler: Scheduler = None,
    resume: Resume = None,
    out: Annotated[Path | None, typer.Option("--out", "-o", help="Write the verdicts (JSON) here.")] = None,
    json: Json = False,
) -> None:
    """Diagnose many recordings: one table and one JSON of verdicts."""
    from symdyn.faces import fleet_command

    chain = chain_of(base, tip, lock_others)
    raise typer.Exit(
        fleet_command.run(cases, model, chain, holdout, channel_map, executor_of(jobs, scheduler, resume), out, json)
    )
