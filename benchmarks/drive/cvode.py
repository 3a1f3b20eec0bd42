"""A peer: CVODE of SUNDIALS (scikit-sundae) with root finding on the seed's drive, its equations compiled by Numba."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray
from sksundae.cvode import CVODE

from benchmarks.drive.reference import (
    C_1,
    C_2,
    C_3,
    D_1,
    D_2,
    D_3,
    K_D,
    K_E,
    K_P,
    K_T,
    T_F,
    U_MAX,
    D,
    J,
    L,
    Mode,
    R,
    S,
    next_mode,
)

Array = NDArray[np.float64]
Wave = tuple[float, float, float]  # w: w[0] + w[1] sin(w[2] t), the reference of the servo

GUARDS = 3  # of the friction, of the flank that presses or closes, of the other one
MOST_STEPS = 100_000  # between two reported times
STOPPED = 2  # at a root


@njit  # type: ignore[untyped-decorator]
def _wanted(t: float, x: Array, wave: Wave) -> float:
    """Voltage, before its limit."""
    return K_P * (wave[0] + wave[1] * np.sin(wave[2] * t) - x[1]) - K_D * x[5]


@njit  # type: ignore[untyped-decorator]
def _rate(t: float, x: Array, wave: Wave, friction: int, flank: int, out: Array) -> None:
    first = C_1 * (x[0] - x[1]) + D_1 * (x[4] - x[5])
    second = C_2 * (x[1] - x[2]) + D_2 * (x[5] - x[6])
    third = C_3 * (x[2] - x[3] - flank * S) + D_3 * (x[6] - x[7]) if flank else 0.0
    voltage = min(U_MAX, max(-U_MAX, _wanted(t, x, wave)))
    for k in range(4):
        out[k] = x[4 + k]
    out[4] = (-first - D[0] * x[4]) / J[0]
    out[5] = (first - second + K_T * x[8] - D[1] * x[5] - T_F * friction) / J[1] if friction else 0.0
    out[6] = (second - third - D[2] * x[6]) / J[2]
    out[7] = (third - D[3] * x[7]) / J[3]
    out[8] = (voltage - R * x[8] - K_E * x[5]) / L


@njit  # type: ignore[untyped-decorator]
def _jacobian(t: float, x: Array, wave: Wave, friction: int, flank: int, out: Array) -> None:
    out[:] = 0.0
    for k in range(4):
        out[k, 4 + k] = 1.0
        out[4 + k, 4 + k] = -D[k] / J[k]
    for pair, (stiffness, damping) in enumerate(((C_1, D_1), (C_2, D_2), (C_3, D_3))):
        if pair < 2 or flank:
            for one, other in ((pair, pair + 1), (pair + 1, pair)):
                out[4 + one, one] -= stiffness / J[one]
                out[4 + one, other] += stiffness / J[one]
                out[4 + one, 4 + one] -= damping / J[one]
                out[4 + one, 4 + other] += damping / J[one]
    out[5, 8] = K_T / J[1]
    if not friction:
        out[5] = 0.0
    out[8, 8], out[8, 5] = -R / L, -K_E / L
    if abs(_wanted(t, x, wave)) < U_MAX:
        out[8, 1] = -K_P / L
        out[8, 5] -= K_D / L


@njit  # type: ignore[untyped-decorator]
def _guards(x: Array, friction: int, flank: int, out: Array) -> None:
    twist = x[2] - x[3]
    if friction:
        out[0] = friction * x[5]
    else:
        shafts = C_1 * (x[0] - x[1]) + D_1 * (x[4] - x[5]) - C_2 * (x[1] - x[2]) - D_2 * (x[5] - x[6])
        out[0] = T_F - abs(shafts + K_T * x[8] - D[1] * x[5])
    out[1] = flank * (C_3 * (twist - flank * S) + D_3 * (x[6] - x[7])) if flank else S - twist
    out[2] = 1.0 if flank else S + twist


class _Drive:
    """What CVODE calls, in the mode of the moment."""

    terminal, direction = [True] * GUARDS, [-1] * GUARDS

    def __init__(self, wave: Wave) -> None:
        self.wave, self.mode = wave, Mode(0, 0)

    def rate(self, t: float, x: Array, out: Array) -> None:
        _rate(t, x, self.wave, self.mode.friction, self.mode.flank, out)

    def jacobian(self, t: float, x: Array, _: Array, out: Array) -> None:
        _jacobian(t, x, self.wave, self.mode.friction, self.mode.flank, out)

    def __call__(self, t: float, x: Array, out: Array) -> None:
        _guards(x, self.mode.friction, self.mode.flank, out)

    def switch(self, t: float, x: Array, which: int) -> None:
        """Enter the mode after the root of a guard; a speed that is zero becomes so exactly."""
        closing = "opening" if self.mode.flank else "closing 1"
        what = ("speed" if self.mode.friction else "breakaway", closing, "closing -1")[which]
        self.mode = next_mode(what, x, self.mode, self.wave[0] + self.wave[1] * float(np.sin(self.wave[2] * t)))
        if self.mode.friction == 0 or what == "speed":
            x[5] = 0.0


def solve_with_cvode(wave: Wave, end: float, points: int, rtol: float) -> tuple[Array, int]:
    """States (points, 9) at evenly spaced times, and the number of changes of friction and contact.

    BDF with the Jacobian given, a run of CVODE from event to event.
    """
    drive, times = _Drive(wave), np.linspace(0.0, end, points)
    solver = CVODE(
        drive.rate, jacfn=drive.jacobian, eventsfn=drive, num_events=GUARDS, rtol=rtol, atol=1e-3 * rtol,
        max_num_steps=MOST_STEPS,
    )  # fmt: skip
    states, x, t, done, events = np.zeros((points, 9)), np.zeros(9), 0.0, 1, 0
    while done < points:
        found = solver.solve(np.concatenate([[t], times[done:]]), x)
        t, x = float(found.t[-1]), found.y[-1].copy()
        if done == points - 1:  # with two times it reports its own steps
            states[done] = x
        reached = len(found.t) - 1 - (found.status == STOPPED)
        if done < points - 1:
            states[done : done + reached] = found.y[1 : 1 + reached]
            done += reached
        if found.status != STOPPED:
            break
        drive.switch(t, x, int(np.flatnonzero(found.i_events[-1])[0]))
        events += 1
    return states, events
