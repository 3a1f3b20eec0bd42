"""The reduce command: what a model can do without over a band, what that costs, and the smaller model as a file."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from symdyn import compiler
from symdyn.base.errors import InputError, Problem, UsageError
from symdyn.base.files import write_atomically
from symdyn.faces.console import err, out, print_json, print_table, status
from symdyn.faces.linear_options import Linear, band_of, cost_facts, open_linear, tell
from symdyn.numeric.linear.cost import Band, Cost, Signal
from symdyn.numeric.linear.modes import modes
from symdyn.numeric.linear.propose import Reduction, Step, propose, reduced
from symdyn.numeric.linear.response import frequency_response
from symdyn.spec.edit import set_parameter
from symdyn.spec.urdf_chain import Chain

_SHOWN = 8  # rows of the tables of single drops


def run(
    model: str,
    chain: Chain,
    input: str | None,
    output: str | None,
    low: float | None,
    high: float | None,
    tolerance: float,
    signal: str,
    at: list[str],
    path: Path | None,
    plot: Path | None,
    json: bool,
) -> None:
    if not (math.isfinite(tolerance) and 0 < tolerance < 1):
        raise UsageError(Problem("SD302", "--error must be between 0 and 1"))
    if signal not in tuple(Signal):
        raise UsageError(Problem("SD302", f"--signal {signal}: choose {' or '.join(Signal)}"))
    linear = open_linear(model, chain, at)
    band = Band(*band_of(low, high, modes(linear.family.nominal)), Signal(signal))
    with status(json) as progress:
        found = propose(linear.family, band, tolerance, input, output, progress)
    refused: list[str] = []
    if path is not None:
        text, refused = reduced_text(linear, found)
        write_atomically(path, text)
    if plot is not None:
        write_atomically(plot, _drawn(linear, found))
    if json:
        print_json(linear.facts() | _facts(found) | {"refused": refused})
        return
    tell(linear)
    _print(linear, found)
    if path is not None:
        for reason in refused:
            err.print(f"not in the file: {reason}", markup=False)
        err.print(f"written: {path}", markup=False)
    if plot is not None:
        err.print(f"written: {plot}", markup=False)


def reduced_text(linear: Linear, found: Reduction) -> tuple[str, list[str]]:
    """The robot.toml with the steps that are changes of values; comments and effects that jump are kept.

    And those steps that no file may hold, with the reason: a reader refuses inertias that no body has.
    """
    text, refused = linear.robot.text, []
    units = {p.name: p.unit for p in linear.robot.parameters}
    for step in found.steps:
        changed = text
        for name, value in (step.values or {}).items():
            unit = "" if units[name] == "1" else f" {units[name]}"
            changed = set_parameter(changed, linear.robot, name, f"{value!r}{unit}")
        try:
            compiler.robot_from_text(changed, linear.robot.name)
        except InputError as error:
            refused.append(f"{told(step)}: {error.problems[0].code}: {error.problems[0].message}")
        else:
            text = changed
    return text, refused


def _drawn(linear: Linear, found: Reduction) -> str:
    from symdyn.faces.report.linear_plots import bode

    hertz = found.band.hertz()
    models = {
        f"{found.full_order} states": linear.family.nominal,
        f"{found.order} states": reduced(linear.family, found),
    }
    if found.order == found.full_order:
        models = dict(zip(("all parameters", f"{len(found.parameters)} parameters"), models.values(), strict=True))
    shown = {name: frequency_response(system, hertz, found.input, found.output) for name, system in models.items()}
    return bode(hertz, shown)


def told(step: Step) -> str:
    """A step in words."""
    if step.kind == "lump":
        return f"{step.what}' = {' + '.join(step.members)}"
    return f"{step.what} rigid" if step.kind == "rigid" else f"{step.what} = 0"


def _print(linear: Linear, found: Reduction) -> None:
    band = f"{found.band.low:g} to {found.band.high:g} Hz"
    out.print(
        f"{linear.robot.name}, {found.input} to {found.output}, {band}, at most {100 * found.tolerance:g} %",
        markup=False,
    )
    rows = [(told(s), *_cells(s.alone), *_cells(s.so_far)[:1], "yes" if s.in_file else "") for s in found.steps]
    columns = ("step", "error alone", "at Hz", f"r.m.s., {found.band.signal}", "error so far", "as values")
    print_table("proposed", columns, rows)
    out.print(
        f"{found.full_order} states become {found.order}, {found.full_parameters} parameters {len(found.parameters)}: "
        f"{', '.join(found.parameters)}",
        markup=False,
    )
    for lump in found.lumps:
        into = ", ".join(f"{name} {_percent(cost.worst)}" for name, cost in lump.alternatives)
        out.print(
            f"{', '.join(lump.members)} act as one (cosine {lump.parallel:.3f}); error by place: {into}", markup=False
        )
    drops = [(f"{name} = 0", *_cells(cost)) for name, cost in found.zeroed[:_SHOWN]]
    drops += [(f"{name} rigid", *_cells(cost)) for name, cost in found.rigid]
    print_table("each by itself", ("taken away", "error", "at Hz", "r.m.s."), drops)
    print_table(
        "modes", ("mode taken away", "error", "at Hz", "r.m.s."), [(m.name, *_cells(m.cost)) for m in found.modes]
    )
    balanced = [
        (str(b.order), f"{b.hankel:.3g}", _percent(b.truncated.worst), _percent(b.residualised.worst))
        for b in found.balanced
    ]
    print_table("balanced", ("states", "Hankel singular value gone", "truncated", "exact at rest"), balanced)
    if found.unused:
        err.print(f"not in the linear model: {', '.join(found.unused)}", markup=False)


def _facts(found: Reduction) -> dict[str, Any]:
    return {
        "input": found.input,
        "output": found.output,
        "band": [found.band.low, found.band.high],
        "signal": str(found.band.signal),
        "tolerance": found.tolerance,
        "steps": [
            {
                "kind": s.kind, "what": s.what, "members": list(s.members), "is": told(s), "in_file": s.in_file,
                "alone": cost_facts(s.alone), "so_far": cost_facts(s.so_far),
            }
            for s in found.steps
        ],
        "order": {"full": found.full_order, "reduced": found.order},
        "parameters": {"full": found.full_parameters, "reduced": list(found.parameters)},
        "values": dict(found.values),
        "file_cost": cost_facts(found.file_cost),
        "unused": list(found.unused),
        "lumps": [
            {
                "into": g.into, "members": list(g.members), "value": g.value, "parallel": g.parallel,
                "cost": cost_facts(g.cost), "alternatives": {name: cost_facts(c) for name, c in g.alternatives},
            }
            for g in found.lumps
        ],
        "zeroed": {name: cost_facts(c) for name, c in found.zeroed},
        "rigid": {name: cost_facts(c) for name, c in found.rigid},
        "modes": [
            {"name": m.name, "pole": [m.pole.real, m.pole.imag], "states": m.states, "cost": cost_facts(m.cost)}
            for m in found.modes
        ],
        "balanced": [
            {
                "order": b.order, "hankel": b.hankel, "truncated": cost_facts(b.truncated),
                "residualised": cost_facts(b.residualised),
            }
            for b in found.balanced
        ],
    }  # fmt: skip


def _cells(cost: Cost) -> tuple[str, str, str]:
    return _percent(cost.worst), f"{cost.hertz:.4g}", _percent(cost.rms)


def _percent(value: float) -> str:
    return f"{100 * value:.3g} %" if math.isfinite(value) else "none left"
