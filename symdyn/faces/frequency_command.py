"""The frequency command: modes by name, peaks, and the response from an input to a sensor or state."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from symdyn.base.errors import Problem, UsageError
from symdyn.base.files import write_atomically
from symdyn.faces import amplitude_command
from symdyn.faces.amplitude_command import Excitation
from symdyn.faces.console import err, out, print_json, print_table
from symdyn.faces.linear_options import band_of, check_points, finite, mode_facts, open_linear, tell
from symdyn.numeric.linear.modes import Mode, modes
from symdyn.numeric.linear.response import extrema, frequency_response
from symdyn.numeric.linear.signals import grid
from symdyn.numeric.linear.transfer import transfer_function
from symdyn.spec.urdf_chain import Chain

_POINTS, _MEASURED = 2000, 40  # frequencies, of the linear part and at an amplitude
_SHOWN = 0.01  # share from which a part of a mode is listed


def run(
    model: str,
    chain: Chain,
    input: str | None,
    output: str | None,
    low: float | None,
    high: float | None,
    points: int | None,
    at: list[str],
    excitation: Excitation | None,
    plot: Path | None,
    json: bool,
) -> None:
    if excitation is not None:
        count = points if points is not None else _MEASURED
        amplitude_command.run(model, chain, at, input, output, low, high, count, excitation, plot, json)
        return
    points = points if points is not None else _POINTS
    check_points(points)
    linear = open_linear(model, chain, at)
    system = linear.family.nominal
    found = modes(system)
    first, last = band_of(low, high, found)
    response = frequency_response(system, grid(first, last, points), input, output)
    peaks = extrema(system, first, last, input, output)
    if plot is not None:
        from symdyn.faces.report.linear_plots import overview

        write_atomically(plot, overview(response, peaks, found))
    if json:
        g = transfer_function(system, input, output)
        facts: dict[str, Any] = linear.facts() | {
            "input": response.input,
            "output": response.output,
            "unit": response.unit,
            "modes": [mode_facts(mode) for mode in found],
            "extrema": [{"kind": e.kind, "frequency": e.frequency, "magnitude": e.magnitude} for e in peaks],
            "transfer_function": {
                "zeros": [[z.real, z.imag] for z in g.zeros],
                "poles": [[p.real, p.imag] for p in g.poles],
                "gain": g.gain,
            },
            "response": {
                "hertz": response.hertz.tolist(),
                "magnitude": [finite(v) for v in response.magnitude],
                "phase": [finite(v) for v in response.phase],
            },
        }
        print_json(facts)
        return
    tell(linear)
    rows = [_row(mode) for mode in found]
    print_table(f"{linear.robot.name}: modes", ("mode", "Hz", "damping", "strain in", "damped by"), rows)
    out.print(f"{response.input} to {response.output}, {response.unit}:", markup=False)
    for e in peaks:
        size = 20 * np.log10(e.magnitude) if e.magnitude > 0 else -np.inf
        out.print(f"  {e.kind} at {e.frequency:.5g} Hz: {e.magnitude:.4g} ({size:.1f} dB)", markup=False)
    if not peaks:
        out.print(f"  no peak between {first:g} and {last:g} Hz", markup=False)
    if plot is not None:
        err.print(f"written: {plot}", markup=False)


def excitation(amplitude: float | None, method: str | None, realisations: int, seed: int) -> Excitation | None:
    """What --amplitude and its companions say; None where the linear part is asked for.

    Raises UsageError (SD302) for a method without an amplitude.
    """
    if amplitude is None:
        if method is not None:
            raise UsageError(Problem("SD302", f"--method {method} needs an --amplitude"))
        return None
    return Excitation(amplitude, method or "stepped", realisations, seed)


def _row(mode: Mode) -> tuple[str, ...]:
    strain = {name: share for name, share in mode.strain.items() if abs(share) >= _SHOWN}
    total = sum(map(abs, strain.values())) or 1.0
    damping = f"{mode.damping:.4f}" if mode.frequency else ""
    return mode.name, f"{mode.frequency:.5g}", damping, _shares(strain, total), _shares(mode.losses, mode.decay)


def _shares(table: Any, total: float) -> str:
    """Largest first, in percent."""
    rows = sorted(table.items(), key=lambda row: -abs(row[1]))
    return ", ".join(f"{name} {100 * v / total:.0f} %" for name, v in rows if total and abs(v / total) >= _SHOWN)
