"""Linear models as arrays: those of the kernel, and derivatives against fifty digits and closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from symdyn.base.errors import NumericalError
from symdyn.base.linear_system import LinearFamily
from symdyn.compiler import compile_robot, linearise, load_robot
from symdyn.derive.linearize import without_nonsmooth


def states(family: LinearFamily) -> int:
    return len(family.nominal.states)


def matrices(family: LinearFamily, p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A and B."""
    system = family.at(p)
    return np.linalg.solve(system.e, system.f), np.linalg.solve(system.e, system.h)


@pytest.mark.parametrize("machine", ["irb6-axis1", "two-link", "irb6-arm"])
def test_the_matrices_are_those_of_the_kernel_at_any_point(machine: str) -> None:
    robot = without_nonsmooth(load_robot(machine))
    kernel = compile_robot(robot).kernel()
    rng = np.random.default_rng(7)
    x, u = rng.normal(size=len(kernel.states)), rng.normal(size=len(kernel.inputs))
    system = linearise(robot, x, u).nominal
    a, b = np.linalg.solve(system.e, system.f), np.linalg.solve(system.e, system.h)
    expected = kernel.state_derivative_state_jacobian(x, u)
    assert a == pytest.approx(expected, rel=1e-12, abs=1e-12 * np.abs(expected).max())
    assert b == pytest.approx(kernel.state_derivative_input_jacobian(x, u), rel=1e-12, abs=1e-12)
    assert system.drift == pytest.approx(kernel.state_derivative(x, u), rel=1e-11, abs=1e-11)
    assert (system.states, system.inputs, system.outputs) == (kernel.states, kernel.inputs, kernel.outputs)
    if kernel.outputs:
        assert system.c == pytest.approx(kernel.output_state_jacobian(x, u))


@pytest.mark.parametrize("machine", ["two-link", "irb6-arm"])
def test_derivatives_off_equilibrium_follow_the_accelerations(machine: str) -> None:
    """x and u held, the arm accelerates, and by how much depends on the parameters: against central differences."""
    robot = without_nonsmooth(load_robot(machine))
    rng = np.random.default_rng(3)
    x = rng.normal(size=4)
    family = linearise(robot, x, np.array([3.0, -1.0]))
    system, d = family.nominal, family.derivatives(family.values)
    assert np.abs(system.drift[2:]).max() > 0.1
    a = np.linalg.solve(system.e, system.f)
    for k, value in enumerate(family.values):
        if value == 0.0:
            continue
        step = np.zeros(len(family.values))
        step[k] = 1e-5 * value
        ahead, behind = matrices(family, family.values + step), matrices(family, family.values - step)
        got = np.linalg.solve(system.e, d.f[k] - d.e[k] @ a)
        difference = (ahead[0] - behind[0]) / (2 * step[k])
        assert got == pytest.approx(difference, rel=1e-6, abs=1e-7 * max(1.0, float(np.abs(difference).max())))


def test_the_drive_in_closed_form() -> None:
    """Every parameter of the seed's drive stands in its matrices as in equations 14 to 17."""
    family = linearise(without_nonsmooth(load_robot("irb6-axis1")))
    d = family.derivatives(family.values)
    twist = {"1": (0, 1), "2": (1, 2), "3": (2, 3)}
    for number, (i, j) in twist.items():
        pulls = np.zeros(4)
        pulls[i], pulls[j] = -1.0, 1.0
        for name, columns in ((f"c_{number}", slice(0, 4)), (f"d_{number}", slice(4, 8))):
            expected = np.zeros((9, 9))
            expected[4:8, columns] = -np.outer(pulls, pulls)
            assert np.array_equal(d.f[family.index(name)], expected)
            assert not d.e[family.index(name)].any()
    for k in range(4):
        inertia = d.e[family.index(f"J_{k + 1}")]
        assert inertia[4 + k, 4 + k] == 1.0
        assert np.count_nonzero(inertia) == 1
        damper = d.f[family.index(f"d_{k + 4}")]
        assert damper[4 + k, 4 + k] == -1.0
        assert np.count_nonzero(damper) == 1
    assert d.e[family.index("L")][8, 8] == 1.0
    assert d.f[family.index("R")][8, 8] == -1.0
    assert d.f[family.index("K_T")][5, 8] == 1.0
    assert d.f[family.index("K_E")][8, 5] == -1.0
    assert d.c[family.index("K_Et")][0, 4] == 1.0
    assert [name for name, used in zip(family.parameters, d.used, strict=True) if not used] == ["T_f", "S"]


def test_elements_add_up_to_the_matrices() -> None:
    system = linearise(without_nonsmooth(load_robot("irb6-axis1"))).nominal
    inertia, stiffness, damping = (
        sum(getattr(e, kind) * np.outer(e.lever, e.lever) for e in system.elements)
        for kind in ("inertia", "stiffness", "damping")
    )
    assert stiffness == pytest.approx(-system.f[4:8, :4])
    assert damping == pytest.approx(-system.f[4:8, 4:8])
    assert inertia == pytest.approx(np.diag([34e-6, 41e-6, 196e-6, 0.0]))  # J_4 is the link's
    assert {e.address for e in system.elements if e.stiffness} == {
        "axis1.tachometer_shaft", "axis1.motor_shaft", "axis1.flexspline",
    }  # fmt: skip


def test_an_inductance_at_zero_is_finite_and_an_inertia_at_zero_too() -> None:
    family = linearise(without_nonsmooth(load_robot("irb6-axis1")))
    for name in ("L", "J_1"):
        p = family.values.copy()
        p[family.index(name)] = 0.0
        system = family.at(p)
        assert np.linalg.matrix_rank(system.e) == 8


def test_an_accelerating_machine_without_inertia_is_refused() -> None:
    family = linearise(without_nonsmooth(load_robot("irb6-axis1")), u=np.array([1.0]))
    p = family.values.copy()
    p[family.index("L")] = 0.0
    with pytest.raises(NumericalError, match="SD610"):
        family.at(p)


def test_a_value_that_is_not_finite_is_refused() -> None:
    family = linearise(without_nonsmooth(load_robot("irb6-axis1")))
    p = family.values.copy()
    p[family.index("c_1")] = np.nan
    with pytest.raises(NumericalError, match="SD610"):
        family.at(p)
    with pytest.raises(KeyError):
        family.index("c_9")
