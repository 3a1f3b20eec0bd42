"""The ``symdyn`` command: arguments, exit codes, nothing else; imports stay lazy so that --help is quick."""

from __future__ import annotations

import io
import sys
from pathlib import Path
from typing import Annotated

import typer

from symdyn import __version__
from symdyn.faces.cli_beyond import experiment, fleet, profile
from symdyn.faces.cli_linear import frequency, reduce, sensitivity
from symdyn.faces.cli_options import Base, Duration, Json, Limits, Lock, Map, Model, Tip, chain_of

app = typer.Typer(
    name="symdyn",
    help="Symbolic robot dynamics with drives, fast kernels, and a diagnosis of what a model lacks.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)

Band = Annotated[float | None, typer.Option("--band", help="Analysis band in Hz; default: found from the residual.")]


def _version(asked: bool) -> None:
    if asked:
        typer.echo(f"symdyn {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Show the version.")
    ] = False,
    debug: Annotated[bool, typer.Option("--debug", help="Show tracebacks.")] = False,
) -> None:
    """Both are handled elsewhere: the version by its callback, --debug by main(), which prints errors."""


@app.command()
def check(
    model: Annotated[
        str | None, typer.Argument(help="A robot.toml, a URDF or a bundled machine; none: list the machines.")
    ] = None,
    recording: Annotated[list[Path] | None, typer.Argument(help="Recordings to check with it.")] = None,
    base: Base = None,
    tip: Tip = None,
    lock_others: Lock = False,
    channel_map: Map = None,
    json: Json = False,
) -> None:
    """Read a model (and recordings) and say what is in it, or what is wrong with it."""
    from symdyn.faces import model_commands

    model_commands.check(model, chain_of(base, tip, lock_others), recording or [], channel_map, json)


@app.command()
def derive(
    model: Model,
    base: Base = None,
    tip: Tip = None,
    lock_others: Lock = False,
    steps: Annotated[bool, typer.Option("--steps", help="Show the Newton-Euler intermediates.")] = False,
    json: Json = False,
) -> None:
    """Derive the equations of motion and print them for reading."""
    from symdyn.faces import model_commands

    model_commands.derive(model, chain_of(base, tip, lock_others), steps, json)


@app.command("base-parameters")
def base_parameters(
    model: Model, base: Base = None, tip: Tip = None, lock_others: Lock = False, json: Json = False
) -> None:
    """List the fewest inertial parameters that the arm's efforts depend on, as expressions of the given ones."""
    from symdyn.faces import arm_commands

    arm_commands.base_parameters(model, chain_of(base, tip, lock_others), json)


@app.command()
def variants(
    model: Model,
    base: Base = None,
    tip: Tip = None,
    lock_others: Lock = False,
    states: Annotated[int, typer.Option("--states", help="How many random states to compare at.")] = 100,
    speed: Annotated[float, typer.Option("--speed", help="Share of the top speeds that the states reach.")] = 1.0,
    json: Json = False,
) -> None:
    """Compare simpler models of the arm: what they miss at each joint, and what they save."""
    from symdyn.faces import arm_commands

    arm_commands.variants(model, chain_of(base, tip, lock_others), states, speed, json)


@app.command()
def cost(
    model: Model,
    base: Base = None,
    tip: Tip = None,
    lock_others: Lock = False,
    function: Annotated[
        str | None, typer.Option("--function", help="Pass by pass, for this function: inverse_dynamics, mass_matrix_p.")
    ] = None,
    json: Json = False,
) -> None:
    """Count the operations of each function of the kernel, and the time that optimising it takes."""
    from symdyn.faces import cost_command

    cost_command.cost(model, chain_of(base, tip, lock_others), function, json)


