"""From a recording to what inverse dynamics needs: joint motion with derivatives, and measured effort."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from symdyn.base.errors import InputError, Problem
from symdyn.emit.kernel import Kernel
from symdyn.numeric.circuits import effort_by_current, input_of
from symdyn.numeric.known import Known, known_in
from symdyn.numeric.mechanics import at_joints
from symdyn.numeric.memory import driven_states
from symdyn.numeric.position_spectrum import WHOLE, floor, motion_cutoff
from symdyn.numeric.reading import declared
from symdyn.numeric.recording import Recording
from symdyn.numeric.steady_clock import steady
from symdyn.spec.records import Joint, Quantity, Robot, Side

Array = NDArray[np.float64]

BESIDE = 2  # samples on either side that a derivative is taken from
FILTER_ORDER = 4  # Butterworth, run forwards and backwards: no phase, order doubled
KEPT = 0.5  # of a filter's edge: it takes 0.4 % of an amplitude there


@dataclass(frozen=True, slots=True, eq=False)
class Observation:
    """Joint motion q, qd, qdd and measured effort tau, each (N, n), in stretches without gaps."""

    time: Array
    q: Array
    qd: Array
    qdd: Array
    tau: Array
    segments: tuple[slice, ...]
    sample_time: float
    cutoff: float  # Hz: positions were low-passed there before they were differentiated
    measured: Array  # (N, n) positions before that
    noise: Array  # (n,) power density per hertz of what these are off by
    below: tuple[float, ...] | None = None  # Hz, of each joint: where its own were, if that is lower
    quick: Array | None = None  # (N, n) speeds as they were before that; None: nothing was lower
    factor: Array | None = None  # (n,) tau per effort as it was shown; None: ones
    passed_on: Array | None = None  # (N, n) effort that goes on to what lies beyond a torque sensor; None: nothing does
    known: Known | None = None  # parameters whose values the recording tells
    imposed: NDArray[np.bool_] | None = None  # (n,) joints moved by efforts that nobody measured; None: there is none
    sparing: bool = False  # a joint that often stands for a moment is judged by what is far from that (``rest``)

    @property
    def rate(self) -> float:
        return 1.0 / self.sample_time

    @property
    def motions(self) -> Array:
        """(n,) Hz: below which each joint's motion is known."""
        whole = np.full(self.q.shape[1], self.cutoff)
        return whole if self.below is None else np.minimum(whole, np.array(self.below))

    @property
    def tested(self) -> NDArray[np.bool_]:
        """(n,) joints of which the equation says something: all that acts there is known."""
        return np.ones(self.tau.shape[1], dtype=bool) if self.imposed is None else ~self.imposed

    @property
    def shown(self) -> Array:
        """(n,) what a sensor shows of a unit of effort. Its noise is as it is, whatever that is."""
        return np.ones(self.tau.shape[1]) if self.factor is None else 1.0 / self.factor


def observe(robot: Robot, kernel: Kernel, recording: Recording, cutoff: float | None = None) -> Observation:
    """Positions are low-passed without phase and differentiated; efforts are taken as measured.

    Samples of a clock that trembles are brought to even steps before (``steady``).
    ``cutoff`` in Hz; None takes the highest frequency at which a position still stands above its
    noise floor. Effort is measured directly, or follows from the actuator's input through the kernel; a joint of
    which neither was recorded is moved by something unknown: its motion is ``imposed``, its own equation says nothing.

    Raises InputError (SD520, SD521) when a joint's position, or the effort of all that are driven, was not measured, or
    the robot has coordinates or states that inverse dynamics would need and nobody measures.
    """
    _refuse_memory(robot, kernel)
    recording = steady(at_joints(robot, recording))
    positions = np.column_stack([recording.channel(Quantity.POSITION, joint.name) for joint in robot.joints])
    rate = 1.0 / recording.sample_time
    limit = cutoff if cutoff is not None else motion_cutoff(positions, recording.segments, rate)
    q, qd, qdd = (np.zeros_like(positions) for _ in range(3))
    for part in recording.segments:
        smooth = low_pass(positions[part], rate, limit)
        time = recording.time[part]
        q[part] = smooth
        qd[part] = derivative(smooth, time)
        qdd[part] = derivative(qd[part], time)
    return Observation(
        recording.time,
        q,
        qd,
        qdd,
        measured_effort(robot, kernel, recording),
        recording.segments,
        recording.sample_time,
        limit,
        positions,
        floor(positions, recording.segments, rate),
        passed_on=_passed_on(robot, recording),
        known=known_in(kernel, recording),
        imposed=_imposed(robot, recording),
    )


