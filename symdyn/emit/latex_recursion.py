"""The recursion of a large arm as a document for people: every intermediate under its link and its law."""

from __future__ import annotations

import re
from dataclasses import dataclass
from itertools import groupby

from symdyn.derive.equations import EquationsOfMotion
from symdyn.derive.steps import Step
from symdyn.emit.latex_names import Printer
from symdyn.emit.latex_text import Equation, escape, listed, ordered, signed

_GREEK = {"omega": r"\omega", "alpha": r"\alpha", "c": r"\mathrm{c}", "s": r"\mathrm{s}"}
_NAME = re.compile(r"([A-Za-z]+)_(\d+)([a-z]?)(?:_(\w+))?")


@dataclass(frozen=True, slots=True)
class Passage:
    """Equations of one law at one link; the efforts, at the end, have no law."""

    heading: str  # "Link 2"
    law: str
    equations: tuple[Equation, ...]


def recursion(equations: EquationsOfMotion) -> str:
    """The passages as LaTeX, a paragraph per link."""
    parts = []
    for heading, of_link in groupby(passages(equations), key=lambda passage: passage.heading):
        title = f"\\paragraph{{{escape(heading)}}}"
        for passage in of_link:
            lead = f"\n\n{escape(passage.law)}:" if passage.law else ""
            parts.append(f"{title}{lead}\n{listed(passage.equations)}".lstrip("\n"))
            title = ""
    return "\n\n".join(parts)


def passages(equations: EquationsOfMotion) -> tuple[Passage, ...]:
    """Named intermediates of inverse dynamics in the order of their computation, then the efforts."""
    steps = _needed(equations)
    printer = Printer(equations, {step.symbol: step_name(str(step.symbol)) for step in steps})
    found = []
    for origin, lines in groupby(steps, key=lambda step: step.origin):
        link, _, law = origin.partition(": ")
        found.append(Passage(link.capitalize(), law, tuple(_equation(printer, step) for step in lines)))
    efforts = [
        Equation("", (rf"\tau^{{\mathrm{{arm}}}}_{{{k}}}",), signed(printer, ordered(effort)))
        for k, effort in enumerate(equations.arm, start=1)
        if effort != 0
    ]
    return (*found, Passage("Efforts", "", tuple(efforts)))


def step_name(name: str) -> str:
    r"""``omega_2r_x`` is \omega^{r}_{2,x}: quantity, stage, link and axis."""
    found = _NAME.fullmatch(name)
    if found is None:
        return rf"\mathrm{{{escape(name)}}}"
    base, link, stage, axes = found.groups()
    index = f"{link},{axes}" if axes else link
    return f"{_GREEK.get(base, base)}{f'^{{{stage}}}' if stage else ''}_{{{index}}}"


def _needed(equations: EquationsOfMotion) -> list[Step]:
    """The steps that an effort depends on."""
    wanted = set().union(*(effort.free_symbols for effort in equations.arm))
    kept: list[Step] = []
    for step in reversed(equations.steps):
        if step.symbol in wanted:
            wanted |= step.expression.free_symbols
            kept.append(step)
    return kept[::-1]


def _equation(printer: Printer, step: Step) -> Equation:
    return Equation("", (printer(step.symbol),), signed(printer, ordered(step.expression)))