@app.command()
def generate(
    models: Annotated[list[str] | None, typer.Argument(help="Robots to generate.")] = None,
    base: Base = None,
    tip: Tip = None,
    lock_others: Lock = False,
    out: Annotated[
        Path, typer.Option("--out", "-o", help="Folder to write to; a folder per robot is made in it.")
    ] = Path("generated"),
    everything: Annotated[bool, typer.Option("--all", help="All bundled machines.")] = False,
    target: Annotated[
        list[str] | None, typer.Option("--target", help="Language of the code, such as c; default: numba. Repeatable.")
    ] = None,
    json: Json = False,
) -> None:
    """Write the code (kernel.py), equations.tex and manifest.json for each robot."""
    from symdyn.faces import model_commands

    model_commands.generate(models or [], chain_of(base, tip, lock_others), out, everything, target or [], json)


@app.command()
def latex(
    model: Model,
    base: Base = None,
    tip: Tip = None,
    lock_others: Lock = False,
    out: Annotated[Path | None, typer.Option("--out", "-o", help="File to write; default: stdout.")] = None,
) -> None:
    """Print the equations as a LaTeX document."""
    from symdyn.faces import model_commands

    model_commands.latex(model, chain_of(base, tip, lock_others), out)


@app.command()
def convert(
    model: Model,
    base: Base = None,
    tip: Tip = None,
    lock_others: Lock = False,
    into: Annotated[
        Path | None,
        typer.Option("--into", help="Write the model's inertials and friction into the text of this URDF instead."),
    ] = None,
    out: Annotated[Path | None, typer.Option("--out", "-o", help="File to write; default: stdout.")] = None,
) -> None:
    """Print a robot as robot.toml (from a URDF, say), or put its numbers back into the URDF it came from."""
    from symdyn.faces import model_commands

    model_commands.convert(model, chain_of(base, tip, lock_others), into, out)


@app.command()
def effects(json: Json = False) -> None:
    """List the catalogue of physical effects."""
    from symdyn.faces import model_commands

    model_commands.effects(json)


@app.command()
def simulate(
    model: Model,
    base: Base = None,
    tip: Tip = None,
    lock_others: Lock = False,
    duration: Annotated[float, typer.Option("--duration", "-t", help="Seconds.")] = 1.0,
    step: Annotated[float, typer.Option("--step", help="Seconds between the rows of the result.")] = 1e-3,
    input: Annotated[
        list[str] | None,
        typer.Option(
            "--input",
            "-u",
            help="NAME=VALUE holds an input; or NAME=step:VALUE,TIME, ramp:, sine:, trapezoid:, chirp:, multisine:, "
            "file:PATH; repeatable.",
        ),
    ] = None,
    start: Annotated[
        list[str] | None, typer.Option("--start", "-x", help="NAME=VALUE sets a state at t = 0; repeatable.")
    ] = None,
    smoothing: Annotated[
        float | None,
        typer.Option("--smoothing", help="Smooth jumps over this width (SI units) instead of locating their events."),
    ] = None,
    tolerance: Annotated[
        float, typer.Option("--tolerance", help="Of a step, relative; linear drives are propagated exactly without it.")
    ] = 1e-8,
    events: Annotated[
        Path | None, typer.Option("--events", help="CSV file for the events: stick, slip, contact, limit.")
    ] = None,
    energy: Annotated[
        Path | None,
        typer.Option("--energy", help="CSV file for the energy supplied, dissipated, lost and stored, by element."),
    ] = None,
    sensitivities: Annotated[
        Path | None, typer.Option("--sensitivities", help="CSV file for the derivatives of the states by parameters.")
    ] = None,
    parameter: Annotated[
        list[str] | None, typer.Option("--parameter", "-p", help="For --sensitivities; repeatable. Default: all.")
    ] = None,
    out: Annotated[Path | None, typer.Option("--out", "-o", help="CSV file to write; default: stdout.")] = None,
    json: Json = False,
) -> None:
    """Simulate the full drive model with located events; writes a CSV with named, unit-bearing columns."""
    from symdyn.faces import simulate_command

    simulate_command.run(
        model,
        chain_of(base, tip, lock_others),
        duration,
        step,
        input or [],
        start or [],
        smoothing,
        tolerance,
        simulate_command.Files(out, events, energy, sensitivities),
        parameter or [],
        json,
    )


