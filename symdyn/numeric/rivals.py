"""What a finding cannot be told from: other effects at its place, and itself at other places."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from symdyn.numeric.few_waves import waves_of_rival
from symdyn.numeric.findings import Finding, Rival
from symdyn.numeric.forward import tried_revisions
from symdyn.numeric.inquiry import Inquiry
from symdyn.numeric.kinship import ready
from symdyn.numeric.noise_floor import independent_samples
from symdyn.numeric.regression import likelier
from symdyn.numeric.revision import Revision
from symdyn.numeric.scan import WAVES
from symdyn.numeric.search import TIE, Search
from symdyn.physics import catalogue

Progress = Callable[[str], None]


def with_rivals(inquiry: Inquiry, finding: Finding, open_: Sequence[Revision], progress: Progress) -> Finding:
    """What it does not improve on beyond chance: other explanations at its place (rivals), itself elsewhere (group)."""
    case, current = inquiry.case, inquiry.current
    mine = [i for i in current.found if (i[0].effect, i[0].place.address) == (finding.effect, finding.place)]
    if not mine:
        return finding  # a sensor's fault, or gravity: it explains more than any effect does
    progress(f"looking for rivals of {finding.title} at {finding.place}")
    rest = case.explain(tuple(item for item in current.found if item is not mine[0]), current)
    search = Search(case.laws, rest.fit.p, rest.training, rest.design, rest.weight)
    own = search.at(mine[0][0], current.fitted[current.found.index(mine[0])].shapes)
    rivals, group = [], list(finding.group)
    count = independent_samples(case.bench)
    for other in ready(inquiry.setting.proposed, case.robot, rest.effects):
        if (other.effect == finding.effect) == (other.place.address == finding.place):
            continue
        if finding.effect in catalogue()[other.effect].generalises:
            continue  # the finding and more: it fits as well by being the same
        waves = waves_of_rival(other, mine[0][0])
        trial = search.trial(other, waves)
        if len(other.shapes) > 1 and other.place.address == finding.place and trial.gain > 0:
            trial = search.polished(trial)
        if search.contains(trial, own):
            continue
        gain, p_value = likelier(trial.errors, own.errors)
        # The shapes of both were fitted to these very samples: each number more is worth log(N) by that (Schwarz).
        bought = waves < WAVES and gain * count < (own.candidate.size - other.size) * np.log(count)
        if trial.admissible and trial.gain > 0 and (p_value > TIE or bought):
            if other.place.address == finding.place:
                rivals.append(Rival(other.effect, other.place.address, p_value))
            else:
                group.append(other.place.address)
    for revised in tried_revisions(replace(inquiry, current=rest), search, open_, [own], progress):
        if revised.matches > TIE and revised.revision.key[1] in (finding.place, "base"):
            rivals.append(Rival(*revised.revision.key, revised.matches))
    return replace(finding, rivals=tuple(rivals), group=tuple(group))
