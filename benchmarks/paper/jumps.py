"""What the page needs of friction and clearance: simulated with every event located, computed once."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from symdyn.compiler import compile_hybrid, load_robot, robot_from_text
from symdyn.numeric.hybrid.machine import Machine
from symdyn.numeric.hybrid.signals import Piece, Signal, constant, sine, step, trapezoid
from symdyn.numeric.hybrid.simulate import simulate_events
from symdyn.numeric.hybrid.stepped_sine import SteppedSine, stepped_sine
from symdyn.numeric.hybrid.trajectory import HybridTrajectory
from symdyn.spec.edit import add_effect, set_parameter

Array = NDArray[np.float64]

CLEARANCE = 0.01  # rad; the paper names it S and prints no value
VOLTS, BACK, END = 5.0, 0.4, 0.8  # a step of voltage, taken back after BACK seconds
AMPLITUDES = (1.5, 4.0, 12.0)  # V
LOW, HIGH, POINTS = 0.5, 2000.0, 49
NEAR, NEAR_POINTS = (6.0, 20.0), 31  # Hz, around the first anti-resonance and mode
SETTLED = 1e-4
SERVO = {"proportional": "50 V/rad", "derivative": "0.5 V s/rad", "limit": "24 V"}
ARM = "irb6-arm-drives"
HOLD, MOVE = 5.0, 1.5  # s
LIFT = 0.6  # rad: the arm's angle at the start, above the horizontal
ANGLE, SPEED, ACCELERATION = 1.0, 2.0, 10.0  # of the joints: rad, rad/s, rad/s^2
TOLERANCE = 1e-9  # of the arm's integration


@dataclass(frozen=True)
class ArmRun:
    """The arm with its drives, after it has come to rest under gravity: angles of the joints asked for, and the run."""

    asked: Array  # (N, 2)
    found: HybridTrajectory


@dataclass(frozen=True)
class Jumps:
    """The drive by its jumps: none, friction, friction and clearance; in the servo; measured by sines; the arm."""

    steps: Mapping[str, HybridTrajectory]
    servo: Mapping[str, HybridTrajectory]
    measured: Mapping[str, SteppedSine]
    drive: Machine
    arm: Machine
    both: ArmRun
    column: ArmRun  # the column moves, the arm is to hold


def drive(friction: bool, clearance: bool, servo: bool = False) -> Machine:
    """irb6-axis1 with T_f or without, with a clearance or the printed none."""
    robot = load_robot("irb6-axis1")
    text = robot.text
    if clearance:
        text = set_parameter(text, robot, "S", f"{CLEARANCE} rad")
    if not friction:
        text = set_parameter(text, robot, "T_f", "0 N m")
    if servo:
        text = add_effect(text, "position_servo", "axis1.motor", SERVO)
    return Machine(compile_hybrid(robot_from_text(text, "drive.toml")))


def jumps() -> Jumps:
    full = drive(True, True)
    pulse = Signal((Piece(0.0, (VOLTS,)), Piece(BACK, (0.0,))))
    time = np.linspace(0.0, END, 1601)
    machines = {"linear part": drive(False, False), "friction": drive(True, False), "friction and clearance": full}
    steps = {name: simulate_events(machine, time, [pulse]) for name, machine in machines.items()}
    closed = drive(True, True, servo=True)
    servo = {
        "step of 1 rad": simulate_events(closed, np.linspace(0.0, 1.0, 1001), [step(1.0)]),
        "sine of 1 rad, 0.2 Hz": simulate_events(closed, np.linspace(0.0, 5.0, 1001), [sine(1.0, 0.2)]),
    }
    hertz = np.union1d(np.geomspace(LOW, HIGH, POINTS), np.geomspace(*NEAR, NEAR_POINTS))
    measured = {f"{a:g} V": stepped_sine(full, hertz, a, settled=SETTLED) for a in AMPLITUDES}
    arm = Machine(compile_hybrid(load_robot(ARM)))
    return Jumps(steps, servo, measured, full, arm, _move(arm, (1.0, -1.0)), _move(arm, (1.0, 0.0)))


def turns(arm: Machine) -> float:
    """Of a motor per turn of its joint."""
    return float(arm.kernel.values[arm.kernel.parameters.index("N")])


def cases(j: Jumps) -> dict[str, tuple[float, Callable[[], HybridTrajectory]]]:
    """What is simulated to see how long it takes: the time that passes in the machine, and the simulation."""
    closed, ratio = drive(True, True, servo=True), turns(j.arm)
    both = _asked(ratio, (1.0, -1.0))
    begin = j.both.found.states[0]
    return {
        "drive and servo, step": (1.0, lambda: simulate_events(closed, np.linspace(0.0, 1.0, 101), [step(1.0)])),
        "drive and servo, sine": (5.0, lambda: simulate_events(closed, np.linspace(0.0, 5.0, 101), [sine(1.0, 0.2)])),
        "arm with both drives, 1e-7 a step": (
            MOVE,
            lambda: simulate_events(j.arm, np.linspace(0.0, MOVE, 101), both, start=begin, tolerance=1e-7),
        ),
    }


def _move(arm: Machine, share: tuple[float, float]) -> ArmRun:
    ratio = turns(arm)
    still = [constant(0.0), constant(ratio * LIFT)]
    held = simulate_events(arm, np.linspace(0.0, HOLD, 11), still, tolerance=TOLERANCE)
    signals = _asked(ratio, share)
    time = np.linspace(0.0, MOVE, 1501)
    found = simulate_events(arm, time, signals, start=held.states[-1], tolerance=TOLERANCE)
    return ArmRun(found.inputs / ratio, found)


def _asked(ratio: float, share: tuple[float, float]) -> list[Signal]:
    """References of both motors, for shares of the angle."""
    column, arm = (trapezoid(s * ratio * ANGLE, ratio * SPEED, ratio * ACCELERATION) for s in share)
    lifted = (replace(p, powers=(p.powers[0] + ratio * LIFT, *p.powers[1:])) for p in arm.pieces)
    return [column, Signal(tuple(lifted))]
