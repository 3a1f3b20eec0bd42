"""The commands that work on recordings: identify, diagnose, demo."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

from symdyn import compiler
from symdyn.base.errors import BadRecording, Problem, UsageError
from symdyn.base.files import check_writable, write_atomically
from symdyn.faces.console import err, out, print_error, print_json, print_table, print_warnings, status
from symdyn.faces.experiment_command import add_experiment, check_plan, experiment_bounds
from symdyn.faces.recordings import open_recording, open_recordings
from symdyn.faces.words import (
    VERDICT_MEANINGS,
    effect_title,
    located_words,
    nats,
    noise_words,
    parameter_lines,
    percent,
    quantity_text,
    same_law_words,
    verdict_sentence,
)
from symdyn.numeric.experiment.next_experiment import Plan
from symdyn.numeric.findings import Diagnosis, Verdict, bad_recording_json
from symdyn.numeric.runs import training_and_heldout
from symdyn.spec.records import Robot
from symdyn.spec.urdf_chain import WHOLE, Chain

DEMO = Path(__file__).parent.parent / "demo"


def identify(
    model: str, chain: Chain, recording: Path, channel_map: Path | None, band: float | None, json: bool
) -> None:
    from symdyn.numeric.identify import identify as run

    _check_band(band)
    robot = compiler.load_robot(model, chain)
    data = open_recording(recording, robot, channel_map)
    print_warnings(data.warnings)
    with status(json) as progress:
        result = run(robot, data, band=band, progress=progress)
    if json:
        print_json(result.to_json())
        return
    rows = [(name, quantity_text(estimate)) for name, estimate in result.parameters.items()]
    print_table(f"{robot.name} fitted to {data.name}", ("parameter", "value"), rows)
    out.print(f"relative effort error {percent(result.error)} below {result.band:.3g} Hz")
    _print_notes(result.alarms)


def diagnose(
    model: str,
    chain: Chain,
    recordings: Sequence[Path],
    holdout: Sequence[Path],
    channel_map: Path | None,
    band: float | None,
    report: Path | None,
    model_out: Path | None,
    generate: Path | None,
    json: bool,
    experiment: Path | None = None,
    limits: Sequence[str] = (),
    duration: float = 20.0,
    hold: Sequence[str] = (),
    thorough: bool = False,
) -> int:
    """Returns the exit code: 1 when something is left that no known effect explains, 3 for a bad recording."""
    from symdyn.numeric.diagnose import diagnose as run

    _check_band(band)
    plan = Plan(duration)
    check_plan(plan)
    for path in (model_out, report, experiment, generate / "kernel.py" if generate else None):
        if path is not None:
            check_writable(path)
    robot = compiler.load_robot(model, chain)
    allowed = experiment_bounds(limits, robot, experiment)
    try:
        training, judges = open_recordings(recordings, holdout, robot, channel_map)
        for recording in (*training, *judges):
            print_warnings(recording.warnings)
        with status(json) as progress:
            result = run(robot, training, judges or None, band=band, hold=hold, thorough=thorough, progress=progress)
            if experiment is not None:
                fitted, _ = training_and_heldout(training, judges or None)
                result = add_experiment(result, fitted, allowed, plan, experiment, progress)
    except BadRecording as bad:
        return _refused(robot, bad, json)
    if model_out is not None:
        write_atomically(model_out, _model_text(result, model, chain, model_out))
    if generate is not None:
        compiler.generate(result.diagnosed, generate)
    if report is not None:
        from symdyn.faces.report import write_report

        write_report(result, report)
    if json:
        print_json(result.to_json())
    else:
        show(result)
    if result.next_experiment is None or result.next_experiment.file is None:
        experiment = None  # no question left, or no motion that answers it
    written = (("report", report), ("diagnosed model", model_out), ("kernel", generate), ("experiment", experiment))
    for what, path in written:
        if path is not None:
            err.print(f"{what}: {path}", markup=False)
    return 1 if result.verdict is Verdict.UNEXPLAINED or result.remaining.structured else 0


def _refused(robot: Robot, bad: BadRecording, json: bool) -> int:
    """Tell that nothing was diagnosed, and why."""
    if json:
        print_json(bad_recording_json(robot.name, bad.problems))
    else:
        out.print(VERDICT_MEANINGS[Verdict.BAD_RECORDING], style="bold", markup=False)
    print_error(bad)
    return bad.exit_code


def _check_band(band: float | None) -> None:
    if band is not None and not (math.isfinite(band) and band > 0.0):
        raise UsageError(Problem("SD010", f"--band is a frequency in Hz above zero, not {band}"))


def _model_text(result: Diagnosis, model: str, chain: Chain, path: Path) -> str:
    """The diagnosed model in the language of the file to write."""
    if path.suffix != ".urdf":
        return result.diagnosed.text
    return compiler.robot_into_urdf(result.diagnosed, model, chain)


def demo(folder: Path, json: bool) -> int:
    return diagnose(
        str(DEMO / "two-link.toml"),
        WHOLE,
        [DEMO / "identification.csv.gz"],
        [DEMO / "holdout.csv.gz"],
        None,
        None,
        folder / "report.html",
        folder / "robot.toml",
        folder / "kernel",
        json,
    )


def show(result: Diagnosis) -> None:
    """The diagnosis in words and one table."""
    out.print(verdict_sentence(result), style="bold", markup=False)
    rows = [
        ("", "model as given, fitted", "", percent(result.before.heldout)),
        *(
            (
                f.place,
                f.title,
                "\n".join(parameter_lines(f)),
                percent(f.heldout_after),
            )
            for f in result.findings
        ),
    ]
    print_table("", ("where", "what", "with", "held out"), rows, whole="with")
    for located in result.located:
        out.print(f"mismatch at {located_words(located)} (evidence {nats(located.evidence)} nats)", markup=False)
    for finding in result.findings:
        for other in finding.alternatives:
            out.print(
                f"instead of {finding.title} at {finding.place}, {effect_title(other.effect)} at {other.place} "
                f"would have left {percent(other.heldout)}",
                style="dim",
                markup=False,
            )
        for rival in finding.rivals:
            out.print(
                f"cannot tell {finding.title} at {finding.place} from {rival.effect} at {rival.place}", markup=False
            )
    names = {(s.effect, s.place): same_law_words(f, s) for f in result.findings for s in f.same_as}
    for words in names.values():
        out.print(words, style="dim", markup=False)
    left = result.remaining
    shape = f", {percent(left.share)} of its power follows the {left.variable}" if left.variable else ""
    unlike = "slow, unlike noise" if left.slow >= left.beyond_noise else "beyond what noise would leave"
    if left.structured and left.variable is None:
        shape = f", {percent(left.share)} of its power {unlike}, but not a function of the motion"
    elif left.unlike_noise > left.share:
        shape += f" and {percent(left.unlike_noise)} is {unlike}"
    what = "left unexplained" if left.structured else "left, and like noise"
    out.print(
        f"{what}: {percent(left.heldout)} of the {result.judged}{shape} (below {result.band:.3g} Hz). "
        f"{noise_words(result)}".rstrip(),
        markup=False,
    )
    if result.next_experiment is not None:
        out.print(f"next experiment: {result.next_experiment.why}", markup=False)
    _print_notes(result.alarms)


def _print_notes(alarms: Sequence[str]) -> None:
    for alarm in alarms:
        out.print(f"note: {alarm}", markup=False)
