"""The unrolled L D L^T solver against numpy, digit for digit, and what it leaves out where a matrix has zeros."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from symdyn.program.builder import Builder
from symdyn.program.evaluate import evaluate
from symdyn.program.solve import solve_symmetric
from symdyn.program.ssa import Argument, Op, Program

Array = NDArray[np.float64]
Structure = Callable[[int, int], bool]  # which entries (i >= j) of the matrix are inputs; the rest is zero

DIGITS = 40


def everywhere(i: int, j: int) -> bool:
    return True


def diagonal(i: int, j: int) -> bool:
    return i == j


def chain(i: int, j: int) -> bool:
    return i - j <= 1


def arrow(i: int, j: int) -> bool:
    """Each rotor is coupled to the first coordinate alone, as rotors on one link are."""
    return i == j or j == 0


def solver(n: int, structure: Structure = everywhere, rest: tuple[int, ...] = (), poison: bool = False) -> Program:
    """x(a, b) for a matrix of that structure; ``rest`` are entries of the right side that are zero.

    With ``poison`` the upper triangle holds a line that is never a number.
    """
    builder, names = Builder(), []
    zero = builder.constant(0.0)
    lines = [[zero] * n for _ in range(n)]
    for i in range(n):
        for j in range(i + 1):
            names.append(f"a_{i}_{j}")
            if structure(i, j):
                lines[i][j] = lines[j][i] = builder.input(names[-1])
    if poison:
        nothing = builder.intern(Op.DIV, (zero, zero))
        for i in range(n):
            lines[i][i + 1 :] = [nothing] * (n - i - 1)
    right = [zero if i in rest else builder.input(f"b_{i}") for i in range(n)]
    arguments = (Argument("a", tuple(names)), Argument("b", tuple(f"b_{i}" for i in range(n))))
    return builder.program("solve", arguments, solve_symmetric(builder, lines, right), (n,))


def solution(program: Program, matrix: Array, right: Array, digits: int = DIGITS) -> list[mpmath.mpf]:
    entries = [float(matrix[i, j]) for i in range(len(matrix)) for j in range(i + 1)]
    return evaluate(program, {"a": entries, "b": [float(value) for value in right]}, digits)


def positive_definite(rng: np.random.Generator, n: int, structure: Structure = everywhere) -> Array:
    """Random; of any condition up to 1e4 where it is dense, else diagonally dominant."""
    if structure is everywhere:
        q, _ = np.linalg.qr(rng.standard_normal((n, n)))
        return np.asarray((q * 10.0 ** rng.uniform(-2, 2, n)) @ q.T)
    low = np.array([[rng.uniform(-1, 1) if j < i and structure(i, j) else 0.0 for j in range(n)] for i in range(n)])
    return np.asarray(low + low.T + np.diag(np.sum(np.abs(low + low.T), axis=1) + rng.uniform(0.1, 2.0, n)))


def operations(program: Program) -> Counter[Op]:
    return Counter(node.op for node in program.nodes)


@settings(deadline=None)
@given(n=st.integers(1, 6), seed=st.integers(0, 2**32 - 1))
def test_solution_is_that_of_numpy(n: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    matrix, right = positive_definite(rng, n), rng.standard_normal(n)
    found = [float(value) for value in solution(solver(n), matrix, right)]
    np.testing.assert_allclose(found, np.linalg.solve(np.tril(matrix) + np.tril(matrix, -1).T, right), rtol=1e-9)


@settings(deadline=None)
@given(n=st.integers(1, 6), seed=st.integers(0, 2**32 - 1), structure=st.sampled_from((everywhere, chain, arrow)))
def test_matrix_times_solution_is_the_right_side_to_thirty_digits(n: int, seed: int, structure: Structure) -> None:
    rng = np.random.default_rng(seed)
    matrix, right = positive_definite(rng, n, structure), rng.standard_normal(n)
    with mpmath.workdps(DIGITS):
        found = solution(solver(n, structure), matrix, right)
        for i in range(n):
            product = mpmath.fsum(mpmath.mpf(float(matrix[max(i, j), min(i, j)])) * found[j] for j in range(n))
            assert abs(product - mpmath.mpf(float(right[i]))) < mpmath.mpf(10) ** -30


@pytest.mark.parametrize("n", range(1, 7))
def test_hilbert_matrix_has_its_exact_inverse(n: int) -> None:
    """Of integers; for n = 6 the condition is 1.5e7, so that an order of elimination gone wrong shows."""
    with mpmath.workdps(DIGITS):
        hilbert = mpmath.hilbert(n)
        entries = [hilbert[i, j] for i in range(n) for j in range(i + 1)]
        for column in range(n):
            unit = [float(row == column) for row in range(n)]
            found = evaluate(solver(n), {"a": entries, "b": unit}, DIGITS)
            for value in found:
                assert abs(value - mpmath.nint(value)) < mpmath.mpf(10) ** -25
            assert mpmath.nint(found[column]) > 0


def test_only_the_lower_triangle_is_read() -> None:
    plain, poisoned = solver(3), solver(3, poison=True)
    assert plain == poisoned


@pytest.mark.parametrize("n", range(1, 7))
def test_diagonal_matrix_costs_one_division_a_row(n: int) -> None:
    assert operations(solver(n, diagonal)) == Counter({Op.INPUT: 2 * n, Op.DIV: n})


@pytest.mark.parametrize("structure", [chain, arrow])
@pytest.mark.parametrize("n", range(2, 7))
def test_chains_and_rotors_fill_nothing_in(n: int, structure: Structure) -> None:
    """Cost grows with the number of couplings: per coupling one factor, one pivot update, two substitutions."""
    cost = operations(solver(n, structure))
    couplings = n - 1
    assert cost[Op.DIV] == n + couplings
    assert cost[Op.MUL] == cost[Op.SUB] == 3 * couplings
    assert cost[Op.NEG] == 0


def test_dense_matrix_costs_more_than_a_chain() -> None:
    dense, sparse = operations(solver(6)), operations(solver(6, chain))
    assert dense[Op.MUL] > 3 * sparse[Op.MUL]


def test_decoupled_coordinate_without_a_force_stays_the_constant_zero() -> None:
    program = solver(3, lambda i, j: i == j or (i, j) == (1, 0), rest=(2,))
    last = program.nodes[program.outputs[2]]
    assert (last.op, last.value) == (Op.CONST, 0.0)
    found = solution(program, np.array([[2.0, 1.0, 0.0], [1.0, 3.0, 0.0], [0.0, 0.0, 5.0]]), np.array([1.0, 2.0, 9.0]))
    assert [float(value) for value in found] == pytest.approx([0.2, 0.6, 0.0], abs=1e-15)


def test_coupled_coordinate_without_a_force_of_its_own_still_moves() -> None:
    """A zero on the right side is no zero of the solution: the force comes through the coupling."""
    matrix = np.array([[2.0, 1.0], [1.0, 3.0]])
    for rest, expected in (((0,), [-0.2, 0.4]), ((1,), [0.6, -0.2])):
        found = solution(solver(2, rest=rest), matrix, np.ones(2))
        assert [float(value) for value in found] == pytest.approx(expected, rel=1e-14)
