"""The verdict: what may be said of a model, given what was found and what is left."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from symdyn.numeric.findings import Errors, Finding, Remaining, Verdict

EXPLAINED = 0.75  # of the structured mismatch's power that findings must tell for their names to be the answer
HOLDS = 0.995  # the same where what is left follows a finding's own variable: its law holds but for 7 % of its size
ALL = 1.0  # the same where the model's own parameters went where no data sheet is wrong: who explained it is open
NEGLIGIBLE = 0.001  # of the effort, or of the motion: no sensor of a robot tells so little, whatever its structure


def that_matters(remaining: Remaining, findings: Sequence[Finding], hidden: Mapping[str, float]) -> Remaining:
    """The same, without a structure that nobody would ask about, or that no larger one could be told from.

    None is small beside what findings took off, and the steps of an encoder take off nothing. An effort that a
    controller holds over each sample is told as a smooth one to a thousandth; recordings without any noise show that,
    and all that a simulation rounds. What samples and the steps of known encoders leave of each joint's effort is
    ``hidden``: it follows the motion, and is nothing that the machine lacks.
    """
    took = any(f.heldout_gain > 0.0 for f in findings)
    there = hidden.values() if remaining.place is None else [hidden.get(remaining.place, 0.0)]
    if not remaining.structured or remaining.size > max((0.0 if took else NEGLIGIBLE, *there)):
        return remaining
    return Remaining(remaining.heldout, False, 0.0, None, remaining.p_value, 0.0)


def verdict_of(
    findings: Sequence[Finding], remaining: Remaining, before: Errors, after: Errors, needed: float = EXPLAINED
) -> Verdict:
    """The rules, first that holds:

    1. ``unexplained``: what is left is structured, and nothing was found; or what was found tells less
       than the part ``needed`` of the structured mismatch (``explained_share``): three quarters; 99.5 % where
       its law is refuted (what is left still follows the very variable that a finding is a law in, at its own
       place, alone or with another one there); all where the model's parameters took up some of it. The
       findings are still told then, as the nearest that is known.
    2. ``ambiguous``: a finding has a rival that these recordings do not tell from it.
    3. ``missing_physics``: there are findings (``remaining.structured`` says whether more is missing).
    4. ``complete``: nothing was found, and what is left has no structure.
    """
    follows, unlike = (
        explained_share(left, remaining, before, after)
        for left in (max(remaining.share, remaining.slow), remaining.unlike_noise)
    )
    if remaining.structured and (not findings or follows < needed or unlike < EXPLAINED):
        return Verdict.UNEXPLAINED
    if any(f.rivals for f in findings):
        return Verdict.AMBIGUOUS
    return Verdict.MISSING_PHYSICS if findings else Verdict.COMPLETE


def explained_share(share: float, remaining: Remaining, before: Errors, after: Errors) -> float:
    """Part of the structured mismatch's held-out power that the findings took away.

    The structured mismatch is what they took, and of what is left that ``share`` of its power.
    """
    taken = max(before.heldout**2 - after.heldout**2, 0.0)
    left = share * after.heldout**2 if remaining.structured else 0.0
    return taken / (taken + left) if taken + left > 0.0 else 0.0
