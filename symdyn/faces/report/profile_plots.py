"""Figure of profile likelihoods: a curve per parameter, with the threshold that ends its interval."""

from __future__ import annotations

import math
from collections.abc import Sequence

from matplotlib.figure import Figure

from symdyn.faces.report.svg import AFTER, BEFORE, QUIET, page_style, standalone_svg
from symdyn.numeric.profile_likelihood import Profile

COLUMNS = 3
HIGHEST = 3.0  # times the threshold that a plot shows
SIZE = (3.2, 2.4)  # inches of each


def profiles(found: Sequence[Profile]) -> str:
    """SVG: the fall of twice the log-likelihood over each parameter."""
    columns = min(COLUMNS, len(found))
    rows = math.ceil(len(found) / columns)
    with page_style():
        figure = Figure(figsize=(SIZE[0] * columns, SIZE[1] * rows), layout="constrained")
        axes = figure.subplots(rows, columns, squeeze=False).ravel()
        for ax, one in zip(axes, found, strict=False):
            ax.plot(one.values, one.rise, color=AFTER, marker=".", markersize=4)
            ax.axhline(one.threshold, color=BEFORE, linewidth=0.8)
            ax.axvline(one.estimate, color=QUIET, linewidth=0.8)
            for end in (one.lower, one.upper):
                if end is not None:
                    ax.axvline(end, color=BEFORE, linewidth=0.8, linestyle="dashed")
            ax.set_ylim(0.0, HIGHEST * one.threshold)
            ax.set_xlabel(f"{one.parameter} [{one.unit}]", parse_math=False)
        for ax in axes[len(found) :]:
            ax.set_axis_off()
        axes[0].set_ylabel("fall of 2 log L")
        return standalone_svg(figure)
