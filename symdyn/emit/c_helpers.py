"""The static functions that an emitted C source may need: what <math.h> lacks, waves without a branch, blocks."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from symdyn.base.wording import word_set
from symdyn.program.ssa import Op, Program

INLINE = "SYMDYN_INLINE"  # a macro of the source: whatever makes the compiler at hand inline for certain
NAMES = word_set(
    "sign_of step_of lesser greater wave_of sine_of cosine_of take_rows give_rows take_columns give_columns"
)

_OF_OPS: Mapping[Op, str] = {  # not fmin and fmax: they are calls, and treat NaN otherwise
    Op.SIGN: f"{INLINE} double sign_of(double x) {{ return x > 0.0 ? 1.0 : (x < 0.0 ? -1.0 : 0.0); }}",
    Op.STEP: f"{INLINE} double step_of(double x) {{ return x > 0.0 ? 1.0 : 0.0; }}",
    Op.MIN: f"{INLINE} double lesser(double a, double b) {{ return b < a ? b : a; }}",
    Op.MAX: f"{INLINE} double greater(double a, double b) {{ return b > a ? b : a; }}",
    Op.SIN: f"{INLINE} double sine_of(double x) {{ return wave_of(x, 0.0, sin(x)); }}",
    Op.COS: f"{INLINE} double cosine_of(double x) {{ return wave_of(x, 1.0, cos(x)); }}",
}
# As the Numba kernel's _sincos, but with the bits of numbers where that one compares them, and with neither the floor
# nor the test of size: older processors have no vector instruction for these, or compilers do not use it.
_WAVE = f"""\
/* The sine of x + lead pi/2 without a branch, so that loops over states vectorise: to 2.3e-16 for |x| up to 1e6;
 * beyond, as exact as x itself is spaced; not a number from 1e15 on. The argument is reduced by multiples of pi/2 in
 * three parts (Cody and Waite 1980), polynomials are those of fdlibm (Sun Microsystems 1993). Where the compiler may
 * reorder sums, or computes with more digits than a double has, the reduction would fail: there libm is called.
 */
#if defined(__FAST_MATH__) || defined(__ASSOCIATIVE_MATH__) || defined(_M_FP_FAST)
#define wave_of(x, lead, libm) (libm)
#elif defined(__FLT_EVAL_METHOD__) && (__FLT_EVAL_METHOD__ == 2 || __FLT_EVAL_METHOD__ < 0)
#define wave_of(x, lead, libm) (libm)
#else
#define wave_of(x, lead, libm) reduced_wave_of(x, lead)
{INLINE} double reduced_wave_of(double x, double lead)
{{
    const double whole = 6755399441055744.0; /* what is added to it is rounded, and stands in its lowest bits */
    const double shifted = x * 0.6366197723675814 + whole;
    const double n = shifted - whole;
    const double r = ((x - n * 1.5707963267341256) - n * 6.077100506303966e-11) - n * 2.0222662487959506e-21;
    const double z = r * r;
    const double s = 8.33333333332248946124e-03 + z * (-1.98412698298579493134e-04 + z * (2.75573137070700676789e-06
        + z * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10)));
    const double c = 2.48015872894767294178e-05 + z * (-2.75573143513906633035e-07 + z * (2.08757232129817482790e-09
        + z * -1.13596475577881948265e-11));
    union {{ double number; unsigned long long bits; }} sine, cosine, quarter, wave;
    sine.number = r + r * z * (-1.66666666666666324348e-01 + z * s);
    cosine.number = 1.0 - (0.5 * z - z * z * (4.16666666666666019037e-02 + z * (-1.38888888888741095749e-03 + z * c)));
    quarter.number = shifted + lead;
    const unsigned long long odd = 0 - (quarter.bits & 1), sign = (quarter.bits & 2) << 62;
    wave.bits = ((cosine.bits & odd) | (sine.bits & ~odd)) ^ sign;
    const double reach = x * 1.797693134862316e293; /* infinite from 1e15 on */
    return wave.number + (reach - reach);
}}
#endif"""
_BLOCKS = f"""\
/* States to and from a block, in which entry i of state k is at [i * S + k]. */
{INLINE} void take_rows(double *block, size_t S, const double *rows, size_t states, size_t entries)
{{
    for (size_t k = 0; k < states; k++)
        for (size_t i = 0; i < entries; i++)
            block[i * S + k] = rows[k * entries + i];
}}

{INLINE} void give_rows(double *rows, size_t states, size_t entries, const double *block, size_t S)
{{
    for (size_t k = 0; k < states; k++)
        for (size_t i = 0; i < entries; i++)
            rows[k * entries + i] = block[i * S + k];
}}

{INLINE} void take_columns(double *block, size_t S, const double *from, size_t states, size_t entries, size_t count)
{{
    for (size_t i = 0; i < entries; i++)
        for (size_t k = 0; k < states; k++)
            block[i * S + k] = from[i * count + k];
}}

{INLINE} void give_columns(double *to, size_t states, size_t entries, size_t count, const double *block, size_t S)
{{
    for (size_t i = 0; i < entries; i++)
        for (size_t k = 0; k < states; k++)
            to[i * count + k] = block[i * S + k];
}}"""


def helpers(programs: Iterable[Program]) -> list[str]:
    """Definitions of the functions that the forms call: those of operations that <math.h> does not have, and blocks."""
    called = {node.op for program in programs for node in program.nodes}
    wave = [_WAVE] if called & {Op.SIN, Op.COS} else []
    return [*wave, *(text for op, text in _OF_OPS.items() if op in called), _BLOCKS]
