"""Edits of an XML text in place: attributes set, elements added; all other bytes stay as they are."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

from symdyn.spec.xml_source import Element

_QUOTED = {'"': "&quot;", "'": "&apos;", "<": "&lt;", "&": "&amp;", ">": "&gt;"}


@dataclass
class XmlEdits:
    """Collects edits of one text by offset; ``apply`` makes them all."""

    text: str
    _pieces: list[tuple[int, int, str]] = field(default_factory=list)

    def set(self, element: Element, name: str, value: str) -> None:
        """Give an attribute a value; one that is not there is added behind the others."""
        attribute = element.attributes.get(name)
        if attribute is not None:
            self._pieces.append((attribute.start, attribute.end, _escaped(value)))
            return
        end = element.opened - (2 if element.closed is None else 1)  # before "/>" or ">"
        while self.text[end - 1].isspace():
            end -= 1
        self._pieces.append((end, end, f' {name}="{_escaped(value)}"'))

    def add(self, parent: Element, name: str, attributes: dict[str, str]) -> None:
        """Add an element as the last child, on a line of its own where its siblings have one."""
        inside = "".join(f' {key}="{_escaped(value)}"' for key, value in attributes.items())
        self.add_text(parent, f"<{name}{inside}/>")

    def add_text(self, parent: Element, tag: str) -> None:
        """As ``add``, of an element that is written out."""
        if parent.closed is None:
            end = parent.opened - 2
            self._pieces.append((end, parent.opened, f">{tag}</{parent.name}>"))
            return
        last = parent.children[-1] if parent.children else None
        if last is None:
            self._pieces.append((parent.opened, parent.opened, tag))
            return
        indent = re.search(r"(?:\r?\n)?[ \t]*\Z", self.text[: last.start])
        end = self._end_of(last)
        self._pieces.append((end, end, f"{indent[0] if indent else ''}{tag}"))

    def _end_of(self, element: Element) -> int:
        return element.opened if element.closed is None else self.text.index(">", element.closed) + 1

    def apply(self) -> str:
        text = self.text
        for start, end, new in sorted(self._pieces, key=lambda piece: piece[0])[::-1]:
            text = text[:start] + new + text[end:]
        return text


def _escaped(value: str) -> str:
    return "".join(_QUOTED.get(character, character) for character in value)
