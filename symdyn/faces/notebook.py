"""Notebook display: ``show(equations)`` as the last line of a cell. IPython itself is not needed."""

from __future__ import annotations

from dataclasses import dataclass

from markupsafe import Markup

from symdyn.derive.equations import EquationsOfMotion
from symdyn.emit.latex import equations_of_motion
from symdyn.emit.latex_text import Equation, escape
from symdyn.faces.mathml import equation_markup
from symdyn.faces.recursion import recursion_markup


@dataclass(frozen=True, slots=True)
class ShownEquations:
    """Equations that a notebook draws: as MathML, or as LaTeX where it has MathJax only."""

    equations: tuple[Equation, ...]
    recursion: Markup  # the arm step by step, where it is large

    def _repr_latex_(self) -> str:
        return "\n\n".join(
            f"$$\n\\begin{{aligned}}\n  & \\text{{{escape(e.title)}:}} \\\\\n{e.lines()}\n\\end{{aligned}}\n$$"
            for e in self.equations
        )

    def _repr_html_(self) -> str:
        row = Markup('<div style="margin: 0.4em 0"><b>{}</b><div>{}</div></div>')
        rows = [row.format(e.title, equation_markup(e)) for e in self.equations]
        return str(Markup("\n").join([*rows, self.recursion]))

    def __repr__(self) -> str:
        return f"<equations of motion of {', '.join(e.title for e in self.equations)}>"


def show(equations: EquationsOfMotion) -> ShownEquations:
    """The equations of motion, one per coordinate and hidden state, for display."""
    return ShownEquations(equations_of_motion(equations), recursion_markup(equations))
