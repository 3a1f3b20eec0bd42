"""A reduction that proposes itself: what may be lumped, dropped or made rigid, until the error allowed is spent."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from symdyn.base.errors import NumericalError
from symdyn.base.linear_system import Array, LinearFamily, LinearSystem
from symdyn.numeric.linear.cost import Band, Cost, cost
from symdyn.numeric.linear.drops import rigid, shafts, with_sensor, without
from symdyn.numeric.linear.eigen import poles
from symdyn.numeric.linear.lumps import Lump, lumps
from symdyn.numeric.linear.mode_removal import BalancedOrder, ModeRemoval, balanced_orders, mode_removals
from symdyn.numeric.linear.resolvent import Complex
from symdyn.numeric.linear.response import frequency_response

TOLERANCE = 0.05


@dataclass(frozen=True, slots=True)
class Step:
    """One simplification. ``kind``: "lump" (``what`` takes the sum of ``members``), "zero" (a parameter), "rigid"
    (a shaft). ``alone`` is its cost by itself, ``so_far`` that of all steps up to it.

    ``values``: the parameters that it changes in a file. None where it is no change of values alone: an inertia or an
    inductance at zero, and a rigid shaft, change the order of the model.
    """

    kind: str
    what: str
    members: tuple[str, ...]
    alone: Cost
    so_far: Cost
    values: Mapping[str, float] | None

    @property
    def in_file(self) -> bool:
        return self.values is not None


@dataclass(frozen=True, slots=True)
class Reduction:
    """What was found for one channel, band and tolerance.

    ``zeroed`` and ``rigid``: the cost of each possible drop by itself, cheapest first. ``steps`` is the proposal, with
    ``order`` states and ``parameters`` left of ``full_order`` and ``full_parameters``; ``values`` are the parameter
    values of the part of it that a file can hold, at the cost ``file_cost``. ``unused``: not in the linear model.
    """

    band: Band
    tolerance: float
    input: str
    output: str
    zeroed: tuple[tuple[str, Cost], ...]
    rigid: tuple[tuple[str, Cost], ...]
    lumps: tuple[Lump, ...]
    modes: tuple[ModeRemoval, ...]
    balanced: tuple[BalancedOrder, ...]
    steps: tuple[Step, ...]
    full_order: int
    order: int
    full_parameters: int
    parameters: tuple[str, ...]
    values: Mapping[str, float]
    file_cost: Cost
    unused: tuple[str, ...]


@dataclass(frozen=True, slots=True, eq=False)
class _State:
    """A machine on its way: parameter values, and shafts made rigid."""

    values: Array
    rigid: tuple[str, ...] = ()


class _Search:
    def __init__(self, family: LinearFamily, band: Band, input: str | None, output: str | None) -> None:
        self.family, self.band, self.hertz = family, band, band.hertz()
        nominal = family.nominal
        first = frequency_response(nominal, self.hertz, input, output)
        self.input, self.output, self.exact = first.input, first.output, first.values

    def system(self, state: _State) -> LinearSystem:
        return _system(self.family, state, self.output)

    def response(self, system: LinearSystem) -> Complex:
        return frequency_response(system, self.hertz, self.input, self.output).values

    def cost(self, state: _State) -> Cost:
        try:
            return cost(self.band, self.hertz, self.exact, self.response(self.system(state)))
        except NumericalError:
            return Cost(np.inf, self.band.low, np.inf, np.inf)


def propose(
    family: LinearFamily,
    band: Band,
    tolerance: float = TOLERANCE,
    input: str | None = None,
    output: str | None = None,
    progress: Callable[[str], None] = lambda _: None,
) -> Reduction:
    """Everything that can be taken from the model of one channel, and how far it goes within ``tolerance``.

    ``tolerance`` is the largest |change of G| / |G| in the band that all steps together may cost. Steps are tried
    cheapest first, each computed exactly on top of those before. UsageError for a bad band or an unknown name.
    """
    search = _Search(family, band, input, output)
    channel = {"input": search.input, "output": search.output}
    nominal, derivatives = family.nominal, family.derivatives(family.values)
    used = derivatives.used
    progress("parameters at zero")
    zeroed = _zeroed(search, [name for name, is_used in zip(family.parameters, used, strict=True) if is_used])
    progress("rigid shafts")
    stiff = tuple((a, search.cost(_State(family.values, (a,)))) for a in shafts(nominal))
    progress("parameters that act as one")
    groups = lumps(family, band, tolerance, **channel)
    progress("all together")
    steps, final, in_file = _spend(search, tolerance, zeroed, stiff, groups)
    progress("modes")
    reduced = search.system(final)
    kept = _still_used(family, final, used)
    return Reduction(
        band=band,
        tolerance=tolerance,
        input=search.input,
        output=search.output,
        zeroed=zeroed,
        rigid=tuple(sorted(stiff, key=lambda row: row[1].worst)),
        lumps=groups,
        modes=mode_removals(nominal, band, **channel),
        balanced=balanced_orders(nominal, band, **channel),
        steps=steps,
        full_order=_order(nominal),
        order=_order(reduced),
        full_parameters=sum(used),
        parameters=kept,
        values={
            name: float(new)
            for name, new, old in zip(family.parameters, in_file, family.values, strict=True)
            if new != old
        },
        file_cost=search.cost(_State(in_file)),
        unused=tuple(name for name, is_used in zip(family.parameters, used, strict=True) if not is_used),
    )


def reduced(family: LinearFamily, found: Reduction) -> LinearSystem:
    """The smaller model: all steps of the proposal, those that a file cannot hold among them."""
    values, stiff = family.values, []
    for step in found.steps:
        if step.kind == "rigid":
            stiff.append(step.what)
        else:
            values = _changed(family, values, step.kind, step.what, step.members)
    return _system(family, _State(values, tuple(stiff)), found.output)


def _system(family: LinearFamily, state: _State, output: str) -> LinearSystem:
    system = with_sensor(family.at(state.values), output)
    for address in state.rigid:
        system = rigid(system, address)
    return system


def _zeroed(search: _Search, names: Sequence[str]) -> tuple[tuple[str, Cost], ...]:
    rows = []
    for name in names:
        system = without(search.family, name)
        if system is not None:
            rows.append((name, cost(search.band, search.hertz, search.exact, search.response(system))))
    return tuple(sorted(rows, key=lambda row: row[1].worst))


def _spend(
    search: _Search,
    tolerance: float,
    zeroed: Sequence[tuple[str, Cost]],
    stiff: Sequence[tuple[str, Cost]],
    groups: Sequence[Lump],
) -> tuple[tuple[Step, ...], _State, Array]:
    """Steps taken, the machine after them, and the parameter values after those that a file can hold."""
    possible = [("lump", g.into, g.members, g.cost) for g in groups]
    possible += [("rigid", address, (), c) for address, c in stiff]
    possible += [("zero", name, (name,), c) for name, c in zeroed]
    state, in_file = _State(search.family.values), search.family.values
    unstable = _unstable(search.system(state))
    taken: list[Step] = []
    full = _order(search.system(state))

    def rank(row: tuple[str, str, tuple[str, ...], Cost]) -> tuple[bool, float]:
        """Lumps that leave the order first: they keep what a drop would lose; then by cost."""
        kind, what, members, alone = row
        keeps = kind == "lump" and full == _order(
            search.family.at(_changed(search.family, search.family.values, kind, what, members))
        )
        return not keeps, alone.worst

    for kind, what, members, alone in sorted(possible, key=rank):
        if alone.worst > tolerance:
            continue
        changed = _State(state.values, (*state.rigid, what)) if kind == "rigid" else state
        if kind != "rigid":
            changed = _State(_changed(search.family, state.values, kind, what, members), state.rigid)
            if np.array_equal(changed.values, state.values):
                continue
        so_far = search.cost(changed)
        if so_far.worst > tolerance or _unstable(search.system(changed)) > unstable:
            continue
        keeps_order = kind != "rigid" and _order(search.system(changed)) == _order(search.system(state))
        written = None
        if keeps_order:
            in_file = _changed(search.family, in_file, kind, what, members)
            written = {name: float(in_file[search.family.index(name)]) for name in members}
        taken.append(Step(kind, what, members, alone, so_far, written))
        state = changed
    return tuple(taken), state, in_file


def _changed(family: LinearFamily, values: Array, kind: str, what: str, members: Sequence[str]) -> Array:
    """Parameter values after a lump or a zero."""
    moved = values.copy()
    at = [family.index(name) for name in members]
    moved[at] = 0.0
    if kind == "lump":
        moved[family.index(what)] = values[at].sum()
    return moved


def _order(system: LinearSystem) -> int:
    """How many states the model really has: its finite poles."""
    return sum(2 if pole.imag > 0 else 1 for pole in poles(system).values)


def _unstable(system: LinearSystem) -> int:
    return int(np.count_nonzero(poles(system).values.real > 0))


def _still_used(family: LinearFamily, final: _State, used: Sequence[bool]) -> tuple[str, ...]:
    """Parameters that stand in the reduced model: not zero, and not of a shaft that is rigid."""
    system = family.at(final.values)
    try:
        d = family.derivatives(final.values)
    except NumericalError:  # an inertia is zero where the machine would accelerate: where letters stand stays the same
        d = family.derivatives(family.values)
    kept = []
    for k, name in enumerate(family.parameters):
        if not used[k] or final.values[k] == 0.0:
            continue
        moved = replace(system, e=d.e[k], f=d.f[k], h=d.h[k], c=d.c[k], d=d.d[k])
        for address in final.rigid:
            moved = rigid(moved, address)
        if any(matrix.any() for matrix in (moved.e, moved.f, moved.h, moved.c, moved.d)):
            kept.append(name)
    return tuple(kept)
