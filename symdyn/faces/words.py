"""The words and numbers that the command line and the report share."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from decimal import Decimal
from types import MappingProxyType

from symdyn.numeric.findings import Diagnosis, Estimate, Finding, Located, SameLaw, Verdict
from symdyn.numeric.groups import elsewhere
from symdyn.physics import catalogue

VERDICT_NAMES: Mapping[Verdict, str] = MappingProxyType(
    {
        Verdict.COMPLETE: "complete",
        Verdict.MISSING_PHYSICS: "missing physics",
        Verdict.AMBIGUOUS: "ambiguous",
        Verdict.UNEXPLAINED: "unexplained",
        Verdict.BAD_RECORDING: "bad recording",
    }
)

VERDICT_MEANINGS: Mapping[Verdict, str] = MappingProxyType(
    {
        Verdict.COMPLETE: (
            "No known effect lowers the error on the held-out recording by enough to matter, and what is left there "
            "does not follow the motion. Motions unlike those recorded may still show more."
        ),
        Verdict.MISSING_PHYSICS: (
            "Each effect below was chosen and fitted on the training recording alone, and lowers the error on the "
            "held-out recording by more than chance (an encoder's steps do not: they stand in the recording itself); "
            "no other known effect does as well in its place."
        ),
        Verdict.AMBIGUOUS: (
            "Something is missing, but for at least one finding another known effect explains the recordings "
            "as well. Take the finding as a group until a recording that tells its members apart has been made."
        ),
        Verdict.UNEXPLAINED: (
            "What is left on the held-out recording is not noise, but no effect that symdyn knows explains it. "
            "Effects listed all the same are the nearest known ones: they tell too little of the mismatch, or what is "
            "left follows their own variable, so that their law does not hold."
        ),
        Verdict.BAD_RECORDING: (
            "The recording itself is wrong; nothing was diagnosed, since whatever came out would be about its faults."
        ),
    }
)

EXACT = 1e-9  # a standard error below this part of the value is written on its own: the digits would fill a line


def verdict_sentence(diagnosis: Diagnosis) -> str:
    """The verdict in plain words, then the headline number."""
    sentences = (verdict_words(diagnosis), error_words(diagnosis), leftover_words(diagnosis))
    return " ".join(sentence for sentence in sentences if sentence)


def verdict_words(diagnosis: Diagnosis) -> str:
    """One sentence: what the model lacked."""
    if diagnosis.findings and diagnosis.verdict is Verdict.UNEXPLAINED:
        nearest = _joined([f"{f.title} at {_at(diagnosis, f)}" for f in diagnosis.findings], " and ")
        return f"The model misses {_kind(diagnosis)}, which no known effect explains; nearest is {nearest}."
    if diagnosis.findings:
        unsure = any(f.rivals for f in diagnosis.findings)
        lacked = _joined([_lacked(diagnosis, f) for f in diagnosis.findings], ", and " if unsure else " and ")
        return f"The model lacked {lacked}{': these recordings do not tell which' if unsure else ''}."
    if diagnosis.remaining.structured:
        return f"The model misses {_kind(diagnosis)}, and no known effect explains it."
    return "These recordings show nothing that the model lacks."


def error_words(diagnosis: Diagnosis) -> str:
    """One sentence: the error on data that nothing was fitted to."""
    before, after = diagnosis.before.heldout, diagnosis.after.heldout
    if not diagnosis.findings or percent(before) == percent(after):
        return f"Held-out error is {percent(after)}."
    return f"Held-out error {'fell' if after < before else 'went'} from {percent(before)} to {percent(after)}."


def leftover_words(diagnosis: Diagnosis) -> str:
    """A caveat where effects were found and what is left still follows the motion; else nothing."""
    if not diagnosis.findings or not diagnosis.remaining.structured or diagnosis.verdict is Verdict.UNEXPLAINED:
        return ""
    variable, where = diagnosis.remaining.variable, _where(diagnosis)
    if variable is None:
        return f"Part of what is left{where} is no noise, but does not follow the motion."
    return f"Part of what is left{where} still follows the {variable}."


def located_words(located: Located) -> str:
    """``elbow (or elbow.motor): follows sign of speed, low speed``."""
    others = [place for place in located.group if place != located.place]
    group = f" (or {_joined(others, ' or ')})" if others else ""
    return f"{located.place}{group}: follows {', '.join(located.when)}" if located.when else f"{located.place}{group}"


def parameter_lines(finding: Finding) -> list[str]:
    """``level = 2.1 ± 0.1 N m``, one line each; then those at other places where they are other numbers."""
    lines = [f"{name} = {quantity_text(e)}" for name, e in finding.parameters.items()]
    for place, values in told_elsewhere(finding).items():
        lines += [f"at {place} instead:", *(f"  {name} = {quantity_text(e)}" for name, e in values.items())]
    return lines


def told_elsewhere(finding: Finding) -> Mapping[str, Mapping[str, Estimate]]:
    """What the finding's numbers are at other places of its group, where they are not the same."""
    own = finding.parameters
    return {place: values for place, values in finding.elsewhere.items() if values != own}


