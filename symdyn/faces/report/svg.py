"""Matplotlib figures as inline SVG in the colours and fonts of the page, the same bytes every time."""

from __future__ import annotations

import io
import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import matplotlib
import matplotlib.style
from markupsafe import Markup
from matplotlib.figure import Figure

# Each colour of a figure stands for a variable of the page's style sheet, which knows light and dark.
INK, QUIET, RULE, BEFORE, AFTER = "#1d2329", "#5b6570", "#d9dee3", "#c4570e", "#1766c2"
VARIABLES = {INK: "--ink", QUIET: "--quiet", RULE: "--rule", BEFORE: "--before", AFTER: "--after"}

STYLE: dict[Any, object] = {
    "font.family": "DejaVu Sans",  # comes with matplotlib: the same widths on every machine
    "font.size": 8.5,
    "axes.labelsize": 8.5,
    "axes.titlesize": 9.0,
    "axes.titlelocation": "left",
    "axes.labelcolor": QUIET,
    "axes.titlecolor": INK,
    "axes.edgecolor": RULE,
    "axes.linewidth": 0.8,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "grid.color": RULE,
    "grid.linewidth": 0.5,
    "xtick.color": RULE,
    "ytick.color": RULE,
    "xtick.labelcolor": QUIET,
    "ytick.labelcolor": QUIET,
    "xtick.labelsize": 8.0,
    "ytick.labelsize": 8.0,
    "text.color": INK,
    "lines.linewidth": 1.2,
    "path.simplify": False,  # it drops the zero-length strokes that stand for points
}


@contextmanager
def page_style() -> Iterator[None]:
    """Figures made and saved inside do not depend on the settings of the user."""
    with (
        matplotlib.style.context("default"),
        matplotlib.rc_context({**STYLE, "svg.hashsalt": "symdyn", "svg.fonttype": "none"}),
    ):
        yield


def standalone_svg(figure: Figure) -> str:
    """The figure as the text of an SVG file, on white; the same bytes every time."""
    stream = io.StringIO()
    figure.savefig(stream, format="svg", facecolor="white", metadata={"Date": None, "Creator": None})
    text = re.sub(r"<metadata>.*?</metadata>|<!--.*?-->", "", stream.getvalue(), flags=re.DOTALL)
    text = re.sub(r'\bd="[^"]*"', lambda path: _shortened(path[0]), text)
    return "\n".join(line.rstrip() for line in text.split("\n") if line.strip()) + "\n"


def inline_svg(figure: Figure, name: str, description: str) -> Markup:
    """The figure as an ``<svg>`` element; ``name`` keeps its ids apart from those of other figures."""
    stream = io.StringIO()
    figure.savefig(stream, format="svg", transparent=True, metadata={"Date": None, "Creator": None})
    text = stream.getvalue()
    text = text[text.index("<svg") :]
    text = re.sub(r"<metadata>.*?</metadata>", "", text, flags=re.DOTALL)
    text = re.sub(r"<!--.*?-->", "", text, flags=re.DOTALL)
    text = re.sub(r'\bid="', f'id="{name}-', text)
    text = re.sub(r'\b(?:xlink:)?href="#', f'href="#{name}-', text).replace("url(#", f"url(#{name}-")
    text = re.sub(r"font: ([\d.]+)px [^;\"]*", r"font-size: \1px", text)  # the page's own font
    for colour, variable in VARIABLES.items():
        text = text.replace(colour, f"var({variable})")
    text = re.sub(r'\bd="[^"]*"', lambda path: _shortened(path[0]), text)
    view = re.search(r'viewBox="[^"]*"', text)
    assert view is not None
    body = text[text.index(">") + 1 :]
    head = Markup('<svg xmlns="http://www.w3.org/2000/svg" {} role="img" aria-label="{}">')
    return head.format(Markup(view[0]), description) + Markup(re.sub(r"\n\s*", "\n", body).strip())


def _shortened(path: str) -> str:
    """Coordinates to a hundredth of a point; a point's stroke of no length as ``h0``."""
    path = re.sub(r"-?\d+\.\d+", lambda number: f"{float(number[0]):.2f}".rstrip("0").rstrip("."), path)
    path = re.sub(r"M (\S+) (\S+)\s+L \1 \2(?=\s|\")", r"M\1 \2h0", path)
    return re.sub(r"\s*\n\s*", " ", path)
