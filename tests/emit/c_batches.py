"""Batches of emitted C beside its functions of one state."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from symdyn.emit.forms import Form
from symdyn.program.ssa import Program
from tests.emit.c_library import ULPS, Array, Library

COUNTS = (0, 1, 31, 32, 71)  # none, one, less than a block, a block, two blocks and a part


def states_of(program: Program, p: Array, count: int) -> list[Array]:
    """A row per state, and one vector p."""
    rng = np.random.default_rng(count)
    return [
        p * rng.uniform(0.8, 1.2, p.size)
        if argument.name == "p"
        else rng.uniform(-2.0, 2.0, (count, len(argument.symbols)))
        for argument in program.arguments
    ]


def columns(arrays: Sequence[Array]) -> list[Array]:
    return [np.ascontiguousarray(array.T) for array in arrays]  # of a vector: itself


def both(library: Library, form: Form, arguments: Sequence[Array], count: int) -> tuple[Array, Array]:
    """Of rows and of columns, each as rows."""
    size = len(form.program.outputs)
    rows = library.many(f"{form.name}_batch", count, arguments, (count, size))
    return rows, library.many(f"{form.name}_soa", count, columns(arguments), (size, count)).T


def assert_close(found: Array, wanted: Array, message: str) -> None:
    tolerance = ULPS * np.finfo(float).eps * np.abs(wanted).max(initial=0.0)
    np.testing.assert_allclose(found, wanted, rtol=0.0, atol=tolerance, err_msg=message)


def assert_batches(library: Library, forms: Sequence[Form], p: Array) -> None:
    """Every state of a batch is as by itself, whatever their number."""
    for form in forms:
        for count in COUNTS:
            arguments = states_of(form.program, p, count)
            one = [[a if a.ndim == 1 else a[k] for a in arguments] for k in range(count)]
            wanted = [library(form.name, state, (len(form.program.outputs),)) for state in one]
            for found in both(library, form, arguments, count):
                assert len(found) == count
                assert_close(found, np.reshape(wanted, found.shape), form.name)
