"""An arm of two links behind soft gears, in a vertical plane, by equations written here; encoders at both ends."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numba import njit
from numpy.typing import NDArray

from symdyn.compiler import robot_from_text
from symdyn.numeric.diagnose import diagnose
from symdyn.numeric.recording import Recording, read_recording
from symdyn.spec.records import Robot

Array = NDArray[np.float64]

RATE, SECONDS, PARTS, GRAVITY = 500, 15.0, 200, 9.81
L1, M1, M2, R1, R2, I1, I2 = 0.5, 4.0, 2.5, 0.25, 0.2, 0.09, 0.04
NAMES = ("shoulder", "elbow")
RATIO, ROTOR, DRAG = np.array([100.0, 80.0]), np.array([8e-5, 5e-5]), np.array([4e-4, 3e-4])
STIFFNESS, DAMPING = np.array([3000.0, 1500.0]), np.array([3.0, 1.5])  # at the joints
OFF = {
    "m1": "4.3 kg", "m2": "2.5 kg", "r1": "0.237 m", "r2": "0.194 m", "I1": "0.077 kg m^2", "I2": "0.047 kg m^2",
    "J0": "9.2e-5 kg m^2", "J1": "4.2e-5 kg m^2", "b0": "4.5e-4 N m s/rad", "b1": "2.8e-4 N m s/rad",
}  # fmt: skip


def model(soft: bool) -> Robot:
    """With wrong numbers; ``soft``: or with gears that are rigid."""
    numbers = OFF | ({"k0": "0.25 N m/rad", "k1": "0.28 N m/rad"} if soft else {})
    text = f'[robot]\nname = "arm"\ngravity = [0, -{GRAVITY}, 0]\n\n[parameters]\n'
    text += "".join(f'{name} = "{value}"\n' for name, value in numbers.items())
    text += f'\n[dh]\nconvention = "modified"\nrows = [["q", 0, 0, 0], ["q", 0, {L1}, 0]]\n'
    for j, name in enumerate(NAMES):
        link = f'mass = "m{j + 1}", com = ["r{j + 1}", 0, 0], inertia = {{ about = "com", zz = "I{j + 1}" }}'
        fixed = "" if soft else ", fixed_to_joint = true"
        text += f'\n[[joint]]\nname = "{name}"\nlink = {{ {link} }}\n\n[joint.drive]\nratio = {RATIO[j]:g}\n'
        text += f'rotors = [{{ name = "motor", inertia = "J{j}"{fixed} }}]\n'
        if soft:
            text += (
                f'shafts = [{{ name = "gear", from = "motor", to = "joint", stiffness = "k{j}", damping = 3e-4 }}]\n'
            )
            text += 'effort_at = "motor"\n'
    for j, name in enumerate(NAMES):
        text += f'\n[[effect]]\ntype = "viscous_friction"\nat = "{name}.motor"\ncoefficient = "b{j}"\n'
    text += '\n[recording]\ntime = { column = "t", unit = "s" }\n'
    for j, name in enumerate(NAMES):
        for column, quantity, at, unit, side in (
            (f"u{j}", "effort", name, "N m", "motor"),
            (f"m{j}", "position", f"{name}.motor", "rad", "link"),
            (f"q{j}", "position", name, "rad", "link"),
        ):
            text += f'[[recording.channel]]\ncolumn = "{column}"\nquantity = "{quantity}"\njoint = "{at}"\n'
            text += f'unit = "{unit}"\nside = "{side}"\n'
    return robot_from_text(text, "arm.toml")


@njit
def simulated(wanted: Array, speed: Array, ahead: Array, dry: Array) -> Array:
    """(N, 6) angles of the motors, of the joints, and torques, which are held over a sample."""
    h = 1.0 / RATE / PARTS
    reflected = ROTOR + np.array([1.5, 0.2]) / RATIO**2
    stiff, damp = reflected * 15.7**2, reflected * 22.0
    q, w = wanted[0].copy(), speed[0].copy()
    weight = np.array([
        GRAVITY * ((M1 * R1 + M2 * L1) * np.cos(q[0]) + M2 * R2 * np.cos(q[0] + q[1])),
        GRAVITY * M2 * R2 * np.cos(q[0] + q[1]),
    ])  # fmt: skip
    motor, turning = RATIO * (q + weight / STIFFNESS), RATIO * w
    shown, torque, force = np.zeros((len(wanted), 6)), np.zeros(2), np.zeros(2)
    for k in range(len(wanted)):
        for j in range(2):
            torque[j] = ahead[k, j] + stiff[j] * (wanted[k, j] * RATIO[j] - motor[j])
            torque[j] += damp[j] * (speed[k, j] * RATIO[j] - turning[j])
        shown[k, :2], shown[k, 2:4], shown[k, 4:] = motor, q, torque
        for _ in range(PARTS):
            for j in range(2):
                force[j] = STIFFNESS[j] * (motor[j] / RATIO[j] - q[j]) + DAMPING[j] * (turning[j] / RATIO[j] - w[j])
                moved = turning[j] + h * (torque[j] - DRAG[j] * turning[j] - force[j] / RATIO[j]) / ROTOR[j]
                stuck = dry[j] * h / ROTOR[j]
                moved = 0.0 if abs(moved) <= stuck else moved - np.sign(moved) * stuck
                motor[j] += 0.5 * h * (moved + turning[j])
                turning[j] = moved
            c, s = M2 * L1 * R2 * np.cos(q[1]), M2 * L1 * R2 * np.sin(q[1])
            m22 = I2 + M2 * R2**2
            m11, m12 = I1 + M1 * R1**2 + M2 * L1**2 + m22 + 2 * c, m22 + c
            outer = GRAVITY * M2 * R2 * np.cos(q[0] + q[1])
            one = force[0] + s * w[1] * (2 * w[0] + w[1]) - outer - GRAVITY * (M1 * R1 + M2 * L1) * np.cos(q[0])
            two = force[1] - s * w[0] ** 2 - outer
            det = m11 * m22 - m12**2
            last = w.copy()
            w[0] += h * (m22 * one - m12 * two) / det
            w[1] += h * (m11 * two - m12 * one) / det
            q += 0.5 * h * (last + w)
    return shown


def recorded(file: Path, robot: Robot, seed: int, dry: tuple[float, float] = (0.0, 0.0)) -> Recording:
    """Encoders of 4096 steps per turn at the motors, and of 2^18 at the joints; torques with 0.2 % of noise."""
    rng = np.random.default_rng(seed)
    time = np.arange(int(RATE * SECONDS)) / RATE
    wanted = np.empty((len(time), 2))
    waves = np.array([1, 2, 3, 5, 8, 13])
    for j, (slowest, middle) in enumerate(((0.13, -0.6), (0.15, 0.3))):
        phase, size = rng.uniform(0.0, 2.0 * np.pi, 6), rng.uniform(0.4, 1.0, 6) / np.sqrt(waves)
        course = np.sin(2.0 * np.pi * slowest * np.outer(time, waves) + phase) @ size
        wanted[:, j] = course / np.abs(course).max() + middle
    speed = np.gradient(wanted, time, axis=0)
    outer = GRAVITY * M2 * R2 * np.cos(wanted.sum(axis=1))
    weight = np.column_stack([outer + GRAVITY * (M1 * R1 + M2 * L1) * np.cos(wanted[:, 0]), outer])
    ahead = weight / RATIO + speed * RATIO * DRAG
    shown = simulated(wanted, speed, ahead, np.array(dry))
    steps = 2.0 * np.pi / np.array([4096, 4096, 2**18, 2**18])
    shown[:, :4] = steps * np.round(shown[:, :4] / steps)
    shown[:, 4:] += 2e-3 * shown[:, 4:].std(axis=0) * rng.standard_normal((len(time), 2))
    np.savetxt(
        file, np.column_stack([time, shown]), delimiter=",", header="t,m0,m1,q0,q1,u0,u1", comments="", fmt="%.10g"
    )
    assert robot.channels is not None
    return read_recording(file, robot.channels)


@pytest.mark.slow
def test_two_gears_taken_for_rigid_are_told_soft(tmp_path: Path) -> None:
    robot = model(soft=False)
    runs = [recorded(tmp_path / f"{seed}.csv", robot, seed) for seed in (1, 2)]
    found = diagnose(robot, *runs)
    assert found.verdict == "missing_physics"
    assert {(f.effect, f.place) for f in found.findings} == {("joint_compliance", name) for name in NAMES}
    for finding in found.findings:
        j = NAMES.index(finding.place)
        assert finding.parameters["stiffness"].value == pytest.approx(STIFFNESS[j] / RATIO[j] ** 2, rel=1e-2)
    assert found.after.heldout < 1e-3


@pytest.mark.slow
def test_friction_of_one_of_two_soft_drives_is_named_at_its_motor(tmp_path: Path) -> None:
    robot = model(soft=True)
    runs = [recorded(tmp_path / f"{seed}.csv", robot, seed, (0.0, 0.02)) for seed in (1, 2)]
    found = diagnose(robot, *runs)
    assert (found.verdict, [(f.effect, f.place) for f in found.findings]) == (
        "missing_physics", [("coulomb_friction", "elbow.motor")],
    )  # fmt: skip
    assert found.findings[0].parameters["level"].value == pytest.approx(0.02, rel=1e-2)
