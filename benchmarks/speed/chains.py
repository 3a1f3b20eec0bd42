"""Operations of inverse dynamics against the number of joints: random arms of 2 to 12 joints; and their plot."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import matplotlib
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

from benchmarks.speed.arms import generic
from benchmarks.speed.costs import inverse_dynamics_cost
from symdyn.program.cost import Cost

JOINTS = range(2, 13)


def chain_costs() -> dict[int, Cost]:
    return {n: inverse_dynamics_cost(generic(n)) for n in JOINTS}


def plot(chains: Mapping[int, Cost], arms: Mapping[str, tuple[int, Cost]], path: Path) -> None:
    """An SVG, the same bytes for the same numbers."""
    with matplotlib.rc_context({"svg.hashsalt": "symdyn", "svg.fonttype": "none"}):
        figure = Figure(figsize=(6.4, 3.8), layout="constrained")
        axes = figure.add_subplot()
        joints = list(chains)
        axes.plot(joints, [c.multiplications for c in chains.values()], "o-", label="multiplications, generic arm")
        axes.plot(joints, [c.additions for c in chains.values()], "s-", label="additions, generic arm")
        for name, (n, cost) in arms.items():
            axes.plot([n, n], [cost.multiplications, cost.additions], "k_")
            axes.annotate(name, (n, cost.multiplications), (4, 2), textcoords="offset points", fontsize=8)
        axes.set(xlabel="joints", ylabel="operations of inverse dynamics", ylim=(0, None), xticks=joints)
        axes.legend(frameon=False)
        axes.spines[["top", "right"]].set_visible(False)
        FigureCanvasSVG(figure).print_svg(path, metadata={"Date": None})  # type: ignore[no-untyped-call]  # Matplotlib's
