"""The equations of the diagnosed model, the terms that the diagnosis added marked."""

from __future__ import annotations

from markupsafe import Markup

from symdyn.derive.equations import EquationsOfMotion, equations_of_motion
from symdyn.emit import latex
from symdyn.faces.mathml import equation_markup, mathml
from symdyn.faces.recursion import recursion_markup
from symdyn.spec.records import Robot


def marked_equations(given: Robot, diagnosed: Robot) -> Markup:
    """One block per coordinate and hidden state of ``diagnosed``, then a large arm's efforts, step by step."""
    equations = equations_of_motion(diagnosed)
    new = latex.terms_with(equations, {p.name for p in diagnosed.parameters} - {p.name for p in given.parameters})
    block = Markup('<div class="equation"><h3>{}</h3><p>{}</p></div>')
    blocks = [
        block.format(_heading(equations, e.title), equation_markup(e, new))
        for e in latex.equations_of_motion(equations)
    ]
    return Markup("\n").join([*blocks, recursion_markup(equations)])


def _heading(equations: EquationsOfMotion, title: str) -> Markup:
    for i, axis in enumerate(equations.axes, start=1):
        if axis.address == title:
            return Markup('{} <span class="quiet">{} in {}</span>').format(title, mathml(f"q_{{{i}}}"), axis.unit)
    return Markup("{}").format(title)
