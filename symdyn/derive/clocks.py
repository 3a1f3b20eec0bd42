"""What is sampled: instants at a steady period, and what hidden states become at them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import sympy as sp

from symdyn.base.errors import InputError, Problem
from symdyn.derive.equations import EquationsOfMotion


@dataclass(frozen=True, slots=True)
class Clock:
    """At ``delay + k period``, k = 0, 1, ..., each of ``values`` is given to its hidden state, all at once."""

    period: sp.Expr
    delay: sp.Expr
    values: Mapping[sp.Symbol, sp.Expr]


def clocks(equations: EquationsOfMotion) -> tuple[Clock, ...]:
    """Clocks of everything that is sampled, in the order in which they go off where they do so together.

    What has the same period and delay shares a clock, in which the loops of a cascade run one after the other, in the
    order of their declaration. Outputs come before measurements, so that what waited for a whole period is
    not lost. Raises InputError (SD452) for a delay longer than its period.
    """
    found: dict[tuple[sp.Expr, sp.Expr], dict[sp.Symbol, sp.Expr]] = {}
    for item in equations.attachments:
        for update in item.effect.updates(item.port, item.values, item.states, item.control):
            _check(equations, item.address, update.period, update.delay)
            together = found.setdefault((update.period, update.delay), {})
            new = {z: sp.sympify(v).xreplace(together) for z, v in zip(item.states, update.values, strict=True)}
            together.update({z: v for z, v in new.items() if v != z})
    order = sorted(found, key=lambda key: key[1] == 0)
    return tuple(Clock(period, delay, found[period, delay]) for period, delay in order)


def require_continuous(equations: EquationsOfMotion, what: str) -> None:
    """Raise InputError (SD453) where something is sampled, because ``what`` knows no samples."""
    for item in equations.attachments:
        if item.effect.updates(item.port, item.values, item.states, item.control):
            message = f"{item.effect.identifier} at '{item.address}' is sampled, and {what} is not"
            raise InputError(Problem("SD453", message, hint="leave its period out"))


def _check(equations: EquationsOfMotion, address: str, period: sp.Expr, delay: sp.Expr) -> None:
    numbers = {s: p.value for s, p in zip(equations.parameters, equations.robot.parameters, strict=True)}
    excess = (delay - period).subs({s: v for s, v in numbers.items() if v is not None})
    if excess.is_positive:
        message = (
            f"the delay of the samples at '{address}' is {float(delay.subs(numbers)):g} s, longer than their period"
        )
        raise InputError(Problem("SD452", message, hint="an output must come before the next sample is taken"))
