"""The simulate command: inputs by shape, named states, located events; a CSV with units in its header."""

from __future__ import annotations

import io
import math
import sys
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, fields
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
from symdyn.numeric.hybrid.samples import timing
from symdyn.numeric.hybrid.sensitivities import simulate_sensitivities
from symdyn.numeric.hybrid.simulate import simulate_events
from symdyn.numeric.hybrid.trajectory import Event
from symdyn.numeric.simulate import Trajectory, simulate
from symdyn.spec.records import Robot
from symdyn.spec.urdf_chain import Chain

Array = NDArray[np.float64]

MOST_ROWS = 10_000_000


@dataclass(frozen=True, slots=True)
class Files:
    """Where each part of the result goes; states to stdout where no file is given."""

    states: Path | None
    events: Path | None
    energy: Path | None
    sensitivities: Path | None


@dataclass(frozen=True, slots=True)
class _Extras:
    """What was asked for beside the trajectory."""

    events: tuple[Event, ...] = ()
    energy: EnergyBalance | None = None
    sensitivities: Mapping[str, Array] | None = None


def run(
    model: str,
    chain: Chain,
    duration: float,
    step: float,
    inputs: list[str],
    start: list[str],
    smoothing: float | None,
    tolerance: float,
    files: Files,
    parameters: list[str],
    json: bool,
) -> None:
    if not (math.isfinite(duration) and duration > 0 and math.isfinite(step) and 0 < step <= duration):
        raise UsageError(Problem("SD302", "--duration and --step must be positive, the step not above the duration"))
    if duration / step > MOST_ROWS:
        raise UsageError(Problem("SD302", f"{duration / step:.3g} rows: choose a longer --step"))
    if smoothing is not None and not (math.isfinite(smoothing) and smoothing > 0):
        raise UsageError(Problem("SD302", "--smoothing must be positive"))
    for option, path in (("--energy", files.energy), ("--sensitivities", files.sensitivities)):
        if smoothing is not None and path is not None:
            raise UsageError(Problem("SD302", f"{option} needs located events: leave --smoothing out"))
    if parameters and files.sensitivities is None:
        raise UsageError(Problem("SD302", "--parameter says which --sensitivities to write: name a file for them"))
    robot = compiler.load_robot(model, chain)
    refuse_free_parameters(robot)
    time = np.arange(round(duration / step) + 1, dtype=np.float64) * step
    with status(json) as progress:
        if smoothing is None:
            kernel, result, extras = _with_events(robot, inputs, start, time, tolerance, files, parameters, progress)
        else:
            kernel, result = _smoothed(robot, inputs, start, time, smoothing, progress)
            extras = _Extras()
    columns, events = result.table(kernel), extras.events
    if json:
        shown = _lists(columns) | {"events": [asdict(e) for e in events]}
        if extras.energy is not None:
            shown["energy"] = _lists(extras.energy.table()) | {"closure": extras.energy.closure}
        if extras.sensitivities is not None:
            shown["sensitivities"] = _lists(extras.sensitivities)
        print_json(shown)
        return
    if files.events is not None:
        rows = {f.name: [getattr(e, f.name) for e in events] for f in fields(Event)}
        write_atomically(files.events, _csv(rows, "%.12g"))
    if files.energy is not None and extras.energy is not None:
        write_atomically(files.energy, _csv(dict(extras.energy.table()), "%.12g"))
        err.print(f"energy accounted for but {extras.energy.closure:.1e} of it: {files.energy}", markup=False)
    if files.sensitivities is not None and extras.sensitivities is not None:
        write_atomically(files.sensitivities, _csv(dict(extras.sensitivities), "%.10g"))
    text = _csv(dict(columns), "%.10g")
    if files.states is None:
        sys.stdout.write(text)
        return
    write_atomically(files.states, text)
    jumps = f"{len(events)} events located" if smoothing is None else f"jumps smoothed over {smoothing:g}"
    err.print(f"{len(time)} rows, {jumps}: {files.states}", markup=False)


def _with_events(
    robot: Robot,
    inputs: list[str],
    start: list[str],
    time: Array,
    tolerance: float,
    files: Files,
    parameters: list[str],
    progress: Callable[[str], None],
) -> tuple[Kernel, Trajectory, _Extras]:
    machine = Machine(compiler.compile_hybrid(robot))
    kernel = machine.kernel
    signals = read_signals(inputs, kernel.inputs, kernel.input_units)
    x = _named(start, kernel.states, "--start")
    progress("simulating (the first time on a machine, what it needs is compiled: a minute or two)")
    found = simulate_events(machine, time, signals, start=x, tolerance=tolerance)
    energy, derivatives = None, None
    if files.energy is not None:
        progress("booking the energy")
        energy = energy_balance(machine, found, signals)
    if files.sensitivities is not None:
        progress("following the sensitivities")
        asked = parameters or [name for name in kernel.parameters if name not in timing(machine)]
        derivatives = simulate_sensitivities(machine, time, signals, start=x, parameters=asked).table(kernel)
    outputs = np.zeros((len(time), 0))
    if kernel.outputs:
        modes = np.zeros((len(time), len(machine.switches)))
        outputs = kernel.rows("output", found.states, found.inputs, modes)
    result = Trajectory(time, found.states, found.inputs, outputs, kernel.states, found.tries)
    return kernel, result, _Extras(found.events, energy, derivatives)


def _smoothed(
    robot: Robot, inputs: list[str], start: list[str], time: Array, smoothing: float, progress: Callable[[str], None]
) -> tuple[Kernel, Trajectory]:
    kernel = compiler.compile_robot(robot, smoothing=smoothing).kernel()
    signals = read_signals(inputs, kernel.inputs, kernel.input_units)
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


def _lists(columns: Mapping[str, Array]) -> dict[str, Any]:
    return {name: values.tolist() for name, values in columns.items()}


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
