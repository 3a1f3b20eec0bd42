"""Modes by their energy: closed forms, the seed's drive, and the balance of decay and losses on random chains."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from symdyn.compiler import linearise, load_robot, robot_from_text
from symdyn.derive.linearize import without_nonsmooth
from symdyn.numeric.linear.drops import without
from symdyn.numeric.linear.eigen import poles
from symdyn.numeric.linear.modes import modes
from symdyn.spec.edit import add_effect

from .machines import chain, drive


def test_two_masses_in_closed_form() -> None:
    j1, j2, c, d = 2e-3, 5e-3, 40.0, 0.01
    *free, mode = modes(chain([j1, j2], [c], [d]).nominal)
    assert [m.frequency for m in free] == [0.0, 0.0]
    assert all(m.name == "free motion of r1 and load" for m in free)
    reduced = j1 * j2 / (j1 + j2)
    assert mode.frequency == pytest.approx(np.sqrt(c / reduced) / (2 * np.pi), rel=1e-12)
    assert mode.damping == pytest.approx(d / (2 * np.sqrt(c * reduced)), rel=1e-9)
    assert mode.name == "r1 against load"
    assert mode.shape["load.r1"] == 1.0
    assert mode.shape["load"] == pytest.approx(-j1 / j2, rel=1e-9)
    assert mode.strain["load.s1"] == pytest.approx(0.5, rel=1e-9)
    assert mode.kinetic["load.r1"] / mode.kinetic["load"] == pytest.approx(j2 / j1, rel=1e-9)
    assert mode.losses == {"load.r1": 0.0, "load.s1": pytest.approx(d / (2 * reduced), rel=1e-9)} | {
        name: 0.0 for name in mode.losses if name not in ("load.r1", "load.s1")
    }


def test_modes_of_the_seed() -> None:
    found = modes(drive().nominal)
    pairs = [m for m in found if m.pole.imag > 0]
    assert [m.frequency for m in pairs] == pytest.approx([15.17, 623.6, 1261.1], rel=5e-4)
    assert [m.damping for m in pairs] == pytest.approx([0.116, 0.064, 0.105], abs=6e-4)
    assert [m.pole.real for m in found if m.pole.imag == 0] == pytest.approx([0.0, -8.859, -18277.8], rel=1e-4)
    assert [m.name for m in found] == [
        "free motion of tachometer, motor, harmonic_drive and axis1",
        "axis1, harmonic_drive, motor and tachometer together slowing down",
        "axis1 against harmonic_drive, motor and tachometer",
        "tachometer and motor against harmonic_drive",
        "motor against tachometer",
        "axis1.motor.current settling",
    ]
    assert pairs[0].strain["axis1.flexspline"] / sum(pairs[0].strain.values()) > 0.999
    assert pairs[1].losses["axis1.motor_shaft"] / pairs[1].decay == pytest.approx(0.948, abs=5e-4)


def test_losses_of_a_motor_whose_constants_differ_still_add_up() -> None:
    """K_T and K_E are one number in SI; where a file says otherwise, the energy of the current is weighted."""
    family = drive()
    p = family.values.copy()
    p[family.index("K_E")] *= 1.3
    for mode in modes(family.at(p)):
        if mode.frequency:
            assert sum(mode.losses.values()) == pytest.approx(mode.decay, rel=1e-9)


def test_a_bristle_at_rest_is_a_spring_with_a_damper() -> None:
    """LuGre friction on the motor holds the drive: what its state stores and loses is in the balance."""
    values = {"stiffness": "20 N m/rad", "damping": "1e-4 N m s/rad", "level": "0.025 N m", "excess": "0.01 N m"}
    values["stribeck_velocity"] = "0.1 rad/s"
    text = add_effect(load_robot("irb6-axis1").text, "lugre_friction", "axis1.motor", values)
    found = modes(linearise(without_nonsmooth(robot_from_text(text, "lugre.toml"))).nominal)
    assert all(sum(m.losses.values()) == pytest.approx(m.decay, rel=1e-7) for m in found if m.losses)
    held = [m for m in found if m.pole.imag > 0]
    (bristle,) = (name for name in held[0].hidden if "current" not in name)
    assert max(m.hidden[bristle] for m in held) > 0.2
    slowest = min((m for m in found if m.pole.imag > 0), key=lambda m: m.frequency)
    assert slowest.kinetic["axis1"] > 0.4  # the load swings on the flexspline against a motor that is held
    assert slowest.frequency == pytest.approx(np.sqrt(1.44 / 372e-6) / (2 * np.pi), rel=0.05)


positive = st.floats(0.2, 5.0)


@pytest.mark.slow
@settings(max_examples=12, phases=(Phase.explicit, Phase.reuse, Phase.generate))  # a machine is derived per example
@given(data=st.data(), size=st.integers(2, 5), grounded=positive)
def test_energy_is_shared_and_losses_add_up_to_the_decay(data: st.DataObject, size: int, grounded: float) -> None:
    inertias = [1e-3 * data.draw(positive) for _ in range(size)]
    stiffnesses = [100 * data.draw(positive) for _ in range(size - 1)]
    dampings = [1e-3 * data.draw(positive) for _ in range(size - 1)]
    found = modes(chain(inertias, stiffnesses, dampings, 1e-3 * grounded).nominal)
    assert sum(2 if m.pole.imag > 0 else 1 for m in found) == 2 * size
    for mode in found:
        if mode.frequency == 0.0:
            continue
        assert mode.decay > 0
        assert sum(mode.losses.values()) == pytest.approx(mode.decay, rel=1e-7)
        shares = [*mode.kinetic.values(), *mode.strain.values(), *mode.hidden.values()]
        assert sum(shares) == pytest.approx(1.0, rel=1e-9)


def test_an_arm_upside_down_falls() -> None:
    robot = without_nonsmooth(load_robot("irb6-arm"))
    found = modes(linearise(robot, np.array([0.0, np.pi / 2, 0.0, 0.0])).nominal)
    falling = [m for m in found if m.pole.real > 0]
    assert [m.name for m in falling] == ["arm running away"]
    assert falling[0].pole == pytest.approx(np.sqrt(9.81 / 0.5), rel=1e-9)


def test_a_state_that_is_gone_has_no_pole() -> None:
    limit = without(drive(), "L")
    assert limit is not None
    found = modes(limit)
    assert sum(2 if m.pole.imag > 0 else 1 for m in found) == 8
    assert all("current" not in m.name for m in found)


def test_poles_that_meet_are_marked() -> None:
    """Two free inertias without friction: a double pole at the origin has no second eigenvector."""
    found = poles(chain([1e-3, 1e-3], [10.0], [0.0]).nominal)
    assert found.values[:2] == pytest.approx([0.0, 0.0])
    assert found.defective == [True, True, False]
