"""The recursion of a large arm as HTML: folded away, a heading per link, every intermediate under its law."""

from __future__ import annotations

from itertools import groupby

from markupsafe import Markup

from symdyn.derive.equations import EquationsOfMotion
from symdyn.emit.latex import READABLE_JOINTS
from symdyn.emit.latex_recursion import Passage, passages
from symdyn.faces.mathml import equation_markup, mathml

_WHOLE = Markup(
    "<details><summary>The arm&rsquo;s efforts, step by step</summary>\n"
    '<p class="quiet">Newton-Euler&rsquo;s equations in frames on the joint axes: z along the axis, {} and {} cosine '
    "and sine of its angle. {} is the pseudo-inertia of a link with base parameters, {}; {} and {} mark a vector "
    "before and after its turn by the joint, {} one in the frame of the link before. What is zero, or equal to "
    "another intermediate, has no line.</p>\n{}\n</details>"
)
_SYMBOLS = (r"\mathrm{c}_i", r"\mathrm{s}_i", "J", r"U = [\alpha]_\times + [\omega]_\times^2", "t", "r", "b")
_LINK = Markup('<h3 style="margin: 1rem 0 0">{}</h3>\n{}')
_LAW = Markup('<p class="quiet" style="margin: 0.6em 0 0">{}</p>\n{}')
_ROW = Markup('<div style="margin: 0.2em 0 0.2em 1.5em">{}</div>')


def recursion_markup(equations: EquationsOfMotion) -> Markup:
    """Nothing for an arm whose equations stand in closed form."""
    if len(equations.robot.joints) <= READABLE_JOINTS:
        return Markup("")
    links = [
        _LINK.format(heading, Markup("\n").join(map(_passage, of_link)))
        for heading, of_link in groupby(passages(equations), key=lambda passage: passage.heading)
    ]
    return _WHOLE.format(*map(mathml, _SYMBOLS), Markup("\n").join(links))


def _passage(passage: Passage) -> Markup:
    rows = Markup("\n").join(_ROW.format(equation_markup(equation)) for equation in passage.equations)
    return _LAW.format(passage.law, rows) if passage.law else rows
