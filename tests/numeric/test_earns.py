"""What a finding must take off the held-out error, and where."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from symdyn.compiler import robot_from_text
from symdyn.numeric.setting import prepare

from .arm_of_two import ARM_OF_TWO, run


def test_a_sensor_must_matter_at_its_own_joint_or_over_all() -> None:
    """What it shows enters all equations, and another joint's may like it by chance."""
    robot = robot_from_text(ARM_OF_TWO, "arm.toml")
    case = prepare(robot, run(1), run(2), lambda _: None, frozenset()).case(12.0)
    given = case.explain()
    noise = np.random.default_rng(5).standard_normal(given.heldout.shape)
    before = replace(given, heldout=noise * case.judge.reference.std(axis=0) * [3.0, 1.0])
    after = replace(before, heldout=before.heldout * [1.0, 0.9])
    assert case.earns(before, after)
    assert case.earns(before, after, "two")
    assert not case.earns(before, after, "one")
    assert case.earns(before, replace(before, heldout=0.9 * before.heldout), "one")
