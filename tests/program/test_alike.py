"""Programs that differ in the names of their inputs alone: optimised once, and each still itself."""

from __future__ import annotations

from hypothesis import given, settings
from hypothesis import strategies as st

from symdyn.program.alike import Optimizer
from symdyn.program.cost import count
from symdyn.program.evaluate import evaluate
from symdyn.program.optimize import optimize
from symdyn.program.ssa import Argument, Node, Op, Program

from .strategies import POINTS, programs, rotations

FIRST = (Argument("a", ("x", "y")),)
SECOND = (Argument("state", ("v", "w")), Argument("input", ("u",)))
AT = {"a": (0.25, -1.5)}


def renamed(program: Program, names: dict[str, str]) -> Program:
    """The same lines, with inputs and their arguments called otherwise."""
    arguments = tuple(Argument(f"{a.name}_", tuple(names[s] for s in a.symbols)) for a in program.arguments)
    nodes = tuple(
        n._replace(name=names[str(n.name)]) if n.op is Op.INPUT else n._replace(name=None) for n in program.nodes
    )
    return Program(f"{program.name}_like", arguments, nodes, program.outputs, program.shape)


@settings(deadline=None)
@given(program=st.one_of(programs(), rotations()))
def test_the_like_of_a_program_is_its_renamed_result(program: Program) -> None:
    own = {symbol: symbol for symbol in program.symbols}
    bare = renamed(program, own)  # without labels, which might be the new names of inputs
    like = renamed(program, {symbol: f"{symbol}_like" for symbol in program.symbols})
    optimizer = Optimizer()
    first, second = optimizer.optimize(bare), optimizer.optimize(like)
    assert (second.program.name, second.program.arguments) == (like.name, like.arguments)
    assert second.costs == first.costs
    assert sum(row.seconds for row in second.costs) == 0.0
    for point in POINTS:
        at = {f"{name}_": values for name, values in point.items()}
        assert evaluate(second.program, at, 50) == evaluate(first.program, at, 50)


def test_entries_that_are_inputs_or_numbers_may_differ() -> None:
    first = Program("first", FIRST, (*named("x", "y"), *law(0, 1, 2)), (5, 6), (2,))
    wide = (*named("v", "w"), Node(Op.CONST, value=1.0), *named("u"), *law(3, 1, 4))
    second = Program("second", SECOND, wide, (0, 7, 2, 8, 1), (5,))
    optimizer = Optimizer()
    lines = [node for node in optimizer.optimize(first).program.nodes if node.args]
    result = optimizer.optimize(second)
    assert sum(row.seconds for row in result.costs) == 0.0  # nothing was optimised again
    assert len([node for node in result.program.nodes if node.args]) == len(lines)
    at = {"state": (0.25, -1.5), "input": (0.75,)}
    assert evaluate(result.program, at, 30) == evaluate(second, at, 30)


def test_other_programs_are_optimised_for_themselves() -> None:
    inputs = named("x", "y")
    optimizer = Optimizer()
    for lines in (law(0, 1, 2), law(1, 0, 2), law(0, 0, 2)):
        for outputs in ((5, 6), (6, 5), (5, 5)):
            program = Program("f", FIRST, (*inputs, *lines), outputs, (2,))
            result = optimizer.optimize(program).program
            assert count(result) == count(optimize(program).program)
            assert evaluate(result, AT, 30) == evaluate(program, AT, 30)


def named(*names: str) -> tuple[Node, ...]:
    return tuple(Node(Op.INPUT, name=name) for name in names)


def law(a: int, b: int, after: int) -> tuple[Node, ...]:
    """sin(a), b sin(a), a sin(a), b sin(a) - a sin(a), a / b: lines from number ``after`` on."""
    products = (Node(Op.MUL, (b, after)), Node(Op.MUL, (a, after)))
    return (Node(Op.SIN, (a,)), *products, Node(Op.SUB, (after + 1, after + 2)), Node(Op.DIV, (a, b)))
