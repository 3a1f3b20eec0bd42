"""The sensitivity command: exact local derivatives, one parameter at a time, or globally by Morris or Sobol."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from symdyn.base.errors import Problem, UsageError
from symdyn.base.files import write_atomically
from symdyn.base.wording import did_you_mean
from symdyn.derive.linearize import without_nonsmooth
from symdyn.faces.console import err, out, print_json, print_table, status
from symdyn.faces.linear_options import Linear, band_of, check_points, finite, mode_facts, open_linear, tell
from symdyn.numeric.executor import Executor
from symdyn.numeric.linear.cost import Band
from symdyn.numeric.linear.global_sensitivity import GlobalSensitivity, SobolIndex, default_ranges, morris, sobol
from symdyn.numeric.linear.local_sensitivity import LocalSensitivity, local_sensitivity
from symdyn.numeric.linear.modes import modes
from symdyn.numeric.linear.one_at_a_time import OneAtATime, one_at_a_time
from symdyn.numeric.linear.scalars import scalars
from symdyn.numeric.linear.signals import grid
from symdyn.numeric.linear.spread_evaluation import Spread
from symdyn.spec.urdf_chain import Chain

METHODS = ("morris", "sobol")


def run(
    model: str,
    chain: Chain,
    input: str | None,
    output: str | None,
    low: float | None,
    high: float | None,
    points: int,
    at: list[str],
    parameters: list[str],
    factors: list[float],
    method: str | None,
    samples: int | None,
    spread: float,
    seed: int,
    executor: Executor,
    plot: Path | None,
    json: bool,
) -> None:
    check_points(points)
    if method is not None and method not in METHODS:
        raise UsageError(Problem("SD302", f"--global {method}: choose morris or sobol"))
    if not 0 < spread < 1 or (samples is not None and samples < 2) or seed < 0:
        raise UsageError(
            Problem("SD302", "--spread must be between 0 and 1, --samples at least 2, --seed not negative")
        )
    if not all(math.isfinite(f) and f > 0 for f in factors):
        raise UsageError(Problem("SD302", "--factor must be positive"))
    linear = open_linear(model, chain, at)
    for name in parameters:
        if name not in linear.family.parameters:
            hint = did_you_mean(name, linear.family.parameters, "parameters")
            raise UsageError(Problem("SD305", f"no parameter `{name}`", hint=hint))
    first, last = band_of(low, high, modes(linear.family.nominal))
    if method is not None:
        _global(linear, method, input, output, (first, last), parameters, samples, spread, seed, executor, json)
        return
    hertz = grid(first, last, points)
    local = local_sensitivity(linear.family, hertz, input, output)
    used = linear.family.derivatives(linear.family.values).used
    unused = [name for name, is_used in zip(linear.family.parameters, used, strict=True) if not is_used]
    names = parameters or [name for name in linear.family.parameters if name not in unused]
    with status(json) as progress:
        varied = one_at_a_time(linear.family, hertz, input, output, names, factors, progress)
    if plot is not None:
        from symdyn.faces.report.linear_plots import sensitivities, variations

        shown = [v.parameter for v in varied.variations]
        write_atomically(plot, variations(varied, list(dict.fromkeys(shown))) if parameters else sensitivities(local))
    if json:
        print_json(linear.facts() | {"unused": unused} | _local_facts(local, varied, names))
        return
    tell(linear)
    if unused:
        err.print(f"not in the linear model: {', '.join(unused)}", markup=False)
    _print_local(linear.robot.name, local, varied, names)
    if plot is not None:
        err.print(f"written: {plot}", markup=False)


def _local_facts(local: LocalSensitivity, varied: OneAtATime, names: Sequence[str]) -> dict[str, Any]:
    at = [local.parameters.index(name) for name in names]
    rows = {}
    for k in at:
        rows[local.parameters[k]] = {
            "value": float(local.values[k]),
            "unit": local.units[k],
            "frequency": [finite(v) for v in local.frequency_log[k]],
            "damping": [finite(v) for v in local.damping_log[k]],
            "pole": [[finite(v.real), finite(v.imag)] for v in local.pole_gradient[k]],
            "magnitude": [finite(v) for v in local.magnitude_log[k]],
            "phase": [finite(v) for v in local.phase_log[k]],
        }
    return {
        "input": local.response.input,
        "output": local.response.output,
        "modes": [mode_facts(mode) for mode in local.modes],
        "hertz": local.response.hertz.tolist(),
        "local": rows,
        "one_at_a_time": [
            {
                "parameter": v.parameter,
                "factor": v.factor,
                "poles": [[finite(p.real), finite(p.imag)] for p in v.poles],
                "magnitude": [finite(m) for m in v.response.magnitude],
            }
            for v in varied.variations
        ],
    }


def _print_local(robot: str, local: LocalSensitivity, varied: OneAtATime, names: Sequence[str]) -> None:
    swinging = [i for i, mode in enumerate(local.modes) if mode.pole.imag > 0]
    for number, i in enumerate(swinging, start=1):
        mode = local.modes[i]
        out.print(f"mode {number}: {mode.name}, {mode.frequency:.5g} Hz, damping {mode.damping:.4f}", markup=False)
    columns = ["parameter", "value", *(f"f{n}" for n in range(1, len(swinging) + 1))]
    columns += [f"d{n}" for n in range(1, len(swinging) + 1)] + ["|G|", "at Hz"]
    columns += [f"dB at × {f:g}" for f in dict.fromkeys(v.factor for v in varied.variations)]
    rows = []
    for name in names:
        k = local.parameters.index(name)
        damping = [local.damping_log[k, i] / local.modes[i].damping for i in swinging]
        worst = int(np.argmax(np.abs(local.magnitude_log[k])))
        changes = [np.abs(varied.deviation(v)).max() for v in varied.variations if v.parameter == name]
        row = [name, f"{local.values[k]:.4g} {local.units[k]}"]
        row += [_number(v) for v in (*local.frequency_log[k, swinging], *damping, local.magnitude_log[k, worst])]
        row += [f"{local.response.hertz[worst]:.4g}", *(f"{c:.3g}" for c in changes)]
        rows.append(row + [""] * (len(columns) - len(row)))
    title = f"{robot}: % of each per % of the parameter (f: frequency, d: damping ratio of a mode; |G|: its largest)"
    print_table(title, columns, rows)


def _global(
    linear: Linear,
    method: str,
    input: str | None,
    output: str | None,
    band: tuple[float, float],
    parameters: Sequence[str],
    samples: int | None,
    spread: float,
    seed: int,
    executor: Executor,
    json: bool,
) -> None:
    family = linear.family
    middle = math.sqrt(band[0] * band[1])
    bands = (Band(band[0], middle), Band(middle, band[1]))
    numbers = scalars(family, bands, input, output)
    spread_out = None
    if executor != Executor():
        nominal = family.nominal
        x, u = (np.array([linear.at.get(n, 0.0) for n in names]) for names in (nominal.states, nominal.inputs))
        spread_out = Spread(without_nonsmooth(linear.robot), x, u, bands, input, output, executor)
    ranges = default_ranges(family, spread, parameters)
    with status(json) as progress:
        run = morris if method == "morris" else sobol
        chosen = samples if samples is not None else 20 if method == "morris" else 256
        result = run(family, numbers, ranges, chosen, seed, progress, spread_out)
    if json:
        table = {name: [asdict(row) for row in rows] for name, rows in result.table.items()}
        facts = {"method": method, "ranges": {k: list(v) for k, v in ranges.items()}, "seed": seed}
        print_json(linear.facts() | facts | {"evaluations": result.evaluations, "table": table})
        return
    tell(linear)
    _print_global(result, spread)


def _print_global(result: GlobalSensitivity, spread: float) -> None:
    for name, found in result.table.items():
        rows: list[tuple[str, ...]] = []
        for row in found:
            if isinstance(row, SobolIndex):
                first = f"{row.first:.3f} ± {row.first_interval:.3f}"
                rows.append((row.parameter, first, f"{row.total:.3f} ± {row.total_interval:.3f}"))
            else:
                size = f"{row.mu_star:.3g} ± {row.mu_star_interval:.2g}"
                rows.append((row.parameter, size, f"{row.mu:.3g}", f"{row.sigma:.3g}"))
        sobol_columns, morris_columns = ("parameter", "alone", "in all"), ("parameter", "mean size", "mean", "spread")
        print_table(name, sobol_columns if result.method == "sobol" else morris_columns, rows)
    out.print(f"{result.evaluations} models, parameters within {100 * spread:.0f} %; intervals 95 %", markup=False)


def _number(value: float) -> str:
    return f"{round(value, 3) + 0.0:.3f}" if math.isfinite(value) else ""
