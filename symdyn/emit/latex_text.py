"""Displayed equations: signed terms, broken into lines that fit a page."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import sympy as sp

from symdyn.emit.latex_names import Printer

LINE_WIDTH = 64  # estimated characters of a typeset line; A4 holds about 75


@dataclass(frozen=True, slots=True)
class Equation:
    """One displayed equation, ``left = right``, as lists of signed LaTeX terms."""

    title: str
    left: tuple[str, ...]
    right: tuple[str, ...]

    def latex(self, environment: str = "align*") -> str:
        return f"\\begin{{{environment}}}\n{self.lines()}\n\\end{{{environment}}}"

    def lines(self) -> str:
        """Lines for amsmath's align or aligned, broken before a sign."""
        head = _rows(self.left)
        if len(head) == 1 and _width(head[0]) <= LINE_WIDTH // 2:
            first, *rest = _rows(self.right, LINE_WIDTH - _width(head[0])) or ["0"]
            lines = [f"  {head[0]} &= {first}", *(f"  &\\quad {row}" for row in rest)]
        else:
            first, *rest = _rows(self.right) or ["0"]
            lines = [f"  & {head[0]}", *(f"  & \\quad {row}" for row in head[1:]), f"  & = {first}"]
            lines += [f"  & \\quad {row}" for row in rest]
        return " \\\\\n".join(lines)


def ordered(value: sp.Expr) -> Sequence[sp.Expr]:
    return value.as_ordered_terms() if value.is_Add else (value,)


def signed(printer: Printer, terms: Iterable[sp.Expr]) -> tuple[str, ...]:
    """LaTeX terms with explicit signs: '+ a', '- b'."""
    found = []
    for term in terms:
        if term == 0:
            continue
        text = printer(term)
        found.append(text if text.lstrip().startswith("-") else f"+ {text}")
    return tuple(found)


def listed(equations: Sequence[Equation]) -> str:
    """Several equations in one display."""
    if not equations:
        return ""
    return "\\begin{align*}\n" + " \\\\\n".join(e.lines() for e in equations) + "\n\\end{align*}"


ESCAPES = {
    "\\": r"\textbackslash{}", "{": r"\{", "}": r"\}", "_": r"\_", "^": r"\^{}", "&": r"\&",
    "%": r"\%", "$": r"\$", "#": r"\#", "~": r"\~{}",
}  # fmt: skip


def escape(text: str) -> str:
    """Text of a user made harmless in LaTeX."""
    return "".join(ESCAPES.get(c, c if c.isascii() else "?") for c in text)


def _rows(terms: Sequence[str], width: int = LINE_WIDTH) -> list[str]:
    rows: list[str] = []
    for term in terms:
        for piece in _pieces(term):
            if rows and _width(rows[-1]) + _width(piece) <= width:
                rows[-1] += f" {piece}"
            else:
                rows.append(piece)
    if rows:
        rows[0] = rows[0].removeprefix("+ ")
    return rows


def _pieces(term: str) -> list[str]:
    r"""A term that is wider than a line is broken inside its brackets: \left( ... \right) cannot be."""
    if _width(term) <= LINE_WIDTH:
        return [term]
    flat = term.replace(r"\left(", r"\bigl(").replace(r"\right)", r"\bigr)")
    pieces, depth, start, position = [], 0, 0, 0
    while position < len(flat):
        character = flat[position]
        depth += (character == "{") - (character == "}")
        if depth == 0 and flat.startswith((" + ", " - "), position) and _width(flat[start:position]) > LINE_WIDTH // 2:
            pieces.append(flat[start:position].strip())
            start = position + 1
        position += 1
    return [*pieces, flat[start:].strip()]


def _width(text: str) -> int:
    """Characters that remain when LaTeX's commands are taken away; fractions count their wider half."""
    text = re.sub(r"\\frac\{((?:[^{}]|\{[^{}]*\})*)\}\{((?:[^{}]|\{[^{}]*\})*)\}", _wider, text)
    text = re.sub(r"\\(left|right|bigl|bigr|,|;|quad|dot|ddot|operatorname|mathrm|text|displaystyle)", "", text)
    text = re.sub(r"\\[a-zA-Z]+", "sin", text)
    return len(re.sub(r"[{}_^ ]", "", text))


def _wider(match: re.Match[str]) -> str:
    return max(match.group(1), match.group(2), key=len)
