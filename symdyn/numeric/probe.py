"""A probe: one joint that carries every candidate effect, whose kernel tells the law of each along any motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from symdyn.base import symbols
from symdyn.compiler import parametric_kernel, robot_from_text
from symdyn.emit.kernel import Kernel
from symdyn.numeric.candidates import Candidate
from symdyn.numeric.memory import remembered
from symdyn.numeric.observation import Observation
from symdyn.numeric.swinging import started
from symdyn.physics import catalogue
from symdyn.physics.effect import Effect
from symdyn.spec.edit import add_effect
from symdyn.spec.records import Motion, PlaceKind, Robot

Array = NDArray[np.float64]

JOINT = "joint"
_TEXT = """[robot]
name = "{name}"
gravity = [0, 0, 0]

[dh]
rows = [{row}]

[[joint]]
name = "joint"
link = {{ {body} }}
"""
_BARE = {
    Motion.ROTATIONAL: _TEXT.format(name="probe-that-turns", row='["q", 0, 0, 0]', body="inertia = { zz = 1 }"),
    Motion.TRANSLATIONAL: _TEXT.format(name="probe-that-slides", row='[0, "q", 0, 0]', body="mass = 1"),
}


@dataclass(frozen=True, slots=True)
class Probe:
    """An effect in the coordinates of one joint alone knows nothing of the robot around it.

    So small kernels for all robots hold their laws; they are compiled once on a machine.
    """

    kernel: Kernel
    memory: frozenset[str]  # effects with hidden states
    swings: bool  # its one effect has several, which act on one another
    _index: Mapping[str, int] = field(repr=False)

    def force(
        self, effect: str, values: Mapping[str, float], seen: Observation, joint: int, load: Array | None = None
    ) -> Array:
        """(N,) effort that the joint must exert against the effect with these parameters, along the motion.

        The probe has an inertia of one, and nothing else: a ``load`` (N,) in the place of the acceleration is the load
        of its joint.
        """
        p = self._numbers(effect, values)
        q, qd, qdd = (np.ascontiguousarray(a[:, [joint]]) for a in (seen.q, seen.qd, seen.qdd))
        qdd = qdd if load is None else load[:, None]
        required = self.kernel.rows("inverse_dynamics_p", q, qd, qdd, p) - qdd
        if effect in self.memory:
            required -= remembered(self.kernel, q, qd, seen.time, seen.segments, p, self.swings)
        return required[:, 0]

    def starts(self, effect: str, values: Mapping[str, float], seen: Observation) -> Array:
        """(N, m) the same because of how its states began, one of them in one stretch at a time; m = 0 for most."""
        if not self.swings:
            return np.zeros((len(seen.time), 0))
        return -started(self.kernel, seen.time, seen.segments, self._numbers(effect, values))[:, 0]

    def _numbers(self, effect: str, values: Mapping[str, float]) -> Array:
        p = self.kernel.values.copy()
        for name, value in values.items():
            if f"{JOINT}_{effect}_{name}" in self._index:  # a whole number is no parameter
                p[self._index[f"{JOINT}_{effect}_{name}"]] = value
        return p


Key = tuple[Motion, str, tuple[tuple[str, float], ...]]  # kind of motion; an effect that is alone, its whole numbers


def key_of(candidate: Candidate) -> Key:
    """The probe that holds a candidate's law."""
    alone = _is_alone(catalogue()[candidate.effect])
    return candidate.place.motion, candidate.effect if alone else "", candidate.counts


def _is_alone(effect: Effect) -> bool:
    """Whether it has a probe of its own: with whole numbers it is several laws, and of states that act on one another
    others would make a larger system.
    """
    return _swings(effect) or any(schema.is_count for schema in effect.parameters)


def _swings(effect: Effect) -> bool:
    return len(effect.hidden_states({p.name: symbols.local(p.name) for p in effect.parameters})) > 1


def probes(proposed: Sequence[Candidate]) -> dict[Key, Probe]:
    """One for each kind of motion that occurs. All proposable effects are in it, so that it is always the same.

    But those that have one of their own, for every choice of their whole numbers.
    """
    return {key: _probe(*key) for key in dict.fromkeys(key_of(c) for c in proposed)}


def _probe(motion: Motion, effect: str, counts: tuple[tuple[str, float], ...]) -> Probe:
    robot = _loaded(motion, effect, dict(counts))
    kernel = parametric_kernel(robot)
    remembering = {e.type for e in robot.effects if type(catalogue()[e.type]).rates is not Effect.rates}
    index = {name: i for i, name in enumerate(kernel.parameters)}
    return Probe(kernel, frozenset(remembering), bool(effect) and _swings(catalogue()[effect]), index)


def _loaded(motion: Motion, alone: str, counts: Mapping[str, float]) -> Robot:
    text = _BARE[motion]
    for effect in [catalogue()[alone]] if alone else catalogue().values():
        if not effect.proposable or PlaceKind.JOINT not in effect.attaches_to or motion not in effect.motions:
            continue
        if effect.reference_unit() is not None or (not alone and _is_alone(effect)):
            continue
        values = {}
        for schema in effect.parameters:
            value = schema.default if schema.null is None else schema.null
            value = counts.get(schema.name, 1.0 if value is None else value)
            values[schema.name] = f"{value} {schema.units[motion]}".removesuffix(" 1")
        text = add_effect(text, effect.identifier, JOINT, values)
    return robot_from_text(text, "probe.toml")
