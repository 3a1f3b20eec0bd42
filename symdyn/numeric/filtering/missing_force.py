"""The force that is missing at a place, for plots: estimated by a filter to which no law of it was told."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from symdyn.numeric.filtering.judged import WORTH, Explanation
from symdyn.numeric.filtering.likelihood import MLFit
from symdyn.numeric.filtering.locate import Place
from symdyn.numeric.filtering.model import Model, with_latent
from symdyn.numeric.filtering.places import Latent, latent_at
from symdyn.numeric.findings import Finding, MissingForce

MOST = 3  # places


def missing_forces(
    as_given: Model, model: Model, final: Explanation, places: Sequence[Place], findings: Sequence[Finding]
) -> tuple[MissingForce, ...]:
    """At the places of the findings, or where nothing was found at the likeliest one; of what moves, not of circuits.

    Beyond the diagnosed ``model``, too, a filter expects a force as large as beyond the model ``as_given``.
    """
    told = list(dict.fromkeys(finding.place for finding in findings))
    likely = [place for place in places if place.gain > WORTH and place.latent.motion.any()]
    if not findings:
        told = [place.latent.place for place in likely[:1]]
    found: list[MissingForce] = []
    for address in told:
        place = next((each for each in likely if each.latent.place == address), None)
        same = latent_at(model.latents, address)
        if place is not None and same is not None and len(found) < MOST:
            found.append(_at(as_given, place, model, same, final.fit))
    return tuple(force for force in found if np.all(np.isfinite([force.before, force.after])))  # none lost its way


def _at(as_given: Model, place: Place, model: Model, same: Latent, final: MLFit) -> MissingForce:
    bench, kernel = place.fit.bench, as_given.kernel
    n = len(kernel.coordinates)
    states = as_given.bench(as_given.heldout, bench.noise, bench.between).filtered(place.fit.p).states
    noise = with_latent(final.bench.noise, same, float(bench.noise.power[-1]))
    decay = np.append(noise.decay[:-1], bench.noise.decay[-1])
    after = model.bench(model.heldout, replace(noise, decay=decay), final.bench.between).filtered(final.p).states
    first, pushed = (int(np.flatnonzero(each)[0]) for each in (place.latent.motion, place.latent.direction))
    return MissingForce(
        place=place.latent.place,
        what="twist" if np.count_nonzero(place.latent.motion) > 1 else "position",
        x=states[:, :n] @ place.latent.motion,
        v=states[:, n : 2 * n] @ place.latent.motion,
        before=states[:, -1],
        after=after[:, -1],
        units=(kernel.state_units[first], kernel.parameter_units[pushed]),
    )
