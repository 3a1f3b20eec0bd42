"""The words of messages: quoting what a file holds, and guessing what was meant."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches

_LONGEST_QUOTE = 60


def quoted(text: object) -> str:
    """The text in backquotes, shortened, with control characters made visible."""
    shown = str(text)
    if len(shown) > _LONGEST_QUOTE:
        shown = shown[: _LONGEST_QUOTE - 3] + "..."
    return "`" + "".join(c if c.isprintable() else ascii(c)[1:-1] for c in shown) + "`"


def listed(words: Iterable[str], limit: int = 12) -> str:
    """``a, b, c`` with the tail of a long list left out."""
    every = list(words)
    tail = [] if len(every) <= limit else [f"... ({len(every) - limit} more)"]
    return ", ".join(every[:limit] + tail)


def closest(word: str, options: Iterable[str]) -> str | None:
    """The option that the word may be a slip of, if there is one."""
    by_folded = {option.casefold(): option for option in options}
    matches = get_close_matches(word[:64].casefold(), by_folded, n=1)
    return by_folded[matches[0]] if matches else None


def did_you_mean(word: str, options: Iterable[str], noun: str = "known") -> str:
    """A hint: the closest option, else the list of them all."""
    every = list(options)
    match = closest(word, every)
    if match is not None:
        return f"did you mean {quoted(match)}?"
    return f"{noun}: {listed(every)}" if every else ""


def word_set(text: str) -> frozenset[str]:
    """The words of a text."""
    return frozenset(text.split())
