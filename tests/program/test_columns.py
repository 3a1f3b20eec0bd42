"""The last step of a program, written out, solves the system; what is zero by structure is told."""

from __future__ import annotations

import numpy as np
import pytest

from symdyn.program.builder import Builder
from symdyn.program.columns import Columns, columns
from symdyn.program.evaluate import evaluate
from symdyn.program.optimize import optimize
from symdyn.program.ssa import Argument, Program

SIZE, WIDTH = 3, 9
A = Argument("a", tuple(f"a_{i}_{j}" for i in range(SIZE) for j in range(i + 1)))
B = Argument("b", tuple(f"b_{i}_{j}" for i in range(SIZE) for j in range(WIDTH)))
NOTHING_ABOVE = 4  # columns of the last row that are zero


def build(coupled: bool) -> Columns:
    """Between a row of ones before and the last entries of ``b`` behind; not ``coupled``: the last row stands alone."""
    builder = Builder()
    zero, one = builder.constant(0.0), builder.constant(1.0)
    matrix = [[builder.input(f"a_{max(i, j)}_{min(i, j)}") for j in range(SIZE)] for i in range(SIZE)]
    if not coupled:
        for i in range(SIZE - 1):
            matrix[SIZE - 1][i] = matrix[i][SIZE - 1] = zero
    right = [
        [zero if i == SIZE - 1 and j < NOTHING_ABOVE else builder.input(f"b_{i}_{j}") for i in range(SIZE)]
        for j in range(WIDTH)
    ]
    last = [builder.input(f"b_{SIZE - 1}_{j}") for j in range(WIDTH)]
    return columns(builder, "solved", (A, B), matrix, right, [one] * WIDTH, last)


def numbers(seed: int, coupled: bool) -> tuple[np.ndarray, np.ndarray, dict[str, list[float]]]:
    rng = np.random.default_rng(seed)
    root, b = rng.normal(size=(SIZE, SIZE)), rng.normal(size=(SIZE, WIDTH))
    a = root @ root.T + np.eye(SIZE)
    if not coupled:
        a[-1, :-1] = a[:-1, -1] = 0.0
    given = {"a": [a[i, j] for i in range(SIZE) for j in range(i + 1)], "b": b.ravel().tolist()}
    right = b.copy()
    right[-1, :NOTHING_ABOVE] = 0.0
    return a, right, given


@pytest.mark.parametrize("coupled", [True, False])
@pytest.mark.parametrize("seed", range(3))
def test_the_whole_is_the_solution_between_other_rows(seed: int, coupled: bool) -> None:
    a, right, given = numbers(seed, coupled)
    found = value(build(coupled).whole(), given)
    np.testing.assert_array_equal(found[0], np.ones(WIDTH))
    np.testing.assert_allclose(found[1:-1], np.linalg.solve(a, right), rtol=1e-12, atol=1e-13)
    np.testing.assert_array_equal(found[-1], given["b"][-WIDTH:])


@pytest.mark.parametrize("coupled", [True, False])
def test_an_optimised_head_has_the_same_end(coupled: bool) -> None:
    ending = build(coupled)
    _, _, given = numbers(7, coupled)
    shorter = Columns(optimize(ending.head).program, ending.shape, ending.start, ending.size, ending.width)
    np.testing.assert_allclose(value(shorter.whole(), given), value(ending.whole(), given), rtol=1e-13)
    assert (shorter.factors, shorter.first) == (ending.factors, ending.first)


def test_zeros_of_the_structure() -> None:
    assert build(True).factors == ((1, 0), (2, 0), (2, 1))
    assert build(False).factors == ((1, 0),)
    assert build(True).first == (0, 0, NOTHING_ABOVE)
    assert build(True).wide


def value(program: Program, given: dict[str, list[float]]) -> np.ndarray:
    return np.array(evaluate(program, given), dtype=float).reshape(program.shape)
