"""Where each key and value of a TOML text stands: key path -> line and column, by tree-sitter."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tree_sitter import Node

KeyPath = tuple[str | int, ...]  # ("joint", 1, "link", "mass"): as the parsed data is indexed


RawPoint = tuple[int, int]  # 0-based line, and offset in bytes


@dataclass(frozen=True, slots=True)
class Position:
    """1-based line and column, in characters."""

    line: int
    column: int


@dataclass(frozen=True, slots=True)
class Positions:
    """Places of keys and values by key path; ``repeated``: (path, again, first) of keys defined twice."""

    lines: list[bytes]
    keys: dict[KeyPath, RawPoint] = field(default_factory=dict)
    values: dict[KeyPath, RawPoint] = field(default_factory=dict)
    repeated: list[tuple[KeyPath, RawPoint, RawPoint]] = field(default_factory=list)

    def find(self, path: KeyPath, *, key: bool = False) -> Position | None:
        """Position of a value (or of its key), else of the nearest table around it that is written down."""
        first, second = (self.keys, self.values) if key else (self.values, self.keys)
        for length in range(len(path), 0, -1):
            point = first.get(path[:length]) or second.get(path[:length])
            if point is not None:
                return self.position(point)
        return None

    def position(self, point: RawPoint) -> Position:
        row, offset = point
        before = self.lines[row][:offset] if row < len(self.lines) else b""
        return Position(row + 1, len(before.decode(errors="replace")) + 1)


def positions_of(text: str) -> Positions:
    """Index a TOML text; one with syntax errors is indexed as far as it can be made out."""
    import tree_sitter
    import tree_sitter_toml

    parser = tree_sitter.Parser(tree_sitter.Language(tree_sitter_toml.language()))
    content = text.encode(errors="replace")
    tree = parser.parse(content)
    walker = _Walker(content.split(b"\n"))
    walker.document(tree.root_node)
    return walker.found


class _Walker:
    """One pass over the syntax tree, with a stack of its own: nesting must not exhaust Python's."""

    def __init__(self, lines: list[bytes]) -> None:
        self.found = Positions(lines)
        self._lengths: dict[KeyPath, int] = {}  # of the arrays of tables so far

    def document(self, root: Node) -> None:
        pending: list[tuple[Node, KeyPath]] = []
        for child in root.named_children:
            if child.type == "pair":
                pending.append((child, ()))
            elif child.type in ("table", "table_array_element"):
                header = self._header(child)
                pending.extend((pair, header) for pair in child.named_children if pair.type == "pair")
        pending.reverse()
        while pending:
            node, path = pending.pop()
            pending.extend(reversed(self._visit(node, path)))

    def _header(self, table: Node) -> KeyPath:
        """The key path that ``[a.b]`` or ``[[a.b]]`` opens."""
        key = next((child for child in table.named_children if child.type.endswith("key")), None)
        parts = _key_parts(key) if key is not None else []
        path: KeyPath = ()
        for depth, part in enumerate(parts):
            path = (*path, part)
            is_new_element = depth == len(parts) - 1 and table.type == "table_array_element"
            if is_new_element:
                self._lengths[path] = self._lengths.get(path, 0) + 1
            if path in self._lengths:
                if is_new_element and key is not None:
                    self.found.keys.setdefault(path, _start(key))
                path = (*path, self._lengths[path] - 1)
        if key is not None:
            self._define(path, key)
        return path

    def _visit(self, node: Node, path: KeyPath) -> list[tuple[Node, KeyPath]]:
        """Record one node; what is left to visit inside it."""
        if node.type == "pair":
            key, *values = node.named_children
            path = (*path, *_key_parts(key))
            self._define(path, key)
            return [(value, path) for value in values[:1]]
        self.found.values.setdefault(path, _start(node))
        if node.type == "inline_table":
            return [(child, path) for child in node.named_children if child.type == "pair"]
        if node.type == "array":
            items = [child for child in node.named_children if child.type != "comment"]
            return [(child, (*path, index)) for index, child in enumerate(items)]
        return []

    def _define(self, path: KeyPath, key: Node) -> None:
        here = _start(key)
        first = self.found.keys.setdefault(path, here)
        if first != here:
            self.found.repeated.append((path, here, first))


def _start(node: Node) -> RawPoint:
    return node.start_point.row, node.start_point.column


def _key_parts(key: Node) -> list[str]:
    """The parts of a bare, quoted or dotted key."""
    return [_key_text(leaf) for leaf in _key_leaves(key)]


def _key_leaves(key: Node) -> Iterator[Node]:
    # dotted_key nests to the left: ((a . b) . c); walked without recursion
    leaves: list[Node] = []
    while key.type == "dotted_key":
        children = key.named_children
        leaves.extend(reversed(children[1:]))
        key = children[0]
    leaves.append(key)
    return reversed(leaves)


def _key_text(leaf: Node) -> str:
    raw = leaf.text.decode(errors="replace") if leaf.text is not None else ""
    if leaf.type != "quoted_key":
        return raw
    try:
        return next(iter(tomllib.loads(f"{raw} = 0")))
    except (ValueError, StopIteration):
        return raw
