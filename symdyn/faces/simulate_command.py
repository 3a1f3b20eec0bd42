"""The simulate command: inputs by shape, named states, located events; a CSV with units in its header."""

from __future__ import annotations

import io
import math
import sys
from collections.abc import Callable
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from symdyn import compiler
from symdyn.base.errors import Problem, UsageError
from symdyn.base.files import write_atomically
from symdyn.emit.kernel import Kernel
from symdyn.faces.console import err, print_json, status
from symdyn.faces.model_commands import refuse_free_parameters
from symdyn.faces.signal_words import read_signals
from symdyn.numeric.hybrid.energy import EnergyBalance, energy_balance
from symdyn.numeric.hybrid.machine import Machine
from symdyn.numeric.hybrid.simulate import simulate_events
from symdyn.numeric.hybrid.trajectory import Event
from symdyn.numeric.simulate import Trajectory, simulate
from symdyn.spec.records import Robot
from symdyn.spec.urdf_chain import Chain

Array = NDArray[np.float64]

MOST_ROWS = 10_000_000


def run(
    model: str,
    chain: Chain,
    duration: float,
    step: float,
    inputs: list[str],
    start: list[str],
    smoothing: float | None,
    tolerance: float,
    path: Path | None,
    events_path: Path | None,
    energy_path: Path | None,
    json: bool,
) -> None:
    if not (math.isfinite(duration) and duration > 0 and math.isfinite(step) and 0 < step <= duration):
        raise UsageError(Problem("SD302", "--duration and --step must be positive, the step not above the duration"))
    if duration / step > MOST_ROWS:
        raise UsageError(Problem("SD302", f"{duration / step:.3g} rows: choose a longer --step"))
    if smoothing is not None and not (math.isfinite(smoothing) and smoothing > 0):
        raise UsageError(Problem("SD302", "--smoothing must be positive"))
    if smoothing is not None and energy_path is not None:
        raise UsageError(Problem("SD302", "--energy needs located events: leave --smoothing out"))
    robot = compiler.load_robot(model, chain)
    refuse_free_parameters(robot)
    time = np.arange(round(duration / step) + 1, dtype=np.float64) * step
    with status(json) as progress:
        if smoothing is None:
            kernel, result, events, energy = _with_events(
                robot, inputs, start, time, tolerance, energy_path is not None, progress
            )
        else:
            kernel, result = _smoothed(robot, inputs, start, time, smoothing, progress)
            events, energy = (), None
    columns = result.table(kernel)
    if json:
        shown = {name: values.tolist() for name, values in columns.items()} | {"events": [asdict(e) for e in events]}
        if energy is not None:
            table = {name: values.tolist() for name, values in energy.table().items()}
            shown["energy"] = table | {"closure": energy.closure}
        print_json(shown)
        return
    if events_path is not None:
        write_atomically(
            events_path, _csv({f.name: [getattr(e, f.name) for e in events] for f in fields(Event)}, "%.12g")
        )
    if energy_path is not None and energy is not None:
        write_atomically(energy_path, _csv(dict(energy.table()), "%.12g"))
        err.print(f"energy accounted for but {energy.closure:.1e} of it: {energy_path}", markup=False)
    text = _csv(dict(columns), "%.10g")
    if path is None:
        sys.stdout.write(text)
        return
    write_atomically(path, text)
    jumps = f"{len(events)} events located" if smoothing is None else f"jumps smoothed over {smoothing:g}"
    err.print(f"{len(time)} rows, {jumps}: {path}", markup=False)


def _with_events(
    robot: Robot,
    inputs: list[str],
    start: list[str],
    time: Array,
    tolerance: float,
    book: bool,
    progress: Callable[[str], None],
) -> tuple[Kernel, Trajectory, tuple[Event, ...], EnergyBalance | None]:
    machine = Machine(compiler.compile_hybrid(robot))
    kernel = machine.kernel
    signals = read_signals(inputs, kernel.inputs)
    x = _named(start, kernel.states, "--start")
    progress("simulating")
    found = simulate_events(machine, time, signals, start=x, tolerance=tolerance)
    energy = None
    if book:
        progress("booking the energy")
        energy = energy_balance(machine, found, signals)
    outputs = np.zeros((len(time), 0))
    if kernel.outputs:
        modes = np.zeros((len(time), len(machine.switches)))
        outputs = kernel.output_batch(found.states, np.ascontiguousarray(found.inputs), modes)
    result = Trajectory(time, found.states, found.inputs, outputs, kernel.states, found.tries)
    return kernel, result, found.events, energy


def _smoothed(
    robot: Robot, inputs: list[str], start: list[str], time: Array, smoothing: float, progress: Callable[[str], None]
) -> tuple[Kernel, Trajectory]:
    kernel = compiler.compile_robot(robot, smoothing=smoothing).kernel()
    signals = read_signals(inputs, kernel.inputs)
    x = _named(start, kernel.states, "--start")
    shown = -1

    def tell(t: float) -> None:
        nonlocal shown
        percent = int(100 * t / time[-1])
        if percent > shown:
            shown = percent
            progress(f"step {t:.3g} s of {time[-1]:.3g} s")

    def control(t: float) -> Array:
        return np.array([signal.at(np.array([t]))[0] for signal in signals])

    return kernel, simulate(kernel, time, control, start=x, progress=tell)


def _csv(columns: dict[str, Any], floats: str) -> str:
    buffer = io.StringIO()
    pd.DataFrame(columns).to_csv(buffer, index=False, float_format=floats, lineterminator="\n")
    return buffer.getvalue()


def _named(given: list[str], names: tuple[str, ...], option: str) -> Array:
    """NAME=VALUE pairs as a vector over ``names``."""
    values = np.zeros(len(names))
    for item in given:
        name, _, text = item.partition("=")
        if name not in names:
            raise UsageError(Problem("SD305", f"{option} {item}: no such name", hint=f"known: {', '.join(names)}"))
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise UsageError(Problem("SD305", f"{option} {item}: {text!r} is no finite number"))
        values[names.index(name)] = value
    return values
