"""What a force that is left follows: the motion, so that it is no noise; the variable of a law, which it refutes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.filtering.judged import Explanation
from symdyn.numeric.filtering.model import Model
from symdyn.numeric.filtering.places import Latent
from symdyn.numeric.filtering.when import conditions, motion_of, when
from symdyn.numeric.groups import same_place
from symdyn.physics import law_variables

Array = NDArray[np.float64]

FOLLOWS = 0.25  # of an unknown force's power, on data that its law was not learnt from: half of its size
FOLLOWED = {  # by an unknown force, in the words of its conditions
    "sign of speed": "speed",
    "low speed": "speed",
    "speed": "speed",
    "position": "position",
    "angle": "position",
}
WORDS = {name: f"{variable} of {{}}" for name, variable in FOLLOWED.items()}  # of a place
WORDS |= {"reversal": "way since a reversal of {}", "time": "time"}


def refuted(model: Model, of: Explanation) -> tuple[tuple[str, str], ...]:
    """Findings whose law does not hold, by their labels, and the variable that the force that is left there follows.

    A force that follows something else is another effect, and refutes nothing.
    """
    told = []
    for j, latent in _unknown(model, of):
        here = same_place(model.robot, latent.place)
        own = [(c.label, law_variables(c.effect)) for c, _ in of.found if c.place.address in here]
        variable = _followed(model, of, latent, j) if own and latent.motion.any() else None
        told += [(label, variable) for label, variables in own if variable is not None and variable in variables]
    return tuple(told)


def left_to_follow(model: Model, of: Explanation) -> tuple[str | None, str | None]:
    """The first place at which a force that is left follows the motion, and what it follows most there."""
    for latent in model.latents:
        told = when(model, of, latent)
        if told:
            word = WORDS.get(told[0].partition(" order")[0])  # what is always there follows nothing
            return latent.place, word.format(latent.place) if word else None
    return None, None


def _unknown(model: Model, of: Explanation) -> list[tuple[int, Latent]]:
    """The unknown forces of a fit: which of its noises, and where."""
    noise = of.fit.bench.noise
    return [
        (j, latent)
        for j in range(noise.inputs, len(noise.power))
        for latent in model.latents
        if np.array_equal(latent.direction, noise.directions[:, j])
    ]


def _followed(model: Model, of: Explanation, latent: Latent, which: int) -> str | None:
    """The variable by which most of an unknown force is told on held-out data, once learnt on training data."""
    first, second = of.fit.bench, model.bench(model.heldout, of.fit.bench.noise, of.fit.bench.between)
    n, p = len(model.kernel.states) + which, of.fit.p
    learnt, checked = (bench.filtered(p).states[:, n] for bench in (first, second))
    motion = motion_of(first, p, latent, None)
    cells, others = conditions(motion, motion), conditions(motion_of(second, p, latent, motion.top), motion)
    best, name = FOLLOWS, None
    for condition, columns in cells.items():
        law = np.linalg.lstsq(columns, learnt, rcond=None)[0]
        left = checked - others[condition] @ law
        told = 1.0 - float(np.sum(left**2)) / max(float(np.sum((checked - checked.mean()) ** 2)), 1e-300)
        if told > best:
            best, name = told, condition
    return FOLLOWED.get(name.partition(" order")[0]) if name else None
