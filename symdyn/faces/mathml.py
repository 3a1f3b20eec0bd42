"""Equations as MathML, which browsers and notebooks draw without any script."""

from __future__ import annotations

import re
from collections.abc import Container
from xml.etree import ElementTree

from latex2mathml.converter import convert
from markupsafe import Markup

from symdyn.base.wording import word_set
from symdyn.emit.latex_text import Equation

NAMESPACE = "{http://www.w3.org/1998/Math/MathML}"
ELEMENTS = frozenset(
    NAMESPACE + name
    for name in word_set(
        "math mrow mi mn mo mtext mspace mstyle mfrac msqrt mroot msub msup msubsup mover munder munderover"
    )
)
_UPRIGHT = re.compile(r'(?:<mi mathvariant="normal">[A-Za-z]</mi>){2,}')
_SIGN = re.compile(r'(form="prefix">[^<]*</mo>)<mo>(&#x02212;|&#x2212;)</mo>')


def mathml(latex: str) -> Markup:
    """A ``<math>`` element.

    Raises ValueError if the converter let anything but MathML through: it does not escape ``\\text{...}``.
    """
    text: str = convert(latex)
    try:
        elements = {element.tag for element in ElementTree.fromstring(text).iter()}
    except ElementTree.ParseError:
        raise ValueError(f"no MathML for {latex!r}") from None
    if elements - ELEMENTS:
        raise ValueError(f"unexpected elements in the MathML of {latex!r}: {sorted(elements - ELEMENTS)}")
    text = _SIGN.sub(r'\1<mo form="prefix">\2</mo>', text)  # behind a bracket it would be spaced as a binary one
    # Words, not products of letters.
    return Markup(_UPRIGHT.sub(lambda run: f"<mi>{re.sub('<[^>]*>', '', run[0])}</mi>", text))


def equation_markup(equation: Equation, new: Container[str] = ()) -> Markup:
    """An equation that wraps between terms; the LaTeX terms in ``new`` are of class ``new``."""
    left = [_term(term, first=i == 0, new=term in new) for i, term in enumerate(equation.left)] or [mathml("0")]
    right = [_term(term, first=i == 0, new=term in new) for i, term in enumerate(equation.right)] or [mathml("0")]
    right[0] = Markup('<span class="together"><span class="equals">=</span> {}</span>').format(right[0])
    return Markup(" ").join([*left, *right])


def _term(term: str, *, first: bool, new: bool) -> Markup:
    """The sign stands outside of ``<math>``, where it is spaced as a binary one."""
    sign, body = "", term
    if term[:1] in "+-":
        sign, body = term[0].replace("-", "−"), term[1:].lstrip()
    if first:
        sign = sign.replace("+", "")
    elif sign:
        sign += "\N{NO-BREAK SPACE}"
    kind = Markup(' class="term new"') if new else Markup(' class="term"')
    return Markup("<span{}>{}{}</span>").format(kind, sign, mathml(body))
