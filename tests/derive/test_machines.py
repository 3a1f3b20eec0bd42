"""The bundled arms of four to seven axes against programs that share no code: Pinocchio and the Robotics Toolbox."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass, replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from symdyn.compiler import load_robot
from symdyn.derive.equations import equations_of_motion
from symdyn.spec.records import Monomial, Robot

from . import published
from .evaluation import close, inverse_dynamics
from .published import TOOLBOX, State
from .test_pinocchio import model_of, pin

MACHINES = ("manutec-r3", "panda", "puma560", "scara", "stanford", "ur10e")
TOLERANCE = 1e-10


def with_numbers(item: Any, values: Mapping[str, float]) -> Any:
    """A record with every parameter in it replaced by its value; exact where there is none."""
    if isinstance(item, Monomial):
        if not item.factors:
            return item
        return Monomial(
            float(item.coefficient) * float(np.prod([values[name] ** power for name, power in item.factors]))
        )
    if isinstance(item, tuple):
        return tuple(with_numbers(element, values) for element in item)
    if is_dataclass(item) and not isinstance(item, type):
        return replace(item, **{f.name: with_numbers(getattr(item, f.name), values) for f in fields(item)})
    return item


@cache
def machine(name: str) -> Robot:
    """The bundled robot, its parameters replaced by their numbers."""
    robot = load_robot(name)
    values = {p.name: p.value for p in robot.parameters if p.value is not None}
    resolved: Robot = with_numbers(robot, values)
    return replace(resolved, parameters=())


@cache
def arm(name: str) -> Robot:
    """The rigid arm alone, without drives and friction."""
    joints = tuple(replace(joint, drive=None) for joint in machine(name).joints)
    return replace(machine(name), joints=joints, effects=())


@cache
def efforts(name: str) -> Callable[[State], np.ndarray]:
    return inverse_dynamics(equations_of_motion(arm(name)))


def states(name: str, count: int) -> list[State]:
    generator, n = np.random.default_rng(3), len(arm(name).joints)
    return [{key: list(generator.uniform(-3, 3, n)) for key in ("q", "qd", "qdd")} for _ in range(count)]


def rnea(model: Any, state: State) -> np.ndarray:
    return np.array(pin.rnea(model, model.createData(), *(np.array(state[key]) for key in ("q", "qd", "qdd"))))


@pytest.mark.parametrize("name", MACHINES)
def test_inverse_dynamics_of_the_arm(name: str) -> None:
    model = model_of(arm(name))
    for state in states(name, 25):
        assert close(efforts(name)(state), rnea(model, state), TOLERANCE)


@pytest.mark.slow
@pytest.mark.parametrize("name", MACHINES)
def test_inverse_dynamics_of_the_arm_in_many_states(name: str) -> None:
    model = model_of(arm(name))
    for state in states(name, 1000):
        assert close(efforts(name)(state), rnea(model, state), TOLERANCE)


@pytest.mark.parametrize("name", MACHINES)
def test_mass_matrix_of_the_arm(name: str) -> None:
    model, compute, n = model_of(arm(name)), efforts(name), len(arm(name).joints)
    rest, unit = [0.0] * n, np.eye(n)
    for state in states(name, 4):
        theirs = np.triu(pin.crba(model, model.createData(), np.array(state["q"])))
        still = compute({"q": state["q"], "qd": rest, "qdd": rest})
        ours = [compute({"q": state["q"], "qd": rest, "qdd": list(unit[j])}) - still for j in range(n)]
        assert close(np.column_stack(ours), theirs + np.triu(theirs, 1).T, TOLERANCE)


@pytest.mark.parametrize("name", MACHINES)
def test_mass_matrix_is_positive_definite(name: str) -> None:
    """Of the whole machine, rotors included: forward dynamics needs it."""
    compute, n = inverse_dynamics(equations_of_motion(machine(name))), len(machine(name).joints)
    rest, unit = [0.0] * n, np.eye(n)
    for state in states(name, 4):
        still = compute({"q": state["q"], "qd": rest, "qdd": rest})
        rows = [compute({"q": state["q"], "qd": rest, "qdd": list(unit[j])}) - still for j in range(n)]
        assert np.linalg.eigvalsh(np.array(rows))[0] > 0


# The numbers of the files against the sources' own, placed the sources' own way.


@pytest.mark.parametrize(("name", "build"), [("panda", published.panda), ("manutec-r3", published.manutec_r3)])
def test_as_published(name: str, build: Callable[[Any], Any]) -> None:
    model = build(pin)
    for state in states(name, 25):
        assert close(efforts(name)(state), rnea(model, state), TOLERANCE)


def test_scara_as_published() -> None:
    model, upwards = published.scara(pin), np.array([1, 1, -1, 1])
    for state in states("scara", 25):
        theirs = rnea(model, {key: list(upwards * values) for key, values in state.items()})
        assert close(efforts("scara")(state), upwards * theirs, TOLERANCE)


@pytest.mark.parametrize("name", TOOLBOX)
def test_with_drives_as_the_robotics_toolbox(name: str) -> None:
    compute = inverse_dynamics(equations_of_motion(machine(name)))
    for state, theirs in TOOLBOX[name]:
        assert np.allclose(compute(state), theirs, rtol=2e-12, atol=1e-12)


def test_friction_of_the_puma_goes_by_the_direction_of_its_joints() -> None:
    """Corke's two Coulomb levels, |G| Tc: waist and elbow have motors that turn backwards."""
    compute, still = inverse_dynamics(equations_of_motion(machine("puma560"))), [0.0] * 6
    ratio = np.array([62.6111, 107.815, 53.7063, 76.0364, 71.923, 76.686])
    forwards = np.array([0.395, 0.126, 0.132, 11.2e-3, 9.26e-3, 3.96e-3])
    backwards = np.array([-0.435, -0.071, -0.105, -16.9e-3, -14.5e-3, -10.5e-3])
    rest = compute({"q": still, "qd": still, "qdd": still})
    for sign, level in ((1, forwards), (-1, backwards)):
        creeping = compute({"q": still, "qd": [sign * 1e-9] * 6, "qdd": still})
        assert np.allclose(creeping - rest, ratio * level, rtol=0, atol=1e-7)
