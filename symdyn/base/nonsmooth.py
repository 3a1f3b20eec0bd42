"""Non-smooth primitives of friction and backlash as SymPy functions whose derivatives stay functions.

SymPy's own ``sign`` differentiates to a Dirac delta, which no code can evaluate; here the derivative
is taken piecewise, which is what an integrator that locates the events needs.
"""

from __future__ import annotations

from typing import Any, ClassVar

import sympy
from sympy.core.function import ArgumentIndexError


class _Piecewise(sympy.Function):  # type: ignore[misc]
    """A real function of real arguments with its own name in LaTeX."""

    _latex_name: ClassVar[str]

    def _eval_is_real(self) -> bool | None:
        return True if all(argument.is_real for argument in self.args) else None

    def _latex_head(self, printer: Any) -> str:
        return self._latex_name

    def _latex(self, printer: Any, exp: str | None = None) -> str:
        power = "" if exp is None else f"^{{{exp}}}"
        head = self._latex_head(printer)
        body = rf"\left({printer._print(self.args[0])}\right)"
        if power and "_" in head:
            return rf"\left({head}{body}\right){power}"
        return f"{head}{power}{body}"


class _PiecewiseConstant(_Piecewise):
    """A function that is constant between its jumps: the derivative is 0 in every argument."""

    def fdiff(self, argindex: int = 1) -> sympy.Expr:
        if not 1 <= argindex <= len(self.args):
            raise ArgumentIndexError(self, argindex)
        return sympy.S.Zero


class sign_of(_PiecewiseConstant):
    """-1, 0 or 1: the sign of x."""

    nargs = 1
    _latex_name = r"\operatorname{sign}"

    @classmethod
    def eval(cls, x: sympy.Expr) -> sympy.Expr | None:
        if x.is_zero:
            return sympy.S.Zero
        if x.is_positive:
            return sympy.S.One
        if x.is_negative:
            return sympy.S.NegativeOne
        if x.could_extract_minus_sign():
            return -cls(-x)
        return None


class step(_PiecewiseConstant):
    """1 where x > 0, else 0."""

    nargs = 1
    _latex_name = r"\operatorname{step}"

    @classmethod
    def eval(cls, x: sympy.Expr) -> sympy.Expr | None:
        if x.is_positive:
            return sympy.S.One
        if x.is_nonpositive:
            return sympy.S.Zero
        return None


def _width(s: sympy.Expr) -> sympy.Expr:
    if s.is_negative:
        raise ValueError(f"the half-width of a dead zone cannot be negative: {s}")
    return s


class outside(_PiecewiseConstant):
    """1 where abs(x) > s, else 0; s >= 0 is the half-width of the gap, and without a gap 1 everywhere."""

    nargs = 2
    _latex_name = r"\operatorname{out}"

    @classmethod
    def eval(cls, x: sympy.Expr, s: sympy.Expr) -> sympy.Expr | None:
        _width(s)
        if s.is_zero:
            return sympy.S.One
        if x.is_zero:
            return sympy.S.Zero
        if x.is_number and s.is_number and x.is_real and s.is_real:
            return step(abs(x) - s)
        if x.could_extract_minus_sign():
            return cls(-x, s)
        return None

    def _latex_head(self, printer: Any) -> str:
        return f"{self._latex_name}_{{{printer._print(self.args[1])}}}"


class pushing(_PiecewiseConstant):
    """0 where flanks with a clearance s > 0, engaged at x, would exert a force of the sign of x: pull; else 1."""

    nargs = 3
    _latex_name = r"\operatorname{push}"

    @classmethod
    def eval(cls, force: sympy.Expr, x: sympy.Expr, s: sympy.Expr) -> sympy.Expr | None:
        if _width(s).is_zero or force.is_zero or x.is_zero:
            return sympy.S.One
        if (force * x).is_negative:
            return sympy.S.One
        if (force * x).is_positive and s.is_positive:
            return sympy.S.Zero
        if x.could_extract_minus_sign():
            return cls(-force, -x, s)
        return None

    def _latex_head(self, printer: Any) -> str:
        return f"{self._latex_name}_{{{printer._print(self.args[2])}}}"

    def _latex(self, printer: Any, exp: str | None = None) -> str:
        x = self.args[1]  # the force is that of all springs and dampers there: it would only repeat them
        twist = printer._print(x.args[0] if isinstance(x, deadzone) else x)
        body = rf"{self._latex_head(printer)}\left({twist}\right)"
        return body if exp is None else rf"\left({body}\right)^{{{exp}}}"


