"""The report's plots: effort over time, residual over speed and position, its spectrum; before and after."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np
from markupsafe import Markup
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter
from numpy.typing import NDArray

from symdyn.faces.report.series import amplitude_density, binned_mean, longest_run, thinned, worst_window
from symdyn.faces.report.svg import AFTER, BEFORE, INK, QUIET, inline_svg, page_style
from symdyn.numeric.findings import Diagnosis, MissingForce, Traces
from symdyn.spec.records import JointKind, Robot

Array = NDArray[np.float64]

WIDTH = 9.6  # inches; the page scales it
ROW = 1.75
WINDOW = 300  # samples of the time plot; a band's edge has about four per period
FEWEST = 32  # samples below which a plot would tell nothing
POINTS = 12000  # in all scatter plots together: what keeps the file small
SAMPLES_PER_BIN = 12
BINS = 40  # at most

KEY = Markup('<span class="key before">model as given, refitted</span> <span class="key after">diagnosed model</span>')
MEASURED = Markup('<span class="key measured">measured</span> ') + KEY
MEAN = Markup(' <span class="key">mean</span>')


def plots(diagnosis: Diagnosis) -> Markup:
    """All figures with their captions, or a sentence where there are too few samples."""
    traces = diagnosis.traces
    run = longest_run(traces.time) if len(traces.time) > 1 else slice(0, 0)
    if run.stop - run.start < FEWEST:
        return Markup("<p>The held-out recording is too short for plots.</p>")
    units = position_units(diagnosis.robot, traces.joints)
    with page_style():
        return Markup("\n").join(
            [
                _over_time(traces),
                _residual_over_time(traces),
                _missing(traces.missing),
                _scatter(traces, "speed", traces.qd, [f"{unit}/s" for unit in units]),
                _scatter(traces, "position", traces.q, units),
                _spectrum(traces, diagnosis.band),
            ]
        )


def _over_time(traces: Traces) -> Markup:
    before, _ = _residuals(traces)
    window = worst_window(traces.time, before / _size(traces.effort), WINDOW)
    time = traces.time[window]
    figure, axes = _grid(len(traces.joints), 1)
    for j, (ax,) in enumerate(axes):
        ax.plot(time, traces.effort[window, j], color=INK, linewidth=2.4, alpha=0.45)
        ax.plot(time, traces.before[window, j], color=BEFORE, linewidth=1.1, dashes=(4, 2))
        ax.plot(time, traces.after[window, j], color=AFTER, linewidth=1.1)
        ax.set_title(traces.joints[j], parse_math=False)
        ax.set_ylabel(f"measured, {_unit(traces.effort_units[j])}", parse_math=False)
        ax.margins(x=0)
    axes[-1][0].set_xlabel("time, s", parse_math=False)
    caption = f"The {time[-1] - time[0]:.3g} s of the held-out recording in which the model as given was furthest off."
    return _figure(figure, "time", "Measured and predicted", caption, MEASURED)


def _residual_over_time(traces: Traces) -> Markup:
    both = _residuals(traces)
    window = worst_window(traces.time, both[0] / _size(traces.effort), WINDOW)
    time = traces.time[window]
    figure, axes = _grid(len(traces.joints), 1)
    for j, (ax,) in enumerate(axes):
        ax.plot(time, both[0][window, j], color=BEFORE, linewidth=1.1, dashes=(4, 2))
        ax.plot(time, both[1][window, j], color=AFTER, linewidth=1.1)
        ax.set_title(traces.joints[j], parse_math=False)
        ax.set_ylabel(f"residual, {_unit(traces.effort_units[j])}", parse_math=False)
        ax.margins(x=0)
    axes[-1][0].set_xlabel("time, s", parse_math=False)
    caption = "Measured less predicted, over the same time."
    return _figure(figure, "residual", "Residual over time", caption, KEY)


def _missing(forces: Sequence[MissingForce]) -> Markup:
    """Over its displacement and its speed, at every place; nothing where no filter told it."""
    if not forces:
        return Markup("")
    figure, axes = _grid(len(forces), 2, sharey="row")
    for force, row in zip(forces, axes, strict=True):
        shown = thinned(len(force.x), max(100, POINTS // (4 * len(forces))))
        bins = min(BINS, max(1, len(force.x) // SAMPLES_PER_BIN))
        unit = force.units[0]
        over = ((force.x, force.what, unit), (force.v, "speed", f"{unit}/s"))
        for ax, (x, what, of) in zip(row, over, strict=True):
            for values, colour in ((force.before, BEFORE), (force.after, AFTER)):
                _points(ax, x[shown], values[shown], colour)
                ax.plot(*binned_mean(x, values, bins), color=colour, linewidth=1.8)
            ax.set_title(force.place, parse_math=False)
            ax.set_xlabel(f"{what}, {_unit(of)}", parse_math=False)
        row[0].set_ylabel(f"missing force, {_unit(force.units[1])}", parse_math=False)
    caption = (
        "What resists there beyond the model as given, and beyond the diagnosed one, as a filter estimates it that was "
        "told no law of it; means as lines."
    )
    return _figure(figure, "missing", "Missing force", caption, KEY)


def _scatter(traces: Traces, what: str, x: Array, units: Sequence[str]) -> Markup:
    joints = len(traces.joints)
    shown = thinned(len(x), max(100, POINTS // (4 * joints)))
    figure, axes = _grid(joints, 2, sharey="row")
    both = _residuals(traces)
    bins = min(BINS, max(1, len(x) // SAMPLES_PER_BIN))
    for j, row in enumerate(axes):
        largest = max(float(np.abs(residual[:, j]).max()) for residual in both) or 1.0
        for ax, residual, colour, title in zip(row, both, (BEFORE, AFTER), ("before", "after"), strict=True):
            _points(ax, x[shown, j], residual[shown, j], colour)
            ax.plot(*binned_mean(x[:, j], residual[:, j], bins), color=INK, linewidth=1.3)
            ax.set_ylim(-1.08 * largest, 1.08 * largest)
            ax.set_title(f"{traces.joints[j]}, {title}", parse_math=False)
            ax.set_xlabel(f"{what}, {_unit(units[j])}", parse_math=False)
        row[0].set_ylabel(f"residual, {_unit(traces.effort_units[j])}", parse_math=False)
    caption = f"Measured less predicted. A mean that bends away from zero is structure in the {what}."
    return _figure(figure, what, f"Residual over {what}", caption, KEY + MEAN)


def _spectrum(traces: Traces, band: float) -> Markup:
    joints, columns = len(traces.joints), min(2, len(traces.joints))
    figure, axes = _grid(-(-joints // columns), columns)
    before, after = (amplitude_density(traces.time, residual) for residual in _residuals(traces))
    panels = [ax for row in axes for ax in row]
    for j, ax in enumerate(panels[:joints]):
        peak = max(float(before[1][:, j].max()), float(after[1][:, j].max()))
        for (frequency, density), colour, dashes in ((before, BEFORE, (4, 2)), (after, AFTER, (None, None))):
            inside = frequency <= band if np.count_nonzero(frequency <= band) > 1 else slice(None)
            ax.plot(frequency[inside], np.maximum(density[inside, j], 1e-6 * peak), color=colour, dashes=dashes)
        if traces.noise is not None and traces.noise[j] > 0.0:
            ax.axhline(traces.noise[j], color=QUIET, linewidth=1.2, dashes=(1, 2))
        if peak > 0:
            ax.set_yscale("log")
            low, high = ax.get_ylim()
            if high > 20.0 * low:  # powers of ten are labels enough
                ax.yaxis.set_minor_formatter(NullFormatter())
        ax.set_title(traces.joints[j], parse_math=False)
        ax.set_xlabel("frequency, Hz", parse_math=False)
        ax.set_ylabel(f"residual, {_unit(traces.effort_units[j])}/√Hz", parse_math=False)
        ax.margins(x=0)
    for ax in panels[joints:]:
        ax.set_axis_off()
    caption = "Amplitude density of the residual in the analysis band (Welch)."
    key = KEY
    if traces.noise is not None:
        caption += " Noise: the level that the effort's sensors show at higher frequencies, where nothing moves."
        key += Markup(' <span class="key noise">noise of the sensors</span>')
    return _figure(figure, "spectrum", "Spectrum of the residual", caption, key)


def _grid(rows: int, columns: int, sharey: Literal["none", "row"] = "none") -> tuple[Figure, Sequence[Sequence[Axes]]]:
    figure = Figure(figsize=(WIDTH, ROW * rows + 0.35), layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False, sharey=sharey)
    return figure, [list(row) for row in axes]


def _points(ax: Axes, x: Array, y: Array, colour: str) -> None:
    """Strokes of no length with round ends: a third of the bytes of markers."""
    gap = np.full_like(x, np.nan)
    ax.plot(
        np.stack([x, x, gap], axis=1).ravel(),
        np.stack([y, y, gap], axis=1).ravel(),
        color=colour,
        linewidth=1.9,
        alpha=0.4,
        solid_capstyle="round",
    )


def _figure(figure: Figure, name: str, title: str, caption: str, key: Markup) -> Markup:
    drawn = inline_svg(figure, f"plot-{name}", f"{title}. {caption}")
    return Markup(
        "<figure>\n<h3>{}</h3>\n"
        '<p class="keys">{}</p>\n'
        '<div class="wide">{}</div>\n'
        "<figcaption>{}</figcaption>\n</figure>"
    ).format(title, key, drawn, caption)


def _residuals(traces: Traces) -> tuple[Array, Array]:
    return traces.effort - traces.before, traces.effort - traces.after


def _size(values: Array) -> Array:
    """(n,) root mean square, 1 for a channel that is all zero."""
    size = np.sqrt(np.mean(values**2, axis=0))
    return np.where(size > 0, size, 1.0)


def position_units(robot: Robot, joints: Sequence[str]) -> list[str]:
    """Of joints, or of their channels where a filter followed them."""
    sliding = {joint.name for joint in robot.joints if joint.kind is JointKind.PRISMATIC}
    return ["m" if {joint, joint.rpartition(".")[0]} & sliding else "rad" for joint in joints]


def _unit(unit: str) -> str:
    return unit.replace("^2", "²").replace("^3", "³")
