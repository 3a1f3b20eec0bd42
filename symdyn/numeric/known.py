"""Parameters of which a recording tells the value: loads that one run has and another has not."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symdyn.base.errors import InputError, Problem
from symdyn.base.wording import quoted
from symdyn.emit.kernel import Kernel
from symdyn.numeric.recording import Recording
from symdyn.spec.records import Quantity, Side

Array = NDArray[np.float64]

MOST = 100  # different values: a load is changed between runs, or a few times in one
APART = 1e-9  # of the effort: by so much it may change with what is fitted
MOVED = 1.1  # times what is fitted, where that is asked


@dataclass(frozen=True, slots=True, eq=False)
class Known:
    """Parameters of a model, and their ``values`` (N, k) along a recording."""

    names: tuple[str, ...]
    values: Array

    def sets(self, p: Array, index: Sequence[int]) -> tuple[Array, NDArray[np.int64]]:
        """(S, np) values of all parameters: ``p`` (np,), but for those known, at ``index``; (N,) which of them hold."""
        distinct, holds = np.unique(self.values, axis=0, return_inverse=True)
        found = np.repeat(p[None, :], len(distinct), axis=0)
        found[:, index] = distinct
        return found, holds.reshape(-1).astype(np.int64)

    def effort(self, kernel: Kernel, motion: tuple[Array, Array, Array], p: Array) -> Array:
        """(N, n) that their values need, more than those in ``p`` do."""
        sets, holds = self.sets(p, [kernel.parameters.index(name) for name in self.names])
        effort = np.zeros_like(motion[0])
        for i, loaded in enumerate(sets):
            rows = holds == i
            here = [np.ascontiguousarray(each[rows]) for each in motion]
            with_it, without = (kernel.rows("inverse_dynamics_p", *here, x) for x in (loaded, p))
            effort[rows] = with_it - without
        return effort


def known_names(recordings: Sequence[Recording]) -> frozenset[str]:
    return frozenset(at for each in recordings for quantity, at, _ in each.channels if quantity is Quantity.PARAMETER)


def known_in(kernel: Kernel, recording: Recording) -> Known | None:
    """Those that the kernel has; None where there are none. Raises InputError (SD537) for one that never stays."""
    names = tuple(name for name in kernel.parameters if name in known_names([recording]))
    if not names:
        return None
    values = np.column_stack([recording.channels[Quantity.PARAMETER, name, Side.LINK] for name in names])
    many = len(np.unique(values, axis=0))
    if many > MOST:
        message = f"recording {quoted(recording.name)} has {many} different values of {', '.join(names)}"
        hint = f"a load that is known is changed a few times (at most {MOST}): round the column, or leave it out"
        raise InputError(Problem("SD537", message, hint=hint))
    return Known(names, values)


def check_separable(known: Known, kernel: Kernel, motion: tuple[Array, Array, Array], own: Sequence[str]) -> None:
    """Raises InputError (SD538) where what known values need depends on parameters that are to be found."""
    p, moved = kernel.values, kernel.values
    moved[[kernel.parameters.index(name) for name in own]] *= MOVED
    one, other = (known.effort(kernel, motion, each) for each in (p, moved))
    if np.max(np.abs(one - other)) > APART * max(float(np.max(np.abs(one))), 1e-300):
        message = f"what {', '.join(known.names)} needs depends on other parameters that are fitted"
        hint = "a known load needs bodies of its own, as the [tool] has: its mass, place and inertia, all of them known"
        raise InputError(Problem("SD538", message, hint=hint))
