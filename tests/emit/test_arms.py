"""Printed kernels of the large arms against Pinocchio, which derives nothing: over a thousand random states."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest

from symdyn.compiler import Compiled, compile_robot
from symdyn.emit.kernel import Kernel
from tests.derive.test_machines import MACHINES, arm
from tests.derive.test_pinocchio import model_of, pin

STATES = 1000
TOLERANCE = 1e-10
CORE = "panda"

ARMS = [pytest.param(name, marks=() if name == CORE else pytest.mark.slow) for name in MACHINES]

pytestmark = pytest.mark.parametrize("name", ARMS)


@pytest.fixture(scope="module")
def kernel(interpret: Callable[[Compiled], Kernel]) -> Callable[[str], Kernel]:
    return cache(lambda name: interpret(compile_robot(arm(name))))


def states(name: str) -> list[tuple[np.ndarray, ...]]:
    n = len(arm(name).joints)
    return [tuple(rows) for rows in np.random.default_rng(7).uniform(-3, 3, (STATES, 3, n))]


def assert_same(ours: np.ndarray, theirs: np.ndarray) -> None:
    np.testing.assert_allclose(ours, theirs, rtol=TOLERANCE, atol=TOLERANCE * np.abs(theirs).max())


def symmetric(upper: Any) -> np.ndarray:
    half = np.triu(np.array(upper))
    return half + np.triu(half, 1).T


def test_efforts_and_accelerations(name: str, kernel: Callable[[str], Kernel]) -> None:
    model, found = model_of(arm(name)), kernel(name)
    data = model.createData()
    for q, qd, third in states(name):
        assert_same(found.inverse_dynamics(q, qd, third), pin.rnea(model, data, q, qd, third))
        assert_same(found.bias_force(q, qd), pin.nonLinearEffects(model, data, q, qd))
        assert_same(found.gravity(q), pin.computeGeneralizedGravity(model, data, q))
        assert_same(found.mass_matrix(q), symmetric(pin.crba(model, data, q)))
        assert_same(found.mass_matrix(q) @ found.forward_dynamics(q, qd, third), third - found.bias_force(q, qd))


def test_forward_dynamics(name: str, kernel: Callable[[str], Kernel]) -> None:
    """Pinocchio solves without M; the two agree as well as M is conditioned."""
    model, found = model_of(arm(name)), kernel(name)
    data = model.createData()
    for q, qd, tau in states(name):
        theirs = np.array(pin.aba(model, data, q, qd, tau))
        condition = np.linalg.cond(found.mass_matrix(q))
        error = np.abs(found.forward_dynamics(q, qd, tau) - theirs).max()
        assert error < max(TOLERANCE, 1e-15 * condition) * np.abs(theirs).max()


def test_derivatives(name: str, kernel: Callable[[str], Kernel]) -> None:
    model, found, n = model_of(arm(name)), kernel(name), len(arm(name).joints)
    data = model.createData()
    for q, qd, third in states(name):
        dq, dqd, _ = pin.computeRNEADerivatives(model, data, q, qd, third)
        assert_same(found.inverse_dynamics_state_jacobian(q, qd, third), np.hstack([dq, dqd]))
        dq, dqd, inverse = (np.array(part) for part in pin.computeABADerivatives(model, data, q, qd, third))
        theirs = np.hstack([dq, dqd])
        error = np.abs(found.forward_dynamics_state_jacobian(q, qd, third) - theirs).max()
        condition = np.linalg.cond(symmetric(inverse))
        assert error < max(TOLERANCE, 1e-14 * condition) * np.abs(theirs).max()
        assert found.state_derivative_state_jacobian(np.concatenate([q, qd]), third)[n:].shape == theirs.shape
