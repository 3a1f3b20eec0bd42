"""Brings the angles of a program to its beginning, so that their sines and cosines can be computed all at once."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from symdyn.program.ssa import Op, Program

TURNS = frozenset({Op.SIN, Op.COS})


@dataclass(frozen=True, slots=True)
class Turned:
    """A program whose lines before ``start`` are those that its first angles depend on.

    ``angles`` are line numbers; ``labels`` are names for the sines and cosines of these that are used.
    """

    program: Program
    angles: tuple[int, ...] = ()
    start: int = 0
    labels: Mapping[tuple[Op, int], str] = field(default_factory=dict)


def angles_first(program: Program) -> Turned:
    """The same program, reordered; an angle that depends on another sine or cosine stays where it is."""
    nodes = program.nodes
    deep: list[bool] = []  # whether a sine or cosine went into the line
    for node in nodes:
        deep.append(node.op in TURNS or any(deep[argument] for argument in node.args))
    turns = [index for index, node in enumerate(nodes) if node.op in TURNS and not deep[node.args[0]]]
    needed = {nodes[index].args[0] for index in turns}
    angles = sorted(needed)
    for index in reversed(range(len(nodes))):
        if index in needed:
            needed.update(nodes[index].args)
    order = sorted(range(len(nodes)), key=lambda index: index not in needed)
    place = {old: new for new, old in enumerate(order)}
    moved = tuple(nodes[old]._replace(args=tuple(place[a] for a in nodes[old].args)) for old in order)
    labels: dict[tuple[Op, int], str] = {}
    for index in turns:
        labels.setdefault((nodes[index].op, place[nodes[index].args[0]]), nodes[index].name or f"t{place[index]}")
    outputs = tuple(place[output] for output in program.outputs)
    reordered = replace(program, nodes=moved, outputs=outputs)
    return Turned(reordered, tuple(place[angle] for angle in angles), len(needed), labels)