def _passed_on(robot: Robot, recording: Recording) -> Array | None:
    outputs = [(Quantity.EFFORT, joint.name, Side.OUTPUT) for joint in robot.joints]
    if not any(key in recording.channels for key in outputs):
        return None
    nothing = np.zeros(len(recording.time))
    return np.column_stack([recording.channels.get(key, nothing) for key in outputs])


def imposed_joints(robot: Robot, recording: Recording) -> tuple[str, ...]:
    """Joints that are driven by an effort of which the recording (``at_joints``) holds nothing."""
    driven = (joint for joint in robot.joints if not joint.passive)
    return tuple(
        joint.name for joint in driven if _effort(robot, joint, recording) is None and _input(joint, recording) is None
    )


def untested_equations(observation: Observation, joints: Sequence[str]) -> list[str]:
    """What is to be said of joints of which the motion is imposed."""
    names = (joint for joint, tested in zip(joints, observation.tested, strict=True) if not tested)
    return [
        f"nothing was recorded of what moves {name}: its motion is imposed, its equation not tested" for name in names
    ]


def _effort(robot: Robot, joint: Joint, recording: Recording) -> Array | None:
    """(N,) effort that was measured, or that the motor's current gives; None where neither was recorded."""
    if recording.has(Quantity.EFFORT, joint.name):
        return recording.channel(Quantity.EFFORT, joint.name)
    return effort_by_current(robot, joint, recording)


def _input(joint: Joint, recording: Recording) -> Array | None:
    """(N,) what its actuator was given; None where that was not recorded."""
    wanted = input_of(joint)
    return recording.channel(wanted, joint.name) if wanted is not None and recording.has(wanted, joint.name) else None


def _imposed(robot: Robot, recording: Recording) -> NDArray[np.bool_] | None:
    """Raises InputError (SD520) where no equation is left."""
    names = imposed_joints(robot, recording)
    if not names:
        return None
    if len(names) < len(robot.joints):
        return np.array([joint.name in names for joint in robot.joints])
    wanted = input_of(robot.joints[0])
    what = f"effort (or {wanted})" if wanted else "effort"
    message = f"recording '{recording.name}' holds no {what} of joint '{names[0]}'"
    hint = "map a column to it under [[recording.channel]], or say `passive = true` if nothing drives the joint"
    raise InputError(Problem("SD520", message, robot.channels.where if robot.channels else None, hint))


def measured_effort(robot: Robot, kernel: Kernel, recording: Recording) -> Array:
    """(N, n) effort at the joints: measured, or by its motor's current, or the actuator's input times its gain.

    None where nothing was recorded of what drives a joint. An ``effort_gain`` is not in it: that is how a recording is
    read (``reading``), whichever way it was made.
    """
    n, count = len(robot.joints), len(recording.time)
    driven = [joint.name for joint in robot.joints if not joint.passive]
    inputs = np.zeros((count, len(driven)))
    direct = np.zeros((count, n))
    for i, joint in enumerate(robot.joints):
        if joint.passive:
            continue
        effort, given = _effort(robot, joint, recording), _input(joint, recording)
        if effort is not None:
            direct[:, i] = effort
        elif given is not None:
            inputs[:, driven.index(joint.name)], direct[:, i] = given, np.nan
    states = np.zeros((count, len(kernel.states)))
    gains = np.array([reading.effort_gain for reading in declared(robot)])
    actuated = kernel.rows("actuation_p", states, inputs, kernel.values) / gains
    return np.where(np.isnan(direct), actuated, direct)


