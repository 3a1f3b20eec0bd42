"""What propagation needs of B machines and their inputs: affine systems and modes, made as they are met."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.hybrid.affine_modes import Base, Modes, room
from symdyn.numeric.hybrid.exponential import growth_rate
from symdyn.numeric.hybrid.machine import CONTACT, FRICTION, LIMIT, Machine

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

LOCATED = 1e-11  # s, to which events are located
FEWEST, MOST = 20, 45  # halvings of a step down to that
LONGEST = 64.0  # of a step, over the machine's fastest time
MOST_STEPS = 10_000_000  # between reports


@dataclass
class Bases:
    """Affine systems (B, K, ...) of B sets in the K combinations of contacts and limits that were met."""

    machine: Machine
    systems: Array  # (B, m, m) of the exosystems
    outputs: Array  # (B, nu, m)
    parameters: Array  # (B, np)
    stacked: Base
    known: Ints  # (K,) numbers of the combinations, -1 where there is room

    @classmethod
    def make(
        cls, machine: Machine, systems: Array, outputs: Array, parameters: Array, known: tuple[int, ...] = ()
    ) -> Bases:
        """With all contacts open and no limit reached, with all on their upper side, and with those ``known``."""
        switches = machine.count(CONTACT) + machine.count(LIMIT)
        inside = sum(3**k for k in range(switches))
        first = machine.base(inside, systems, outputs, parameters)
        empty = Base(*(part[:, None] for part in first))
        bases = cls(machine, systems, outputs, parameters, empty, np.array([inside]))
        if switches:
            bases.add(2 * inside)
        for number in known:
            if number not in bases.known:
                bases.add(number)
        return bases

    def add(self, number: int) -> None:
        base = self.machine.base(number, self.systems, self.outputs, self.parameters)
        free = np.flatnonzero(self.known < 0)
        if not len(free):
            self.known = np.concatenate([self.known, np.full(len(self.known), -1)])
            self.stacked = Base(*(np.concatenate([part, np.zeros_like(part)], axis=1) for part in self.stacked))
            free = np.flatnonzero(self.known < 0)
        for part, new in zip(self.stacked, base, strict=True):
            part[:, free[0]] = new
        self.known[free[0]] = number

    def steps(self, length: float) -> Ints:
        """(B,) into how many steps of propagation a time is divided."""
        return np.array([self._steps(a[:2], length) for a in self.stacked.a], np.int64)

    @staticmethod
    def _steps(matrices: Array, length: float) -> int:
        fastest = max(growth_rate(a) for a in matrices)
        return max(1, math.ceil(min(length * fastest / LONGEST, 2.0 * MOST_STEPS))) if math.isfinite(fastest) else 1

    def room(self, modes: int, levels: int) -> Modes:
        """Empty storage for modes of one set."""
        signals = self.systems.shape[1]
        machine, one = self.machine, self.machine.size + signals
        return room(modes, levels, machine.width(signals), one, machine.count(FRICTION), machine.most_guards)


def divided(first: float, last: float, step: float) -> tuple[int, float]:
    """Into how many reports a stretch is divided, and their spacing: to 12 digits, so that equal ones share modes."""
    count = max(1, round((last - first) / step))
    return count, float(f"{(last - first) / count:.12e}")


def levels_of(horizon: float) -> int:
    """How many halvings locate events in a step."""
    return min(MOST, max(FEWEST, 1 + math.ceil(math.log2(horizon / LOCATED))))


def roomier(modes: Modes) -> Modes:
    """Twice the storage, with the modes that are made already."""
    old, size = len(modes.codes), modes.bounds.shape
    grown = room(2 * old, modes.step.shape[1], size[1], modes.one, modes.sigma.shape[1], size[2])
    grown.made[:] = modes.made
    for new, part in zip(grown[2:], modes[2:], strict=True):
        new[:old] = part
    return grown
