"""The simulate command: constant inputs, named states, a CSV with units in its header."""

from __future__ import annotations

import io
import math
import sys
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from symdyn import compiler
from symdyn.base.errors import Problem, UsageError
from symdyn.base.files import write_atomically
from symdyn.faces.console import err, print_json, status
from symdyn.faces.model_commands import refuse_free_parameters
from symdyn.numeric.simulate import simulate
from symdyn.spec.urdf_chain import Chain

MOST_ROWS = 10_000_000


def run(
    model: str,
    chain: Chain,
    duration: float,
    step: float,
    inputs: list[str],
    start: list[str],
    smoothing: float,
    path: Path | None,
    json: bool,
) -> None:
    if not (math.isfinite(duration) and duration > 0 and math.isfinite(step) and 0 < step <= duration):
        raise UsageError(Problem("SD302", "--duration and --step must be positive, the step not above the duration"))
    if duration / step > MOST_ROWS:
        raise UsageError(Problem("SD302", f"{duration / step:.3g} rows: choose a longer --step"))
    if not (math.isfinite(smoothing) and smoothing > 0):
        raise UsageError(Problem("SD302", "--smoothing must be positive"))
    robot = compiler.load_robot(model, chain)
    refuse_free_parameters(robot)
    kernel = compiler.compile_robot(robot, smoothing=smoothing).kernel()
    u = _named(inputs, kernel.inputs, "--input")
    x = _named(start, kernel.states, "--start")
    time = np.arange(round(duration / step) + 1, dtype=np.float64) * step
    with status(json) as progress:
        shown = -1

        def tell(t: float) -> None:
            nonlocal shown
            percent = int(100 * t / duration)
            if percent > shown:
                shown = percent
                progress(f"step {t:.3g} s of {duration:.3g} s")

        result = simulate(kernel, time, lambda _: u, start=x, progress=tell)
    columns = result.table(kernel)
    if json:
        print_json({name: values.tolist() for name, values in columns.items()})
        return
    buffer = io.StringIO()
    pd.DataFrame(dict(columns)).to_csv(buffer, index=False, float_format="%.10g", lineterminator="\n")
    if path is None:
        sys.stdout.write(buffer.getvalue())
        return
    write_atomically(path, buffer.getvalue())
    err.print(f"{len(time)} rows, jumps smoothed over {smoothing:g}: {path}", markup=False)


def _named(given: list[str], names: tuple[str, ...], option: str) -> NDArray[np.float64]:
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
