"""Figures of linear models: Bode, Nyquist, poles; one parameter varied; a reduced model beside the full one."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from symdyn.faces.report.svg import AFTER, BEFORE, INK, QUIET, page_style, standalone_svg
from symdyn.numeric.linear.local_sensitivity import LocalSensitivity
from symdyn.numeric.linear.modes import Mode
from symdyn.numeric.linear.one_at_a_time import OneAtATime
from symdyn.numeric.linear.response import Extremum, Response

Array = NDArray[np.float64]

WIDTH = 9.6  # inches
COLOURS = (AFTER, BEFORE, "#2b8a3e", "#8f3fa8", "#0b7d8a", "#a83246", "#6b6b00", "#4a5bd0")
_STYLES: tuple[Literal["solid"] | tuple[float, tuple[float, float]], ...] = (
    "solid",
    (0.0, (5.0, 2.0)),
    (0.0, (1.5, 1.5)),
)


def overview(response: Response, extrema: Sequence[Extremum], modes: Sequence[Mode]) -> str:
    """SVG: Bode plot with its peaks named, Nyquist plot, poles."""
    with page_style():
        figure = Figure(figsize=(WIDTH, 6.4), layout="constrained")
        plots = figure.subplot_mosaic([["size", "nyquist"], ["phase", "poles"]], width_ratios=(1.7, 1.0))
        _magnitude(plots["size"], response.hertz, {"": response.decibel}, response.unit)
        for item in extrema:
            size = 20 * np.log10(item.magnitude)
            above = item.kind == "peak"
            plots["size"].annotate(
                f"{item.frequency:.4g} Hz", (item.frequency, size), (0, 4 if above else -10), color=QUIET,
                textcoords="offset points", ha="center", fontsize=7.5,
            )  # fmt: skip
        plots["size"].margins(y=0.12)
        plots["size"].set_title(f"{response.input} to {response.output}", parse_math=False)
        _phase(plots["phase"], response.hertz, {"": response.phase})
        _nyquist(plots["nyquist"], response)
        _poles(plots["poles"], modes)
        return standalone_svg(figure)


def bode(hertz: Array, responses: dict[str, Response]) -> str:
    """SVG: magnitude and phase of several responses over the same frequencies, named."""
    with page_style():
        figure = Figure(figsize=(WIDTH * 0.8, 5.2), layout="constrained")
        size, phase = figure.subplots(2, 1, sharex=True, height_ratios=(1.6, 1.0))
        first = next(iter(responses.values()))
        _magnitude(size, hertz, {name: r.decibel for name, r in responses.items()}, first.unit)
        _phase(phase, hertz, {name: r.phase for name, r in responses.items()})
        if len(responses) > 1:
            size.legend(frameon=False, fontsize=8)
        size.set_xlabel("")
        return standalone_svg(figure)


def variations(result: OneAtATime, parameters: Sequence[str]) -> str:
    """SVG: a panel per parameter, the magnitude at its nominal value and times each factor (seed fig. 12)."""
    with page_style():
        columns = 1 if len(parameters) == 1 else 2
        rows = -(-len(parameters) // columns)
        figure = Figure(
            figsize=(WIDTH * (0.8 if columns == 1 else 1.0), 3.4 if rows == 1 else 2.2 * rows + 0.4),
            layout="constrained",
        )
        axes = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True).ravel()
        for ax, name in zip(axes, parameters, strict=False):
            curves = {"nominal": result.nominal.decibel}
            curves |= {f"{name} × {v.factor:g}": v.response.decibel for v in result.variations if v.parameter == name}
            _magnitude(ax, result.nominal.hertz, curves, result.nominal.unit)
            ax.legend(frameon=False, fontsize=7.5)
            ax.label_outer()
        for ax in axes[len(parameters) :]:
            ax.set_axis_off()
        return standalone_svg(figure)


def sensitivities(result: LocalSensitivity, most: int = 8) -> str:
    """SVG: d ln|G| / d ln p over frequency, of the parameters that move the magnitude most."""
    with page_style():
        figure = Figure(figsize=(WIDTH * 0.8, 3.8), layout="constrained")
        ax = figure.subplots()
        size = np.sqrt(np.mean(result.magnitude_log**2, axis=1))
        for i, k in enumerate(np.argsort(-size, kind="stable")[:most]):
            ax.semilogx(
                result.response.hertz, result.magnitude_log[k], color=COLOURS[i % len(COLOURS)],
                label=result.parameters[k], linewidth=1.1,
            )  # fmt: skip
        ax.set_xlabel("frequency, Hz")
        ax.set_ylabel("% of magnitude per % of parameter")
        ax.margins(x=0)
        ax.legend(frameon=False, fontsize=8, ncols=2)
        return standalone_svg(figure)


def _magnitude(ax: Axes, hertz: Array, curves: dict[str, Array], unit: str) -> None:
    for i, (name, decibel) in enumerate(curves.items()):
        colour = INK if i == 0 and len(curves) > 1 else COLOURS[(i - (len(curves) > 1)) % len(COLOURS)]
        ax.semilogx(hertz, decibel, color=colour, linestyle=_STYLES[i % len(_STYLES)], linewidth=1.2, label=name)
    ax.set_ylabel("magnitude, dB" if unit == "1" else f"magnitude, dB re 1 {unit}", parse_math=False)
    ax.set_xlabel("frequency, Hz")
    ax.margins(x=0)


def _phase(ax: Axes, hertz: Array, curves: dict[str, Array]) -> None:
    for i, (name, degrees) in enumerate(curves.items()):
        colour = INK if i == 0 and len(curves) > 1 else COLOURS[(i - (len(curves) > 1)) % len(COLOURS)]
        ax.semilogx(hertz, degrees, color=colour, linestyle=_STYLES[i % len(_STYLES)], linewidth=1.2, label=name)
    ax.yaxis.set_major_locator(MaxNLocator(6, steps=[1, 1.5, 3, 4.5, 9, 10]))
    ax.set_ylabel("phase, degrees")
    ax.set_xlabel("frequency, Hz")
    ax.margins(x=0)


def _nyquist(ax: Axes, response: Response) -> None:
    ax.plot(response.values.real, response.values.imag, color=AFTER, linewidth=1.1)
    ax.plot(response.values.real, -response.values.imag, color=AFTER, linewidth=0.8, linestyle=(0, (3, 2)))
    ax.plot([response.values.real[0]], [response.values.imag[0]], "o", color=BEFORE, markersize=3)
    ax.set_aspect("equal", adjustable="datalim")
    ax.set_title("Nyquist (dashed: negative frequencies)")
    ax.set_xlabel("real")
    ax.set_ylabel("imaginary")


def _poles(ax: Axes, modes: Sequence[Mode]) -> None:
    pole = np.array([mode.pole for mode in modes]) / (2 * np.pi)
    both = np.concatenate([pole, pole[pole.imag > 0].conj()])
    ax.axvline(0, color=QUIET, linewidth=0.8)
    ax.plot(both.real, both.imag, "x", color=BEFORE, markersize=5, markeredgewidth=1.3)
    ax.set_xscale("symlog", linthresh=1.0)
    ax.set_yscale("symlog", linthresh=1.0)
    ax.set_title("poles / 2π (scale linear within ±1)")
    ax.set_xlabel("real, Hz")
    ax.set_ylabel("imaginary, Hz")
