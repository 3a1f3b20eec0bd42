"""The report's tables and paragraphs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from markupsafe import Markup

from symdyn import __version__
from symdyn.faces.mathml import mathml
from symdyn.faces.report.html import LINE, bullets, facts, paragraph, quiet, table, typeset
from symdyn.faces.words import (
    effect_title,
    nats,
    noise_words,
    percent,
    plain_number,
    probability,
    quantity_text,
    told_elsewhere,
    with_unit,
)
from symdyn.numeric.findings import Diagnosis, Errors, Estimate, Finding
from symdyn.spec.monomials import parameter_of
from symdyn.spec.records import Parameter


def headline(diagnosis: Diagnosis) -> Markup:
    """The held-out error, large; both numbers only where something was found."""
    after = Markup('<b class="to">{}</b> ').format(percent(diagnosis.after.heldout))
    if not diagnosis.findings:
        return after + Markup('<span class="label">held-out error of the model, refitted</span>')
    before = Markup('<b class="from">{}</b> <span class="arrow">→</span> ').format(percent(diagnosis.before.heldout))
    return before + after + Markup('<span class="label">held-out error, model as given → diagnosed</span>')


def findings_table(diagnosis: Diagnosis) -> Markup:
    """One row per finding, in the order in which they were made."""
    if not diagnosis.findings:
        return paragraph("No known effect lowers the held-out error by more than chance and by enough to matter.")
    head = ("Step", "Where", "What was missing", "Parameters", "Held-out error", "Evidence")
    rows = [
        (
            str(step),
            _place(finding.place, finding.group),
            Markup('<span class="what">{}</span>').format(finding.title),
            _parameters(finding, _symbols(finding, diagnosis)),
            Markup('<span class="line">{} → {}</span>').format(
                percent(finding.heldout_before), percent(finding.heldout_after)
            ),
            Markup('<span class="line">{} nats</span><br>{}').format(
                nats(finding.evidence), quiet(probability(finding.p_value))
            ),
        )
        for step, finding in enumerate(diagnosis.findings, start=1)
    ]
    return table(head, rows)


def located_table(diagnosis: Diagnosis) -> Markup:
    """Where the model as given does not account for the recordings, and when."""
    if not diagnosis.located:
        return paragraph("The residual of the model as given shows no structure at any joint.")
    rows = [
        (_place(found.place, found.group), ", ".join(found.when), f"{nats(found.evidence)} nats")
        for found in diagnosis.located
    ]
    return table(("Place", "What the mismatch follows, strongest first", "Evidence"), rows)


def rivals_table(diagnosis: Diagnosis) -> Markup:
    """What else could stand in each finding's place, and how it was told apart, if it was."""
    rows, named = [], set()
    for finding in diagnosis.findings:
        mine = f"{finding.title} at {finding.place}"
        for rival in finding.rivals:
            told = Markup("<b>not told apart</b>, {}").format(probability(rival.p_value))
            rows.append((mine, f"{effect_title(rival.effect)} at {rival.place}", "as well", told))
            mine = ""
        for same in (each for each in finding.same_as if (each.effect, each.place) not in named):
            named.add((same.effect, same.place))  # it is told at the first of its parts
            numbers = ", ".join(f"{name} {quantity_text(e)}" for name, e in same.parameters.items())
            beside = " and ".join(effect_title(effect) for effect in same.beside)
            law = f"{effect_title(same.effect)} in place of it and {beside}"
            rows.append((mine, law, "the same", Markup("one law, in other words: {}").format(numbers)))
            mine = ""
        for other in finding.alternatives:
            errors = f"{percent(other.heldout)} instead of {percent(finding.heldout_after)}"
            rows.append((mine, f"{effect_title(other.effect)} at {other.place}", errors, Markup("told apart")))
            mine = ""
    if not rows:
        return paragraph("No other known effect came near." if diagnosis.findings else "There is no finding to rival.")
    return table(("Finding", "Instead of it", "Would leave", ""), rows)


def next_experiment_text(diagnosis: Diagnosis) -> Markup:
    """The motion that would settle what these recordings leave open."""
    planned = diagnosis.next_experiment
    if planned is None and any(finding.rivals for finding in diagnosis.findings):
        return paragraph("No motion has been designed yet that would tell the rivals apart.")
    if planned is None and diagnosis.remaining.structured:
        return paragraph("None was designed: no two known effects compete for what is left.")
    if planned is None:
        return paragraph("None is needed to tell explanations apart.")
    between = " from ".join(f"{effect_title(effect)} at {place}" for effect, place in planned.between[:2])
    where = f" It is in {planned.file}." if planned.file else ""
    gain = f" It is expected to tell {between} by {nats(planned.separation)} nats." if planned.separation else ""
    return paragraph(f"{planned.why[:1].upper()}{planned.why[1:]}.{gain}{where}")


def joints_table(diagnosis: Diagnosis) -> Markup:
    """Relative errors per joint or channel, beside what noise would leave."""
    rows = []
    for joint, errors in diagnosis.per_joint.items():
        before = diagnosis.per_joint_before[joint].heldout
        noise = diagnosis.noise_floor.per_joint.get(joint) if diagnosis.noise_floor else None
        rows.append((joint, percent(before), percent(errors.heldout), _noise(noise), percent(errors.training)))
    whole = diagnosis.noise_floor.errors if diagnosis.noise_floor else None
    rows.append(_total(diagnosis.before, diagnosis.after, whole))
    return table(("Place", "Held out, before", "Held out, after", "Noise floor", "Training, after"), rows)


