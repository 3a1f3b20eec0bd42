"""Random programs that stay away from poles and kinks, for tests that range over programs."""

from __future__ import annotations

from hypothesis import strategies as st

from symdyn.program.builder import Builder
from symdyn.program.ssa import Argument, Op, Program

SYMBOLS = ("x_1", "x_2", "x_3")
ARGUMENTS = (Argument("x", SYMBOLS[:2]), Argument("p", SYMBOLS[2:]))

# Irrational points in general position: no two lines of a small program are equal by accident.
POINTS = (
    {"x": (0.7320508075688772, -1.2360679774997896), "p": (0.4142135623730951,)},
    {"x": (-0.3178372451957822, 0.8793852415718167), "p": (-1.6457513110645907,)},
)

_PLAIN = (Op.ADD, Op.SUB, Op.MUL, Op.ADD, Op.SUB, Op.MUL, Op.NEG, Op.SIN, Op.COS)
_BOUNDED = (Op.TANH, Op.ABS, Op.SIGN, Op.STEP, Op.MIN, Op.MAX, Op.FLOOR)


def _grow(builder: Builder, draw: st.DrawFn, smooth: bool) -> None:
    line = st.integers(0, len(builder) - 1)
    op = draw(st.sampled_from(_PLAIN + (() if smooth else _BOUNDED) + (Op.DIV, Op.SQRT, Op.ATAN2)))
    x = draw(line)
    if op in (Op.ADD, Op.SUB, Op.MUL, Op.MIN, Op.MAX):
        builder.intern(op, (x, draw(line)), "random")
    elif op is Op.DIV:  # by a positive number that is not small
        y = draw(line)
        builder.intern(op, (x, _positive(builder, y)), "random")
    elif op is Op.SQRT:
        builder.intern(op, (_positive(builder, x),), "random")
    elif op is Op.ATAN2:
        builder.intern(op, (x, _positive(builder, draw(line))), "random")
    else:
        builder.intern(op, (x,), "random")


def _positive(builder: Builder, line: int) -> int:
    sine = builder.intern(Op.SIN, (line,))
    return builder.intern(Op.ADD, (builder.constant(2.5), sine))


@st.composite
def programs(draw: st.DrawFn, smooth: bool = False, size: int = 30) -> Program:
    """A program of up to ``size`` random operations, rich in equal, opposite and constant operands."""
    builder = Builder()
    for symbol in SYMBOLS:
        builder.input(symbol)
    for value in (0.0, 1.0, -1.0, 2.0, 0.5, 3.0):
        builder.constant(value)
    for _ in range(draw(st.integers(1, size))):
        _grow(builder, draw, smooth)
    outputs = draw(st.lists(st.integers(0, len(builder) - 1), min_size=1, max_size=4))
    return builder.program("random", ARGUMENTS, outputs, (len(outputs),))


@st.composite
def rotations(draw: st.DrawFn) -> Program:
    """Sums of products of sines and cosines of a few angles: what the trigonometric pass is about."""
    builder = Builder()
    symbols = [builder.input(symbol) for symbol in SYMBOLS]
    waves = [builder.intern(op, (angle,)) for angle in symbols[:2] for op in (Op.SIN, Op.COS)]
    factors = [*waves, *waves, symbols[2], builder.constant(3.0)]
    outputs = []
    for _ in range(draw(st.integers(1, 3))):
        total = None
        for _ in range(draw(st.integers(1, 6))):
            term = draw(st.sampled_from(factors))
            for factor in draw(st.lists(st.sampled_from(factors), max_size=3)):
                term = builder.intern(Op.MUL, (term, factor))
            sign = draw(st.sampled_from((Op.ADD, Op.SUB)))
            total = term if total is None else builder.intern(sign, (total, term))
        assert total is not None
        outputs.append(total)
    return builder.program("rotations", ARGUMENTS, outputs, (len(outputs),))
