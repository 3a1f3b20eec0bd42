"""How large a fit takes parameters to be whose values do not tell it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from symdyn.compiler import robot_from_text
from symdyn.numeric.sizes import sized, sizes

TEXT = """
[robot]
name = "arm"
gravity = [0, 0, -9.81]

[parameters]
m = "2 kg"
c_x = "0.3 m"
c_y = "0 m"
c_z = "0.4 m"
I_xx = "0.04 kg m^2"
I_yy = "0.09 kg m^2"
I_zz = "0.1 kg m^2"
I_xy = "0.001 kg m^2"

[dh]
rows = [["q", 0, 0, 0]]

[[joint]]
name = "turn"
link = { mass = "m", com = ["c_x", "c_y", "-c_z"], inertia = { xx = "I_xx", yy = "I_yy", zz = "I_zz", xy = "I_xy" } }
"""


def test_a_coordinate_is_as_large_as_its_vector_and_a_product_as_its_moments() -> None:
    found = sizes(robot_from_text(TEXT, "arm.toml"))
    assert found == {f"c_{axis}": pytest.approx(0.5) for axis in "xyz"} | {
        "I_xy": pytest.approx(math.sqrt(0.04 * 0.09)),
        "gravity_z": 30.0,
    }


def test_gravity_may_be_three_times_that_of_earth() -> None:
    text = TEXT.replace("gravity = [0, 0, -9.81]", 'gravity = [0, "g_y", "-2*g_z"]')
    text = text.replace("[parameters]\n", '[parameters]\ng_y = "1e-6 m/s^2"\ng_z = "4.9 m/s^2"\n')
    found = sizes(robot_from_text(text, "arm.toml"))
    assert (found["g_y"], found["g_z"]) == (30.0, 15.0)


def test_of_all_else_its_value_tells() -> None:
    np.testing.assert_array_equal(sized(["m", "x", "b"], np.array([2.0, 0.1, 0.0]), {"x": 0.5}), [2.0, 0.5, 2.0])
