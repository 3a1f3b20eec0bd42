"""An XML file as plain records that know where each tag and attribute stands; hardened, nothing outside is read."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from lxml import etree

from symdyn.base.errors import InputError, Problem, Where
from symdyn.spec.toml_positions import KeyPath

LARGEST_XML = 16 << 20  # bytes
DEEPEST_XML = 64

_PROLOG = re.compile(r"(?:\s+|<!--.*?-->|<\?.*?\?>)*", re.DOTALL)
_TAG = re.compile(
    r"""<!--.*?-->|<!\[CDATA\[.*?\]\]>|<\?.*?\?>|</(?P<close>[^\s>]+)\s*>
    |<(?P<open>[^\s/>!?]+)(?P<attributes>(?:[^>"']|"[^"]*"|'[^']*')*?)(?P<empty>/?)>""",
    re.DOTALL | re.VERBOSE,
)
_ATTRIBUTE = re.compile(r"""(?P<name>[^\s=]+)\s*=\s*(?:"(?P<double>[^"]*)"|'(?P<single>[^']*)')""")
_END = re.compile(r"premature end|end of (?:data|document|file)|not terminated|document is empty", re.IGNORECASE)


@dataclass(frozen=True, slots=True)
class Attribute:
    """``start`` and ``end`` are offsets in the text, of what stands between the quotes."""

    name: str
    value: str
    start: int
    end: int


@dataclass(frozen=True, slots=True)
class Element:
    """Offsets in the text: of its ``<``, behind the ``>`` of its start tag, of its end tag (None: ``<a/>``)."""

    name: str
    attributes: Mapping[str, Attribute]
    start: int
    opened: int
    closed: int | None
    children: tuple[Element, ...]

    def all(self, name: str) -> tuple[Element, ...]:
        return tuple(child for child in self.children if child.name == name)

    def first(self, name: str) -> Element | None:
        return next(iter(self.all(name)), None)

    def walk(self) -> Iterator[Element]:
        yield self
        for child in self.children:
            yield from child.walk()


@dataclass(frozen=True)
class XmlSource:
    """The text and its root. Places of a robot's numbers are noted in ``named`` while it is built."""

    text: str
    file: str
    root: Element
    foreign: tuple[Problem, ...]  # warnings: SD404, prefixes that are declared nowhere
    named: dict[KeyPath, int] = field(default_factory=dict)

    def where(self, path: KeyPath, *, key: bool = False) -> Where:
        """Place of what was noted under a key path, or under the nearest one around it; ``("@", offset)`` is itself."""
        if path[:1] == ("@",):
            return place(self.text, self.file, int(path[1]))
        for length in range(len(path), 0, -1):
            if path[:length] in self.named:
                return place(self.text, self.file, self.named[path[:length]])
        return Where(self.file)


def at(item: Element | Attribute) -> KeyPath:
    """The key path of a tag or of an attribute's value."""
    return ("@", item.start)


def place(text: str, file: str, offset: int) -> Where:
    return Where(file, text.count("\n", 0, offset) + 1, offset - text.rfind("\n", 0, offset))


def parse_xml(text: str, file: str) -> XmlSource:
    """Parse an XML text. InputError SD401 (not well-formed), SD402 (a DTD), SD002 (too deep), SD004 (too large)."""
    if len(text.encode(errors="replace")) > LARGEST_XML:
        raise InputError(Problem("SD004", "the text is larger than 16 MiB", Where(file)))
    if "\0" in text:
        raise InputError(Problem("SD401", "not well-formed XML: a NUL character", place(text, file, text.index("\0"))))
    prolog = _PROLOG.match(text)
    if prolog is not None and text.startswith("<!DOCTYPE", prolog.end()):
        where = place(text, file, prolog.end())
        raise InputError(Problem("SD402", "a DTD is not allowed", where, "remove the <!DOCTYPE ...> declaration"))
    root, foreign = _parsed(text, file)
    elements = list(root.iter("*"))
    tags = [match for match in _TAG.finditer(text) if match["open"] or match["close"]]
    too_deep = _too_deep(tags)
    if too_deep is not None:
        where = place(text, file, too_deep.start())
        raise InputError(Problem("SD002", f"nested deeper than {DEEPEST_XML} levels", where))
    return XmlSource(text, file, _records(elements, tags), foreign)


def _too_deep(tags: list[re.Match[str]]) -> re.Match[str] | None:
    depth = 0
    for tag in tags:
        depth += 1 if tag["open"] else -1
        if depth > DEEPEST_XML:
            return tag
        depth -= 1 if tag["empty"] else 0
    return None


def _parser(*, recover: bool) -> etree.XMLParser:
    return etree.XMLParser(
        encoding="utf-8",
        resolve_entities=False,
        no_network=True,
        load_dtd=False,
        dtd_validation=False,
        huge_tree=False,
        recover=recover,
    )


def _parsed(text: str, file: str) -> tuple[etree._Element, tuple[Problem, ...]]:
    content = text.encode(errors="surrogatepass")
    parser = _parser(recover=False)
    try:
        return etree.fromstring(content, parser), ()
    except etree.XMLSyntaxError as error:
        entries = list(parser.error_log)
        if not entries or any(entry.domain_name != "NAMESPACE" for entry in entries):
            raise InputError(_syntax_problem(error, text, file)) from None
    root = etree.fromstring(content, _parser(recover=True))
    if root is None:
        raise InputError(Problem("SD401", "not well-formed XML", Where(file)))
    foreign = (
        Problem(
            "SD404",
            f"{entry.message}: ignored",
            Where(file, entry.line, entry.column),
            "declare it at the root: xmlns:prefix=\"...\"",
        )
        for entry in entries
    )  # fmt: skip
    return root, tuple(foreign)


def _syntax_problem(error: etree.XMLSyntaxError, text: str, file: str) -> Problem:
    line, column = error.lineno or 1, max(1, error.offset or 1)
    message = (error.msg or "the document is empty").partition(", line ")[0]
    if "Entity '" in message:
        return Problem("SD402", f"{message}: entities are not allowed", Where(file, line, column), "write it out")
    is_cut = not text.rstrip().endswith(">") or _END.search(message) is not None
    hint = "the file is empty, or cut off: fetch it again" if is_cut else ""
    return Problem("SD401", f"not well-formed XML: {message}", Where(file, line, column), hint)


def _records(elements: list[etree._Element], tags: list[re.Match[str]]) -> Element:
    """Tags of the text and elements of the parser, in one order, as records; children before their parents."""
    opened: list[tuple[etree._Element, re.Match[str], list[Element]]] = []
    pending = iter(elements)
    for tag in tags:
        if tag["open"]:
            opened.append((next(pending), tag, []))
            if not tag["empty"]:
                continue
        element, start, children = opened.pop()
        closed = None if tag is start else tag.start()
        name = f"{element.prefix}:{etree.QName(element).localname}" if element.prefix else _local(str(element.tag))
        record = Element(name, _attributes(element, start), start.start(), start.end(), closed, tuple(children))
        if not opened:
            return record
        opened[-1][2].append(record)
    raise AssertionError("a well-formed text closes its root")


def _local(tag: str) -> str:
    return tag.rpartition("}")[2]


def _attributes(element: etree._Element, tag: re.Match[str]) -> dict[str, Attribute]:
    found = {}
    for match in _ATTRIBUTE.finditer(tag["attributes"]):
        kind = "single" if match["double"] is None else "double"
        start, end = (tag.start("attributes") + offset for offset in match.span(kind))
        value = element.get(match["name"]) if ":" not in match["name"] else None
        if value is not None:
            found[match["name"]] = Attribute(match["name"], str(value), start, end)
    return found
