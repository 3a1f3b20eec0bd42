"""What the operators in a set of equations mean, for those that occur in it."""

from __future__ import annotations

from collections.abc import Iterable

import sympy as sp

from symdyn.base.nonsmooth import clip, deadzone, outside, pushing, quantise, sign_of, step

_MEANINGS: tuple[tuple[type[sp.Function], str, str], ...] = (
    (sign_of, r"\operatorname{sign}(x)", "the sign of $x$; at rest, whatever in $[-1, 1]$ holds the body"),
    (step, r"\operatorname{step}(x)", "1 where $x > 0$, else 0"),
    (deadzone, r"\operatorname{dz}_S(x)", r"$x$ beyond $\pm S$, measured from there; 0 within"),
    (outside, r"\operatorname{out}_S(x)", r"1 where $|x| > S$, else 0"),
    (
        pushing,
        r"\operatorname{push}_S(x)",
        "0 where the springs and dampers of the contact at $x$ together would pull, else 1",
    ),
    (clip, r"\operatorname{clip}_a^b(x)", "$x$ held between $a$ and $b$"),
    (quantise, r"\operatorname{quant}_q(x)", "$x$ to the nearest multiple of $q$"),
)


def notation(expressions: Iterable[sp.Expr]) -> tuple[tuple[str, str], ...]:
    """(LaTeX, meaning) of each operator that occurs, in a fixed order; meanings may hold LaTeX between dollar signs."""
    found = {type(atom) for e in expressions for atom in sp.sympify(e, strict=True).atoms(sp.Function)}
    return tuple((symbol, words) for kind, symbol, words in _MEANINGS if kind in found)
