"""Energy along trajectories: everything that goes in is found again, and each element has its share by hand."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.drive.machine import seed_drive
from benchmarks.drive.reference import SINE, STEP
from symdyn.base.errors import InputError
from symdyn.compiler import compile_hybrid, robot_from_text
from symdyn.numeric.hybrid.affine_simulation import simulate_affine
from symdyn.numeric.hybrid.energy import EnergyBalance, energy_balance
from symdyn.numeric.hybrid.general_simulation import simulate_general
from symdyn.numeric.hybrid.machine import Machine
from symdyn.numeric.hybrid.signals import Signal, constant, sine, step
from symdyn.numeric.hybrid.simulate import simulate_events

from .machines import COULOMB, GAP, PAIR, SLIDER, effect, machine

Array = NDArray[np.float64]

WINDING = """
[robot]
name = "winding"
gravity = [0, 0, 0]
[parameters]
R = "1.6 Ohm"
L = "80 mH"
[dh]
rows = [["q", 0, 0, 0]]
[[joint]]
name = "arm"
link = { inertia = { about = "joint", zz = 0.5 } }
[joint.drive]
rotors = [{ name = "motor", inertia = 0.2, fixed_to_joint = true }]
motor = { name = "circuit", at = "motor", resistance = "R", inductance = "L", torque_constant = 0.1, \
back_emf_constant = 0.1 }
"""
PENDULUM = """
[robot]
name = "pendulum"
gravity = [0, -9.81, 0]
[dh]
rows = [["q", 0, 0, 0]]
[[joint]]
name = "pivot"
link = { mass = 1.2, com = [0.4, 0, 0], inertia = { about = "joint", zz = 0.25 } }
"""


def balance(
    of: Machine, end: float, signals: Sequence[Signal], start: Array | None = None, points: int = 11
) -> EnergyBalance:
    time = np.linspace(0.0, end, points)
    return energy_balance(of, simulate_events(of, time, signals, start=start, tolerance=1e-11), signals)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("case", "signal"), [pytest.param(STEP, step(1.0), id="step"), pytest.param(SINE, sine(1.0, 0.2), id="sine")]
)
def test_the_seed_drive_loses_nothing(case: tuple, signal: Signal) -> None:
    """Over all sticking, contacts and saturation, with a thousand reporting times and with four."""
    fine = balance(seed_drive(), case[1], [signal], points=1001)
    coarse = balance(seed_drive(), case[1], [signal], points=5)
    assert fine.closure < 1e-11
    assert coarse.closure < 1e-11
    for name, column in fine.table().items():
        if name != "residual [J]":
            np.testing.assert_allclose(column[::250], coarse.table()[name], rtol=1e-8, atol=1e-14)
    assert all(np.all(np.diff(column) >= -1e-15) for column in fine.dissipated.values())
    assert fine.lost["axis1.flexspline"][-1] > 0.0
    assert fine.dissipated["axis1.motor.coulomb_friction"][-1] > 0.01


def test_every_element_of_the_seed_drive_is_named() -> None:
    book = balance(seed_drive(), 0.01, [step(1.0)])
    assert set(book.supplied) == {"axis1.motor.dc_motor"}
    shafts = ("tachometer_shaft", "motor_shaft", "flexspline")
    rotors = ("tachometer", "motor", "harmonic_drive")
    assert set(book.dissipated) == {
        "axis1.motor.dc_motor",
        "axis1.motor.coulomb_friction",
        *(f"axis1.{place}.viscous_friction" for place in (*shafts, *rotors)),
    }
    assert set(book.stored) == {
        "links",
        "axis1.motor.dc_motor",
        *(f"axis1.{rotor}.added_inertia" for rotor in rotors),
        *(f"axis1.{shaft}.linear_spring" for shaft in shafts),
    }
    assert set(book.lost) == {"axis1.flexspline"}


@pytest.mark.parametrize(
    "way",
    [
        pytest.param(simulate_affine, id="exact"),
        pytest.param(partial(simulate_general, tolerance=1e-11), id="general", marks=pytest.mark.slow),
    ],
)
def test_a_block_that_slides_to_rest_turns_force_times_distance_to_heat(way: partial) -> None:
    """It is pushed with 1 N against friction of 3 N until it sticks, and takes no energy from then on."""
    block = machine(SLIDER + COULOMB)
    speed = 2.0
    distance = 2.0 * speed**2 / (2 * (3.0 - 1.0))
    time = np.linspace(0.0, 4.0, 9)
    book = energy_balance(block, way(block, time, [constant(1.0)], start=np.array([0.0, speed])), [constant(1.0)])
    assert book.dissipated["slide.coulomb_friction"][-1] == pytest.approx(3.0 * distance, rel=1e-9)
    assert book.supplied["slide.effort"][-1] == pytest.approx(1.0 * distance, rel=1e-9)
    assert book.stored["links"][[0, -1]] == pytest.approx([speed**2, 0.0], abs=1e-15)
    assert book.dissipated["slide.coulomb_friction"][-1] == book.dissipated["slide.coulomb_friction"][-3]
    assert book.closure < 1e-9


def test_a_locked_motor_heats_its_winding() -> None:
    """I = (U / R) (1 - exp(-t R / L)): three columns in closed form, and none for the friction that holds it."""
    held = machine(WINDING + effect("coulomb_friction", "arm", level=100.0))
    voltage, r, inductance, end = 5.0, 1.6, 0.08, 0.3
    tau = inductance / r
    book = balance(held, end, [constant(voltage)])
    t = book.time
    current = voltage / r * (1 - np.exp(-t / tau))
    charge = voltage / r * (t - tau * (1 - np.exp(-t / tau)))
    heat = voltage**2 / r * (t - 2 * tau * (1 - np.exp(-t / tau)) + tau / 2 * (1 - np.exp(-2 * t / tau)))
    np.testing.assert_allclose(book.supplied["arm.motor.dc_motor"], voltage * charge, rtol=1e-12, atol=1e-14)
    np.testing.assert_allclose(book.dissipated["arm.motor.dc_motor"], heat, rtol=1e-12, atol=1e-14)
    np.testing.assert_allclose(book.stored["arm.motor.dc_motor"], inductance * current**2 / 2, rtol=1e-12)
    assert np.all(book.dissipated["arm.coulomb_friction"] == 0.0)
    assert book.closure < 1e-12


@pytest.mark.slow
def test_other_parameters_than_those_of_the_file() -> None:
    """A kernel with the resistance doubled books what a machine with that resistance does."""
    kernel = machine(WINDING).kernel
    values = kernel.values
    values[kernel.parameters.index("R")] *= 2.0
    book = balance(Machine(kernel, values), 0.5, [constant(5.0)])
    twice = Machine(compile_hybrid(robot_from_text(WINDING.replace("1.6 Ohm", "3.2 Ohm"), "winding")))
    expected = balance(twice, 0.5, [constant(5.0)])
    for name, column in book.dissipated.items():
        np.testing.assert_allclose(column, expected.dissipated[name], rtol=1e-12)
    assert book.closure < 1e-12


@pytest.mark.slow  # one more machine to compile
def test_what_is_lost_as_flanks_open_is_the_strain_that_is_left() -> None:
    """The twist in contact is u = v/w exp(-a t) sin(w t); the flanks open as c u + d u' = 0, with c u^2 / 2 left."""
    stiffness, damping, relative = 40.0, 0.3, 2.0
    inertia = 1.0 / (1.0 / 0.5 + 1.0 / 0.2)
    a = damping / (2 * inertia)
    w = math.sqrt(stiffness / inertia - a**2)
    opens = (math.pi - math.atan(damping * w / (stiffness - damping * a))) / w
    u = relative / w * math.exp(-a * opens) * math.sin(w * opens)
    start = np.array([0.0, 0.0, 0.0, 0.0])
    kernel = machine(PAIR + GAP).kernel
    start[kernel.states.index("arm.qd")] = relative
    book = balance(machine(PAIR + GAP), 0.1 / relative + opens + 0.01, [constant(0.0)], start=start)
    assert book.lost["arm.shaft"][-1] == pytest.approx(stiffness * u**2 / 2, rel=1e-8)
    rate = relative * math.exp(-a * opens) * (math.cos(w * opens) - a / w * math.sin(w * opens))
    heat = inertia * relative**2 / 2 - inertia * rate**2 / 2 - stiffness * u**2 / 2
    assert book.dissipated["arm.shaft.viscous_friction"][-1] == pytest.approx(heat, rel=1e-9)
    assert book.stored["arm.shaft.linear_spring"][-1] == 0.0
    assert book.closure < 1e-12


