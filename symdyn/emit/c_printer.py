"""C99's syntax: what the functions of a C source are made of."""

from __future__ import annotations

import re
from collections.abc import Mapping

from symdyn.base.wording import word_set
from symdyn.emit import printer
from symdyn.emit.c_helpers import INLINE
from symdyn.emit.c_helpers import NAMES as HELPERS
from symdyn.emit.printer import PARAMETERS, Syntax, argument_names, used_symbols
from symdyn.program.ssa import Op, Program

_CALLS: Mapping[Op, str] = {
    Op.SIN: "sine_of",
    Op.COS: "cosine_of",
    Op.TAN: "tan",
    Op.TANH: "tanh",
    Op.EXP: "exp",
    Op.LOG: "log",
    Op.SQRT: "sqrt",
    Op.ATAN2: "atan2",
    Op.ABS: "fabs",
    Op.FLOOR: "floor",
    Op.SIGN: "sign_of",
    Op.STEP: "step_of",
    Op.MIN: "lesser",
    Op.MAX: "greater",
}
_KEYWORDS = word_set(  # of C99 to C23, and of C++, whose compilers read the names in the header
    """auto break case char const continue default do double else enum extern float for goto if inline int long
    register restrict return short signed sizeof static struct switch typedef union unsigned void volatile while
    _Alignas _Alignof _Atomic _Bool _Complex _Generic _Imaginary _Noreturn _Static_assert _Thread_local _BitInt
    _Decimal32 _Decimal64 _Decimal128 alignas alignof bool constexpr false nullptr static_assert thread_local true
    typeof typeof_unqual asm and and_eq bitand bitor catch char8_t char16_t char32_t class co_await co_return
    co_yield compl concept const_cast consteval constinit decltype delete dynamic_cast explicit export friend
    mutable namespace new noexcept not not_eq operator or or_eq private protected public reinterpret_cast requires
    static_cast template this throw try typeid typename using virtual wchar_t xor xor_eq"""
)
_MACROS = word_set(  # of <math.h> and <stddef.h>, of compilers that do not keep to the standard, and of platforms
    """FP_ILOGB0 FP_ILOGBNAN FP_INFINITE FP_NAN FP_NORMAL FP_SUBNORMAL FP_ZERO FP_FAST_FMA FP_FAST_FMAF FP_FAST_FMAL
    HUGE HUGE_VAL HUGE_VALF HUGE_VALL INFINITY MATH_ERREXCEPT MATH_ERRNO MAXFLOAT NAN NULL DOMAIN SING OVERFLOW
    UNDERFLOW PLOSS TLOSS X_TLOSS M_1_PI M_2_PI M_2_SQRTPI M_E M_LN10 M_LN2 M_LOG10E M_LOG2E M_PI M_PI_2 M_PI_4
    M_SQRT1_2 M_SQRT2 fpclassify isfinite isgreater isgreaterequal isinf isless islessequal islessgreater isnan
    isnormal isunordered signbit math_errhandling signgam linux unix i386 near far huge interface small min max
    BOOL CONST FALSE IN OPTIONAL OUT TRUE VOID offsetof"""
)
_OWN = word_set("out k S count start states size_t")  # of the functions around a body
C99 = Syntax(
    calls=_CALLS,
    reserved=_KEYWORDS | _MACROS | HELPERS | {*_CALLS.values(), INLINE, "sin", "cos", *_OWN},
    define="const double {} = {};".format,
    store="{} = {};".format,
    comment=lambda text: f"/* {inside_comment(text)} */",
    entry=lambda vector, i: f"{vector}[{i}]" if vector == PARAMETERS else f"{vector}[{i} * S + k]",
)


def body_lines(program: Program, indent: str = "    ") -> list[str]:
    """Lines that load the inputs that are used, compute, and store the outputs; none warns of what is unused.

    Entry i of a vector is at ``i * S + k``: that of state k among S.
    """
    used = used_symbols(program)
    idle = [
        vector
        for vector, argument in zip(argument_names(program, C99), program.arguments, strict=True)
        if used.isdisjoint(argument.symbols)
    ]
    if not program.outputs:
        idle += ["out", "k", "S"]
    silenced = [f"{indent}(void){vector};" for vector in idle]
    return silenced + printer.body_lines(program, C99, "out[{} * S + k]".format, indent)


def identifier(name: str) -> str:
    """The name with an underscore for what no identifier may hold: the beginning of an identifier, never all of it."""
    plain = re.sub(r"[^0-9A-Za-z]+", "_", name).strip("_")
    return plain if plain[:1].isalpha() else f"robot_{plain}"


def string(text: str) -> str:
    """A string literal, ASCII alone; a question mark is escaped because two begin a trigraph."""
    escaped = (chr(b) if 32 <= b < 127 and chr(b) not in '"\\?' else f"\\{b:03o}" for b in text.encode())
    return f'"{"".join(escaped)}"'


def inside_comment(text: str) -> str:
    """The text, unable to end the comment around it, or to begin another."""
    return text.replace("*/", "* /").replace("/*", "/ *")
