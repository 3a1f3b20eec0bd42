"""Models as sums of fixed columns: exact where they are, and known where they are not."""

from __future__ import annotations

import numpy as np
import pytest

from symdyn.compiler import compile_robot, load_robot, robot_from_text
from symdyn.numeric.band import band_of
from symdyn.numeric.candidates import fitted_parameters
from symdyn.numeric.observation import observe
from symdyn.numeric.span import find_span
from symdyn.numeric.workbench import Workbench
from symdyn.spec.edit import add_effect, set_gravity

from .pendulum import TOML, pendulum, record

NAMES = ("m", "r", "I", "b")
CUTOFF = 5.0


def bench(text: str = TOML) -> Workbench:
    robot = pendulum(text)
    kernel = compile_robot(robot).kernel()
    return Workbench(kernel, observe(robot, kernel, record(1), 5 * CUTOFF), band_of(CUTOFF, 500.0))


def test_sum_of_columns_is_the_model_at_any_parameters() -> None:
    own = bench()
    assert own.foldable(NAMES)
    rng = np.random.default_rng(0)
    for _ in range(5):
        p = own.kernel.values
        p[[own.index[name] for name in NAMES]] = rng.uniform(0.01, 3.0, len(NAMES))
        residual, columns = own.left(p, NAMES), own.moved(p, NAMES)
        np.testing.assert_allclose(residual, own.residual(p), atol=1e-9 * np.abs(own.effort).max())
        np.testing.assert_allclose(columns, own.columns(p, NAMES), atol=1e-9 * np.abs(columns).max())


def test_four_parameters_that_are_three_numbers_need_three_columns() -> None:
    span, columns = bench().span(NAMES)
    assert columns.shape[2] == len(span.sources) == 3  # m r, I + m r^2, b


@pytest.mark.slow
def test_gravity_that_is_fitted_from_next_to_nothing_multiplies_masses_and_is_still_a_sum() -> None:
    robot = robot_from_text(set_gravity(load_robot("stanford").text, [1e-6, 1e-6, 1e-6]), "stanford.toml")
    kernel = compile_robot(robot).kernel()
    index = {name: i for i, name in enumerate(kernel.parameters)}
    rng = np.random.default_rng(0)
    names = (*fitted_parameters(robot), "gravity_x", "gravity_y", "gravity_z")
    span = find_span(kernel, names, index, tuple(rng.uniform(-1.0, 1.0, (3, 1000, 6))))
    assert span.exact
    p = kernel.values
    p[[index[name] for name in names]] *= rng.uniform(0.3, 3.0, len(names))
    p[[index[name] for name in names[-3:]]] = 3.0, -9.0, 1.0
    change = kernel.inverse_dynamics_p_batch(*span.motion, p).reshape(-1) - span.at_start
    known = [
        kernel.inverse_dynamics_parameter_jacobian_p_batch(*span.motion, span.points[at])[:, :, index[names[which]]]
        for at, which in span.sources
    ]
    summed = np.stack([column.reshape(-1) for column in known], axis=1) @ span.coefficients(p)
    np.testing.assert_allclose(summed, change, atol=1e-8 * np.abs(change).max())


def test_characteristic_speed_is_no_sum_of_columns_and_still_evaluated() -> None:
    text = add_effect(TOML, "stribeck_friction", "arm", {"excess": "0.3 N m", "stribeck_velocity": "0.2 rad/s"})
    own = bench(text)
    names = (*NAMES, "arm_stribeck_friction_excess", "arm_stribeck_friction_stribeck_velocity")
    assert not own.foldable(names)
    p = own.kernel.values
    residual, columns = own.left(p, names), own.moved(p, names)
    assert np.array_equal(residual, own.residual(p))
    assert np.array_equal(columns, own.columns(p, names))


@pytest.mark.parametrize("names", [(), ("b",)])
def test_nothing_else_is_moved(names: tuple[str, ...]) -> None:
    own = bench()
    assert own.moved(own.kernel.values, names).shape[2] == len(names)
