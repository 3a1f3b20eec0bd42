"""The frequency command at an amplitude: the response by simulation with friction, clearance and limits."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from symdyn import compiler
from symdyn.base.errors import Problem, UsageError
from symdyn.base.files import write_atomically
from symdyn.emit.kernel import Kernel
from symdyn.faces.console import err, out, print_json, print_table, status
from symdyn.faces.linear_options import Linear, band_of, finite, open_linear, values_at
from symdyn.faces.model_commands import refuse_free_parameters
from symdyn.numeric.hybrid.machine import Machine
from symdyn.numeric.hybrid.multisine import Multisine, multisine_response, odd_grid
from symdyn.numeric.hybrid.stepped_sine import SteppedSine, stepped_sine
from symdyn.numeric.linear.modes import modes
from symdyn.numeric.linear.response import Response, frequency_response
from symdyn.numeric.linear.signals import grid, per_unit
from symdyn.spec.urdf_chain import Chain

Array = NDArray[np.float64]

METHODS = ("stepped", "multisine")
MOST_POINTS = 2000
_SMOOTH = 1000  # points of the curve of the linear part


@dataclass(frozen=True, slots=True)
class Excitation:
    """What the machine is measured with."""

    amplitude: float
    method: str
    realisations: int
    seed: int


def check(excitation: Excitation, points: int) -> None:
    """Raises UsageError (SD302) for what cannot be measured with."""
    if excitation.method not in METHODS:
        raise UsageError(Problem("SD302", f"--method {excitation.method}: choose one of {', '.join(METHODS)}"))
    if not (np.isfinite(excitation.amplitude) and excitation.amplitude > 0.0):
        raise UsageError(Problem("SD302", "--amplitude must be positive"))
    if not 1 <= excitation.realisations <= 1000 or excitation.seed < 0:
        raise UsageError(Problem("SD302", "--realisations must be from 1 to 1000, --seed not negative"))
    if not 2 <= points <= MOST_POINTS:
        raise UsageError(Problem("SD302", f"--points must be from 2 to {MOST_POINTS} with an amplitude"))


def run(
    model: str,
    chain: Chain,
    at: Sequence[str],
    input: str | None,
    output: str | None,
    low: float | None,
    high: float | None,
    points: int,
    excitation: Excitation,
    plot: Path | None,
    json: bool,
) -> None:
    check(excitation, points)
    robot = compiler.load_robot(model, chain)
    refuse_free_parameters(robot)
    with status(json) as progress:
        machine = Machine(compiler.compile_hybrid(robot))
        kernel = machine.kernel
        linear = open_linear(model, chain, at, (*kernel.states, *kernel.inputs))
        first, last = band_of(low, high, modes(linear.family.nominal))
        point = values_at(at, (*kernel.states, *kernel.inputs))
        start = np.array([point.get(name, 0.0) for name in kernel.states])
        held = [point.get(name, 0.0) for name in kernel.inputs]
        found: SteppedSine | Multisine
        if excitation.method == "stepped":
            found = stepped_sine(
                machine, grid(first, last, points), excitation.amplitude, input, output, start=start, held=held,
                progress=lambda text: progress(f"step {text}"),
            )  # fmt: skip
        else:
            lines = odd_grid(first, last, points, excitation.seed)
            found = multisine_response(
                machine, lines, excitation.amplitude, input, output, start=start, held=held, seed=excitation.seed,
                realisations=excitation.realisations, progress=lambda text: progress(f"step {text}"),
            )  # fmt: skip
    unit, plain = _unit(kernel, found.input, found.output), _linear_part(linear, found, found.hertz)
    if plot is not None:
        from symdyn.faces.report.distortion_plots import measured

        smooth = _linear_part(linear, found, grid(first, last, _SMOOTH))
        write_atomically(plot, measured({f"amplitude {found.amplitude:g}": found}, smooth, unit))
    facts = {"robot": robot.name, "method": excitation.method, "input": found.input, "output": found.output,
             "unit": unit, "amplitude": found.amplitude, "operating_point": point}  # fmt: skip
    if json:
        print_json(facts | _facts(found, plain))
        return
    out.print(f"{found.input} to {found.output}, {unit}, amplitude {found.amplitude:g}:", markup=False)
    if isinstance(found, SteppedSine):
        _stepped_table(found, plain)
    else:
        _multisine_table(found, plain)
    if not np.all(found.settled):
        err.print("* not periodic in the end: its numbers are those of one period", markup=False)
    if plot is not None:
        err.print(f"written: {plot}", markup=False)


def _linear_part(linear: Linear, found: SteppedSine | Multisine, hertz: Array) -> Response | None:
    """The response of the linear part; None where it has no such input or output."""
    system = linear.family.nominal
    if found.input not in system.inputs or found.output not in (*system.outputs, *system.states):
        return None
    return frequency_response(system, hertz, found.input, found.output)


def _unit(kernel: Kernel, input: str, output: str) -> str:
    per = kernel.input_units[kernel.inputs.index(input)]
    if output in kernel.outputs:
        return per_unit(kernel.output_units[kernel.outputs.index(output)], per)
    return per_unit(kernel.state_units[kernel.states.index(output)], per)


def _stepped_table(found: SteppedSine, plain: Response | None) -> None:
    rows = [
        (f"{f:.5g}", *_size(g), _size(plain.values[i])[1] if plain is not None else "", _percent(found.odd[i]),
         _percent(found.even[i]), f"{found.periods[i]}{'' if found.settled[i] else ' *'}")
        for i, (f, g) in enumerate(zip(found.hertz, found.values, strict=True))
    ]  # fmt: skip
    columns = ("Hz", "size", "dB", "degrees", "linear dB", "odd", "even", "periods")
    print_table("stepped sine", columns, rows)


def _multisine_table(found: Multisine, plain: Response | None) -> None:
    rows = [
        (f"{f:.5g}", *_size(g), _size(plain.values[i])[1] if plain is not None else "", f"{found.deviation[i]:.3g}")
        for i, (f, g) in enumerate(zip(found.hertz, found.values, strict=True))
    ]
    print_table(
        f"multisine, best linear approximation of {len(found.responses)} realisations"
        f"{'' if np.all(found.settled) else ' *'}",
        ("Hz", "size", "dB", "degrees", "linear dB", "deviation"), rows,
    )  # fmt: skip
    whole = float(np.linalg.norm(found.level))
    for name, lines, count in (("odd", found.odd, len(found.odd)), ("even", found.even, len(found.even))):
        if count and whole:
            share = float(np.sqrt(np.mean(lines**2)) / np.sqrt(np.mean(found.level**2)))
            out.print(f"  {name} distortion: {_percent(share)} of the output, r.m.s. of {count} lines", markup=False)


def _size(g: complex) -> tuple[str, str, str]:
    size = abs(g)
    decibel = f"{20 * np.log10(size):.2f}" if size > 0.0 else "-inf"
    return f"{size:.4g}", decibel, f"{np.degrees(np.angle(g)):.1f}"


def _percent(share: float) -> str:
    """Below 1e-6 % it is rounding."""
    return f"{100 * share:.3g} %" if share >= 1e-8 else "0 %"


def _facts(found: SteppedSine | Multisine, plain: Response | None) -> dict[str, Any]:
    facts: dict[str, Any] = {
        "hertz": found.hertz.tolist(),
        "magnitude": np.abs(found.values).tolist(),
        "phase": np.degrees(np.unwrap(np.angle(found.values))).tolist(),
        "linear_magnitude": None if plain is None else [finite(v) for v in plain.magnitude],
        "periods": found.periods.tolist(),
        "settled": found.settled.tolist(),
    }
    if isinstance(found, SteppedSine):
        sizes = np.abs(found.harmonics)
        return facts | {
            "odd": found.odd.tolist(),
            "even": found.even.tolist(),
            "harmonics": sizes.tolist(),
            "events": found.events.tolist(),
        }
    lines = found.grid
    return facts | {
        "deviation": [finite(v) for v in found.deviation],
        "level": found.level.tolist(),
        "odd": {"hertz": (lines.lowest * lines.detection).tolist(), "level": found.odd.tolist()},
        "even": {"hertz": (lines.lowest * lines.even).tolist(), "level": found.even.tolist()},
    }
