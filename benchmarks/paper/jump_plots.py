"""Figures of what friction and clearance do: the step response, and the arm with both drives."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from benchmarks.paper.jumps import CLEARANCE, Jumps, turns
from symdyn.faces.report.linear_plots import COLOURS, WIDTH
from symdyn.faces.report.svg import INK, QUIET, page_style, standalone_svg
from symdyn.numeric.hybrid.trajectory import Event, HybridTrajectory

Array = NDArray[np.float64]

_MILLI = 1e3


def step_response(j: Jumps) -> str:
    """SVG: tachometer voltage of the three models, and the twist of the flexspline; events as marks."""
    states = j.drive.kernel.states
    volts = float(j.drive.kernel.values[j.drive.kernel.parameters.index("K_Et")])
    speed = states.index("axis1.tachometer.qd")
    with page_style():
        figure = Figure(figsize=(WIDTH * 0.8, 5.6), layout="constrained")
        top, bottom = figure.subplots(2, 1, sharex=True, height_ratios=(1.4, 1.0))
        for colour, (name, found) in zip((QUIET, *COLOURS[1:], INK), j.steps.items(), strict=False):
            y = volts * found.states[:, speed]
            top.plot(found.time, y, color=colour, linewidth=1.1, label=name)
            _mark(top, found, y, [e for e in found.events if e.kind == "friction"], colour)
        top.set_ylabel("tachometer voltage, V")
        top.legend(frameon=False, fontsize=8)
        top.set_title("▲ sets off   ■ sticks   ● flank meets   ○ flank leaves")
        full = j.steps["friction and clearance"]
        linear = j.steps["linear part"]
        motor, load = states.index("axis1.harmonic_drive.q"), states.index("axis1.q")
        bottom.axhspan(-_MILLI * CLEARANCE, _MILLI * CLEARANCE, color=QUIET, alpha=0.15, linewidth=0)
        for found, colour in ((linear, QUIET), (full, COLOURS[2])):
            bottom.plot(found.time, _MILLI * (found.states[:, motor] - found.states[:, load]), color=colour)
        twist = _MILLI * (full.states[:, motor] - full.states[:, load])
        _mark(bottom, full, twist, _contacts(full.events), COLOURS[2])
        bottom.set_ylabel("twist at the flexspline, mrad\n(grey: the clearance)")
        bottom.set_xlabel("time, s")
        bottom.margins(x=0.01)
        return standalone_svg(figure)


def two_axes(j: Jumps) -> str:
    """SVG: what the joints do of what they are asked, and the twists of both flexsplines."""
    states, ratio = j.arm.kernel.states, turns(j.arm)
    joints = ("column", "arm")
    with page_style():
        figure = Figure(figsize=(WIDTH * 0.8, 6.4), layout="constrained")
        angle, error, twist = figure.subplots(3, 1, sharex=True)
        found = j.both.found
        bandwidth = _MILLI * CLEARANCE
        twist.axhspan(-bandwidth, bandwidth, color=QUIET, alpha=0.15, linewidth=0)
        for k, (joint, colour) in enumerate(zip(joints, COLOURS, strict=False)):
            q = found.states[:, states.index(f"{joint}.q")]
            angle.plot(found.time, q, color=colour, label=joint)
            asked = "asked" if k == 0 else None
            angle.plot(found.time, j.both.asked[:, k], color=INK, linestyle="--", linewidth=0.8, label=asked)
            error.plot(found.time, _MILLI * (j.both.asked[:, k] - q), color=colour, label=joint)
            spring = _MILLI * (found.states[:, states.index(f"{joint}.harmonic_drive.q")] - ratio * q)
            twist.plot(found.time, spring, color=colour, linewidth=0.9)
            at = [e for e in _contacts(found.events) if e.switch.startswith(f"{joint}.")]
            _mark(twist, found, spring, at, colour, 3.0)
        alone = j.column
        held = alone.asked[:, 1] - alone.found.states[:, states.index("arm.q")]
        error.plot(
            alone.found.time, _MILLI * held, color=COLOURS[2], linestyle=":", label="arm, while the column moves"
        )
        angle.set_ylabel("joint angle, rad")
        error.set_ylabel("asked less done, mrad")
        twist.set_ylabel("twist at the flexsplines,\nmrad (grey: the clearance)")
        twist.set_title("● flank meets   ○ flank leaves")
        twist.set_xlabel("time, s")
        twist.margins(x=0.01)
        for ax in (angle, error):
            ax.legend(frameon=False, fontsize=8)
        return standalone_svg(figure)


def _contacts(events: Sequence[Event]) -> list[Event]:
    """Those at which a flank meets or leaves the other."""
    return [e for e in events if e.kind == "contact" and (abs(e.before) == 1) != (abs(e.after) == 1)]


def _mark(ax: Axes, found: HybridTrajectory, y: Array, events: Sequence[Event], colour: str, size: float = 4.5) -> None:
    for event in events:
        closed = event.kind == "friction" or abs(event.after) == 1
        shape = "o" if event.kind == "contact" else ("s" if event.after == 0 else "^")
        ax.plot(
            [event.time], [np.interp(event.time, found.time, y)], shape, color=colour, markersize=size,
            fillstyle="full" if closed else "none", markeredgewidth=1.0,
        )  # fmt: skip
