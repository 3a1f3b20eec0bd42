"""The commands on linear models: their arguments, nothing else; imports stay lazy so that --help is quick."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from symdyn.faces.cli_options import (
    Base,
    Jobs,
    Json,
    Lock,
    Model,
    Resume,
    Scheduler,
    Tip,
    chain_of,
    executor_of,
)

Input = Annotated[str | None, typer.Option("--input", "-u", help="Input, by name; default: the first.")]
Output = Annotated[
    str | None, typer.Option("--output", "-y", help="Sensor or state, by name; default: the first sensor.")
]  # fmt: skip
From = Annotated[float | None, typer.Option("--from", help="Lowest frequency in Hz; default: below the slowest mode.")]
To = Annotated[float | None, typer.Option("--to", help="Highest frequency in Hz; default: above the fastest mode.")]
At = Annotated[
    list[str] | None,
    typer.Option("--at", help="NAME=VALUE of a state or input at the operating point, in SI units; repeatable."),
]  # fmt: skip
Points = Annotated[int, typer.Option("--points", help="How many frequencies.")]
Plot = Annotated[Path | None, typer.Option("--plot", help="Write an SVG here.")]


def frequency(
    model: Model,
    base: Base = None,
    tip: Tip = None,
    lock_others: Lock = False,
    input: Input = None,
    output: Output = None,
    low: From = None,
    high: To = None,
    points: Annotated[
        int | None, typer.Option("--points", help="How many frequencies; default: 2000, with --amplitude 40.")
    ] = None,
    at: At = None,
    amplitude: Annotated[
        float | None,
        typer.Option("--amplitude", help="Of the input, in its unit: simulate with friction, clearance and limits."),
    ] = None,
    method: Annotated[
        str | None, typer.Option("--method", help="With --amplitude: stepped (sines, the default) or multisine.")
    ] = None,
    realisations: Annotated[int, typer.Option("--realisations", help="Of the multisine's phases.")] = 4,
    seed: Annotated[int, typer.Option("--seed", help="Of them; the same seed gives the same numbers.")] = 0,
    plot: Plot = None,
    json: Json = False,
) -> None:
    """Show the modes of the linear part, named by their energy, and a response with its peaks.

    With --amplitude: the response that a sine or a multisine of that size measures, and its distortions.
    """
    from symdyn.faces import frequency_command

    excitation = frequency_command.excitation(amplitude, method, realisations, seed)
    chain = chain_of(base, tip, lock_others)
    frequency_command.run(model, chain, input, output, low, high, points, at or [], excitation, plot, json)


def sensitivity(
    model: Model,
    base: Base = None,
    tip: Tip = None,
    lock_others: Lock = False,
    input: Input = None,
    output: Output = None,
    low: From = None,
    high: To = None,
    points: Points = 400,
    at: At = None,
    parameter: Annotated[
        list[str] | None, typer.Option("--parameter", "-p", help="Only this one; repeatable. Default: all.")
    ] = None,
    factor: Annotated[
        list[float] | None, typer.Option("--factor", help="Vary by this factor; repeatable. Default: 0.5 and 2.")
    ] = None,
    method: Annotated[
        str | None, typer.Option("--global", help="morris or sobol: over ranges of all parameters together.")
    ] = None,
    samples: Annotated[
        int | None, typer.Option("--samples", help="Morris: trajectories (20); Sobol: a power of two (256).")
    ] = None,
    spread: Annotated[float, typer.Option("--spread", help="Ranges are the values plus and minus this share.")] = 0.2,
    seed: Annotated[int, typer.Option("--seed", help="The same seed gives the same numbers.")] = 0,
    jobs: Jobs = 1,
    scheduler: Scheduler = None,
    resume: Resume = None,
    plot: Plot = None,
    json: Json = False,
) -> None:
    """Show what each parameter does to modes and response: derivatives, factors, or globally."""
    from symdyn.faces import sensitivity_command

    chain = chain_of(base, tip, lock_others)
    sensitivity_command.run(
        model, chain, input, output, low, high, points, at or [], parameter or [], factor or [0.5, 2.0], method,
        samples, spread, seed, executor_of(jobs, scheduler, resume), plot, json,
    )  # fmt: skip


def reduce(
    model: Model,
    base: Base = None,
    tip: Tip = None,
    lock_others: Lock = False,
    input: Input = None,
    output: Output = None,
    low: From = None,
    high: To = None,
    error: Annotated[
        float, typer.Option("--error", help="Relative error of the response that all steps together may cost.")
    ] = 0.05,
    signal: Annotated[
        str, typer.Option("--signal", help="For the r.m.s. errors: step (density 1/f) or white.")
    ] = "step",
    at: At = None,
    out: Annotated[
        Path | None, typer.Option("--out", "-o", help="Write the model with the changed parameters here.")
    ] = None,
    plot: Plot = None,
    json: Json = False,
) -> None:
    """Propose a smaller model for a band: what to lump, drop or make rigid, at what error."""
    from symdyn.faces import reduce_command

    chain = chain_of(base, tip, lock_others)
    reduce_command.run(model, chain, input, output, low, high, error, signal, at or [], out, plot, json)
