"""The EMPS recordings: what the diagnosis finds by itself, beside a fixed ladder of models; writes docs/emps.md.

    python benchmarks/emps_ladder.py

Reads the folder ``emps`` under SYMDYN_DATASETS (default: ../shared/datasets, seen from the checkout); where it is
absent, nothing is written.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from symdyn.compiler import compile_robot, load_robot, robot_from_text
from symdyn.numeric.band import band_of
from symdyn.numeric.candidates import fitted_parameters
from symdyn.numeric.diagnose import diagnose
from symdyn.numeric.findings import Diagnosis, Estimate
from symdyn.numeric.fitting import Fit, fit, relative_error
from symdyn.numeric.observation import observe
from symdyn.numeric.recording import Recording, read_recording
from symdyn.numeric.workbench import Workbench
from symdyn.spec.edit import add_effect
from symdyn.spec.records import Robot

CHECKOUT = Path(__file__).resolve().parent.parent
PLACE = "carriage"

# Effects as a file writes them, at their null values: the fit gives them others.
VISCOUS = ("viscous_friction", {"coefficient": "0 N s/m"})
COULOMB = ("coulomb_friction", {"level": "0 N"})
OFFSET = ("force_offset", {"offset": "0 N"})
ASYMMETRIC = ("asymmetric_viscous_friction", {"difference": "0 N s/m"})
STRIBECK = ("stribeck_friction", {"excess": "0 N", "stribeck_velocity": "0.01 m/s"})
STRIBECK_VELOCITY = f"{PLACE}_stribeck_friction_stribeck_velocity"
STRIBECK_STARTS = np.geomspace(5e-4, 0.2, 40)  # m/s; the carriage moves at up to 0.2 m/s

PUBLISHED = {  # Janot, Gautier, Brunot 2019, for the model of mass, viscous and Coulomb friction, and offset
    "M": 95.1089,
    f"{PLACE}_viscous_friction_coefficient": 203.5034,
    f"{PLACE}_coulomb_friction_level": 20.3935,
    f"{PLACE}_force_offset_offset": -3.1648,
}
PUBLISHED_MODEL = "+ force offset"


@dataclass(frozen=True, slots=True)
class Rung:
    """A model; ``known`` is its held-out error in % by other code (least squares, 100 Hz filter, every 50th sample)."""

    title: str
    effects: tuple[tuple[str, Mapping[str, str]], ...]
    known: float


LADDER = (
    Rung("mass alone", (), 74.1),
    Rung("+ viscous friction", (VISCOUS,), 18.7),
    Rung("+ Coulomb friction", (VISCOUS, COULOMB), 7.4),
    Rung(PUBLISHED_MODEL, (VISCOUS, COULOMB, OFFSET), 4.12),
    Rung("+ direction-asymmetric viscous friction", (VISCOUS, COULOMB, OFFSET, ASYMMETRIC), 2.93),
    Rung("Stribeck instead of asymmetric", (VISCOUS, COULOMB, OFFSET, STRIBECK), 4.04),
)


@dataclass(frozen=True, slots=True)
class Result:
    """A rung, fitted: relative force errors, and its estimates by parameter name."""

    rung: Rung
    training: float
    heldout: float
    estimates: Mapping[str, Estimate]


def main() -> int:
    default = CHECKOUT / "docs" / "emps.md"
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=default, help="the page to write (default: docs/emps.md)")
    arguments = parser.parse_args()
    folder = Path(os.environ.get("SYMDYN_DATASETS") or CHECKOUT.parent / "shared" / "datasets") / "emps"
    if not folder.is_dir():
        print("docs/emps.md: skipped, no EMPS recordings here (SYMDYN_DATASETS names their folder)", file=sys.stderr)
        return 0
    robot = load_robot("emps")
    assert robot.channels is not None
    training = read_recording(folder / "identification.csv.gz", robot.channels)
    heldout = read_recording(folder / "pulses_validation.csv.gz", robot.channels)
    diagnosis = diagnose(robot, training, heldout, progress=lambda text: print(text, file=sys.stderr))
    results = []
    for rung in LADDER:
        print(f"ladder: {rung.title}", file=sys.stderr)
        results.append(climb(robot, rung, training, heldout, diagnosis.band))
    arguments.out.write_text(page(diagnosis, results), encoding="utf-8")
    return 0


def climb(robot: Robot, rung: Rung, training: Recording, heldout: Recording, cutoff: float) -> Result:
    """Fit a rung to the training data and judge it on the held-out data, both in the band below ``cutoff`` Hz."""
    text = robot.text
    for effect, values in rung.effects:
        text = add_effect(text, effect, PLACE, values)
    model = robot_from_text(text, rung.title)
    kernel = compile_robot(model).kernel()
    bench, judge = (
        # As a diagnosis does it: derivatives have room above the band in which residuals are compared.
        Workbench(kernel, observe(model, kernel, r, 5.0 * cutoff), band_of(cutoff, 1.0 / r.sample_time))
        for r in (training, heldout)
    )
    done = _fit(bench, fitted_parameters(model))
    units = dict(zip(kernel.parameters, kernel.parameter_units, strict=True))
    estimates = {n: Estimate(float(done.p[bench.index[n]]), done.standard_error(n), units[n]) for n in done.names}
    return Result(rung, _error(bench, done), _error(judge, done), estimates)


def _fit(bench: Workbench, names: tuple[str, ...]) -> Fit:
    """The characteristic speed of Stribeck friction does not enter linearly: fitted from the best of many starts."""
    p, weight = bench.kernel.values, np.ones(1)
    if STRIBECK_VELOCITY not in names:
        return fit(bench, p, names, weight)
    linear = [name for name in names if name != STRIBECK_VELOCITY]
    fits = []
    for start in STRIBECK_STARTS:
        p[bench.index[STRIBECK_VELOCITY]] = start
        fits.append(fit(bench, p, linear, weight))
    return fit(bench, min(fits, key=lambda f: _error(bench, f)).p, names, weight)


def _error(bench: Workbench, fitted: Fit) -> float:
    return relative_error(bench.residual(fitted.p), bench.effort)


def page(diagnosis: Diagnosis, results: list[Result]) -> str:
    """docs/emps.md."""
    published = next(result for result in results if result.rung.title == PUBLISHED_MODEL)
    asymmetric, stribeck = results[-2:]
    return f"""# EMPS: a ladder of models, and what the diagnosis finds

