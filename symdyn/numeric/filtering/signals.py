"""Which signals of a model a recording holds: its inputs, and states and outputs that were measured."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from symdyn.base.errors import InputError, Problem
from symdyn.emit.kernel import Kernel
from symdyn.numeric.circuits import driven_by_current
from symdyn.numeric.filtering.gears import per_joint, usual_speeds
from symdyn.numeric.gearing import coordinate_shown, effort_shown, joint_name, joint_of, motor_rotor
from symdyn.numeric.known import Known, known_in
from symdyn.numeric.recording import ChannelKey, Recording
from symdyn.numeric.servo_loops import as_driven
from symdyn.spec.records import EffectSpec, Quantity, Robot

Array = NDArray[np.float64]

EVEN = 1e-3  # of a step: less is how time was written, not when a sample was taken

_STATE = {Quantity.POSITION: "q", Quantity.VELOCITY: "qd", Quantity.CURRENT: "current"}
_INPUT_UNIT = {Quantity.VOLTAGE: "V", Quantity.CURRENT: "A"}


@dataclass(frozen=True, slots=True, eq=False)
class Signals:
    """Inputs ``u`` (N, nu) and measurements ``y`` (N, m), in the units and order of a kernel.

    ``index`` (m,) counts states first, then outputs. ``steps`` (N,) are the times to the next sample, nan
    where a gap follows; ``names`` are those of the kernel. ``per_joint`` and ``speeds`` (n,): how far each
    coordinate goes with its joint where nothing twists, and how fast it usually is. ``twists`` (t, m): differences of
    measurements that free runs are judged by, too.
    """

    time: Array
    u: Array
    y: Array
    index: NDArray[np.int64]
    names: tuple[str, ...]
    steps: Array
    floor: Array  # (m,) variance of rounding to the channel's own steps
    per_joint: Array
    speeds: Array
    twists: Array | None = None
    known: Known | None = None  # parameters that the recording tells

    def sets(self, p: Array, index: Mapping[str, int]) -> tuple[Array, NDArray[np.int64]]:
        """(S, np) values of all parameters: ``p`` (np,), but for those that are known; and (N,) which of them hold."""
        if self.known is None:
            return p[None, :], np.zeros(len(self.y), dtype=np.int64)
        return self.known.sets(p, [index[name] for name in self.known.names])

    @property
    def judged(self) -> tuple[str, ...]:
        """Of all that free runs are judged by."""
        rows = () if self.twists is None else self.twists
        return (*self.names, *(f"{self.names[np.argmax(row)]} - {self.names[np.argmin(row)]}" for row in rows))

    def with_differences(self, y: Array) -> Array:
        """(N, m + t) measurements (N, m), and the twists between them."""
        return y if self.twists is None else np.hstack([y, y @ self.twists.T])


def seen_by(robot: Robot, recordings: Sequence[Recording]) -> Robot:
    """The robot with an ammeter wherever a current was measured that is no state of its circuit.

    Where no voltage was recorded, the current is what drives it; servo loops are those that references drive.
    """
    robot = driven_by_current(as_driven(robot, recordings), recordings)
    keys = {key for recording in recordings for key in recording.channels}
    present = {(e.type, e.at) for e in robot.effects}
    added = []
    for joint in robot.joints:
        motor = joint.drive.motor if joint.drive else None
        if motor is None or not any(q is Quantity.CURRENT and joint_name(at) == joint.name for q, at, _ in keys):
            continue
        place = f"{joint.name}.{motor.name}"
        if not motor.inductance.coefficient and ("ammeter", place) not in present:
            added.append(EffectSpec("ammeter", place, ()))
    return replace(robot, effects=(*robot.effects, *added)) if added else robot


def signals(robot: Robot, kernel: Kernel, recording: Recording) -> Signals:
    """Raises InputError (SD520) for an input that was not recorded, SD521 where nothing else was measured."""
    count = len(recording.time)
    u, given = np.zeros((count, len(kernel.inputs))), set[str]()
    columns: list[tuple[str, int, Array]] = []
    for key, values in recording.channels.items():
        if key[0] is Quantity.PARAMETER:
            continue
        name, scale = _name(robot, kernel, key)
        shown = key[0] is Quantity.VOLTAGE and "." in key[1] and name in kernel.outputs  # of a sensor on that part
        if name in kernel.inputs and not shown:
            u[:, kernel.inputs.index(name)] = values * scale
            given.add(name)
        elif name in kernel.states:
            columns.append((name, kernel.states.index(name), values * scale))
        elif name in kernel.outputs:
            columns.append((name, len(kernel.states) + kernel.outputs.index(name), values * scale))
    missing = [name for name in kernel.inputs if name not in given]
    where = robot.channels.where if robot.channels else None
    if missing:
        message = f"recording '{recording.name}' does not hold {', '.join(missing)}"
        hint = "map a column to it under [[recording.channel]]"
        if any(name.endswith(".voltage") for name in missing):
            hint += ", or the reference that its servo loop follows"
        raise InputError(Problem("SD520", message, where, hint))
    if not columns:
        message = f"recording '{recording.name}' measures nothing that the model answers with"
        raise InputError(Problem("SD521", message, where, "map a position, speed, current or sensor voltage"))
    steps = np.append(np.diff(recording.time), np.nan)
    even = np.abs(steps - recording.sample_time) < EVEN * recording.sample_time
    steps[even] = recording.sample_time  # of an even clock exactly even: the filter then repeats itself
    for part in recording.segments:
        steps[part.stop - 1] = np.nan
    y = np.column_stack([values for _, _, values in columns])
    return Signals(
        recording.time, u, y, np.array([i for _, i, _ in columns]), tuple(n for n, _, _ in columns), steps,
        np.array([_rounding(column) for column in y.T]),
        per_joint(robot, kernel.coordinates), usual_speeds(robot, recording, kernel.coordinates),
        known=known_in(kernel, recording),
    )  # fmt: skip


def stretch(signals: Signals, count: int) -> Signals:
    """The ``count`` samples in a row in which the channels move most; all, if there are not twice as many."""
    if len(signals.y) < 2 * count:
        return signals
    way = np.abs(np.diff(signals.y, axis=0, prepend=signals.y[:1]))
    size = np.nanstd(signals.y, axis=0)
    moved = np.nansum(way / np.where(size > 0, size, 1.0), axis=1)
    within = np.convolve(moved, np.ones(count), mode="valid")
    first = int(np.argmax(within))
    part = slice(first, first + count)
    steps = signals.steps[part].copy()
    steps[-1] = np.nan
    known = None if signals.known is None else replace(signals.known, values=signals.known.values[part])
    return replace(signals, time=signals.time[part], u=signals.u[part], y=signals.y[part], steps=steps, known=known)


def opening(signals: Signals, position: Array, span: float) -> tuple[float, float]:
    """Speed and acceleration as a position (N,) begins, by a parabola over ``span`` s; 0 where it begins with a gap."""
    parted = np.flatnonzero(np.isnan(signals.steps[:-1]))
    last = int(parted[0]) if len(parted) else len(position) - 1
    count = min(last, max(2, int(span / float(np.nanmedian(signals.steps)))))
    if count < 2:
        return 0.0, 0.0
    here = slice(0, count + 1)
    bent = np.polynomial.polynomial.polyfit(signals.time[here] - signals.time[0], position[here], 2)
    return float(bent[1]), 2.0 * float(bent[2])


def _name(robot: Robot, kernel: Kernel, key: ChannelKey) -> tuple[str | None, float]:
    """The kernel's signal that a channel shows, and the factor from the channel to it."""
    quantity, address, _ = key
    joint = joint_of(robot, address)
    scale = 1.0
    if quantity in (Quantity.POSITION, Quantity.VELOCITY):
        address, scale = coordinate_shown(robot, key)
    if quantity is Quantity.EFFORT:
        address, scale = effort_shown(robot, key)
        candidates = [f"{address}.effort", f"{address}.input"]
    elif quantity is Quantity.REFERENCE:
        candidates = [n for n in kernel.inputs if n.endswith(".reference") and joint_name(n) == joint.name]
    elif quantity in _INPUT_UNIT:
        motor = motor_rotor(joint)
        circuit = f"{joint.name}.{joint.drive.motor.name}" if joint.drive and joint.drive.motor else None
        places = [address, *(p for p in (motor, circuit) if p and address in (joint.name, motor, circuit))]
        candidates = [f"{p}.ammeter" for p in places if quantity is Quantity.CURRENT]
        candidates += [f"{p}.{quantity.value}" for p in places]
        inputs = dict(zip(kernel.inputs, kernel.input_units, strict=True))
        if inputs.get(f"{joint.name}.input") == _INPUT_UNIT[quantity]:
            candidates.append(f"{joint.name}.input")
    else:
        candidates = [f"{address}.{_STATE[quantity]}"]
    known = (*kernel.inputs, *kernel.states, *kernel.outputs)
    return next((name for name in candidates if name in known), None), scale


def _rounding(values: Array) -> float:
    """Variance of rounding: a twelfth of the square of the smallest step between different values."""
    distinct = np.unique(values[np.isfinite(values)])
    if len(distinct) < 2:
        return 0.0
    steps = np.diff(distinct)
    smallest = float(np.min(steps[steps > 1e-9 * np.ptp(distinct)], initial=np.inf))
    # A true quantum divides every step; of unrounded values the smallest distance means nothing.
    whole = steps / smallest
    return smallest**2 / 12.0 if np.all(np.abs(whole - np.round(whole)) < 0.05) else 0.0
