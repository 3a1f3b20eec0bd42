"""What a designed experiment promises, in one or two sentences."""

from __future__ import annotations

from collections.abc import Sequence

from symdyn.numeric.experiment.design import SEPARATES, WIDER, Design
from symdyn.numeric.experiment.identification import Identifying
from symdyn.physics import catalogue, load_dependent

Between = Sequence[tuple[str, str]]  # (effect, place) of each explanation

LOAD = "the same motions with and without a known load at the tip would"
SENSOR = "a sensor elsewhere (at the other end of the transmission, or of the effort itself) would have to"


def separation_words(found: Design, between: Between, duration: float, assumed: str) -> str:
    """Whether the motion tells the two apart, how surely, and what would where it does not."""
    one, other = _names(between)
    if all(direction.nested for direction in found.directions):
        return f"{one} and {other} take the same efforts on every motion of the joints: {_beyond(between)}"
    if found.separates:
        sentences = [
            f"on this motion of {duration:.3g} s the wrong one of {one} and {other}, fitted anew, loses at least "
            f"{found.separation:.3g} nats of log-likelihood; the usual motion within the same limits shows "
            f"{found.usual:.3g}"
        ]
    else:
        sentences = [
            f"no motion of {duration:.3g} s within the limits separates {one} from {other} surely: the best shows "
            f"{found.separation:.2g} nats of the {SEPARATES:g} that are asked for",
            _wider(found, between, duration),
        ]
    for direction in found.directions:
        if direction.nested:
            truth, rival = (one, other) if direction.truth == 0 else (other, one)
            sentences.append(f"if {truth} is true, {rival} fits as well, with what it has more coming out as zero")
    if assumed:
        sentences.append(assumed)
    return "; ".join(sentences)


def identifying_words(found: Identifying, duration: float, assumed: str) -> str:
    """How well the motion tells the parameters."""
    lost = [name for name, error in found.standard_errors.items() if error is None]
    told = (
        f"this motion of {duration:.3g} s tells the parameters {found.gain:.3g} times as well as the usual one within "
        "the same limits"
    )
    never = f"; no motion tells {', '.join(lost)} one by one" if lost else ""
    return told + never + (f"; {assumed}" if assumed else "")


def hidden_words(between: Between, reason: str) -> str:
    """Where no motion can be designed because the joints do not show what the explanations differ in."""
    return (
        f"no motion was designed: {reason}; {_beyond(between)}"
        if _loaded(between)
        else f"no motion was designed: {reason}"
    )


def _names(between: Between) -> tuple[str, str]:
    found = [f"{catalogue()[effect].title} at {place}" if effect else "" for effect, place in between]
    if not any(found):
        return "the first model", "the second model"
    return found[0] or "the model without it", found[1] or "the model without it"


def _wider(found: Design, between: Between, duration: float) -> str:
    if found.wider == "time":
        return f"the same motion would in {found.factor * duration:.2g} s"
    if found.wider:
        return f"{found.factor:.2g} times the {found.wider} would"
    return f"nor do limits {WIDER[-1]:g} times as wide; {_beyond(between)}"


def _beyond(between: Between) -> str:
    """What no motion can do."""
    if _loaded(between):
        return f"another load is needed: {LOAD}"
    return f"another load, or another sensor, is needed: {SENSOR}"


def _loaded(between: Between) -> bool:
    return any(effect in load_dependent() for effect, _ in between)
