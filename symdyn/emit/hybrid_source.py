"""The source of a hybrid machine's module: its functions in a mode, with the table of its switches."""

from __future__ import annotations

from collections.abc import Sequence

from symdyn.derive.switches import HybridEquations
from symdyn.emit.forms import Form
from symdyn.emit.kernel_source import kernel_source


def hybrid_source(hybrid: HybridEquations, forms: Sequence[Form], affine: bool) -> str:
    """A kernel module whose functions take the modes ``s``; AFFINE tells whether each mode is affine in x and u."""
    tables = {
        "SWITCHES": repr(tuple(s.name for s in hybrid.switches)),
        "SWITCH_KINDS": repr(tuple(str(s.kind) for s in hybrid.switches)),
        "AFFINE": repr(affine),
    }
    return kernel_source(hybrid.equations, forms, tables)
