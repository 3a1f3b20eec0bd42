"""Simpler models of the arm: each misses what its name says, and costs less."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from symdyn.compiler import load_robot
from symdyn.derive.equations import EquationsOfMotion, equations_of_motion
from symdyn.program.evaluate import evaluate
from symdyn.program.functions import functions
from symdyn.program.ssa import Program
from symdyn.program.variants import variant_table, variants
from symdyn.spec.records import Link


@pytest.fixture(scope="module")
def equations() -> EquationsOfMotion:
    """Puma 560, the arm alone: what effects add is the same for all."""
    robot = load_robot("puma560")
    return equations_of_motion(
        replace(robot, joints=tuple(replace(joint, drive=None) for joint in robot.joints), effects=())
    )


def test_each_is_what_its_name_says(equations: EquationsOfMotion) -> None:
    values = [p.value or 0.0 for p in equations.robot.parameters]
    generator = np.random.default_rng(1)
    q, qd, qdd = (generator.uniform(-2, 2, 6) for _ in range(3))
    given = {"q": q.tolist(), "qd": qd.tolist(), "qdd": qdd.tolist(), "p": values}

    def value(program: Program) -> np.ndarray:
        return np.array(evaluate(program, {a.name: given[a.name] for a in program.arguments}), dtype=float)

    needed = ("mass_matrix", "gravity", "inverse_dynamics")
    of = {f.name: value(f.program) for f in functions(equations) if f.name in needed}
    mass = of["mass_matrix"].reshape(6, 6)
    found = {f.name: value(f.program) for f in variants(equations)}
    wanted = {
        "full": of["inverse_dynamics"],
        "no_coriolis": mass @ qdd + of["gravity"],
        "diagonal_inertia": np.diag(mass) * qdd + of["gravity"],
        "gravity": of["gravity"],
    }
    assert list(found) == list(wanted)
    for name, efforts in wanted.items():
        np.testing.assert_allclose(found[name], efforts, rtol=1e-10, atol=1e-10, err_msg=name)


def test_the_table(equations: EquationsOfMotion) -> None:
    rows = variant_table(equations, states=20)
    assert [row.weight for row in rows] == sorted((row.weight for row in rows), reverse=True)
    assert rows[0].error == (0.0,) * 6
    assert all(0 < error < 1.5 for row in rows[1:] for error in row.error)
    assert rows == variant_table(equations, states=20)
    assert rows != variant_table(equations, states=20, seed=1)


def test_slow_motion_needs_no_coriolis_terms(equations: EquationsOfMotion) -> None:
    """They fall with the square of the speed."""
    fast, slow = (variant_table(equations, 20, speed)[1].error for speed in (1.0, 0.01))
    assert all(b < 0.02 * a for a, b in zip(fast, slow, strict=True))


def test_an_arm_without_inertia_has_no_error_to_speak_of() -> None:
    robot = load_robot("two-link")
    robot = replace(robot, joints=tuple(replace(joint, link=Link()) for joint in robot.joints))
    assert all(math.isnan(e) for row in variant_table(equations_of_motion(robot), 2) for e in row.error)


def test_a_free_parameter_is_refused(equations: EquationsOfMotion) -> None:
    first, *others = equations.robot.parameters
    robot = replace(equations.robot, parameters=(replace(first, value=None), *others))
    with pytest.raises(ValueError, match="left free"):
        variant_table(replace(equations, robot=robot), 2)
