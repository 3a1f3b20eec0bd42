"""Arms with drives, simulated with located events: ``python -m benchmarks.drive.arms``.

Thread CPU time of one run after compilation, best of five; errors are the largest of all states over all reported
points, each over the largest size of its state, against DOP853 at 1e-10 with events.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from benchmarks.drive.event_solver import EventSolver
from symdyn.compiler import compile_hybrid, compile_robot, load_robot
from symdyn.numeric.hybrid.general_simulation import simulate_general
from symdyn.numeric.hybrid.machine import Machine
from symdyn.numeric.hybrid.signals import Signal, sine, step

Array = NDArray[np.float64]

CASES: dict[str, tuple[list[Signal], float]] = {
    "step": ([step(1.0), step(1.0)], 1.0),
    "sine": ([sine(1.0, 0.2), sine(1.0, 0.2)], 5.0),
}
PEERS = {"step": ("LSODA", "RK45", "DOP853"), "sine": ("LSODA",)}
ROUNDS = 5
PERIOD = 1e-3
AMPLITUDES, OMEGAS = np.array([0.6, 0.5, 0.7, 0.8, 0.6, 1.0]), np.array([2.0, 2.6, 3.1, 3.7, 4.3, 4.9])


def cpu(run: Callable[[], object]) -> float:
    best = np.inf
    for _ in range(ROUNDS):
        start = time.thread_time()
        run()
        best = min(best, time.thread_time() - start)
    return best


def error(found: Array, reference: Array) -> float:
    return float((np.abs(found - reference).max(axis=0) / np.abs(reference).max(axis=0)).max())


def driven_arm() -> Machine:
    return Machine(compile_hybrid(load_robot("irb6-arm-drives")))


def arm_with_scipy(machine: Machine, case: str, method: str, tolerance: float, points: int = 1001) -> tuple[Array, int]:
    """States at evenly spaced times, and the number of events."""
    signals, end = CASES[case]

    def u(t: float) -> Array:
        return np.array([float(s.at(np.array(t))) for s in signals])

    if case == "step":
        held = u(0.0)
        solver = EventSolver(machine.kernel.module, lambda t: held, method, tolerance)
    else:
        solver = EventSolver(machine.kernel.module, u, method, tolerance)
    return solver.travel(np.zeros(len(machine.kernel.states)), np.linspace(0.0, end, points)), solver.events


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


def main() -> None:
    machine = driven_arm()
    for case, (signals, end) in CASES.items():
        times = np.linspace(0.0, end, 1001)
        reference, events = arm_with_scipy(machine, case, "DOP853", 1e-10)
        print(f"IRb6 arm with two drives, 18 states, {case}, {end:g} s, {events} events", flush=True)
        for tolerance in (1e-6, 1e-7, 1e-8):
            run = partial(simulate_general, machine, times, signals, tolerance=tolerance)
            spent, found = cpu(run), run()
            off, count = error(found.states, reference), len(found.events)
            print(
                f"  symdyn {tolerance:.0e}: error {off:.1e}, {count} events, {end / spent:.0f} x real time", flush=True
            )
        for method in PEERS[case]:
            begun = time.thread_time()
            states, count = arm_with_scipy(machine, case, method, 1e-7)
            spent = time.thread_time() - begun
            off = error(states, reference)
            print(f"  scipy {method} 1e-07: error {off:.1e}, {count} events, {end / spent:.2g} x real time", flush=True)
    puma, loop, inverse = computed_torque_loop()
    exact = loop_with_scipy(puma, inverse, 0.5, "DOP853", 1e-10)
    print("Puma 560, six drives with friction, computed torque at 1 kHz")
    for tolerance in (1e-6, 1e-8):
        tally = np.zeros(5, np.int64)
        found = loop(5.0, tolerance, tally)
        spent = cpu(lambda tolerance=tolerance: loop(5.0, tolerance, np.zeros(5, np.int64)))
        off = error(found[: len(exact)], exact)
        print(
            f"  symdyn {tolerance:.0e}: error {off:.1e}, {tally[0]} events, {5.0 / spent:.0f} x real time", flush=True
        )


if __name__ == "__main__":
    main()
