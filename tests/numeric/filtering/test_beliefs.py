"""What is believed of parameters beforehand, and of two that are like each other."""

from __future__ import annotations

import math

import numpy as np
import pytest

from symdyn.compiler import compile_robot, robot_from_text
from symdyn.numeric.filtering.beliefs import Belief, Beliefs, penalty, precision, pull
from symdyn.numeric.filtering.model import RECIPROCAL, _beliefs, one_magnet
from tests.numeric.filtering.drive import MODEL

INDEX = {"a": 0, "other": 1, "b": 2, "c": 3}
KNOWN: Beliefs = {
    "a": Belief(positive=True, centre=0.1, spread=0.4, like="b", apart=0.05),
    "b": Belief(positive=True, centre=-0.3, spread=0.4),
    "c": Belief(-1.0, 5.0, centre=2.0, spread=3.0),
}


def at(x: np.ndarray) -> np.ndarray:
    """Parameters at these coordinates."""
    return np.array([math.exp(x[0]), 7.0, math.exp(x[1]), x[2]])


def test_slope_and_curvature_are_those_of_the_penalty() -> None:
    x, h = np.array([0.3, 0.2, -0.5]), 1e-4

    def off(x: np.ndarray) -> float:
        return penalty(at(x), INDEX, KNOWN)

    slope = [(off(x - h * e) - off(x + h * e)) / (2 * h) for e in np.eye(3)]
    np.testing.assert_allclose(pull(at(x), INDEX, KNOWN), slope, rtol=1e-6)
    mixed = [
        [(off(x + h * (e + f)) - off(x + h * e) - off(x + h * f) + off(x)) / h**2 for f in np.eye(3)] for e in np.eye(3)
    ]
    np.testing.assert_allclose(precision(KNOWN), mixed, rtol=1e-3, atol=1e-3)


def test_what_no_fit_moves_is_like_nothing() -> None:
    alone = {name: belief for name, belief in KNOWN.items() if name != "b"}
    np.testing.assert_array_equal(precision(alone), np.diag([0.4**-2, 3.0**-2]))
    near, far = (penalty(at(np.array([0.1, y, 2.0])), INDEX, alone) for y in (0.1, 3.0))
    assert near == far == pytest.approx(0.0)


def test_a_motor_has_one_constant() -> None:
    robot = robot_from_text(MODEL, "drive.toml")
    assert one_magnet(robot) == (("K_T", "K_E"),)
    kernel = compile_robot(robot).kernel()
    beliefs = _beliefs(robot, kernel)
    assert (beliefs["K_T"].like, beliefs["K_T"].apart) == ("K_E", RECIPROCAL)
    p, index = kernel.values.copy(), {name: i for i, name in enumerate(kernel.parameters)}
    p[index["K_T"]] = 1.05 * p[index["K_E"]]
    alone = {
        name: belief for name, belief in beliefs.items() if name != "K_E"
    }  # held: the other may be for other currents
    more = penalty(p, index, beliefs) - penalty(p, index, alone)
    assert more == pytest.approx(0.5 * (math.log(1.05) / RECIPROCAL) ** 2)


@pytest.mark.parametrize("emf", ['"K_T"', '"2 K_E"'])
def test_other_numbers_are_like_nothing(emf: str) -> None:
    text = MODEL.replace('back_emf_constant = "K_E"', f"back_emf_constant = {emf}")
    assert text != MODEL
    assert one_magnet(robot_from_text(text, "drive.toml")) == ()
