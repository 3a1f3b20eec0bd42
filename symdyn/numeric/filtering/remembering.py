"""Laws with memory, fitted where they promise most: whether one explains more than any effect without states does."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from symdyn.numeric.filtering.bench import FilterBench
from symdyn.numeric.filtering.budget import allowed
from symdyn.numeric.filtering.hypotheses import WARMING
from symdyn.numeric.filtering.judged import (
    EARNS,
    LEVEL,
    LIKELY,
    WORTH,
    Explanation,
    Step,
    certain,
    nothing_left,
    price_of,
    simplest,
    worth,
)
from symdyn.numeric.filtering.memory import Lasting
from symdyn.numeric.filtering.memory_fits import with_memory
from symdyn.numeric.filtering.model import Model
from symdyn.numeric.filtering.places import latent_at
from symdyn.numeric.filtering.travel import travel
from symdyn.numeric.recording import Recording

Progress = Callable[[str], None]
Recordings = tuple[Recording, Recording]
Laws = tuple[tuple[Model, Step], ...]  # the chosen one first, each with its own machine

NUMBERS = 2  # of a loop: how large, and within which distance
PLACES = 2  # for each kind of memory, at which its laws are fitted until one earns its place
EXPECTED = 0.5  # of the best effect's expected gain: a loop that promises less is not worth a compilation


def promised(model: Model, found: Sequence[Lasting]) -> float:
    """Nats that a memory is expected to gain beyond what the same friction without one does; 0 if not its price."""
    return max((each.beyond for each in found if each.beyond >= _least(model)), default=0.0)


def laws_with_memory(
    model: Model,
    current: Explanation,
    best: Step | None,
    found: Sequence[Lasting],
    recordings: Recordings,
    progress: Progress,
    bare: FilterBench | None = None,
) -> Laws:
    """The laws that earn their place beside ``best``, at the most promising place where any does; or none."""
    places: dict[frozenset[str], list[Lasting]] = {}
    for each in sorted(found, key=lambda x: -x.gain):
        if each.beyond >= _least(model):
            places.setdefault(frozenset(each.laws), []).append(each)
    for each in sorted((x for here in places.values() for x in here[:PLACES]), key=lambda x: -x.gain):
        if each.gain < (EXPECTED * best.score.gain if best else 0.0):
            continue
        if not allowed(f"friction with memory at {each.latent.place}"):
            break
        tried = with_memory(model, current, each, LIKELY * needed(model, best), recordings, progress, bare)
        good = likelier(tried, current, best)
        if good:
            chosen = simplest(model, good[0][1], [step for _, step in good])
            return tuple(sorted(good, key=lambda each: each[1] is not chosen))
    return ()


def likelier(laws: Laws, current: Explanation, best: Step | None) -> Laws:
    """Those that earn their place, and explain more than ``best``."""
    return tuple((own, law) for own, law in laws if _earns(own, current, law, best) and warms_slowly(own, law.after))


def warms_slowly(model: Model, of: Explanation) -> bool:
    """Whether heat that was found outlasts a stroke: else it follows the speed, as any law of speed does."""
    for candidate, _ in of.found:
        latent = latent_at(model.latents, candidate.place.address)
        if candidate.effect in WARMING and latent is not None:
            numbers = (candidate.name_of(name) for name in ("heat_capacity", "thermal_resistance"))
            capacity, resistance = (float(of.fit.p[of.fit.bench.index[name]]) for name in numbers)
            if not capacity * resistance > travel(of, latent).stroke:
                return False
    return True


def suffice(laws: Laws) -> bool:
    """Whether nothing is left but the noise of the sensors with the chosen one."""
    return bool(laws) and nothing_left(laws[0][0], laws[0][1].after)


def _least(model: Model) -> float:
    return WORTH + price_of(model, NUMBERS)


def needed(model: Model, best: Step | None) -> float:
    """Nats beyond its price that a law must bring beside ``best``."""
    return WORTH + max(worth(model, best) if best else 0.0, 0.0)


def _earns(model: Model, current: Explanation, each: Step, best: Step | None) -> bool:
    return (
        worth(model, each) > needed(model, best)
        and each.p_value < LEVEL
        and each.after.heldout < (1.0 - EARNS) * current.heldout
        and certain(model, each.after, each.score.candidate)
    )
