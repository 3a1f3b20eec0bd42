"""Reads values of URDF attributes: plain decimal numbers in SI, one or three; nothing is taken for zero silently."""

from __future__ import annotations

import math
import re

import numpy as np
import numpy.typing as npt

from symdyn.base.wording import quoted
from symdyn.spec.findings import Findings
from symdyn.spec.xml_source import Attribute, Element, at

Array = npt.NDArray[np.float64]

_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?", re.ASCII)
_XACRO = re.compile(r"\$\{|\$\(")


class UrdfValues:
    """Reads attributes; what is wrong is added to the findings, and stands as its default."""

    def __init__(self, findings: Findings) -> None:
        self.findings = findings

    def text(self, element: Element, name: str) -> str | None:
        """The attribute, which must be there (SD411); None after an error."""
        attribute = self._required(element, name)
        if attribute is None or self._is_xacro(attribute):
            return None
        return attribute.value

    def number(self, element: Element, name: str, default: float | None = None, *, unlimited: bool = False) -> float:
        """One number; without ``default`` the attribute must be there. ``unlimited``: infinite is allowed."""
        attribute = element.attributes.get(name) if default is not None else self._required(element, name)
        if attribute is None:
            return default or 0.0
        return self._number(attribute.value.strip(), attribute, unlimited=unlimited)

    def three(self, element: Element | None, name: str, default: tuple[float, float, float]) -> Array:
        """Three numbers (3,) between spaces; the default where element or attribute is left out."""
        attribute = element.attributes.get(name) if element is not None else None
        if attribute is None or self._is_xacro(attribute):
            return np.array(default)
        words = attribute.value.split()
        if len(words) != 3:
            hint = (
                "write a decimal point, and spaces between numbers" if "," in attribute.value else 'such as "0 0 0.1"'
            )
            self._refuse(attribute, f"expected three numbers, found {quoted(attribute.value)}", hint)
            return np.array(default)
        return np.array([self._number(word, attribute) for word in words])

    def _number(self, word: str, attribute: Attribute, *, unlimited: bool = False) -> float:
        if self._is_xacro(attribute):
            return 0.0
        if unlimited and re.fullmatch(r"[+-]?inf(inity)?", word, re.IGNORECASE):
            return float(word)
        value = float(word) if _NUMBER.fullmatch(word) else math.nan
        if not math.isfinite(value):
            self._refuse(attribute, f"{quoted(word)} is not a finite number", _hint(word))
            return 0.0
        return value

    def _required(self, element: Element, name: str) -> Attribute | None:
        attribute = element.attributes.get(name)
        if attribute is None:
            self.findings.error(at(element), "SD411", f"<{element.name}> has no attribute {quoted(name)}")
        return attribute

    def _is_xacro(self, attribute: Attribute) -> bool:
        if _XACRO.search(attribute.value) is None:
            return False
        self.findings.error(
            at(attribute),
            "SD405",
            f"{quoted(attribute.value)} is xacro, which is not expanded",
            "name the file .urdf.xacro and install symdyn[xacro], or expand it first: xacro file.xacro > file.urdf",
        )
        return True

    def _refuse(self, attribute: Attribute, message: str, hint: str) -> None:
        self.findings.error(at(attribute), "SD403", f"{attribute.name}: {message}", hint)


def _hint(word: str) -> str:
    if word.endswith(","):
        return "numbers stand between spaces, without commas"
    if re.fullmatch(r"[+-]?\d+,\d+", word):
        return f"write a decimal point: {word.replace(',', '.')}"
    unit = re.fullmatch(rf"({_NUMBER.pattern})\s*[A-Za-z]+", word)
    if unit:
        return f"numbers of a URDF are plain, in SI units: {unit[1]}"
    return "write a plain decimal number"