def remaining_text(diagnosis: Diagnosis) -> Markup:
    """What is left: how much, whether it is structured, what it follows."""
    left = diagnosis.remaining
    stays = "stays unexplained" if left.structured else "is left"
    sentences = [f"On the held-out recording {percent(left.heldout)} of the {diagnosis.judged} {stays}."]
    sentences += [noise_words(diagnosis)] if diagnosis.noise_floor else []
    follows = f"the {left.variable}" if left.variable else "the motion"
    where = f" at {left.place}" if left.place else ""
    if left.structured and left.variable is None:
        slow = left.slow >= left.beyond_noise
        unlike = "slow, where noise would be even" if slow else "beyond what the noise of the sensors would leave"
        sentences.append(
            f"It is no noise: {percent(left.share)} of its power{where} is {unlike} "
            f"({probability(left.p_value)}), but it does not follow position, speed or acceleration. Look for what "
            "changes with time, for disturbances from outside, and for physics with a memory."
        )
    elif left.structured:
        sentences.append(
            f"It is structured: {percent(left.share)} of its power{where} follows {follows} "
            f"({probability(left.p_value)}). Look there for physics that symdyn does not know."
        )
    elif left.share > 0.0:
        sentences.append(
            f"It is close to noise: only {percent(left.share)} of its power follows {follows} "
            f"({probability(left.p_value)})."
        )
    else:
        sentences.append("It looks like noise: none of it follows the position, speed or acceleration of a joint.")
    return paragraph(" ".join(sentences))


def model_table(diagnosis: Diagnosis) -> Markup:
    """The model's own parameters, as given and as fitted together with the findings."""
    if not diagnosis.model:
        return paragraph("The model has no parameters of its own that these recordings could move.")
    known = {p.name: p for p in diagnosis.robot.parameters}
    rows = []
    for name, estimate in diagnosis.model.items():
        given = known.get(name)
        fitted = typeset(quantity_text(estimate))
        if estimate.se is None:
            fitted += LINE + quiet("not identifiable alone")
        rows.append((_symbol(given, name), name, _as_given(given), fitted, given.meaning if given else ""))
    return table(("Symbol", "Name", "As given", "Fitted", "Meaning"), rows)


def alarms_list(diagnosis: Diagnosis) -> Markup:
    return bullets(diagnosis.alarms) if diagnosis.alarms else paragraph("None.")


def provenance(diagnosis: Diagnosis) -> Markup:
    """What the numbers come from."""
    robot = diagnosis.robot
    joints = len(robot.joints)
    band = f"0 to {plain_number(diagnosis.band)} Hz" if diagnosis.band > 0 else "all frequencies"
    return facts(
        [
            ("Robot", f"{robot.name}: {robot.description}" if robot.description else robot.name),
            ("Joints", f"{joints}: {', '.join(joint.name for joint in robot.joints)}"),
            ("Training recording", f"{diagnosis.training}: effects were chosen and fitted on it"),
            ("Held-out recording", f"{diagnosis.heldout}: nothing was fitted to it, it judged each effect"),
            ("Analysis band", f"{band}, where the mismatch lives; model and recording pass the same filter"),
            ("Error", f"size of the residual over that of the {diagnosis.judged}, root mean square over the places"),
            ("Errors after", "computed by the kernel generated anew from the diagnosed robot.toml below"),
            ("Made by", f"symdyn {__version__}"),
        ]
    )


def _parameters(finding: Finding, shown: Mapping[str, Parameter]) -> Markup:
    """Its own, and what they would be at the other places that are not told from its own."""
    lines = _lines(finding.parameters, shown)
    for place, values in told_elsewhere(finding).items():
        lines += [Markup('<span class="line">{}</span>').format(quiet(f"at {place} instead:")), *_lines(values, {})]
    return LINE.join(lines)


def _lines(values: Mapping[str, Estimate], shown: Mapping[str, Parameter]) -> list[Markup]:
    lines = []
    for name, estimate in values.items():
        value = typeset(quantity_text(estimate))
        note = Markup(" ") + quiet(name.replace("_", " "))
        symbol = mathml(shown[name].latex) + " = " if name in shown else Markup("")
        lines.append(Markup('<span class="line">{}{}{}</span>').format(symbol, value, note))
    return lines


def _symbols(finding: Finding, diagnosis: Diagnosis) -> dict[str, Parameter]:
    """The finding's parameters as the diagnosed model knows them, by the names of the effect's declaration."""
    by_name = {p.name: p for p in diagnosis.diagnosed.parameters}
    of_kind = sorted({f.number for f in diagnosis.findings if f.key[:2] == finding.key[:2]})
    there = [e for e in diagnosis.diagnosed.effects if (e.type, e.at) == finding.key[:2]]
    return {
        name: by_name[parameter]
        for effect in there[of_kind.index(finding.number) :][:1]
        for name, value in effect.values
        if (parameter := parameter_of(value)) is not None
    }


def _place(place: str, group: Sequence[str]) -> Markup:
    """The place, and below it those that no recording of this kind could tell from it."""
    others = [other for other in group if other != place]
    return Markup("{}").format(place) + (LINE + quiet(f"or {', '.join(others)}") if others else Markup(""))


def _noise(floor: Errors | None) -> str:
    return percent(floor.heldout) if floor else "not known"


def _total(before: Errors, after: Errors, noise: Errors | None) -> tuple[str, str, str, str, str]:
    return ("all", percent(before.heldout), percent(after.heldout), _noise(noise), percent(after.training))


def _symbol(parameter: Parameter | None, name: str) -> Markup:
    return mathml(parameter.latex) if parameter is not None else Markup("{}").format(name)


def _as_given(parameter: Parameter | None) -> Markup:
    if parameter is None or parameter.value is None:
        return quiet("free")
    return typeset(with_unit(plain_number(parameter.value), parameter.unit))
