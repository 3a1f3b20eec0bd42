"""What a finding cannot be told from: other effects at its place, and itself at other places."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from symdyn.base.errors import NumericalError
from symdyn.numeric.explanation import Explanation
from symdyn.numeric.few_waves import waves_of_rival
from symdyn.numeric.findings import Finding, Rival
from symdyn.numeric.forward import RevisionTrial, tried_revisions
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
    mine = [i for i in current.found if i[0].key == finding.key]
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
    bare = replace(inquiry, current=rest)
    near = [revision for revision in open_ if revision.key[1] in (finding.place, "base")]
    for revised in tried_revisions(bare, search, near, [own], progress):
        if revised.matches > TIE:
            p_value = _as_good(bare, current, revised)
            if p_value > TIE:
                rivals.append(Rival(*revised.revision.key, p_value))
    return replace(finding, rivals=tuple(rivals), group=tuple(group))


def _as_good(bare: Inquiry, found: Explanation, tried: RevisionTrial) -> float:
    """P-value of "the finding explains no more than this revision", which is fitted for that; 0 where it cannot be.

    To first order a limit of the efforts has any size, and so looks like much that follows the sign of an effort.
    """
    try:
        after = tried.revision.revised(bare, tried.tried)
    except NumericalError:
        return 0.0
    if after is None:
        return 0.0
    gain, p_value = likelier(after.current.training * found.weight, found.training * found.weight)
    return p_value if gain > 0.0 else 1.0
