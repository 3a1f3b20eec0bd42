"""The expression program in static single assignment form: what every pass reads and returns."""

from __future__ import annotations

import keyword
import math
from collections import Counter
from dataclasses import dataclass
from enum import StrEnum
from typing import NamedTuple

from symdyn.program.errors import ProgramError


class Op(StrEnum):
    """An operation on real numbers; SIGN(0) = 0, and STEP(x) is 1 where x > 0, else 0."""

    CONST = "const"
    INPUT = "input"
    ADD = "add"
    SUB = "sub"
    MUL = "mul"
    DIV = "div"
    NEG = "neg"
    SIN = "sin"
    COS = "cos"
    TAN = "tan"
    TANH = "tanh"
    EXP = "exp"
    LOG = "log"
    SQRT = "sqrt"
    ABS = "abs"
    SIGN = "sign"
    MIN = "min"
    MAX = "max"
    ATAN2 = "atan2"
    STEP = "step"
    FLOOR = "floor"


NULLARY = frozenset({Op.CONST, Op.INPUT})
BINARY = frozenset({Op.ADD, Op.SUB, Op.MUL, Op.DIV, Op.MIN, Op.MAX, Op.ATAN2})
COMMUTATIVE = frozenset({Op.ADD, Op.MUL, Op.MIN, Op.MAX})


def arity(op: Op) -> int:
    """How many arguments the operation takes."""
    return 0 if op in NULLARY else 2 if op in BINARY else 1


_ARITY = {op: arity(op) for op in Op}


class Node(NamedTuple):
    """One line of a program: an operation on earlier lines."""

    op: Op
    args: tuple[int, ...] = ()
    value: float | None = None  # of a CONST
    name: str | None = None  # of an INPUT; else an optional label, such as "omega_2_z"
    origin: str = ""  # the link and the law that the line came from: "link 2: angular velocity"


@dataclass(frozen=True, slots=True)
class Argument:
    """A vector argument of the function, and the names of its entries in order."""

    name: str
    symbols: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Program:
    """A straight-line function of real vectors.

    ``nodes`` are in topological order (arguments of a node come before it), ``outputs`` are node
    numbers in row-major order of an array of ``shape``. Checked when it is made.
    """

    name: str
    arguments: tuple[Argument, ...]
    nodes: tuple[Node, ...]
    outputs: tuple[int, ...]
    shape: tuple[int, ...]

    def __post_init__(self) -> None:
        check(self)

    @property
    def symbols(self) -> tuple[str, ...]:
        """Names of all scalar inputs, in the order of the arguments."""
        return tuple(symbol for argument in self.arguments for symbol in argument.symbols)


def check(program: Program) -> None:
    """Raise ProgramError (SD813) unless the program is well formed and safe to print as code."""
    names = [program.name, *(argument.name for argument in program.arguments)]
    input_ = Op.INPUT
    named = [node for node in program.nodes if node.name is not None]
    labels = [str(node.name) for node in named if node.op is not input_]
    for name in (*names, *program.symbols, *labels):
        if not (name.isidentifier() and name.isascii()) or keyword.iskeyword(name):
            raise _malformed(program, f"{name!r} is not an identifier")
    _unique(program, names[1:], "argument")
    _unique(program, [*program.symbols, *labels], "symbol or label")
    _unique(program, [str(node.name) for node in named if node.op is input_], "input line")
    inputs = frozenset(program.symbols)
    for index, (op, args, value, _, _) in enumerate(program.nodes):
        # What is right at a glance needs no closer look: every pass makes a program.
        if not args or value is not None or len(args) != _ARITY[op] or not -1 < args[0] < index > args[-1] > -1:
            _check_node(program, index, program.nodes[index], inputs)
    if not "".join({node.origin for node in program.nodes}).isprintable():  # they are printed in comments of one line
        index = next(i for i, node in enumerate(program.nodes) if not node.origin.isprintable())
        raise _malformed(program, f"line {index}: the origin holds a line break or a control character")
    if any(not 0 <= output < len(program.nodes) for output in program.outputs):
        raise _malformed(program, "an output names a line that does not exist")
    if any(extent < 0 for extent in program.shape) or math.prod(program.shape) != len(program.outputs):
        raise _malformed(program, f"{len(program.outputs)} outputs do not fill the shape {program.shape}")


def _check_node(program: Program, index: int, node: Node, inputs: frozenset[str]) -> None:
    if len(node.args) != arity(node.op):
        raise _malformed(program, f"line {index}: {node.op} takes {arity(node.op)} arguments, not {len(node.args)}")
    if any(not 0 <= argument < index for argument in node.args):
        raise _malformed(program, f"line {index}: an argument does not come before the line")
    if (node.op is Op.CONST) != (node.value is not None):
        raise _malformed(program, f"line {index}: constants, and only they, have a value")
    if node.value is not None and not math.isfinite(node.value):
        raise _malformed(program, f"line {index}: the constant is not finite")
    if node.op is Op.INPUT and node.name not in inputs:
        raise _malformed(program, f"line {index}: input {node.name!r} belongs to no argument")


def _unique(program: Program, names: list[str], what: str) -> None:
    if len(set(names)) != len(names):
        repeated = sorted(name for name, times in Counter(names).items() if times > 1)
        raise _malformed(program, f"{what} {', '.join(repeated)} appears more than once")


def _malformed(program: Program, message: str) -> ProgramError:
    return ProgramError("SD813", f"program {program.name!r}: {message}")
