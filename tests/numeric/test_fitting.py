"""Gauss-Newton on inverse dynamics: known parameters are found again, bounds hold, the unknown stays put."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from threadpoolctl import threadpool_info

from symdyn.compiler import compile_robot
from symdyn.numeric import identify as identify_module
from symdyn.numeric.band import band_of
from symdyn.numeric.fitting import Fit, fit, joint_weight, minimise, relative_error
from symdyn.numeric.identify import identify
from symdyn.numeric.observation import observe
from symdyn.numeric.workbench import Workbench

from .pendulum import ARM, INERTIA, MASS, TURNING, VISCOUS, pendulum, record

ONE = np.ones(1)
CUTOFF = 5.0


@pytest.fixture(scope="module")
def bench() -> Workbench:
    robot = pendulum()
    kernel = compile_robot(robot).kernel()
    return Workbench(kernel, observe(robot, kernel, record(1), 5 * CUTOFF), band_of(CUTOFF, 500.0))


def values(bench: Workbench, **changed: float) -> np.ndarray:
    p = bench.kernel.values
    for name, value in changed.items():
        p[bench.index[name]] = value
    return p


def test_parameters_are_found_from_a_start_far_off(bench: Workbench) -> None:
    done = fit(bench, values(bench, r=0.9, b=5.0), ("r", "b"), ONE)  # the arm enters squared: not linear
    for name, truth in (("r", ARM), ("b", VISCOUS)):
        error = done.standard_error(name)
        assert error is not None
        assert abs(float(done.p[bench.index[name]]) - truth) < max(5 * error, 1e-3 * truth)


def test_solution_is_a_minimum(bench: Workbench) -> None:
    names = ("r", "b", "I")
    is_least(bench, fit(bench, values(bench, r=0.4), names, ONE))


def test_solution_is_a_minimum_where_another_parameter_is_held_elsewhere(bench: Workbench) -> None:
    is_least(bench, fit(bench, values(bench, b=2.0 * VISCOUS), ("r", "I"), ONE))


def is_least(bench: Workbench, done: Fit) -> None:
    least = np.sum(bench.residual(done.p) ** 2)
    for name in done.names:
        for share in (-1e-3, 1e-3):
            other = done.p.copy()
            other[bench.index[name]] *= 1 + share
            assert np.sum(bench.residual(other) ** 2) > least


def test_parameters_that_are_not_named_stay(bench: Workbench) -> None:
    start = values(bench, b=1.0, m=1.7)
    done = fit(bench, start, ("b",), ONE)
    others = [i for name, i in bench.index.items() if name != "b"]
    assert np.array_equal(done.p[others], start[others])
    assert start[bench.index["b"]] == 1.0  # not written to


def test_what_the_recording_does_not_tell_is_said_and_kept_in_proportion(bench: Workbench) -> None:
    """Three parameters, two numbers in the equation: m r, and I + m r^2."""
    done = fit(bench, values(bench, m=1.6, I=0.06), ("m", "r", "I", "b"), ONE)
    assert [done.standard_error(name) for name in ("m", "r", "I")] == [None] * 3
    assert done.standard_error("b") is not None
    m, r, inertia = (float(done.p[bench.index[name]]) for name in ("m", "r", "I"))
    assert m * r == pytest.approx(MASS * ARM, rel=1e-3)
    assert inertia + m * r**2 == pytest.approx(TURNING, rel=2e-3)
    for found, start in ((m, 1.6), (r, ARM), (inertia, 0.06)):
        assert found == pytest.approx(start, rel=0.5)


@pytest.mark.parametrize("sizes", [{}, {"g": 30.0}])
def test_of_what_nothing_is_known_its_size_may_be(bench: Workbench, sizes: dict[str, float]) -> None:
    """Half the mass wants twice the gravity; a recording of no weight does not get it against a size that is told."""
    begun, given = values(bench, m=0.5 * MASS), float(bench.kernel.values[bench.index["g"]])
    nothing = np.zeros((*bench.effort.shape, 0))
    unknown = frozenset({"g"})
    p, _, ended = minimise(bench, begun, ("g",), nothing, np.zeros(0), (), 1e-9 * ONE, {}, sizes, 1.0, unknown)
    assert p[bench.index["g"]] == pytest.approx(given if sizes else 2.0 * given, rel=0.1)
    assert ended


def test_bounds_hold_and_bind(bench: Workbench) -> None:
    done = fit(bench, values(bench, b=1.0), ("b", "I"), ONE, {"b": (0.5, 2.0)})
    assert done.p[bench.index["b"]] == pytest.approx(0.5, abs=1e-5)
    done = fit(bench, values(bench, b=0.05), ("b", "I"), ONE, {"b": (0.0, 0.1)})
    assert done.p[bench.index["b"]] == pytest.approx(0.1, abs=1e-5)
    free = fit(bench, values(bench, b=1.0), ("b", "I"), ONE, {"b": (0.0, 2.0)})
    assert free.p[bench.index["b"]] == pytest.approx(VISCOUS, rel=0.01)


def test_fit_of_nothing_is_the_start(bench: Workbench) -> None:
    start = values(bench, b=1.0)
    done = fit(bench, start, (), ONE)
    assert np.array_equal(done.p, start)
    assert done.names == ()


def test_columns_are_the_derivatives_of_inverse_dynamics(bench: Workbench) -> None:
    p, names = bench.kernel.values, ("m", "r", "I", "b")
    columns = bench.columns(p, names)
    for k, name in enumerate(names):
        step = 1e-6 * p[bench.index[name]]
        high, low = (values(bench, **{name: p[bench.index[name]] + s}) for s in (step, -step))
        slope = (bench.residual(low) - bench.residual(high)) / (2 * step)
        np.testing.assert_allclose(columns[:, :, k], slope, atol=1e-6 * np.max(np.abs(slope)))


def test_relative_error_counts_joints_alike() -> None:
    effort = np.column_stack([np.full(10, 100.0), np.full(10, 1.0)])
    assert relative_error(0.1 * effort, effort) == pytest.approx(0.1)
    assert relative_error(effort * [0.3, 0.4], effort) == pytest.approx(np.sqrt((0.09 + 0.16) / 2))
    assert relative_error(np.ones((5, 1)), np.zeros((5, 1))) == 0.0  # nothing measured, nothing to compare


def test_weights_bring_residuals_of_all_joints_to_one_size() -> None:
    rng = np.random.default_rng(0)
    residual = rng.standard_normal((500, 3)) * [1e-3, 1.0, 50.0]
    weighted = residual * joint_weight(residual, np.full((500, 3), 100.0))
    np.testing.assert_allclose(np.sqrt(np.mean(weighted**2, axis=0)), 1.0, rtol=1e-12)
    assert np.all(np.isfinite(joint_weight(np.zeros((5, 2)), np.ones((5, 2)))))


def test_identified_model_fits_down_to_the_noise() -> None:
    found = identify(pendulum(), record(2))
    viscous = found.parameters["b"]
    assert viscous.se is not None
    assert abs(viscous.value - VISCOUS) < 5 * viscous.se
    assert viscous.unit == "N m s/rad"
    assert found.error < 0.005
    assert found.to_json()["parameters"]["b"] == {"value": viscous.value, "se": viscous.se, "unit": "N m s/rad"}


def test_identification_takes_a_wrong_model_to_the_right_numbers() -> None:
    text = pendulum().text.replace('b = "0.2', 'b = "2.0').replace('I = "0.05', 'I = "0.5')
    found = identify(pendulum(text), record(2)).parameters
    assert found["b"].value == pytest.approx(VISCOUS, rel=0.01)
    m, r, inertia = (found[name].value for name in ("m", "r", "I"))
    assert inertia + m * r**2 == pytest.approx(INERTIA + MASS * ARM**2, rel=0.01)


def test_a_fit_keeps_to_one_thread(monkeypatch: pytest.MonkeyPatch) -> None:
    """Beside other work, threads that wait for each other made a fit of six joints take twenty times as long."""
    threads: list[int] = []

    def counted(*of: Any) -> Fit:
        threads.append(max(pool["num_threads"] for pool in threadpool_info()))
        return fit(*of)

    monkeypatch.setattr(identify_module, "fit", counted)
    identify(pendulum(), record(2))
    assert threads == [1, 1]
