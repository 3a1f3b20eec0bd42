"""Which parameters act as one over a band: d_5' = d_4 + d_5 + d_6 + d_7."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np

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
    relative = gradient / exact
    active = [k for k in range(len(family.parameters)) if np.any(relative[k] != 0)]
    found: list[Lump] = []
    for _, same in groupby(sorted(active, key=lambda k: (family.units[k], k)), key=lambda k: family.units[k]):
        left = list(same)
        while len(left) > 1:
            group = _largest(family, band, tolerance, left, relative, exact, hertz, input, output)
            if group is None:
                break
            found.append(_lump(family, nominal, derivatives, group, relative, input))
            left = [k for k in left if family.parameters[k] not in found[-1].members]
    return tuple(sorted(found, key=lambda lump: lump.cost.worst))


@dataclass(frozen=True, slots=True)
class _Found:
    members: tuple[int, ...]
    targets: Mapping[int, Cost]  # the cost of moving the whole group there


def _largest(
    family: LinearFamily,
    band: Band,
    tolerance: float,
    among: Sequence[int],
    relative: Complex,
    exact: Complex,
    hertz: Array,
    input: str | None,
    output: str | None,
) -> _Found | None:
    """The group with the most members that can be moved into one of them."""
    best: _Found | None = None
    for target in among:
        members = [k for k in among if _alike(relative[target], relative[k])]
        # the first to leave is the one whose move costs most
        members.sort(key=lambda k: float(np.abs(family.values[k] * (relative[k] - relative[target])).max()))
        while len(members) > 1 and (best is None or len(members) > len(best.members)):
            costs = {k: _moved(family, band, members, k, exact, hertz, input, output) for k in members}
            if costs[target].worst <= tolerance:
                best = _Found(tuple(sorted(members)), {k: c for k, c in costs.items() if c.worst <= tolerance})
                break
            members.pop()
    return best


def _alike(a: Complex, b: Complex) -> bool:
    dot, aa, bb = float(np.vdot(a, b).real), float(np.vdot(a, a).real), float(np.vdot(b, b).real)
    parallel = dot / np.sqrt(aa * bb)
    return bool(parallel >= PARALLEL and 1 / SAME_SIZE <= dot / aa <= SAME_SIZE)


def _moved(
    family: LinearFamily,
    band: Band,
    members: Sequence[int],
    target: int,
    exact: Complex,
    hertz: Array,
    input: str | None,
    output: str | None,
) -> Cost:
    values = lumped(family.values, members, target)
    return cost(band, hertz, exact, frequency_response(family.at(values), hertz, input, output).values)


def lumped(values: Array, members: Sequence[int], target: int) -> Array:
    """The parameter vector with the members' sum at ``target`` and zero at the others."""
    moved = values.copy()
    moved[list(members)] = 0.0
    moved[target] = values[list(members)].sum()
    return moved


def _lump(
    family: LinearFamily,
    system: LinearSystem,
    derivatives: Derivatives,
    group: _Found,
    relative: Complex,
    input: str | None,
) -> Lump:
    by_cost = sorted(group.targets, key=lambda k: group.targets[k].worst)
    here = _driven(system, input)
    into = next((k for k in by_cost if _acts_on(derivatives, k) == here), by_cost[0])
    others = [k for k in group.members if k != into and family.values[k] != 0]
    cosines = [_cosine(relative[into], relative[k]) for k in others]
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
