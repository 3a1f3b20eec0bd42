"""A hybrid kernel in numbers: the affine system of each mode, as the exact propagation needs it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symdyn.emit.kernel import Kernel
from symdyn.numeric.hybrid.affine_modes import Base
from symdyn.numeric.hybrid.vectors import LANES

Array = NDArray[np.float64]

FRICTION, CONTACT, LIMIT = "friction", "contact", "limit"


@dataclass(frozen=True, eq=False)
class Observer:
    """States o that listen to a machine and never act on it: do/dt = system o + by_state x + by_input u + constant."""

    system: Array  # (no, no)
    by_state: Array  # (no, nx)
    by_input: Array  # (no, nu)
    constant: Array  # (no,)


@dataclass(frozen=True)
class Machine:
    """A hybrid kernel with values for its parameters; ``p`` None: those of the file, folded into the code.

    An ``observer`` adds its states behind those of a machine that is affine in every mode.
    """

    kernel: Kernel
    p: Array | None = None
    observer: Observer | None = None

    @property
    def switches(self) -> tuple[str, ...]:
        return tuple(self.kernel.module.SWITCHES)

    @property
    def affine(self) -> bool:
        return bool(self.kernel.module.AFFINE)

    @property
    def size(self) -> int:
        """States, with those of the observer."""
        return len(self.kernel.states) + (0 if self.observer is None else len(self.observer.constant))

    def count(self, kind: str) -> int:
        return sum(k == kind for k in self.kernel.module.SWITCH_KINDS)

    @property
    def parameters(self) -> Array:
        """(np,) values that a simulation takes."""
        return self.kernel.values if self.p is None else self.p

    @property
    def clocks(self) -> Array:
        """(K, 2) period and delay of what is sampled, in s."""
        kernel = self.kernel
        return self.call("clocks", *(np.zeros(len(v)) for v in (kernel.states, kernel.inputs, self.switches))).reshape(
            -1, 2
        )

    def call(self, name: str, x: Array, u: Array, s: Array) -> Array:
        """A function of the kernel; an empty array where it has no entries."""
        form = name if self.p is None else f"{name}_p"
        if not self.kernel.has(form):
            return np.zeros(0)
        arguments = (x, u, s) if self.p is None else (x, u, s, self.p)
        return np.asarray(getattr(self.kernel, form)(*arguments))

    def rows(self, name: str, x: Array, u: Array, s: Array) -> Array:
        """The same for many: x (m, nx), u (m, nu), s (m, switches)."""
        form = name if self.p is None else f"{name}_p"
        if not self.kernel.has(form):
            return np.zeros((len(x), 0))
        arguments = (x, u, s) if self.p is None else (x, u, s, self.p)
        return self.kernel.rows(form, *arguments)

    def base(self, number: int, systems: Array, outputs: Array, parameters: Array) -> Base:
        """Affine systems of B sets with one combination of contacts and limits, stacked as (B, ...).

        ``number`` is that of ``affine_switches.base_of``. Inputs come from exosystems dw/dt = S w, u = U w with S
        in ``systems`` (B, m, m), U in ``outputs`` (B, nu, m); ``parameters`` (B, np).
        """
        nf, nc, nl = (self.count(kind) for kind in (FRICTION, CONTACT, LIMIT))
        sets, nx, nu, nw = len(parameters), len(self.kernel.states), len(self.kernel.inputs), systems.shape[1]
        first = self.size  # of the exosystem
        n, one = self.width(nw), first + nw
        s = np.zeros(nf + nc + nl)
        for k in range(nc + nl):
            s[-1 - k] = number // 3**k % 3 - 1
        x, u = np.zeros(nx), np.zeros(nu)

        def call(name: str, *shape: int) -> Array:
            form = f"{name}_p"
            if not self.kernel.has(form):
                return np.zeros((sets, *shape))
            function = getattr(self.kernel, form)
            return np.array([function(x, u, s, p) for p in parameters]).reshape(sets, *shape)

        def affine(name: str, count: int) -> Array:
            rows = np.zeros((sets, count, n))
            rows[:, :, :nx] = call(f"{name}_state_jacobian", count, nx)
            rows[:, :, first:one] = call(f"{name}_input_jacobian", count, nu) @ outputs
            rows[:, :, one] = call(name, count)
            return rows

        a, friction = np.zeros((sets, n, n)), np.zeros((sets, n, nf))
        a[:, :nx] = affine("state_derivative", nx)
        if self.observer is not None:
            o = self.observer
            a[:, nx:first, :nx], a[:, nx:first, nx:first], a[:, nx:first, one] = o.by_state, o.system, o.constant
            a[:, nx:first, first:one] = o.by_input @ outputs
        a[:, first:one, first:one] = systems
        if nf:
            friction[:, :nx] = call("state_derivative_friction_jacobian", nx, nf)
        guards = affine("guards", nf + 3 * nc + nl)
        bounds = call("bounds", nc + 2 * nl)
        speeds, gap, high, low, argument = np.split(guards, np.cumsum([nf, nc, nc, nc]), axis=1)
        half, lower, upper = np.split(bounds, np.cumsum([nc, nl]), axis=1)
        parts = (a, friction, speeds, gap, high, low, argument, half, np.stack([lower, upper], axis=2))
        return Base(*map(np.ascontiguousarray, parts))

    def width(self, signals: int) -> int:
        """Of the matrices over z = [x, observer, signals, 1], rounded up for vector instructions."""
        return -(-(self.size + signals + 1) // LANES) * LANES

    @property
    def most_guards(self) -> int:
        """Of any mode, rounded up for vector instructions."""
        count = 2 * (self.count(FRICTION) + self.count(CONTACT) + self.count(LIMIT))
        return max(LANES, -(-count // LANES) * LANES)
