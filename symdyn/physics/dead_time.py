"""What all delays share: dead time as a Pade approximant."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import ClassVar

import sympy as sp

from symdyn.physics.effect import Effect, HiddenState, Port, Rate, Unit, Values
from symdyn.spec.effect_schema import ParameterSchema
from symdyn.spec.records import Motion


def dead_time(motions: Sequence[Motion]) -> tuple[ParameterSchema, ParameterSchema]:
    """The delay, and the order of what stands for it."""
    seconds: Mapping[Motion, str] = dict.fromkeys(motions, "s")
    plain: Mapping[Motion, str] = dict.fromkeys(motions, "1")
    return (
        ParameterSchema("delay", seconds, "T_d", "dead time", lower=0.0, zero_is_structural=True),
        ParameterSchema("order", plain, "n", "number of states", None, 1.0, 9.0, default=2.0, is_count=True),
    )


class DeadTime(Effect):
    """exp(-s T) as a quotient of polynomials of degrees n - 1 and n, n being the order; n = 1 is a first-order lag.

    The degree above is the lower one, so that nothing of a step comes through at once, let alone with the
    wrong sign. The phase is good up to a frequency (rad/s) of about n / T.
    """

    passes: ClassVar[Unit]  # unit of what comes late
    source = "Pade 1892; Vajta 2000, Some remarks on Pade-approximations"

    def hidden_states(self, p: Values) -> tuple[HiddenState, ...]:
        count = 0 if p["delay"] == 0 else int(p["order"])
        return tuple(HiddenState(f"delay_{k}", self.passes, r"\xi") for k in range(1, count + 1))

    def rates(self, port: Port, p: Values, z: Sequence[sp.Expr], control: sp.Expr) -> tuple[Rate, ...]:
        """A chain of integrators in units of the delay, fed back by the denominator."""
        if not z:
            return ()
        _, below = _pade(len(z))
        last = (control - sum(c * state for c, state in zip(below, z, strict=False))) / below[-1]
        return tuple(Rate(p["delay"], change) for change in (*z[1:], last))

    @staticmethod
    def late(z: Sequence[sp.Expr], control: sp.Expr) -> sp.Expr:
        """What comes out."""
        if not z:
            return control
        above, _ = _pade(len(z))
        return sum((c * state for c, state in zip(above, z, strict=True)), sp.Integer(0))


def _pade(n: int) -> tuple[list[sp.Rational], list[sp.Rational]]:
    """Coefficients of rising powers of s T above (n of them) and below (n + 1), the lowest ones 1."""
    m = n - 1

    def share(degree: int, k: int) -> sp.Rational:
        return sp.Rational(
            math.factorial(m + n - k) * math.factorial(degree),
            math.factorial(m + n) * math.factorial(k) * math.factorial(degree - k),
        )

    return [(-1) ** k * share(m, k) for k in range(n)], [share(n, k) for k in range(n + 1)]