for command in (frequency, sensitivity, reduce):
    app.command()(command)
app.command("response", hidden=True)(frequency)  # what some would look for


@app.command()
def identify(
    model: Model,
    recording: Path,
    base: Base = None,
    tip: Tip = None,
    lock_others: Lock = False,
    channel_map: Map = None,
    band: Band = None,
    json: Json = False,
) -> None:
    """Fit the parameters of the model as it is to a recording."""
    from symdyn.faces import recording_commands

    recording_commands.identify(model, chain_of(base, tip, lock_others), recording, channel_map, band, json)


@app.command()
def diagnose(
    model: Model,
    recordings: Annotated[
        list[Path], typer.Argument(metavar="RECORDING...", help="One run of the machine, or several.")
    ],
    holdout: Annotated[
        list[Path] | None,
        typer.Option(
            "--holdout",
            help="Another recording of the same machine, on which nothing is fitted and which judges; repeatable. "
            "Default: blocks of each recording, a third of it, are set aside to judge.",
        ),
    ] = None,
    base: Base = None,
    tip: Tip = None,
    lock_others: Lock = False,
    channel_map: Map = None,
    band: Band = None,
    report: Annotated[Path | None, typer.Option("--report", help="Write the HTML report here.")] = None,
    model_out: Annotated[
        Path | None, typer.Option("--model-out", help="Write the diagnosed robot.toml (or .urdf) here.")
    ] = None,
    generate: Annotated[
        Path | None, typer.Option("--generate", help="Write the kernel of the diagnosed robot into this folder.")
    ] = None,
    experiment: Annotated[
        Path | None,
        typer.Option("--experiment", help="Design the motion that tells rivals apart, and write it (CSV) here."),
    ] = None,
    limits: Limits = None,
    duration: Duration = 20.0,
    hold: Annotated[
        list[str] | None,
        typer.Option(
            "--hold",
            metavar="NAME",
            help="A parameter that the model is right about, and no fit moves ('*' stands for anything); repeatable. "
            "With all of them held, what is found is what has changed since the model was fitted: a payload, say. "
            "'gravity': as the model has it.",
        ),
    ] = None,
    thorough: Annotated[
        bool,
        typer.Option(
            "--thorough",
            help="Ask everything, however long it takes. Default: a search that takes long ends early, and an alarm "
            "says what it did not ask; what counts is work, not time, so that every machine answers the same.",
        ),
    ] = False,
    json: Json = False,
) -> None:
    """Find the physics that the model lacks: where, what, how much, proved on held-out data."""
    from symdyn.faces import recording_commands

    chain = chain_of(base, tip, lock_others)
    code = recording_commands.diagnose(
        model, chain, recordings, holdout or [], channel_map, band, report, model_out, generate, json,
        experiment, limits or [], duration, hold or [], thorough,
    )  # fmt: skip
    if code:
        raise typer.Exit(code)


for beyond in (experiment, profile, fleet):
    app.command()(beyond)


@app.command()
def demo(
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder for the report and the diagnosed model.")] = Path(
        "out/demo"
    ),
    json: Json = False,
) -> None:
    """Diagnose the recording that ships with symdyn: an arm in which one effect is concealed."""
    from symdyn.faces import recording_commands

    code = recording_commands.demo(out, json)
    if code:
        raise typer.Exit(code)


def main() -> None:
    """Entry point: known errors become messages and exit codes 2, 3, 4; tracebacks only with --debug."""
    from symdyn.base.errors import SymdynError

    debug = "--debug" in sys.argv[1:]
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal without a sign for "plus or minus" gets a "?"
    try:
        app()
    except SymdynError as error:
        if debug:
            raise
        from symdyn.faces.console import print_error

        print_error(error)
        sys.exit(error.exit_code)
    except OSError as error:
        if debug:
            raise
        typer.echo(f"error: {error.strerror or error}: {error.filename or ''}".rstrip(": "), err=True)
        sys.exit(2)
