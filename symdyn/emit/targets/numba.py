"""Numba: one Python module, ``kernel.py``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from symdyn.derive.equations import EquationsOfMotion
from symdyn.emit.forms import Form
from symdyn.emit.kernel_source import TEMPLATES, kernel_source
from symdyn.emit.target import Target


def _files(equations: EquationsOfMotion, forms: Sequence[Form]) -> Mapping[str, str]:
    return {"kernel.py": kernel_source(equations, forms)}


TARGET = Target("numba", "Numba kernel, one Python module", _files, TEMPLATES)
