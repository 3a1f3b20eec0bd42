"""A hybrid kernel in numbers: the affine system of each mode, as the exact propagation needs it."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from symdyn.emit.kernel import Kernel
from symdyn.numeric.hybrid.affine_modes import Base

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

FRICTION, CONTACT, LIMIT = "friction", "contact", "limit"
BLOCK = 4  # of states: what the propagation takes at a time


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

    def base(self, held: tuple[int, ...], system: Array, output: Array) -> Base:
        """The affine system with contacts and limits as ``held`` (-1, 0, 1 each); inputs come from an exosystem."""
        nf, nc, nl = (self.count(kind) for kind in (FRICTION, CONTACT, LIMIT))
        nx, nu, nw = len(self.kernel.states), len(self.kernel.inputs), len(system)
        first = self.size  # of the exosystem
        n = -(-(first + nw + 1) // BLOCK) * BLOCK
        x, u = np.zeros(nx), np.zeros(nu)
        s = np.concatenate([np.zeros(nf), np.array(held, dtype=np.float64)])

        def affine(value: Array, by_state: Array, by_input: Array) -> Array:
            rows = np.zeros((len(value), n))
            rows[:, :nx] = by_state.reshape(len(value), nx)
            rows[:, first : first + nw] = by_input.reshape(len(value), nu) @ output
            rows[:, n - 1] = value
            return rows

        a = np.zeros((n, n))
        a[:nx] = affine(
            *(self.call(f"state_derivative{kind}", x, u, s) for kind in ("", "_state_jacobian", "_input_jacobian"))
        )
        if self.observer is not None:
            o = self.observer
            a[nx:first] = affine(o.constant, o.by_state, o.by_input)
            a[nx:first, nx:first] = o.system
        a[first : first + nw, first : first + nw] = system
        friction = np.zeros((n, nf))
        if nf:
            friction[:nx] = self.call("state_derivative_friction_jacobian", x, u, s)
        guards = affine(*(self.call(f"guards{kind}", x, u, s) for kind in ("", "_state_jacobian", "_input_jacobian")))
        bounds = self.call("bounds", x, u, s)
        cuts = np.cumsum([nf, nc, nc, nc])
        speeds, gap, high, low, argument = np.split(guards, cuts)
        half, lower, upper = np.split(bounds, np.cumsum([nc, nl]))
        return Base(a, friction, speeds, gap, high, low, argument, half, np.column_stack([lower, upper]))

    def bases(self, system: Array, output: Array) -> tuple[Base, Ints]:
        """Stacked bases of every combination of contacts and limits, and the place of each in the stack."""
        held = self.count(CONTACT) + self.count(LIMIT)
        found = [self.base(combination, system, output) for combination in product((-1, 0, 1), repeat=held)]
        return Base(*(np.ascontiguousarray(np.stack(parts)) for parts in zip(*found, strict=True))), np.arange(
            len(found)
        )

    @property
    def most_guards(self) -> int:
        """Of any mode, rounded up for vector instructions."""
        count = 2 * (self.count(FRICTION) + self.count(CONTACT) + self.count(LIMIT))
        return max(8, -(-count // 8) * 8)
