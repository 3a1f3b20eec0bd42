"""Which parameters act as one over a band: d_5' = d_4 + d_5 + d_6 + d_7."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np

from symdyn.base.errors import NumericalError
from symdyn.base.linear_system import Array, Derivatives, LinearFamily, LinearSystem
from symdyn.numeric.linear.cost import Band, Cost, cost
from symdyn.numeric.linear.local_sensitivity import response_gradient
from symdyn.numeric.linear.resolvent import Complex
from symdyn.numeric.linear.response import frequency_response
from symdyn.numeric.linear.signals import channel

PARALLEL = 0.8  # cosine between two sensitivities from which it is tried to lump them; the exact cost decides
SAME_SIZE = 1.25  # and how much one of them may be larger per unit


@dataclass(frozen=True, slots=True)
class Lump:
    """``into`` takes the sum of ``members`` (itself among them), the others become zero.

    ``alternatives``: the cost for each member that could take the sum instead, cheapest first. ``parallel`` is the
    smallest cosine between the sensitivities of a member that is not zero and of ``into``.
    """

    into: str
    members: tuple[str, ...]
    value: float
    parallel: float
    cost: Cost
    alternatives: tuple[tuple[str, Cost], ...]


def lumps(
    family: LinearFamily, band: Band, tolerance: float, input: str | None = None, output: str | None = None
) -> tuple[Lump, ...]:
    """Groups of parameters of one unit whose sum can stand for them, at a cost of at most ``tolerance``.

    To first order, moving p_j into p_k changes G by p_j (dG/dp_k - dG/dp_j): candidates are those whose
    sensitivities are parallel, and equal per unit, over the band; each group is then computed exactly. The sum goes to
    the member that acts on the body that the input drives, where it would be measured; else to the cheapest.
    """
    hertz = band.hertz()
    nominal, derivatives = family.nominal, family.derivatives(family.values)
    exact, gradient = response_gradient(nominal, derivatives, channel(nominal, input, output), hertz)
    search = _Search(family, band, tolerance, hertz, exact, gradient / exact, input, output)
    active = [k for k in range(len(family.parameters)) if np.any(search.relative[k] != 0)]
    found: list[Lump] = []
    for _, same in groupby(sorted(active, key=lambda k: (family.units[k], k)), key=lambda k: family.units[k]):
        left = list(same)
        while len(left) > 1:
            group = search.largest(left)
            if group is None:
                break
            found.append(_lump(search, nominal, derivatives, group))
            left = [k for k in left if k not in group.members]
    return tuple(sorted(found, key=lambda lump: lump.cost.worst))


@dataclass(frozen=True, slots=True)
class _Group:
    """Numbers of parameters, and the cost of moving them all into one of them, where that is allowed."""

    members: tuple[int, ...]
    targets: Mapping[int, Cost]


@dataclass(frozen=True, slots=True, eq=False)
class _Search:
    """``exact`` (N,) is G on the band's grid ``hertz``, ``relative`` (np, N) is dG/dp / G."""

    family: LinearFamily
    band: Band
    tolerance: float
    hertz: Array
    exact: Complex
    relative: Complex
    input: str | None
    output: str | None

    def largest(self, among: Sequence[int]) -> _Group | None:
        """The group with the most members that can be moved into one of them."""
        best: _Group | None = None
        for target in among:
            members = [k for k in among if _alike(self.relative[target], self.relative[k])]
            # the first to leave is the one whose move costs most
            members.sort(key=lambda k, t=target: self.estimate(k, t))  # type: ignore[misc]
            while len(members) > 1 and (best is None or len(members) > len(best.members)):
                costs = {k: self.cost(members, k) for k in members}
                if costs[target].worst <= self.tolerance:
                    allowed = {k: c for k, c in costs.items() if c.worst <= self.tolerance}
                    best = _Group(tuple(sorted(members)), allowed)
                    break
                members.pop()
        return best

    def estimate(self, member: int, target: int) -> float:
        """The cost of moving one, to first order."""
        change = self.family.values[member] * (self.relative[member] - self.relative[target])
        return float(np.abs(change).max())

    def cost(self, members: Sequence[int], target: int) -> Cost:
        """Infinite where the machine would accelerate without inertia."""
        try:
            system = self.family.at(lumped(self.family.values, members, target))
        except NumericalError:
            return Cost(np.inf, self.band.low, np.inf, np.inf)
        simpler = frequency_response(system, self.hertz, self.input, self.output).values
        return cost(self.band, self.hertz, self.exact, simpler)


def _alike(a: Complex, b: Complex) -> bool:
    longer = float(np.vdot(a, b).real / np.vdot(a, a).real)
    return _cosine(a, b) >= PARALLEL and 1 / SAME_SIZE <= longer <= SAME_SIZE


def lumped(values: Array, members: Sequence[int], target: int) -> Array:
    """The parameter vector with the members' sum at ``target`` and zero at the others."""
    moved = values.copy()
    moved[list(members)] = 0.0
    moved[target] = values[list(members)].sum()
    return moved


def _lump(search: _Search, system: LinearSystem, derivatives: Derivatives, group: _Group) -> Lump:
    family = search.family
    by_cost = sorted(group.targets, key=lambda k: group.targets[k].worst)
    here = _driven(system, search.input)
    into = next((k for k in by_cost if _acts_on(derivatives, k) == here), by_cost[0])
    others = [k for k in group.members if k != into and family.values[k] != 0]
    cosines = [_cosine(search.relative[into], search.relative[k]) for k in others]
    return Lump(
        into=family.parameters[into],
        members=tuple(family.parameters[k] for k in group.members),
        value=float(family.values[list(group.members)].sum()),
        parallel=min(cosines, default=1.0),
        cost=group.targets[into],
        alternatives=tuple((family.parameters[k], group.targets[k]) for k in by_cost),
    )


def _cosine(a: Complex, b: Complex) -> float:
    return float(np.vdot(a, b).real / np.sqrt(np.vdot(a, a).real * np.vdot(b, b).real))


def _driven(system: LinearSystem, input: str | None) -> frozenset[int]:
    """Rows of motion that the input pushes, directly or through a hidden state, as rows of the whole system."""
    n = len(system.coordinates)
    column = system.h[:, system.inputs.index(input) if input is not None else 0]
    rows = set(np.flatnonzero(column[n : 2 * n]))
    for i in np.flatnonzero(column[2 * n :]):
        rows |= set(np.flatnonzero(system.f[n : 2 * n, 2 * n + i]))
    return frozenset(n + int(r) for r in rows)


def _acts_on(d: Derivatives, k: int) -> frozenset[int]:
    """Rows (of the whole system) in which the parameter stands."""
    rows = np.any(d.f[k] != 0, axis=1) | np.any(d.e[k] != 0, axis=1)
    return frozenset(int(r) for r in np.flatnonzero(rows))
