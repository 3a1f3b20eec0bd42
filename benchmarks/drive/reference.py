"""The seed's drive by hand: equations written out, scipy's DOP853 at 1e-12 between events; nothing of symdyn."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

Array = NDArray[np.float64]

R, L, K_T, K_E, T_F = 1.6, 87e-6, 0.088, 0.088, 0.025
J = np.array([34e-6, 41e-6, 196e-6, 372e-6])
D = np.array([76e-6, 12e-6, 700e-6, 0.0])
C_1, C_2, C_3, D_1, D_2, D_3 = 789.0, 1225.0, 1.44, 1200e-6, 68000e-6, 1600e-6
S, K_P, K_D, U_MAX = 0.01, 50.0, 0.5, 24.0

STEP: tuple[Callable[[float], float], float] = (lambda t: 1.0, 1.0)
SINE: tuple[Callable[[float], float], float] = (lambda t: float(np.sin(2 * np.pi * 0.2 * t)), 5.0)


@dataclass(frozen=True)
class Mode:
    """Friction: the sign of the motor's speed, 0 where it sticks; flank: +-1 where engaged."""

    friction: int
    flank: int


def torques(x: Array, mode: Mode, reference: float) -> tuple[Array, float]:
    """(4,) torque on each inertia without friction, and the motor's voltage; x = [phi (4), omega (4), I]."""
    phi, omega, current = x[:4], x[4:8], x[8]
    first = C_1 * (phi[0] - phi[1]) + D_1 * (omega[0] - omega[1])
    second = C_2 * (phi[1] - phi[2]) + D_2 * (omega[1] - omega[2])
    third = press(x, mode.flank) * mode.flank
    voltage = min(U_MAX, max(-U_MAX, K_P * (reference - phi[1]) - K_D * omega[1]))
    return np.array([-first, first - second + K_T * current, second - third, third]) - D * omega, voltage


def press(x: Array, flank: int) -> float:
    """What the flank presses with, towards the load if positive: spring and damper together."""
    twist, rate = x[2] - x[3], x[6] - x[7]
    return float(flank * (C_3 * (twist - flank * S) + D_3 * rate)) if flank else 0.0


def solve(
    case: tuple[Callable[[float], float], float], points: int = 1001, method: str = "DOP853",
    rtol: float = 1e-12, atol: float = 1e-14,
) -> tuple[Array, list[tuple[float, Mode]]]:  # fmt: skip
    """States (points, 9) and the modes entered, each with its time."""
    reference, end = case
    time = np.linspace(0.0, end, points)
    states = np.zeros((points, 9))
    t, x, mode = 0.0, np.zeros(9), Mode(0, 0)
    entered: list[tuple[float, Mode]] = []
    while t < end:
        events = _events(mode, reference)
        found = solve_ivp(
            _rate, (t, end), x, method=method, rtol=rtol, atol=atol, events=[e for e, _ in events],
            dense_output=True, args=(mode, reference), max_step=2e-3,
        )  # fmt: skip
        here = (time >= t) & (time <= found.t[-1])
        if here.any():
            states[here] = found.sol(time[here]).T
        if found.status == 0:
            break
        fired = next(k for k, times in enumerate(found.t_events) if len(times))
        t, x = float(found.t_events[fired][0]), found.y_events[fired][0].copy()
        mode = next_mode(events[fired][1], x, mode, reference(t))
        if mode.friction == 0 or events[fired][1] == "speed":
            x[5] = 0.0
        entered.append((t, mode))
    return states, entered


def _rate(t: float, x: Array, mode: Mode, reference: Callable[[float], float]) -> Array:
    torque, voltage = torques(x, mode, reference(t))
    torque[1] -= T_F * mode.friction
    acceleration = torque / J
    if mode.friction == 0:
        acceleration[1] = 0.0
    return np.concatenate([x[4:8], acceleration, [(voltage - R * x[8] - K_E * x[5]) / L]])


def _events(mode: Mode, reference: Callable[[float], float]) -> list[tuple[Callable[..., float], str]]:
    found: list[tuple[Callable[..., float], str]] = []
    if mode.friction:
        found.append((lambda t, x, m, r: mode.friction * x[5], "speed"))
    else:
        found.append((lambda t, x, m, r: T_F - abs(torques(x, m, r(t))[0][1]), "breakaway"))
    if mode.flank:
        found.append((lambda t, x, m, r: press(x, mode.flank), "opening"))
    else:
        for flank in (1, -1):
            found.append((lambda t, x, m, r, f=flank: S - f * (x[2] - x[3]), f"closing {flank}"))
    for event, _ in found:
        event.terminal, event.direction = True, -1.0  # type: ignore[attr-defined]
    return found


def next_mode(what: str, x: Array, mode: Mode, reference: float) -> Mode:
    """The mode after ``what``: speed, breakaway, opening, closing 1 or closing -1."""
    if what == "opening":
        return Mode(mode.friction, 0)
    if what.startswith("closing"):
        return Mode(mode.friction, int(what.split()[1]))
    torque = float(torques(x, mode, reference)[0][1])
    slips = abs(torque) >= T_F or what == "breakaway"
    return Mode(int(np.sign(torque)) if slips else 0, mode.flank)
