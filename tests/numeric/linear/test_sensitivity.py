"""Local sensitivities against closed forms and differences; one at a time; global ones against known answers."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from symdyn.base.errors import InputError, NumericalError, UsageError
from symdyn.base.linear_system import LinearFamily
from symdyn.numeric.linear.cost import Band
from symdyn.numeric.linear.eigen import poles
from symdyn.numeric.linear.global_sensitivity import default_ranges, morris, sobol
from symdyn.numeric.linear.local_sensitivity import local_sensitivity
from symdyn.numeric.linear.one_at_a_time import matched, one_at_a_time
from symdyn.numeric.linear.response import frequency_response
from symdyn.numeric.linear.scalars import Scalar, scalars

from .machines import chain, drive

HERTZ = np.geomspace(0.3, 2500, 60)


def moved(family: LinearFamily, name: str, by: float) -> np.ndarray:
    p = family.values.copy()
    p[family.index(name)] += by
    return p


@pytest.mark.parametrize("output", [None, "axis1.qd", "axis1.motor.current"])
def test_gradients_of_the_response_against_differences(output: str | None) -> None:
    family = drive()
    found = local_sensitivity(family, HERTZ, None, output)
    for k, (name, value) in enumerate(zip(family.parameters, family.values, strict=True)):
        step = 1e-4 * (value or 1e-3)
        ahead, behind = (
            frequency_response(family.at(moved(family, name, sign * step)), HERTZ, None, output).values
            for sign in (1, -1)
        )
        difference = (ahead - behind) / (2 * step)
        size = np.abs(difference).max()
        assert np.abs(found.response_gradient[k] - difference).max() <= 1e-5 * size + 1e-9 * np.abs(ahead).max() / step


def test_gradients_of_poles_against_differences() -> None:
    family = drive()
    found = local_sensitivity(family, HERTZ)
    for k, (name, value) in enumerate(zip(family.parameters, family.values, strict=True)):
        if value == 0.0:
            continue
        step = 1e-4 * value
        ahead, behind = (poles(family.at(moved(family, name, sign * step))).values for sign in (1, -1))
        difference = (ahead - behind) / (2 * step)
        size = np.abs([mode.pole for mode in found.modes])
        assert np.all(np.abs(found.pole_gradient[k] - difference) * value <= 1e-6 * size + 1e-6)


def test_a_two_mass_oscillator_in_closed_form() -> None:
    """f = sqrt(c (1/J_1 + 1/J_2)) / 2 pi, damping ratio = d/2 sqrt((1/J_1 + 1/J_2) / c)."""
    j1, j2 = 2e-3, 5e-3
    found = local_sensitivity(chain([j1, j2], [40.0], [0.01]), HERTZ)
    by_name = {name: k for k, name in enumerate(found.parameters)}
    share = (1 / j1) / (1 / j1 + 1 / j2)
    frequency = found.frequency_log[:, -1]
    damping = found.damping_log[:, -1] / found.modes[-1].damping
    for name, f, z in (("c_1", 0.5, -0.5), ("J_1", -share / 2, -share / 2), ("d_1", 0.0, 1.0)):
        assert frequency[by_name[name]] == pytest.approx(f, abs=1e-9)
        assert damping[by_name[name]] == pytest.approx(z, abs=1e-7)
    assert np.isnan(found.frequency_log[:, 0]).all()  # the two poles at the origin meet


def test_logarithmic_sensitivities_of_a_gain() -> None:
    found = local_sensitivity(drive(), HERTZ)
    k = found.parameters.index("K_Et")
    assert found.magnitude_log[k] == pytest.approx(1.0)
    assert found.phase_log[k] == pytest.approx(0.0, abs=1e-12)
    assert found.response.unit == "1"


def test_scaling_every_inertia_stiffness_and_damping_scales_the_poles_not_at_all() -> None:
    """Euler's theorem: poles are homogeneous of degree 0 in all mechanical parameters and the motor's constants."""
    found = local_sensitivity(drive(), HERTZ)
    together = [k for k, name in enumerate(found.parameters) if name[:2] in ("J_", "c_", "d_") or name == "K_T"]
    total = found.values[together] @ found.pole_gradient[together]
    assert np.abs(total).max() < 1e-7 * max(abs(mode.pole) for mode in found.modes)


def test_one_at_a_time_is_the_machine_with_that_value() -> None:
    family = drive()
    found = one_at_a_time(family, HERTZ, parameters=("c_3", "d_7", "L"), factors=(0.5, 3.0))
    assert [(v.parameter, v.factor) for v in found.variations] == [("c_3", 0.5), ("c_3", 3.0), ("L", 0.5), ("L", 3.0)]
    tripled = found.variations[1]
    system = family.at(moved(family, "c_3", 2 * 1.44))
    assert tripled.response.values == pytest.approx(frequency_response(system, HERTZ).values)
    assert found.deviation(tripled) == pytest.approx(tripled.response.decibel - found.nominal.decibel)
    assert tripled.poles[2] == pytest.approx(poles(system).values[2])
    with pytest.raises(KeyError):
        one_at_a_time(family, HERTZ, parameters=("c_9",))


def test_poles_are_matched_to_the_nearest_and_may_be_missing() -> None:
    reference = np.array([1j, -5.0, 100j])
    found = matched(reference, np.array([90j, 1.2j]))
    assert np.isnan(found[1])
    assert [found[0], found[2]] == [1.2j, 90j]


# --- global ---------------------------------------------------------------------------------------------------------


def product() -> tuple[LinearFamily, list[Scalar]]:
    """K_Et and c_3 read back from the matrices: numbers whose sensitivities are known."""
    sensor = Scalar("sensor", "V s/rad", lambda s: float(s.c[0, 4]))
    sum_ = Scalar("sum", "", lambda s: float(3 * s.c[0, 4] / 0.029 - s.f[7, 2] / 1.44 * -1))
    both = Scalar("product", "", lambda s: float((s.c[0, 4] / 0.029 - 1) * (s.f[7, 2] / 1.44 - 1)))
    return drive(), [sensor, sum_, both]


RANGES = {"K_Et": (0.029 * 0.8, 0.029 * 1.2), "c_3": (1.44 * 0.8, 1.44 * 1.2), "d_6": (5e-4, 9e-4)}


def test_sobol_indices_of_known_functions() -> None:
    family, numbers = product()
    found = sobol(family, numbers, RANGES, samples=256)
    assert found.evaluations == 256 * (3 + 2)
    sensor = {row.parameter: row for row in found.table["sensor"]}
    assert sensor["K_Et"].first == pytest.approx(1.0, abs=0.02)
    assert (sensor["c_3"].total, sensor["d_6"].total) == pytest.approx((0.0, 0.0), abs=1e-12)
    total = {row.parameter: row for row in found.table["sum"]}
    for name, share in (("K_Et", 0.9), ("c_3", 0.1)):
        assert abs(total[name].first - share) <= max(total[name].first_interval, 0.02)
        assert abs(total[name].total - share) <= max(total[name].total_interval, 0.02)
    product_ = {row.parameter: row for row in found.table["product"]}
    assert product_["K_Et"].total == pytest.approx(1.0, abs=0.1)  # acts together with c_3 alone
    assert product_["K_Et"].first == pytest.approx(0.0, abs=0.1)
    assert found.table["sum"][0].parameter == "K_Et"


def test_morris_effects_of_known_functions() -> None:
    family, numbers = product()
    found = morris(family, numbers, RANGES, trajectories=12)
    assert found.evaluations == 12 * (3 + 1)
    rows = {row.parameter: row for row in found.table["sum"]}
    assert rows["K_Et"].mu_star == pytest.approx(3 * 0.4, rel=1e-9)
    assert rows["c_3"].mu == pytest.approx(0.4, rel=1e-9)
    assert rows["K_Et"].sigma == pytest.approx(0.0, abs=1e-9)
    bent = {row.parameter: row for row in found.table["product"]}
    assert bent["K_Et"].sigma > 0.5 * bent["K_Et"].mu_star


@pytest.mark.parametrize("method", [morris, sobol])
def test_the_same_seed_gives_the_same_numbers(method: Callable[..., Any]) -> None:
    family, numbers = product()
    once, again, other = (method(family, numbers, RANGES, 8, seed) for seed in (0, 0, 1))
    assert once == again
    assert once.table != other.table


def test_scalars_of_the_drive() -> None:
    numbers = scalars(drive(), (Band(1.0, 10.0),))
    assert [n.unit for n in numbers] == ["Hz", "1"] * 3 + ["dB"]
    values = [n.value(drive().nominal) for n in numbers]
    assert values[0::2][:3] == pytest.approx([15.167, 623.56, 1261.07], rel=1e-4)
    stiff = moved(drive(), "d_3", 1.0)  # mode 1 is no oscillation any more
    assert np.isnan(numbers[0].value(drive().at(stiff)))


def test_default_ranges() -> None:
    ranges = default_ranges(drive())
    assert not {"T_f", "S", "d_7"} & set(ranges)
    assert ranges["J_1"] == pytest.approx((34e-6 * 0.8, 34e-6 * 1.2))
    assert set(default_ranges(drive(), 0.1, ("c_3",))) == {"c_3"}
    negative = replace(drive(), values=-drive().values)
    assert default_ranges(negative, 0.2, ("c_3",))["c_3"] == pytest.approx((-1.44 * 1.2, -1.44 * 0.8))


@pytest.mark.parametrize(
    "ranges", [{}, {"c_9": (1.0, 2.0)}, {"c_3": (2.0, 1.0)}, {"c_3": (1.0, 1.0)}, {"c_3": (1.0, np.inf)}]
)
def test_ranges_that_are_none(ranges: dict[str, tuple[float, float]]) -> None:
    family, numbers = product()
    with pytest.raises(InputError, match="SD307"):
        morris(family, numbers, ranges)


def test_a_number_that_does_not_exist_everywhere() -> None:
    numbers = scalars(drive(), ())
    with pytest.raises(NumericalError, match="SD611"):
        morris(drive(), numbers, {"d_3": (1e-3, 1.0)}, trajectories=4)


def test_sobol_needs_a_power_of_two() -> None:
    with pytest.raises(UsageError, match="SD302"):
        sobol(drive(), [], RANGES, samples=100)


def test_without_salib_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "SALib.analyze.morris", None)
    family, numbers = product()
    with pytest.raises(UsageError, match="SD306"):
        morris(family, numbers, RANGES)
