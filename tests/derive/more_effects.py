"""A driven joint with effects, and what they add to its equations."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from functools import cache

import numpy as np
import sympy as sp

from symdyn.base.symbols import parameter
from symdyn.derive.equations import EquationsOfMotion, equations_of_motion
from symdyn.program.evaluate import evaluate
from symdyn.program.functions import functions
from symdyn.program.ssa import Program
from symdyn.spec.records import ZERO, Drive, EffectSpec, Monomial, Motor, Robot

from .drives import BELT, driven, letter
from .exact import required_efforts

N, J_m, c, d, K_T, K_E, R, L = map(parameter, ("N", "J_m", "c", "d", "K_T", "K_E", "R", "L"))
q1, q2, v1, v2, a1, a2, u1, z1, z2 = sp.symbols("q_1 q_2 qd_1 qd_2 qdd_1 qdd_2 u_1 z_1 z_2", real=True)
TWIST, SLIP = N * q2 - q1, N * v2 - v1
NO_COIL = Drive(
    BELT.ratio,
    BELT.rotors,
    BELT.shafts,
    Motor("circuit", "motor", letter("R"), ZERO, letter("K_T"), letter("K_E")),
)


def effect(identifier: str, at: str, **values: str | int) -> EffectSpec:
    numbers = {name: letter(v) if isinstance(v, str) else Monomial(Fraction(v)) for name, v in values.items()}
    return EffectSpec(identifier, at, tuple(numbers.items()))


def derived(*effects: EffectSpec, drive: Drive = BELT) -> EquationsOfMotion:
    return equations_of_motion(driven(drive, effects))


def residuals(equations: EquationsOfMotion) -> list[sp.Expr]:
    """Per coordinate: needed less supplied, zero along every motion."""
    return [a - b for a, b in zip(required_efforts(equations), equations.actuation(), strict=True)]


def extra(*effects: EffectSpec) -> list[sp.Expr]:
    return [sp.expand(a - b) for a, b in zip(residuals(derived(*effects)), residuals(derived()), strict=True)]


@cache
def programs(robot: Robot) -> dict[str, Program]:
    return {f.name: f.program for f in functions(equations_of_motion(robot))}


def numbers(robot: Robot, name: str, **arguments: Sequence[float]) -> np.ndarray:
    """A function of the kernel by the reference evaluator."""
    program = programs(robot)[name]
    p = [value for value in (p.value for p in robot.parameters) if value is not None]
    found = evaluate(program, {**arguments, "p": p})
    return np.array(found, dtype=float).reshape(program.shape)
