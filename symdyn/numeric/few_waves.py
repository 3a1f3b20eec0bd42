"""A ripple that goes round but once or twice in the travel, in place of laws of position that were found.

Over so few waves nothing is seen to repeat, and any smooth force of position looks like part of a wave: such a ripple
is not looked for. Where another law of position was found, a force of position is there, and the two compete.
"""

from __future__ import annotations

from collections.abc import Callable, Collection

import numpy as np

from symdyn.numeric.candidates import Candidate
from symdyn.numeric.forward import first_that_earns
from symdyn.numeric.inquiry import Inquiry
from symdyn.numeric.nested import exchanged, explained_without, search_beside
from symdyn.numeric.scan import WAVES
from symdyn.physics import catalogue
from symdyn.physics.effect import Effect

ONCE = 1.0  # wave that the travel must hold: of less it is open where the force turns


def waves_instead(inquiry: Inquiry, places: Collection[str], progress: Callable[[str], None]) -> tuple[Inquiry, bool]:
    """A ripple of few waves takes the place of all laws of position at its joint where it explains more; and whether.

    Asked at ``places``. What is told is that nothing was seen to repeat.
    """
    swapped = False
    for wave in inquiry.setting.proposed:
        if wave.place.address not in places or not wave.repeats:
            continue
        less = [c for c, _ in inquiry.current.found if c.place == wave.place and _of_position(c.effect)]
        if all(c.effect == wave.effect for c in less):  # none, or nothing but the ripple itself
            continue
        names = ", ".join(c.title for c in less)
        progress(f"instead of {names} at {wave.place.address}: {wave.title} of few waves")
        rest = explained_without(inquiry, less)
        search = search_beside(inquiry, rest)
        trial = search.trial(wave, ONCE)
        step = first_that_earns(inquiry, [trial], rest)[0] if trial.gain > 0.0 and trial.admissible else None
        if step is not None:
            inquiry, swapped = exchanged(inquiry, less, rest, step[1]), True
            joint = search.laws.joint(wave)
            waves = trial.shapes[0] * float(np.ptp(search.laws.bench.observation.q[:, joint])) / (2.0 * np.pi)
            told = f"{wave.label} took the place of {names}: the joint moves through {waves:.1f} of its waves"
            inquiry = inquiry.noting(f"{told}, and a motion over more of them would show whether it repeats")
    return inquiry, swapped


def waves_of_rival(other: Candidate, found: Candidate) -> float:
    """Waves that the travel must hold of a rival: a law of position with as many numbers may as well be part of one."""
    alike = other.repeats and other.place == found.place and _of_position(found.effect)
    return 0.0 if alike and other.size <= found.size else WAVES


def _of_position(effect: str) -> bool:
    """Whether its force is that of a potential."""
    return type(catalogue()[effect]).potential_energy is not Effect.potential_energy
