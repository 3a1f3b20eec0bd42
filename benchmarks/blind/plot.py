"""The confusion matrix as a figure: what was concealed, against what was named."""

from __future__ import annotations

import io
import re
from collections import Counter

import matplotlib
import numpy as np
from matplotlib.figure import Figure

LAST = ("unexplained", "nothing", "no answer")


def confusion_svg(counts: Counter[tuple[str, str]]) -> str:
    """SVG, the same bytes for the same counts; each row is shaded by its share."""
    rows = sorted({true for true, _ in counts}, key=lambda name: (name == "nothing", name))
    columns = sorted(
        {named for _, named in counts}, key=lambda name: (LAST.index(name) + 1 if name in LAST else 0, name)
    )
    table = np.array([[counts.get((true, named), 0) for named in columns] for true in rows], dtype=float)
    share = table / np.maximum(table.sum(axis=1, keepdims=True), 1.0) if rows else table.reshape(0, 0)
    with matplotlib.rc_context({"svg.hashsalt": "blind", "svg.fonttype": "none", "font.size": 7.0}):
        figure = Figure(figsize=(2.2 + 0.27 * len(columns), 2.0 + 0.2 * len(rows)), layout="constrained")
        axes = figure.add_subplot()
        if rows:
            axes.imshow(share, cmap="Blues", vmin=0.0, vmax=1.0, aspect="auto")
        axes.set_xticks(range(len(columns)), columns, rotation=90)
        axes.set_yticks(range(len(rows)), rows)
        axes.set_xlabel("named")
        axes.set_ylabel("concealed")
        for (i, j), count in np.ndenumerate(table):
            if count:
                axes.text(
                    j, i, f"{count:.0f}", ha="center", va="center", color="white" if share[i, j] > 0.6 else "black"
                )
        stream = io.StringIO()
        figure.savefig(stream, format="svg", facecolor="white", metadata={"Date": None, "Creator": None})
    text = re.sub(r"<metadata>.*?</metadata>", "", stream.getvalue(), flags=re.DOTALL)
    return "\n".join(line.rstrip() for line in text.splitlines() if line.strip()) + "\n"