@pytest.mark.slow  # compiles a machine of its own by the general way
def test_a_pendulum_with_bristles_and_a_hardening_spring() -> None:
    """Nothing is linear: the book closes to what the trajectory was asked for."""
    pendulum = machine(
        PENDULUM
        + effect("coulomb_friction", "pivot", level=0.2)
        + effect("hardening_spring", "pivot", stiffness=1.0)
        + effect("lugre_friction", "pivot", stiffness=50.0, damping=0.5, level=0.3, excess=0.1, stribeck_velocity=0.1)
    )
    assert not pendulum.affine
    book = balance(pendulum, 3.0, [sine(1.0, 1.0)], start=np.array([1.0, 0.0, 0.0]), points=31)
    assert book.closure < 1e-8
    assert book.stored["pivot.lugre_friction"].max() > 1e-6
    assert book.dissipated["pivot.lugre_friction"][-1] > 0.1


@pytest.mark.slow  # likewise
def test_an_error_of_the_trajectory_shows_in_the_residual() -> None:
    time = np.linspace(0.0, 1.0, 11)
    rough = simulate_general(seed_drive(), time, [step(1.0)], tolerance=1e-4)
    assert 1e-9 < energy_balance(seed_drive(), rough, [step(1.0)]).closure < 1e-2


def test_a_trajectory_of_another_machine_is_refused() -> None:
    block = machine(SLIDER + COULOMB)
    found = simulate_affine(block, np.linspace(0.0, 1.0, 3), [constant(0.0)])
    with pytest.raises(InputError, match="SD302"):
        energy_balance(seed_drive(), found, [step(1.0)])
    with pytest.raises(InputError, match="SD302"):
        energy_balance(block, found, [])
