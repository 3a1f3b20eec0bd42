"""Arms with drives, simulated with located events: the IRb6's with two whole drives, and the Puma 560."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from benchmarks.drive.event_solver import EventSolver
from benchmarks.drive.measure import Row, error, measured, thread_time
from symdyn.compiler import compile_hybrid, compile_robot, load_robot
from symdyn.numeric.hybrid.general_simulation import simulate_general
from symdyn.numeric.hybrid.machine import Machine
from symdyn.numeric.hybrid.signals import Signal, sine, step

Array = NDArray[np.float64]

CASES: dict[str, tuple[list[Signal], float]] = {
    "step": ([step(1.0), step(1.0)], 1.0),
    "sine": ([sine(1.0, 0.2), sine(1.0, 0.2)], 5.0),
}
PEERS: dict[str, tuple[tuple[str, float], ...]] = {
    "step": (("RK45", 1e-7), ("DOP853", 3e-9), ("LSODA", 3e-8)),
    "sine": (),
}
TOLERANCES = (1e-6, 2e-7, 1e-8)
POINTS = 1001
ROUNDS = 5
PERIOD = 1e-3
AMPLITUDES, OMEGAS = np.array([0.6, 0.5, 0.7, 0.8, 0.6, 1.0]), np.array([2.0, 2.6, 3.1, 3.7, 4.3, 4.9])


def driven_arm() -> Machine:
    return Machine(compile_hybrid(load_robot("irb6-arm-drives")))


def arm_with_scipy(machine: Machine, case: str, method: str, tolerance: float) -> tuple[Array, int]:
    """States at evenly spaced times, and the number of events, with inputs as they are at first."""
    signals, end = CASES[case]

    held = np.array([float(s.at(np.array(0.0))) for s in signals])
    solver = EventSolver(machine.kernel.module, lambda t: held, method, tolerance)
    return solver.travel(np.zeros(len(machine.kernel.states)), np.linspace(0.0, end, POINTS)), solver.events


@njit  # type: ignore[untyped-decorator]
def _command(t: float, x: Array, amplitudes: Array, omegas: Array, gain: float, out: Array) -> None:
    """Accelerations that a computed-torque loop with both poles at -gain asks for."""
    n = len(out)
    for i in range(n):
        wave = omegas[i] * t
        lag = amplitudes[i] * (1.0 - np.cos(wave)) - x[i]
        slower = amplitudes[i] * omegas[i] * np.sin(wave) - x[n + i]
        out[i] = amplitudes[i] * omegas[i] ** 2 * np.cos(wave) + 2.0 * gain * slower + gain * gain * lag


def computed_torque_loop() -> tuple[Machine, Callable[..., Array], Any]:
    """The Puma 560 with its drives, a loop at 1 kHz around it in compiled code, and its inverse dynamics."""
    robot = load_robot("puma560")
    machine = Machine(compile_hybrid(robot))
    inverse = compile_robot(robot).kernel().inverse_dynamics_into
    module = machine.kernel.module
    advance, restart, workspace, n = module.advance, module._restart, module.workspace, module.NU

    @njit(error_model="numpy")  # type: ignore[untyped-decorator]
    def loop(samples: int, gain: float, tolerance: float, smallest: Array, tally: Any) -> Array:
        work, x, switches = workspace(), np.zeros(2 * n), np.zeros(n, np.int64)
        powers, sines, step = np.zeros((n, 1)), np.zeros((n, 0, 3)), np.array([PERIOD])
        events, command, torque = np.zeros((10_000, 4)), np.zeros(n), np.zeros(n)
        every = np.zeros((samples + 1, 2 * n))
        for k in range(samples):
            t = k * PERIOD
            _command(t, x, AMPLITUDES, OMEGAS, gain, command)
            inverse(x[:n], x[n:], command, torque)
            powers[:, 0] = torque
            restart(x, switches, t, powers, sines, work)
            status = advance(x, switches, t, t + PERIOD, powers, sines, step, tolerance, smallest, events, tally, work)
            if status != 0:
                raise ArithmeticError("the integrator gave up")
            every[k + 1] = x
        return every

    def run(seconds: float, tolerance: float, tally: Any) -> Array:
        found: Array = loop(round(seconds / PERIOD), 40.0, tolerance, np.full(2 * n, 1e-3 * tolerance), tally)
        return found

    return machine, run, inverse


def loop_with_scipy(machine: Machine, inverse: Any, seconds: float, method: str, tolerance: float) -> Array:
    """The same loop around scipy."""
    module, torque, command = machine.kernel.module, np.zeros(6), np.zeros(6)
    solver = EventSolver(module, lambda t: torque, method, tolerance)
    states = [np.zeros(12)]
    for k in range(round(seconds / PERIOD)):
        x = states[-1]
        _command(k * PERIOD, x, AMPLITUDES, OMEGAS, 40.0, command)
        inverse(x[:6], x[6:], command, torque)
        states.append(solver.travel(x, np.array([k * PERIOD, (k + 1) * PERIOD]))[-1])
    return np.array(states)


def arm_rows(case: str) -> list[Row]:
    """Ours first, the peers behind them; see ``arm_reference``."""
    machine, (signals, end) = driven_arm(), CASES[case]
    times, reference = np.linspace(0.0, end, POINTS), arm_reference(machine, case)

    def ours(tolerance: float) -> tuple[Array, int]:
        found = simulate_general(machine, times, signals, tolerance=tolerance)
        return found.states, len(found.events)

    rows = [measured(f"symdyn, {t:g}", partial(ours, t), reference, end, ROUNDS) for t in TOLERANCES]
    for method, tolerance in PEERS[case]:
        run = partial(arm_with_scipy, machine, case, method, tolerance)
        rows.append(measured(f"scipy {method}, {tolerance:g}", run, reference, end, 0))
    return rows


def arm_reference(machine: Machine, case: str) -> Array:
    """DOP853 at 1e-10 with events for the step; of the longer sine our own method at 1e-12."""
    signals, end = CASES[case]
    if case == "step":
        return arm_with_scipy(machine, case, "DOP853", 1e-10)[0]
    return simulate_general(machine, np.linspace(0.0, end, POINTS), signals, tolerance=1e-12).states


def computed_torque_rows() -> list[Row]:
    """The first half second against DOP853 at 1e-10, the speed over 5 s."""
    machine, loop, inverse = computed_torque_loop()
    exact = loop_with_scipy(machine, inverse, 0.5, "DOP853", 1e-10)
    rows = []
    for tolerance in (1e-6, 1e-8):
        tally = np.zeros(5, np.int64)
        found = loop(5.0, tolerance, tally)
        run = partial(loop, 5.0, tolerance, np.zeros(5, np.int64))
        spent = min(thread_time(run) for _ in range(ROUNDS))
        rows.append(Row(f"symdyn, {tolerance:g}", error(found[: len(exact)], exact), int(tally[0]), 5.0 / spent))
    return rows
