"""Figures of responses measured at an amplitude: magnitude and phase beside the linear part, and the distortions."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from symdyn.faces.report.linear_plots import COLOURS, WIDTH
from symdyn.faces.report.svg import INK, page_style, standalone_svg
from symdyn.numeric.hybrid.multisine import Multisine
from symdyn.numeric.hybrid.stepped_sine import SteppedSine
from symdyn.numeric.linear.response import Response

Array = NDArray[np.float64]

_SEEN = 1e-7  # of the fundamental: distortions below it are rounding
_FAINT = 1e-5  # of the largest magnitude: phases below it are not drawn


def measured(found: Mapping[str, SteppedSine | Multisine], linear: Response | None = None, unit: str = "1") -> str:
    """SVG: magnitude, phase and distortion over frequency, of one or more measurements by name.

    Circles are points that were not periodic in the end; ``linear`` is the response of the linear part.
    """
    first = next(iter(found.values()))
    with page_style():
        figure = Figure(figsize=(WIDTH * 0.8, 6.6), layout="constrained")
        size, phase, rest = figure.subplots(3, 1, sharex=True, height_ratios=(1.6, 1.0, 1.0))
        if linear is not None:
            size.semilogx(linear.hertz, linear.decibel, color=INK, linewidth=1.1, label="linear part")
            phase.semilogx(linear.hertz, linear.phase, color=INK, linewidth=1.1)
        largest = max(np.abs(each.values).max() for each in found.values())
        for colour, (name, each) in zip(COLOURS * len(found), found.items(), strict=False):
            steady = each.settled if isinstance(each, SteppedSine) else np.full(len(each.hertz), each.settled.all())
            shown = np.where(np.abs(each.values) > _FAINT * largest, each.values, np.nan)
            size.semilogx(
                each.hertz, _decibel(np.abs(shown)), ".-", color=colour, linewidth=0.9, markersize=4, label=name
            )
            size.semilogx(
                each.hertz[~steady], _decibel(np.abs(shown[~steady])), "o", color=colour, markersize=6, fillstyle="none"
            )
            degrees = np.full(len(each.hertz), np.nan)
            here = np.isfinite(np.abs(shown))
            degrees[here] = np.degrees(np.unwrap(np.angle(shown[here])))
            phase.semilogx(each.hertz, degrees, ".-", color=colour, linewidth=0.9, markersize=4)
            _distortions(rest, each, colour)
        size.set_ylabel("magnitude, dB" if unit == "1" else f"magnitude, dB re 1 {unit}", parse_math=False)
        size.set_title(f"{first.input} to {first.output}", parse_math=False)
        size.legend(frameon=False, fontsize=8)
        phase.yaxis.set_major_locator(MaxNLocator(6, steps=[1, 1.5, 3, 4.5, 9, 10]))
        phase.set_ylabel("phase, degrees")
        rest.set_xlabel("frequency, Hz")
        rest.margins(x=0)
        if rest.get_lines():
            rest.set_yscale("log")
        return standalone_svg(figure)


def _distortions(ax: Axes, found: SteppedSine | Multisine, colour: str) -> None:
    """Odd as a solid line, even as a dotted one; what is rounding is left out."""
    if isinstance(found, SteppedSine):
        ax.set_ylabel("odd (—) and even (···)\nharmonics, %")
        for part, style in ((found.odd, "-"), (found.even, ":")):
            _line(ax, found.hertz, 100 * part, 100 * _SEEN, style, colour)
        return
    ax.set_ylabel("output (—), odd (--) and\neven (···) distortion")
    floor, grid = _SEEN * float(found.level.max(initial=0.0)), found.grid
    _line(ax, found.hertz, found.level, floor, "-", colour)
    _line(ax, np.asarray(grid.lowest * grid.detection, np.float64), found.odd, floor, "--", colour)
    _line(ax, np.asarray(grid.lowest * grid.even, np.float64), found.even, floor, ":", colour)


def _line(ax: Axes, hertz: Array, value: Array, floor: float, style: str, colour: str) -> None:
    if np.any(value > floor):
        ax.semilogx(hertz, np.where(value > floor, value, np.nan), style, color=colour, linewidth=1.0)


def _decibel(size: Array) -> Array:
    with np.errstate(divide="ignore"):
        return np.asarray(20 * np.log10(size), np.float64)