def derivative(values: Array, time: Array, beside: int = BESIDE) -> Array:
    """By time, along the first axis: that of the polynomial through a sample and ``beside`` ones on either side.

    The ends have fewer. Through five samples it is 0.5 % too small at a tenth of the rate; through three, 6 %.
    """
    slope: Array = np.gradient(values, time, axis=0)
    inner = len(time) - 2 * beside
    if beside < 2 or inner < 1:
        return slope
    apart = np.stack([time[k : k + inner] - time[beside : beside + inner] for k in range(2 * beside + 1)])
    others = [k for k in range(2 * beside + 1) if k != beside]
    total = np.zeros_like(slope[beside:-beside])
    for k in others:  # Lagrange's polynomials, differentiated in the middle
        rest = [m for m in others if m != k]
        weight = np.prod([apart[m] / (apart[m] - apart[k]) for m in rest], axis=0) / apart[k]
        change = values[k : k + inner] - values[beside : beside + inner]
        total += (change.T * weight).T
    slope[beside:-beside] = total
    return slope


def slope_gain(turn: Array, beside: int = BESIDE) -> Array:
    """What ``derivative`` makes of a motion of ``turn`` radians per sample, per what is its derivative."""
    at = np.arange(-beside, beside + 1, dtype=float)
    return np.asarray(derivative(np.sin(np.multiply.outer(at, turn)), at, beside)[beside] / turn)


def is_cut(rate: float, cutoff: float) -> bool:
    """Whether a filter of that edge leaves anything away at that rate."""
    return cutoff < WHOLE * rate


def low_pass(values: Array, rate: float, cutoff: float) -> Array:
    """Butterworth, forwards and backwards, along the first axis; beyond ``WHOLE`` of the rate nothing is cut."""
    if not is_cut(rate, cutoff):
        return values
    pad = min(len(values) - 1, int(3 * rate / cutoff))
    sections, settled = _butterworth(rate, cutoff)
    # As `sosfiltfilt` does it, which would find the settled state anew for every column.
    ends = 2.0 * values[0] - values[pad:0:-1], 2.0 * values[-1] - values[-2 : -pad - 2 : -1]
    rows = np.concatenate([ends[0], values, ends[1]]).reshape(len(values) + 2 * pad, -1).T
    for _ in range(2):
        rows = signal.sosfilt(sections, rows, axis=1, zi=settled * rows[:, :1])[0][:, ::-1]
    return np.ascontiguousarray(rows[:, pad : rows.shape[1] - pad].T).reshape(values.shape)


def passed(frequency: Array, rate: float, cutoff: Array) -> Array:
    """What ``low_pass`` leaves of an amplitude at these frequencies (Hz)."""
    return np.where(cutoff < WHOLE * rate, 1.0 / (1.0 + (frequency / cutoff) ** (2 * FILTER_ORDER)), 1.0)


@lru_cache
def _butterworth(rate: float, cutoff: float) -> tuple[Array, Array]:
    """Its sections, and their states (sections, 1, 2) once an input of one has been there for ever."""
    sections = signal.butter(FILTER_ORDER, cutoff, fs=rate, output="sos")
    return sections, signal.sosfilt_zi(sections)[:, None, :]


def smoothed(values: Array, segments: Sequence[slice], rate: float, cutoff: float) -> Array:
    """(N,) without what is quicker, each stretch by itself."""
    smooth = values.copy()
    for part in segments:
        smooth[part] = low_pass(smooth[part], rate, cutoff)
    return smooth


def _refuse_memory(robot: Robot, kernel: Kernel) -> None:
    known = driven_states(robot)
    memory = [name for name in kernel.states[2 * len(kernel.coordinates) :] if name not in known]
    if memory:
        message = f"'{robot.name}' has states that neither a channel nor the motion tells: {', '.join(memory)}"
        hint = "take the effects away that bring them"
        raise InputError(Problem("SD521", message, robot.where, hint))
