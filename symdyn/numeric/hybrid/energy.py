"""Energy book-keeping: what was supplied, dissipated and stored along a trajectory, element by element."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symdyn.base.errors import InputError, Problem
from symdyn.numeric.hybrid.machine import CONTACT, Machine
from symdyn.numeric.hybrid.samples import due_at, samples, updated
from symdyn.numeric.hybrid.signals import Signal
from symdyn.numeric.hybrid.spans import divided_at, mode_of, settled, spans
from symdyn.numeric.hybrid.trajectory import CLOSE, HybridTrajectory
from symdyn.numeric.hybrid.work import worker

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class EnergyBalance:
    """Energies in J at ``time`` (N,), a column for each element by name.

    ``supplied`` and ``dissipated`` count from the first time on, ``stored`` is what is held. ``lost`` is the strain
    that contacts take away: flanks open when they would pull, which is before the spring behind them is slack.
    """

    time: Array
    supplied: Mapping[str, Array]
    dissipated: Mapping[str, Array]
    lost: Mapping[str, Array]
    stored: Mapping[str, Array]

    @property
    def residual(self) -> Array:
        """(N,) supplied - dissipated - lost - growth of stored: what the trajectory does not account for."""
        stored = self._sum(self.stored)
        gone = self._sum(self.dissipated) + self._sum(self.lost)
        return np.asarray(self._sum(self.supplied) - gone - (stored - stored[0]))

    @property
    def closure(self) -> float:
        """The largest residual, over the largest of the sums; 0 where no energy moves."""
        sums = (self.supplied, self.dissipated, self.lost, self.stored)
        largest = max(float(np.abs(self._sum(part)).max()) for part in sums)
        return float(np.abs(self.residual).max()) / largest if largest else 0.0

    def table(self) -> Mapping[str, Array]:
        """Columns by name for a CSV file: "time [s]", "dissipated axis1.motor.viscous_friction [J]", ..."""
        columns = {"time [s]": self.time}
        for what in ("supplied", "dissipated", "lost", "stored"):
            columns |= {f"{what} {name} [J]": values for name, values in getattr(self, what).items()}
        return columns | {"residual [J]": self.residual}

    def _sum(self, part: Mapping[str, Array]) -> Array:
        return np.asarray(sum(part.values(), np.zeros(len(self.time))))


def energy_balance(machine: Machine, trajectory: HybridTrajectory, signals: Sequence[Signal]) -> EnergyBalance:
    """Book the energy of a trajectory of ``machine`` under ``signals``, one per input, as it was simulated.

    Powers are integrated in the mode that holds between events, not on the grid of reporting times: exactly
    where the machine is affine in every mode, to 1e-11 of the state elsewhere. At each reporting time the book
    goes on from the reported state, so that errors of the trajectory show in the residual.

    Raises InputError (SD302) where the number of signals, or the states, are not the machine's.
    """
    kernel, module = machine.kernel, machine.kernel.module
    if len(signals) != len(kernel.inputs) or trajectory.states.shape[1] != len(kernel.states):
        raise InputError(Problem("SD302", "the trajectory, or the number of signals, is not this machine's"))
    kinds = tuple(module.SWITCH_KINDS)
    contacts = [k for k, kind in enumerate(kinds) if kind == CONTACT]
    rows, work, time = len(trajectory.time), worker(machine, signals), trajectory.time
    close = CLOSE * float(time[1] - time[0])
    instants, sampled = samples(machine.clocks, float(time[0]), float(time[-1]), closed=True), float(time[0])
    x = np.array(trajectory.states[0])
    powers = len(module.SUPPLIED) + len(module.DISSIPATED)
    booked, lost = np.zeros((rows, powers)), np.zeros((rows, len(contacts)))
    modes = np.zeros((rows, len(kinds)))
    total, gone = np.zeros(powers), np.zeros(len(contacts))
    switches: tuple[int, ...] | None = None
    for span in divided_at(instants[0], spans(trajectory, machine.switches, kinds), close):
        due = due_at(instants, span.first, close)
        if len(due) and span.first > sampled + close:
            x, sampled = updated(machine, x, signals, span.first, due), span.first
        if span.switches != switches:
            u = np.array([signal.piece_at(span.begun).at(np.array(span.first)) for signal in signals], np.float64)
            x = settled(machine, span.switches, x, u)
            if switches is None:
                modes[0] = mode_of(span.switches)
            else:
                gone += _losses(machine, contacts, switches, span.switches, x, u)
            switches = span.switches
        x, done = work(x, span)
        total += done
        if span.row is not None:
            booked[span.row], lost[span.row], modes[span.row] = total, gone, mode_of(span.switches)
            x, sampled = np.array(trajectory.states[span.row]), span.last  # reported right after the sample
    stored = machine.rows("stored_energy", trajectory.states, np.ascontiguousarray(trajectory.inputs), modes)
    cut = len(module.SUPPLIED)
    return EnergyBalance(
        trajectory.time,
        _by_name(module.SUPPLIED, booked[:, :cut]),
        _by_name(module.DISSIPATED, booked[:, cut:]),
        _by_name([machine.switches[k] for k in contacts], lost),
        _by_name(module.STORED, stored),
    )


def _losses(
    machine: Machine, contacts: Sequence[int], before: Sequence[int], after: Sequence[int], x: Array, u: Array
) -> Array:
    """What each contact that changes takes out of the store, one after the other."""
    found = np.zeros(len(contacts))
    s, new = mode_of(before), mode_of(after)
    for c, k in enumerate(contacts):
        if s[k] != new[k]:
            held = machine.call("stored_energy", x, u, s).sum()
            s[k] = new[k]
            found[c] = held - machine.call("stored_energy", x, u, s).sum()
    return found


def _by_name(names: Sequence[str], columns: Array) -> Mapping[str, Array]:
    return dict(zip(names, columns.T, strict=True))