def same_law_words(finding: Finding, same: SameLaw) -> str:
    """What it is together with what acts beside it: no rival, since no motion tells the two apart."""
    parts = _joined([finding.title, *(effect_title(effect) for effect in same.beside)], " and ")
    numbers = ", ".join(f"{name} {quantity_text(e)}" for name, e in same.parameters.items())
    return f"{parts} at {finding.place} are in other words {effect_title(same.effect)}: {numbers}"


def nats(evidence: float) -> str:
    """Evidence to three digits: ``227``, ``11.3``."""
    return f"{evidence:.0f}" if abs(evidence) >= 99.95 else f"{evidence:.3g}"


def noise_words(diagnosis: Diagnosis) -> str:
    """One sentence on the noise floor; nothing where the recording does not tell it."""
    if diagnosis.noise_floor is None:
        return ""
    return f"The noise of the sensors alone would leave {percent(diagnosis.noise_floor.errors.heldout)}."


def effect_title(identifier: str) -> str:
    """An effect's name for people."""
    known = catalogue().get(identifier)
    return known.title if known is not None else identifier.replace("_", " ")


def percent(x: float) -> str:
    """``41 %``, ``6.1 %``, ``0.35 %``: two digits are all that a relative error tells."""
    if not math.isfinite(x):
        return "not defined"
    size = abs(100.0 * x)
    if 0.0 < size < 0.0005:
        return "< 0.001 %"
    decimals = 0 if size >= 9.95 or size == 0.0 else 1 if size >= 0.995 else 2 if size >= 0.0995 else 3
    return f"{100.0 * x:.{decimals}f} %"


def probability(p: float) -> str:
    """``p = 0.012``, ``p < 0.001``."""
    return "p < 0.001" if p < 0.001 else f"p = {p:.2g}"


def quantity_text(estimate: Estimate) -> str:
    """``203.4 ± 1.2 N s/m``: the standard error to two digits, the value to the same place."""
    return with_unit(_number(estimate.value, estimate.se), estimate.unit)


def with_unit(number: str, unit: str) -> str:
    """``2 N m``; a number without dimension stands alone."""
    return number if unit in ("", "1", "rad/rad") else f"{number} {unit}"


def plain_number(value: float) -> str:
    """A number without a known error, to four digits: ``0.2264``, ``3.6e-5``."""
    return _trimmed(f"{value:.4g}")


def _number(value: float, se: float | None) -> str:
    if se is None or not (math.isfinite(value) and math.isfinite(se) and se > 0.0):
        return plain_number(value)
    if se < EXACT * abs(value):
        return _trimmed(f"{value:.10g} ± {se:.1g}")
    size = max(abs(value), se)
    exponent = math.floor(math.log10(size))
    if -4 <= exponent < 6:
        return "{} ± {}".format(*_aligned(value, se))
    scaled = (float(Decimal(x).scaleb(-exponent)) for x in (value, se))
    return "({} ± {})e{}".format(*_aligned(*scaled), exponent)


def _trimmed(text: str) -> str:
    """Exponents as people write them: ``e-5`` for ``e-05``."""
    return re.sub(r"e([+-])0*(\d)", lambda m: f"e{m[1].strip('+')}{m[2]}", text)


def _aligned(value: float, se: float) -> tuple[str, str]:
    rounded = float(f"{se:.1e}")  # 0.0996 is 0.10, which moves its first digit
    decimals = 1 - _exponent(rounded)
    value, se = round(value, decimals) + 0.0, round(se, decimals)
    return f"{value:.{max(decimals, 0)}f}", f"{se:.{max(decimals, 0)}f}"


def _exponent(x: float) -> int:
    return int(f"{x:e}".partition("e")[2])


def _kind(diagnosis: Diagnosis) -> str:
    variable = diagnosis.remaining.variable
    kind = f"that follows the {variable}" if variable else "that is no noise and does not follow the motion"
    return f"something{_where(diagnosis)} {kind}"


def _where(diagnosis: Diagnosis) -> str:
    """Of what is left: "at elbow"; nothing where no one place is known, or there is but one."""
    place = diagnosis.remaining.place
    return f" at {place}" if place and len(diagnosis.per_joint) > 1 else ""


def _lacked(diagnosis: Diagnosis, finding: Finding) -> str:
    if not finding.rivals:
        return f"{finding.title} at {_at(diagnosis, finding)}"
    names = [finding.title]
    for rival in finding.rivals:
        elsewhere = "" if rival.place == finding.place else f" at {rival.place}"
        names.append(effect_title(rival.effect) + elsewhere)
    return f"something at {_at(diagnosis, finding)} that may be {_joined(names, ' or ')}"


def _at(diagnosis: Diagnosis, finding: Finding) -> str:
    """Its place, and where else it may be."""
    others = elsewhere(diagnosis.robot, finding.place, finding.group)
    return _joined([finding.place, *others], " or ")


def _joined(items: Sequence[str], last: str) -> str:
    return last.join([", ".join(items[:-1]), items[-1]] if len(items) > 1 else items)
