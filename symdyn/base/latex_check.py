r"""Whether a person's LaTeX for a symbol may be printed: a whitelist, so ``\input`` never gets through."""

from __future__ import annotations

import re

from symdyn.base.wording import word_set

_COMMANDS = word_set(
    """alpha beta gamma delta epsilon varepsilon zeta eta theta vartheta iota kappa lambda mu nu xi pi rho varrho
    sigma tau upsilon phi varphi chi psi omega Gamma Delta Theta Lambda Xi Pi Sigma Upsilon Phi Psi Omega
    mathrm mathit mathbf mathcal hat bar tilde dot ddot vec ell prime infty max min"""
)
_WITH_ARGUMENT = word_set("mathrm mathit mathbf mathcal hat bar tilde dot ddot vec")
_TOKEN = re.compile(r"\\(?P<command>[A-Za-z]+|,)|(?P<plain>[A-Za-z0-9,.+\-])|(?P<mark>[_^{}'])|(?P<space> )", re.ASCII)
_LONGEST = 120


def is_safe_latex(text: str) -> bool:
    """Whether the text is a symbol of letters, digits, Greek, accents, sub- and superscripts that LaTeX accepts."""
    if not text.strip() or len(text) > _LONGEST:
        return False
    tokens: list[str] = []
    position = 0
    while position < len(text):
        match = _TOKEN.match(text, position)
        if match is None or (match["command"] and match["command"] not in _COMMANDS | {","}):
            return False
        if match["space"] is None:
            tokens.append(match[0])
        position = match.end()
    return _group_end(tokens, 0) == len(tokens)


def _group_end(tokens: list[str], start: int) -> int | None:
    """Where the run of symbols that begins at ``start`` ends; None where it is malformed."""
    at = start
    while at < len(tokens) and tokens[at] != "}":
        end = _atom_end(tokens, at)
        if end is None:
            return None
        at = end
        scripts: set[str] = set()
        while at < len(tokens) and tokens[at] in ("_", "^", "'"):
            kind = "^" if tokens[at] == "'" else tokens[at]
            if kind in scripts:
                return None  # LaTeX: double subscript
            scripts.add(kind)
            end = at + 1 if tokens[at] == "'" else _atom_end(tokens, at + 1)
            if end is None:
                return None
            at = end
    return at if at > start else None


def _atom_end(tokens: list[str], at: int) -> int | None:
    if at >= len(tokens) or tokens[at] in ("_", "^", "'", "}"):
        return None
    if tokens[at] == "{":
        end = _group_end(tokens, at + 1)
        return end + 1 if end is not None and end < len(tokens) and tokens[end] == "}" else None
    if tokens[at].removeprefix("\\") in _WITH_ARGUMENT and tokens[at].startswith("\\"):
        return _atom_end(tokens, at + 1)
    return at + 1
