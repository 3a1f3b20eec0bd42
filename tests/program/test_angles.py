"""Angles come first, and the program stays what it was."""

from __future__ import annotations

import math

from mpmath import mpf

from symdyn.program.angles import angles_first
from symdyn.program.evaluate import evaluate
from symdyn.program.ssa import Argument, Node, Op, Program

PROGRAM = Program(
    "nested",
    (Argument("q", ("a", "b")),),
    (
        Node(Op.INPUT, name="a"),
        Node(Op.SIN, (0,), name="s_1"),
        Node(Op.INPUT, name="b"),
        Node(Op.MUL, (1, 2)),
        Node(Op.COS, (3,), name="deep"),
        Node(Op.ADD, (0, 2)),
        Node(Op.COS, (5,)),
        Node(Op.SIN, (5,)),
        Node(Op.MUL, (6, 4)),
        Node(Op.ADD, (8, 7)),
    ),
    (9, 1),
    (2,),
)


def test_the_first_angles_and_what_they_need_come_first() -> None:
    turned = angles_first(PROGRAM)
    nodes = turned.program.nodes
    assert [node.op for node in nodes[: turned.start]] == [Op.INPUT, Op.INPUT, Op.ADD]
    assert [nodes[angle].op for angle in turned.angles] == [Op.INPUT, Op.ADD]
    first, total = turned.angles
    assert turned.labels[Op.SIN, first] == "s_1"
    assert set(turned.labels) == {(Op.SIN, first), (Op.COS, total), (Op.SIN, total)}


def test_it_computes_the_same() -> None:
    a, b = 0.3, -1.7
    wanted = [math.cos(a + b) * math.cos(math.sin(a) * b) + math.sin(a + b), math.sin(a)]
    for program in (PROGRAM, angles_first(PROGRAM).program):
        found = evaluate(program, {"q": [mpf(a), mpf(b)]})
        assert all(abs(x - y) < 1e-15 for x, y in zip(found, wanted, strict=True))


def test_without_sines_nothing_moves() -> None:
    plain = Program("plain", (Argument("q", ("a",)),), (Node(Op.INPUT, name="a"), Node(Op.NEG, (0,))), (1,), (1,))
    turned = angles_first(plain)
    assert (turned.program, turned.angles, turned.labels) == (plain, (), {})
