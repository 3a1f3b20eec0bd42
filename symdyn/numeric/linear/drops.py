"""Parts of a machine taken away exactly: a parameter at zero, a shaft made rigid."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from symdyn.base.errors import NumericalError
from symdyn.base.linear_system import LinearFamily, LinearSystem


def without(family: LinearFamily, parameter: str) -> LinearSystem | None:
    """The machine with the parameter at zero; None where its equations divide by it.

    An inertia or an inductance at zero is an exact limit, not a small number: its equation has no derivative left.
    """
    values = family.values.copy()
    values[family.index(parameter)] = 0.0
    try:
        return family.at(values)
    except NumericalError:
        return None


def shafts(system: LinearSystem) -> tuple[str, ...]:
    """Places with a spring between two coordinates: what may be made rigid."""
    found = dict.fromkeys(e.address for e in system.elements if e.stiffness > 0 and np.count_nonzero(e.lever) > 1)
    return tuple(found)


def rigid(system: LinearSystem, address: str) -> LinearSystem:
    """The machine with a spring of infinite stiffness at the place: its two sides move as one.

    The coordinate nearest to the start of the chain is expressed by the others; it and its rate are states no more,
    and forces on it act on them (d'Alembert). Raises KeyError where no element has this place.
    """
    element = next((e for e in system.elements if e.address == address), None)
    if element is None:
        raise KeyError(address)
    n = len(system.coordinates)
    gone = int(np.flatnonzero(element.lever)[0])
    kept = [i for i in range(n) if i != gone]
    joined = np.eye(n)
    joined[gone] = -element.lever / element.lever[gone]
    joined = joined[:, kept]
    size = len(system.states)
    spread = np.zeros((size, size - 2))
    spread[:n, : n - 1] = joined
    spread[n : 2 * n, n - 1 : 2 * (n - 1)] = joined
    spread[2 * n :, 2 * (n - 1) :] = np.eye(size - 2 * n)
    rows = spread.T.copy()
    rows[: n - 1] = np.eye(size)[kept]  # dq/dt = qd is no balance of forces
    states = [i for i in range(size) if i not in (gone, n + gone)]
    return replace(
        system,
        e=rows @ system.e @ spread,
        f=rows @ system.f @ spread,
        h=rows @ system.h,
        c=system.c @ spread,
        coordinates=tuple(system.coordinates[i] for i in kept),
        states=tuple(system.states[i] for i in states),
        state_units=tuple(system.state_units[i] for i in states),
        drift=system.drift[states],
        elements=tuple(replace(e, lever=e.lever @ joined) for e in system.elements if e.address != address),
    )


def with_sensor(system: LinearSystem, output: str) -> LinearSystem:
    """The system with a state as one more sensor, so that it can still be seen when the state is gone."""
    if output not in system.states or output in system.outputs:
        return system
    i = system.states.index(output)
    return replace(
        system,
        c=np.vstack([system.c, np.eye(len(system.states))[i]]),
        d=np.vstack([system.d, np.zeros(len(system.inputs))]),
        outputs=(*system.outputs, output),
        output_units=(*system.output_units, system.state_units[i]),
    )
