"""Passes over programs: pure functions from Program to Program that never raise the weight."""

from __future__ import annotations

from symdyn.program.passes.collect_terms import collect_terms
from symdyn.program.passes.divide_to_reciprocal import divide_to_reciprocal
from symdyn.program.passes.drop_dead import drop_dead
from symdyn.program.passes.factor_common import factor_common
from symdyn.program.passes.fold_constants import fold_constants
from symdyn.program.passes.share_subexpressions import share_subexpressions
from symdyn.program.passes.trigonometric import trigonometric

__all__ = [
    "collect_terms",
    "divide_to_reciprocal",
    "drop_dead",
    "factor_common",
    "fold_constants",
    "share_subexpressions",
    "trigonometric",
]
