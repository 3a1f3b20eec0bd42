"""The only maker of SymPy symbols: names are positions and parameter names, never free text of a user."""

from __future__ import annotations

import math
from fractions import Fraction

import sympy as sp


def coordinate(index: int) -> sp.Symbol:
    """Generalised coordinate ``q_i`` (index from 1)."""
    return sp.Symbol(f"q_{index}", real=True)


def velocity(index: int) -> sp.Symbol:
    return sp.Symbol(f"qd_{index}", real=True)


def acceleration(index: int) -> sp.Symbol:
    return sp.Symbol(f"qdd_{index}", real=True)


def effort(index: int) -> sp.Symbol:
    """Generalised force ``tau_i`` applied along coordinate ``q_i``."""
    return sp.Symbol(f"tau_{index}", real=True)


def control(index: int) -> sp.Symbol:
    """Input ``u_i`` of the machine: a voltage, a current, a torque."""
    return sp.Symbol(f"u_{index}", real=True)


def hidden(index: int) -> sp.Symbol:
    """State ``z_i`` of an effect, beyond coordinates and velocities: a current, a bristle deflection."""
    return sp.Symbol(f"z_{index}", real=True)


def hidden_rate(index: int) -> sp.Symbol:
    """Time derivative of the hidden state ``z_i``."""
    return sp.Symbol(f"zd_{index}", real=True)


def load(index: int) -> sp.Symbol:
    """Effort ``load_i`` that passes through the joint along ``q_i``."""
    return sp.Symbol(f"load_{index}", real=True)


def wrench(index: int) -> sp.Symbol:
    """Of a wrench on the tool: forces ``w_1`` to ``w_3``, moments ``w_4`` to ``w_6``."""
    return sp.Symbol(f"w_{index}", real=True)


def mode(index: int) -> sp.Symbol:
    """Of a hybrid machine: ``sigma_i`` is what its i-th switch does now."""
    return sp.Symbol(f"sigma_{index}", real=True)


def reference(index: int) -> sp.Symbol:
    """Reference ``r_i`` of a servo loop."""
    return sp.Symbol(f"r_{index}", real=True)


def arm_effort(index: int) -> sp.Symbol:
    """Stands for the effort of a large arm along ``q_i`` where its closed form would not be read."""
    return sp.Symbol(f"tau_arm_{index}", real=True)


def parameter(name: str) -> sp.Symbol:
    """A parameter; the prefix keeps a user's ``q_1`` apart from the coordinate."""
    return sp.Symbol(f"p_{name}", real=True)


def local(name: str) -> sp.Symbol:
    """A symbol of an effect's own law: the displacement, velocity or acceleration at its port."""
    return sp.Symbol(f"port_{name}", real=True)


def number(value: Fraction | float | int) -> sp.Expr:
    """An exact SymPy number; decimal floats become the decimal they print as (0.1 is 1/10), infinity infinity."""
    if isinstance(value, Fraction):
        return sp.Rational(value.numerator, value.denominator)
    if isinstance(value, int):
        return sp.Integer(value)
    if math.isinf(value):
        return sp.oo if value > 0 else -sp.oo
    return sp.Rational(repr(value))


def angle(radians: Fraction | float) -> sp.Expr:
    """An exact angle: multiples of pi/12 are recognised, so that cos(90 deg) is 0 and not 6e-17."""
    twelfths = float(radians) * 12.0 / float(sp.pi)
    if abs(twelfths - round(twelfths)) < 1e-9:
        return sp.Rational(round(twelfths), 12) * sp.pi
    return number(radians)
