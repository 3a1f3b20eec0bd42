"""The recursion of a large arm as a document for people: every intermediate under its link and its law."""

from __future__ import annotations

import re
from itertools import groupby

from symdyn.derive.equations import EquationsOfMotion
from symdyn.derive.steps import Step
from symdyn.emit.latex_names import Printer
from symdyn.emit.latex_text import Equation, escape, listed, ordered, signed

_GREEK = {"omega": r"\omega", "alpha": r"\alpha", "c": r"\mathrm{c}", "s": r"\mathrm{s}"}
_NAME = re.compile(r"([A-Za-z]+)_(\d+)([a-z]?)(?:_(\w+))?")


def recursion(equations: EquationsOfMotion) -> str:
    """Named intermediates of inverse dynamics in the order of their computation, then the efforts."""
    steps = _needed(equations)
    printer = Printer(equations, {step.symbol: step_name(str(step.symbol)) for step in steps})
    parts = []
    for link, of_link in groupby(steps, key=lambda step: step.origin.partition(": ")[0]):
        parts.append(f"\\paragraph{{{escape(link.capitalize())}}}")
        for law, lines in groupby(of_link, key=lambda step: step.origin.partition(": ")[2]):
            shown = [_equation(printer, step) for step in lines]
            parts.append(f"{escape(law)}:\n{listed(shown)}")
    efforts = [
        Equation("", (rf"\tau^{{\mathrm{{arm}}}}_{{{k}}}",), signed(printer, ordered(effort)))
        for k, effort in enumerate(equations.arm, start=1)
        if effort != 0
    ]
    parts.append(f"\\paragraph{{Efforts}}\n{listed(efforts)}")
    return "\n\n".join(parts)


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
