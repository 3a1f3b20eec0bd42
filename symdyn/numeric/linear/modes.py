"""Modes by their energy: which inertias move against each other, which shaft holds the strain, what takes the energy.

For the motion v exp(pole t) the energy is h exp(2 Re(pole) t), and what each damper takes of it adds up exactly:
-Re(pole) = (sum of the losses) / (2 h).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from symdyn.base.linear_system import Array, LinearSystem
from symdyn.numeric.linear.eigen import Poles, poles
from symdyn.numeric.linear.resolvent import Complex
from symdyn.numeric.linear.signals import short_names

NAMED = 0.05  # share of the kinetic energy from which an inertia is named
OTHER = "other"  # stiffness and damping that no single effect has: gravity, coupling of the arm, control
_SMALLEST = 1e-9
_ROUNDING = 1e-12


@dataclass(frozen=True, slots=True, eq=False)
class Mode:
    """One pole, or a conjugate pair; a real pole has |damping| = 1, the origin frequency 0 and damping 0.

    ``kinetic`` (by coordinate), ``strain`` (by place) and ``hidden`` (by state) are shares of the energy;
    together they add up to 1. ``losses`` (by place or state) are shares of ``decay``, in 1/s: they add up to it.
    ``shape`` is the motion of each coordinate, that with the largest kinetic energy being 1.
    """

    name: str
    pole: complex
    frequency: float  # |pole| in Hz
    damping: float
    decay: float
    kinetic: Mapping[str, float]
    strain: Mapping[str, float]
    hidden: Mapping[str, float]
    losses: Mapping[str, float]
    shape: Mapping[str, complex]
    condition: float


def modes(system: LinearSystem, found: Poles | None = None) -> tuple[Mode, ...]:
    """Slowest first, one for each pole or conjugate pair."""
    eigen = poles(system) if found is None else found
    columns = zip(eigen.values, eigen.right.T, eigen.condition, strict=True)
    return tuple(_mode(system, complex(p), v, float(c)) for p, v, c in columns)


def _mode(system: LinearSystem, pole: complex, v: Complex, condition: float) -> Mode:
    n = len(system.coordinates)
    displaced, moving, hidden = v[:n], v[n : 2 * n], v[2 * n :]
    kinetic = np.real(moving.conj() * (system.e[n : 2 * n, n : 2 * n] @ moving)) / 2
    stiffness = -system.f[n : 2 * n, :n]
    damping = -system.f[n : 2 * n, n : 2 * n]
    strain: dict[str, float] = {}
    losses: dict[str, float] = {}
    for element in system.elements:
        stiffness = stiffness - element.stiffness * np.outer(element.lever, element.lever)
        damping = damping - element.damping * np.outer(element.lever, element.lever)
        _add(strain, element.address, element.stiffness * float(abs(element.lever @ displaced)) ** 2 / 2)
        _add(losses, element.address, element.damping * float(abs(element.lever @ moving)) ** 2)
    stiffness = _without_rounding(stiffness, system.f[n : 2 * n, :n])
    damping = _without_rounding(damping, system.f[n : 2 * n, n : 2 * n])
    _add(strain, OTHER, float(np.real(displaced.conj() @ stiffness @ displaced)) / 2)
    circulating = (stiffness - stiffness.T) / 2
    _add(losses, OTHER, float(np.real(moving.conj() @ (damping @ moving + circulating @ displaced))))
    stored, lost = _of_hidden(system, hidden)
    losses |= lost
    energy = float(kinetic.sum()) + sum(strain.values()) + sum(stored.values())
    size = abs(pole)
    whole = float(np.abs(kinetic).sum()) + sum(map(abs, (*strain.values(), *stored.values()))) if size else 0.0
    share = _shares(kinetic, whole)
    names = dict(zip(system.coordinates, share, strict=True))
    strain, stored = _divided(strain, whole), _divided(stored, whole)
    shape = _normalised(displaced if size == 0.0 else moving, kinetic)
    return Mode(
        name=_name(system, pole, shape, share, stored),
        pole=pole,
        frequency=size / (2 * np.pi),
        damping=-pole.real / size if size else 0.0,
        decay=-pole.real + 0.0,
        kinetic=names,
        strain=strain,
        hidden=stored,
        losses=_divided(losses, 2 * energy) if size and abs(energy) > _SMALLEST * whole else {},
        shape={name: complex(entry) for name, entry in zip(system.coordinates, shape, strict=True)},
        condition=condition,
    )


def _of_hidden(system: LinearSystem, hidden: Complex) -> tuple[dict[str, float], dict[str, float]]:
    """Energy and loss of each hidden state, weighted so that what it gives to the motion the motion gets.

    For a motor with K_T = K_E that is L |I|^2 / 2 and R |I|^2. A state that is not driven back by the
    motion stores nothing: it is an input.
    """
    n = len(system.coordinates)
    stored, lost = {}, {}
    for k, amplitude in enumerate(hidden):
        i = 2 * n + k
        pushes, driven = system.f[n : 2 * n, i], system.f[i, n : 2 * n]
        square = float(driven @ driven)
        weight = -float(pushes @ driven) / square if square else 0.0
        stored[system.states[i]] = weight * system.e[i, i] * abs(amplitude) ** 2 / 2
        lost[system.states[i]] = -weight * system.f[i, i] * abs(amplitude) ** 2
    return stored, lost


def _without_rounding(rest: Array, of: Array) -> Array:
    """What is left of a difference, without what is left of rounding: a rigid motion is large beside its rates."""
    return np.where(np.abs(rest) > _ROUNDING * np.abs(of).max(initial=0.0), rest, 0.0)


def _add(table: dict[str, float], address: str, value: float) -> None:
    table[address] = table.get(address, 0.0) + float(value)


def _shares(values: Array, whole: float) -> list[float]:
    return [float(v) for v in (values / whole if whole else np.zeros_like(values))]


def _divided(table: dict[str, float], by: float) -> dict[str, float]:
    found = {name: float(value / by) if by else 0.0 for name, value in table.items()}
    return {name: value for name, value in found.items() if name != OTHER or abs(value) > _SMALLEST}


def _normalised(motion: Complex, kinetic: Array) -> Complex:
    first = int(np.argmax(np.abs(kinetic) if np.any(kinetic) else np.abs(motion))) if len(motion) else 0
    return motion / motion[first] if len(motion) and motion[first] != 0 else motion


def _name(
    system: LinearSystem, pole: complex, shape: Complex, kinetic: list[float], hidden: Mapping[str, float]
) -> str:
    short = short_names(system.coordinates)
    if pole == 0:
        return f"free motion of {_listed([s for s, x in zip(short, shape, strict=True) if abs(x) > NAMED])}"
    if sum(map(abs, hidden.values())) > 0.5:
        most = max(hidden, key=lambda name: abs(hidden[name]))
        return f"{most} settling"
    total = sum(map(abs, kinetic)) or 1.0
    ahead: list[str] = []
    behind: list[str] = []
    for i in sorted(range(len(kinetic)), key=lambda i: -abs(kinetic[i])):
        if abs(kinetic[i]) >= NAMED * total:
            (ahead if shape[i].real >= 0 else behind).append(short[i])
    if not behind:
        together = "" if len(ahead) == 1 else " together"
        way = "" if pole.imag else " slowing down" if pole.real < 0 else " running away"
        return f"{_listed(ahead)}{together}{way}"
    return f"{_listed(ahead)} against {_listed(behind)}"


def _listed(names: list[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}" if names else "nothing"
