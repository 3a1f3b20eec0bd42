"""Names that people give: which are allowed, and how they are written in LaTeX."""

from __future__ import annotations

import re
from collections.abc import Iterable
from itertools import groupby

from symdyn.base.errors import Problem
from symdyn.base.wording import quoted, word_set

LONGEST_NAME = 64

_IDENTIFIER = re.compile(r"[A-Za-z][A-Za-z0-9_]*", re.ASCII)
_ROBOT_NAME = re.compile(r"[a-z][a-z0-9]*(?:[-_][a-z0-9]+)*", re.ASCII)

# Fixed lists, not `keyword` and `builtins`: a file that reads on one Python must read on the next.
_KEYWORDS = word_set(
    """False None True and as assert async await break case class continue def del elif else except finally for from
    global if import in is lambda match nonlocal not or pass raise return try type while with yield"""
)
_BUILTINS = word_set(
    """abs aiter all anext any ascii bin bool breakpoint bytearray bytes callable chr classmethod compile complex
    copyright credits delattr dict dir divmod enumerate eval exec exit filter float format frozenset getattr globals
    hasattr hash help hex id input int isinstance issubclass iter len license list locals map max memoryview min next
    object oct open ord pow print property quit range repr reversed round set setattr slice sorted staticmethod str
    sum super tuple vars zip"""
)
_MEANT_BY_KERNELS = word_set(
    """q qd qdd tau t x u p out pi math numpy np numba nb njit prange
    sin cos tan asin acos atan atan2 sinh cosh tanh exp log sqrt sign"""
)
_RESERVED = _KEYWORDS | _BUILTINS | _MEANT_BY_KERNELS

_GREEK = word_set(
    """alpha beta gamma delta epsilon zeta eta theta iota kappa lambda mu nu xi pi rho sigma tau upsilon phi chi psi
    omega Gamma Delta Theta Lambda Xi Pi Sigma Upsilon Phi Psi Omega varepsilon vartheta varphi varrho"""
)
_LATEX_ESCAPES = str.maketrans(
    {
        "\\": r"\textbackslash{}",
        "{": r"\{",
        "}": r"\}",
        "$": r"\$",
        "&": r"\&",
        "#": r"\#",
        "%": r"\%",
        "_": r"\_",
        "^": r"\textasciicircum{}",
        "~": r"\textasciitilde{}",
        "<": r"\textless{}",
        ">": r"\textgreater{}",
        "`": r"\textasciigrave{}",
    }
)
_SUBSCRIPTED = re.compile(r"(?P<base>[^_^]+)(?:_(?:\{(?P<braced>[^_^]*)\}|(?P<single>\\[A-Za-z]+|[^{}\\_^])))?")


def identifier_problem(name: str) -> Problem | None:
    """What is wrong with the name of a parameter, joint or part (SD101 malformed, SD102 reserved), or None."""
    if len(name) > LONGEST_NAME:
        return Problem("SD101", f"name {quoted(name)} is longer than {LONGEST_NAME} characters")
    if _IDENTIFIER.fullmatch(name) is None:
        return Problem("SD101", f"{quoted(name)} is not a name", hint="a letter, then letters, digits and _ (ASCII)")
    if name in _RESERVED:
        return Problem("SD102", f"{quoted(name)} is a reserved word", hint=f"write {quoted(name + '_')}")
    return None


def robot_name_problem(name: str) -> Problem | None:
    """What is wrong with the name of a robot, which also names its folder of generated code; or None."""
    if len(name) > LONGEST_NAME:
        return Problem("SD101", f"name {quoted(name)} is longer than {LONGEST_NAME} characters")
    if _ROBOT_NAME.fullmatch(name) is None:
        return Problem(
            "SD101",
            f"{quoted(name)} is not a robot's name",
            hint='lower case, digits and hyphens, such as "irb6-axis1"',
        )
    if name in _KEYWORDS:
        return Problem("SD102", f"{quoted(name)} is a reserved word", hint=f"write {quoted(name + '-robot')}")
    return None


def collisions(names: Iterable[str]) -> tuple[tuple[int, int], ...]:
    """Pairs (later, first) of positions whose names are equal but for upper and lower case."""
    first: dict[str, int] = {}
    pairs = []
    for position, name in enumerate(names):
        known = first.setdefault(name.casefold(), position)
        if known != position:
            pairs.append((position, known))
    return tuple(pairs)


def latex_of(name: str) -> str:
    r"""An identifier in LaTeX's math mode: ``m_1`` is ``m_{1}``, ``K_Et`` is ``K_{Et}``, ``alpha`` is ``\alpha``.

    What follows the first underscore is the subscript, further underscores are commas in it. Digits that follow
    one letter are its subscript (``m1``). Words of three letters and more stand upright, a thin space between them.
    """
    base, *rest = [segment for segment in name.split("_") if segment]
    lettered = re.fullmatch(r"([A-Za-z]+)(\d+)", base)
    if lettered is not None and (len(lettered[1]) == 1 or lettered[1] in _GREEK):
        base, rest = lettered[1], [lettered[2], *rest]
    return _atom(base) + _subscript(rest)


def with_subscripts(latex: str, names: Iterable[str]) -> str:
    r"""A symbol with further subscripts: ``F_{c}`` at ``carriage`` is ``F_{c,\mathrm{carriage}}``."""
    added = ",".join(_phrase(name.split("_")) for name in names)
    match = _SUBSCRIPTED.fullmatch(latex)
    if match is None:
        return f"{{{latex}}}_{{{added}}}"
    own = match["braced"] or match["single"]
    return match["base"] + "_{" + (f"{own},{added}" if own else added) + "}"


def escape_latex(text: str) -> str:
    """Any text, for LaTeX's text mode."""
    return text.translate(_LATEX_ESCAPES)


def _is_word(segment: str) -> bool:
    return segment not in _GREEK and sum(c.isalpha() for c in segment) >= 3


def _atom(segment: str) -> str:
    if segment in _GREEK:
        return "\\" + segment
    return rf"\mathrm{{{segment}}}" if _is_word(segment) else segment


def _phrase(segments: Iterable[str]) -> str:
    """Symbols with commas between them; neighbouring words share one upright group, thin spaces between them."""
    parts: list[str] = []
    for are_words, run in groupby(filter(None, segments), _is_word):
        neighbours = list(run)
        parts += ["\\mathrm{" + r"\,".join(neighbours) + "}"] if are_words else [_atom(s) for s in neighbours]
    return ",".join(parts)


def _subscript(segments: list[str]) -> str:
    return f"_{{{_phrase(segments)}}}" if segments else ""