class deadzone(_Piecewise):
    """x - s where x > s, x + s where x < -s, else 0; s >= 0 is the half-width of the gap."""

    nargs = 2
    _latex_name = r"\operatorname{dz}"

    @classmethod
    def eval(cls, x: sympy.Expr, s: sympy.Expr) -> sympy.Expr | None:
        _width(s)
        if x.is_zero:
            return sympy.S.Zero
        if s.is_zero:
            return x
        if x.is_number and s.is_number and x.is_real and s.is_real:
            return outside(x, s) * (x - s * sign_of(x))
        if x.could_extract_minus_sign():
            return -cls(-x, s)
        return None

    def fdiff(self, argindex: int = 1) -> sympy.Expr:
        x, s = self.args
        if argindex == 1:
            return outside(x, s)
        if argindex == 2:
            return -sign_of(x) * outside(x, s)
        raise ArgumentIndexError(self, argindex)

    def _latex_head(self, printer: Any) -> str:
        return f"{self._latex_name}_{{{printer._print(self.args[1])}}}"


class clip(_Piecewise):
    """x held between two bounds, low <= high; where both are infinite, x itself."""

    nargs = 3
    _latex_name = r"\operatorname{clip}"

    @classmethod
    def eval(cls, x: sympy.Expr, low: sympy.Expr, high: sympy.Expr) -> sympy.Expr | None:
        if (high - low).is_negative:
            raise ValueError(f"the bounds of a clip are the wrong way round: {low} > {high}")
        if low is sympy.S.NegativeInfinity and high is sympy.S.Infinity:
            return x
        if (x - low).is_nonnegative and (high - x).is_nonnegative:
            return x
        if (low - x).is_nonnegative:
            return low
        return high if (x - high).is_nonnegative else None

    def fdiff(self, argindex: int = 1) -> sympy.Expr:
        x, low, high = self.args
        if not 1 <= argindex <= 3:
            raise ArgumentIndexError(self, argindex)
        return (step(x - low) * step(high - x), step(low - x), step(x - high))[argindex - 1]

    def _latex_head(self, printer: Any) -> str:
        return f"{self._latex_name}_{{{printer._print(self.args[1])}}}^{{{printer._print(self.args[2])}}}"

    def _latex(self, printer: Any, exp: str | None = None) -> str:
        body = rf"{self._latex_head(printer)}\left({printer._print(self.args[0])}\right)"
        return body if exp is None else rf"\left({body}\right)^{{{exp}}}"


class quantise(_PiecewiseConstant):
    """x to the nearest multiple of q (halves upwards); q = 0 is no quantisation: x itself."""

    nargs = 2
    _latex_name = r"\operatorname{quant}"

    @classmethod
    def eval(cls, x: sympy.Expr, q: sympy.Expr) -> sympy.Expr | None:
        if q.is_negative:
            raise ValueError(f"a quantum cannot be negative: {q}")
        if q.is_zero or x.is_zero:
            return x
        if x.is_number and q.is_number and x.is_real and q.is_real:
            return q * sympy.floor(x / q + sympy.S.Half)
        return None

    def fdiff(self, argindex: int = 1) -> sympy.Expr:
        return self / self.args[1] if argindex == 2 else super().fdiff(argindex)

    def _latex_head(self, printer: Any) -> str:
        return f"{self._latex_name}_{{{printer._print(self.args[1])}}}"


_KINKED = (sympy.Abs, sympy.sign, sympy.Min, sympy.Max)


def is_smooth(expression: sympy.Expr) -> bool:
    """Whether the expression has no jump and no kink."""
    return not sympy.sympify(expression).has(sign_of, step, outside, pushing, deadzone, clip, quantise, *_KINKED)


def absorb(expression: sympy.Expr) -> sympy.Expr:
    """``out_s(x)`` is idempotent, and absorbed by ``dz_s(x)``: products that a chain rule makes get short again.

    So is ``push_s(F, x)``, idempotent.
    """
    return expression.replace(lambda e: (e.is_Mul or e.is_Pow) and e.has(outside, pushing), _absorb_product)


def _absorb_product(product: sympy.Expr) -> sympy.Expr:
    factors = sympy.Mul.make_args(product)
    if any(factor.is_Add and factor.has(outside, deadzone, pushing) for factor in factors):
        return absorb(sympy.expand_mul(product))
    gaps = {factor.args for factor in factors if isinstance(factor, deadzone)}
    kept: list[sympy.Expr] = []
    for factor in factors:
        base, exponent = factor.as_base_exp()
        if isinstance(base, (outside, pushing)) and exponent.is_positive:
            if base.args not in gaps and base not in kept:
                kept.append(base)
        else:
            kept.append(factor)
    return sympy.Mul(*kept)
