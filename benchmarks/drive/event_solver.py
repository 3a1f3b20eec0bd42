"""A peer: scipy's integrators with terminal events, around the compiled functions of the same machine."""

from __future__ import annotations

from collections.abc import Callable
from types import ModuleType

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

Array = NDArray[np.float64]

NUDGE = 1e-11  # s


class EventSolver:
    """Integrates the modes of a hybrid kernel, one ``solve_ivp`` from event to event; inputs are ``u(t)``."""

    def __init__(self, module: ModuleType, u: Callable[[float], Array], method: str, tolerance: float) -> None:
        self.module, self.u, self.method, self.tolerance = module, u, method, tolerance
        self.switches = np.zeros(module.NS, np.int64)
        self.work = module.workspace()
        self.out, self.events = np.zeros(module.NX), 0
        self.tally, self.rows = np.zeros(5, np.int64), np.zeros((64, 4))
        self.guards = np.zeros(module.WATCHED)

    def travel(self, x: Array, times: Array) -> Array:
        """States (N, nx) at ``times``, from x at the first of them; the modes go on from where they were."""
        states = np.empty((len(times), len(x)))
        t, end, x = float(times[0]), float(times[-1]), x.copy()
        self.begin(t, x)
        while t < end:
            count = self._watch(t, x)
            watching = [self._guard(g, count) for g in range(count)]
            found = solve_ivp(
                self._rate, (t, end), x, self.method, rtol=self.tolerance, atol=1e-3 * self.tolerance, events=watching,
                dense_output=True,
            )  # fmt: skip
            here = (times >= t) & (times <= found.t[-1])
            if here.any():
                states[here] = found.sol(times[here]).T
            t, x = float(found.t[-1]), found.y[:, -1].copy()
            if found.status == 1:
                before = self.events
                self._switch(t, x, [g for g, when in enumerate(found.t_events) if len(when)])
                while self.events == before:  # located a rounding too early
                    x, t = x + NUDGE * self._rate(t, x), t + NUDGE
                    crossed = np.flatnonzero(self._watched(t, x) < 0.0)
                    if len(crossed) == 0:
                        break
                    self._switch(t, x, crossed.tolist())
        states[-1] = x
        return states

    def begin(self, t: float, x: Array) -> None:
        self.module.begin(x, self.u(t), self.switches)

    def _rate(self, t: float, x: Array) -> Array:
        s, terms, matrix, sticks, friction = self.work[:5]
        levers = self.work[14]
        self.module._rate(x, self.u(t), s, self.switches, levers, sticks, friction, terms, matrix, False, self.out)
        return self.out.copy()

    def _watch(self, t: float, x: Array) -> int:
        """Guards of the mode at x; also makes ready what the mode needs."""
        s, terms, matrix, sticks, friction, _, plan, weights, _, owner, target = self.work[:11]
        levers, u, module = self.work[14], self.u(t), self.module
        module._modes(self.switches, s)
        module.guards_state_jacobian_into(x, u, s, levers)
        module._rate(x, u, s, self.switches, levers, sticks, friction, terms, matrix, True, self.out)
        count = int(module._plan(self.switches, owner, target, plan, weights))
        module._watch(x, u, s, terms, plan, weights, count, self.guards)
        return count

    def _watched(self, t: float, x: Array) -> Array:
        count = self._watch(t, x)
        return self.guards[:count]

    def _guard(self, g: int, count: int) -> Callable[[float, Array], float]:
        s, terms, matrix, sticks, friction, _, plan, weights = self.work[:8]
        levers, module, spare = self.work[14], self.module, np.zeros(self.module.NX)

        def value(t: float, x: Array) -> float:
            u = self.u(t)
            if sticks[module.NF]:
                module._rate(x, u, s, self.switches, levers, sticks, friction, terms, matrix, False, spare)
            module._watch(x, u, s, terms, plan, weights, count, self.guards)
            return float(self.guards[g])

        value.terminal, value.direction = True, -1.0  # type: ignore[attr-defined]
        return value

    def _switch(self, t: float, x: Array, fired: list[int]) -> None:
        s, terms, matrix, sticks, friction, _, plan, weights, _, owner, target, _, _, _, levers, resting, spare = (
            self.work
        )
        module, u = self.module, self.u(t)
        count = self._watch(t, x)
        self.guards[fired] = -1e-9  # reached, within rounding
        self.tally[0] = 0
        status = module._switch(
            x, u, s, self.switches, levers, sticks, friction, terms, matrix, plan, weights, self.guards, owner, target,
            count, spare, t, self.rows, self.tally, resting,
        )  # fmt: skip
        if status != module.DONE:
            raise ArithmeticError(f"switches do not settle at {t} s")
        self.events += int(self.tally[0])
