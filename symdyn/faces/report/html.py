"""Small pieces of HTML; whatever is not Markup yet is escaped."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

from markupsafe import Markup, escape

LINE = Markup("<br>")
NBSP = "\N{NO-BREAK SPACE}"


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> Markup:
    """A table whose wide rows scroll; the first cell of a row is its header."""
    heads = _concatenated(Markup('<th scope="col">{}</th>').format(cell) for cell in head)
    body = _concatenated(
        Markup('<tr><th scope="row">{}</th>{}</tr>\n').format(
            row[0], _concatenated(Markup("<td>{}</td>").format(cell) for cell in row[1:])
        )
        for row in rows
    )
    return Markup('<div class="wide"><table><thead><tr>{}</tr></thead>\n<tbody>\n{}</tbody></table></div>').format(
        heads, body
    )


def facts(pairs: Iterable[tuple[str, str]]) -> Markup:
    """A list of names and what they are."""
    inside = _concatenated(Markup("<dt>{}</dt><dd>{}</dd>\n").format(*pair) for pair in pairs)
    return Markup("<dl>\n{}</dl>").format(inside)


def bullets(items: Iterable[str]) -> Markup:
    return Markup("<ul>\n{}</ul>").format(_concatenated(Markup("<li>{}</li>\n").format(item) for item in items))


def paragraph(text: str) -> Markup:
    return Markup("<p>{}</p>").format(text)


def quiet(text: str) -> Markup:
    """A side remark."""
    return Markup('<span class="quiet">{}</span>').format(text)


def typeset(text: str) -> Markup:
    """A number with its unit: ``-3.6e-5 kg m^2`` with real minus signs, powers raised, in one line."""
    shown = str(escape(text)).replace(" ", NBSP)
    shown = re.sub(r"(?<=[\d)])e(-?\d+)", f"{NBSP}×{NBSP}10<sup>\\1</sup>", shown)
    shown = re.sub(r"\^(-?\d+)", r"<sup>\1</sup>", shown)
    return Markup(re.sub(r"-(?=\d)", "−", shown))


def _concatenated(pieces: Iterable[Markup]) -> Markup:
    return Markup("").join(pieces)
