"""The equations as Markdown with LaTeX between dollar signs: what notebooks and web pages show with MathJax."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from html import escape
from itertools import groupby

from symdyn.derive.equations import EquationsOfMotion
from symdyn.emit.latex import READABLE_JOINTS, coefficients, equations_of_motion, operators
from symdyn.emit.latex_recursion import passages
from symdyn.emit.latex_text import Equation


def document(equations: EquationsOfMotion) -> str:
    """Coordinates, equations of motion, and of the arm what people can read: coefficients, or the recursion."""
    return "\n".join(_lines(equations))


def _lines(equations: EquationsOfMotion) -> Iterator[str]:
    robot = equations.robot
    yield f"## {robot.name}\n\n{escape(robot.description)}\n"
    yield "| coordinate | place | unit |\n| --- | --- | --- |"
    for i, axis in enumerate(equations.axes, start=1):
        yield f"| $q_{{{i}}}$ | {axis.address} | {axis.unit} |"
    yield "\n### Equations of motion\n"
    for equation in equations_of_motion(equations):
        yield f"{equation.title}:\n\n{_display([equation])}"
    for symbol, words in operators(equations):
        yield f"- ${symbol}$: {words}"
    yield ""
    if len(robot.joints) <= READABLE_JOINTS:
        found = coefficients(equations)
        if found:
            yield f"### Coefficients of the arm\n\n{_display(found)}"
        return
    for heading, of_link in groupby(passages(equations), key=lambda passage: passage.heading):
        yield f"### {heading}\n"
        for passage in of_link:
            if passage.law:
                yield f"{passage.law}:\n"
            yield _display(passage.equations)


def _display(equations: Sequence[Equation]) -> str:
    lines = " \\\\\n".join(equation.lines() for equation in equations)
    return f"$$\n\\begin{{aligned}}\n{lines}\n\\end{{aligned}}\n$$\n"