<!-- Generated by `python benchmarks/emps_ladder.py` (`make docs`); edits are lost. -->

The recordings are those of the electro-mechanical positioning system (a carriage on a ball screw, 1 kHz, closed
loop): A. Janot, M. Gautier, M. Brunot, "Data set and reference models of EMPS", Workshop on Nonlinear System
Identification Benchmarks, 2019. They are not part of this repository. Models are fitted on the identification run;
the held-out run has disturbance pulses that no fit saw. Errors are relative: the size of the force residual over
that of the measured force. Everything is compared below {diagnosis.band:.1f} Hz, the band that the diagnosis chose.

    make docs          # or: SYMDYN_DATASETS=FOLDER python benchmarks/emps_ladder.py

## What the diagnosis finds, starting from the mass alone

{_findings(diagnosis)}

## A fixed ladder, for comparison

"Elsewhere" is an independent least-squares fit, with other code and another filter (100 Hz, then every 50th sample).

| model | training | held out | held out, elsewhere |
| --- | ---: | ---: | ---: |
{chr(10).join(_rung(result) for result in results)}

{_remarks(asymmetric, stribeck)}

## Parameters of the published model

Mass, viscous and Coulomb friction, and offset. Standard errors allow for correlated residuals (Newey and West).

| parameter | symdyn | standard error | published | difference |
| --- | ---: | ---: | ---: | ---: |
{chr(10).join(_parameter(name, published.estimates[name], value) for name, value in PUBLISHED.items())}

## Parameters of every rung

{chr(10).join(f"- **{result.rung.title}**: {_listed(result.estimates)}" for result in results)}
"""


def _remarks(asymmetric: Result, stribeck: Result) -> str:
    """What the numbers of the last two rungs mean, as far as they say it."""
    excess = stribeck.estimates[f"{PLACE}_stribeck_friction_excess"]
    offset = asymmetric.estimates[f"{PLACE}_force_offset_offset"]
    remarks = []
    if stribeck.heldout > asymmetric.heldout:
        remarks.append("Friction that differs by direction explains the held-out run better than Stribeck friction.")
    if excess.value < 0:
        remarks.append(
            f"The excess of the latter comes out at {excess.value:.2f} N: less friction near standstill, not more. The "
            "diagnosis refuses such a value, because it lies outside the bounds of the effect."
        )
    if offset.se is not None and abs(offset.value) < 2 * offset.se:
        remarks.append(
            f"Once friction may differ by direction, the offset is {offset.value:.2f} ± {offset.se:.2f} N, which "
            "cannot be told from zero: that is why the diagnosis does not list it."
        )
    return "\n".join(f"- {remark}" for remark in remarks)


def _findings(diagnosis: Diagnosis) -> str:
    rows = [
        "| step | found | where | value | held-out error |",
        "| --- | --- | --- | --- | ---: |",
        f"| 0 | the model as given | | {_listed(diagnosis.model)} | {_percent(diagnosis.before.heldout)} |",
    ]
    for i, finding in enumerate(diagnosis.findings, start=1):
        values = _listed(finding.parameters)
        rows.append(f"| {i} | {finding.title} | {finding.place} | {values} | {_percent(finding.heldout_after)} |")
    left = diagnosis.remaining
    told = (
        f"{100 * left.share:.0f} % of its power still follows the {left.variable}"
        if left.structured
        else "none of it follows the motion"
    )
    rest = f"What is left is {_percent(left.heldout)} of the held-out force; {told}."
    return "\n".join([*rows, "", f"All values are those of the last step. {rest}"])


def _rung(result: Result) -> str:
    title, known = result.rung.title, result.rung.known
    return f"| {title} | {_percent(result.training)} | {_percent(result.heldout)} | {known:.3g} % |"


def _parameter(name: str, estimate: Estimate, published: float) -> str:
    own = f"{estimate.value:.5g} {estimate.unit} | {_error_of(estimate)}"
    return f"| {_short(name)} | {own} | {published:.6g} | {100 * (estimate.value / published - 1):+.2f} % |"


def _listed(estimates: Mapping[str, Estimate]) -> str:
    return ", ".join(f"{_short(name)} {e.value:.5g} ± {_error_of(e)} {e.unit}" for name, e in estimates.items())


def _error_of(estimate: Estimate) -> str:
    return "?" if estimate.se is None else f"{estimate.se:.2g}"


def _short(name: str) -> str:
    """``carriage_viscous_friction_coefficient`` without the place, which is the only one."""
    return name.removeprefix(f"{PLACE}_").replace("_", " ")


def _percent(value: float) -> str:
    return f"{100 * value:.2f} %"


if __name__ == "__main__":
    sys.exit(main())
