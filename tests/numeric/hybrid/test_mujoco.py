"""Motors with an arm against MuJoCo's own d.c. motor: another engine, another integrator, the same numbers given."""

from __future__ import annotations

import numpy as np
import pytest

from symdyn.compiler import compile_hybrid, robot_from_text
from symdyn.numeric.hybrid.general_simulation import simulate_general
from symdyn.numeric.hybrid.machine import Machine
from symdyn.numeric.hybrid.signals import sine, step
from symdyn.numeric.hybrid.trajectory import HybridTrajectory

mujoco = pytest.importorskip("mujoco", reason="install symdyn[blind]")

RATIOS, ROTORS = (40.0, 25.0), (2e-4, 1e-4)
RESISTANCE, INDUCTANCE, CONSTANT = (1.6, 2.2), (4e-3, 3e-3), (0.19, 0.12)
LENGTH, MASSES, CENTRES, MOMENTS = 0.5, (3.0, 2.0), (0.2, 0.25), (0.04, 0.03)
END, STEP = 0.4, 1e-5


def model(inductance: bool) -> str:
    joints = "".join(
        f"""
[[joint]]
name = "j{k}"
link = {{ mass = {MASSES[k]}, com = [{CENTRES[k] - length}, 0, 0], inertia = {{ zz = {MOMENTS[k]} }} }}
[joint.drive]
ratio = {RATIOS[k]}
rotors = [{{ name = "motor", inertia = {ROTORS[k]}, fixed_to_joint = true }}]
[joint.drive.motor]
name = "circuit"
at = "motor"
resistance = {RESISTANCE[k]}
inductance = {INDUCTANCE[k] if inductance else 0}
torque_constant = {CONSTANT[k]}
back_emf_constant = {CONSTANT[k]}
"""
        for k, length in enumerate((LENGTH, 0.0))
    )
    return f"""
[robot]
name = "driven"
gravity = [0, -9.81, 0]
[dh]
rows = [["q", 0, {LENGTH}, 0], ["q", 0, 0, 0]]
{joints}"""


def in_mujoco(inductance: bool, step: float) -> str:
    def body(k: int, at: float, inside: str) -> str:
        moment, rotor = f"{MOMENTS[k]} " * 3, RATIOS[k] ** 2 * ROTORS[k]
        return f"""<body pos="{at} 0 0"><joint name="j{k}" type="hinge" axis="0 0 1" armature="{rotor}"/>
        <inertial pos="{CENTRES[k]} 0 0" mass="{MASSES[k]}" diaginertia="{moment}"/>{inside}</body>"""

    motors = "".join(
        f'<dcmotor joint="j{k}" gear="{RATIOS[k]}" motorconst="{CONSTANT[k]}" resistance="{RESISTANCE[k]}"'
        + (f' inductance="{INDUCTANCE[k]}"/>' if inductance else "/>")
        for k in range(2)
    )
    return f"""<mujoco><option timestep="{step}" gravity="0 -9.81 0" integrator="RK4"/>
    <worldbody>{body(0, 0.0, body(1, LENGTH, ""))}</worldbody><actuator>{motors}</actuator></mujoco>"""


def ours(inductance: bool) -> tuple[Machine, HybridTrajectory]:
    machine = Machine(compile_hybrid(robot_from_text(model(inductance), "driven.toml")))
    time = np.linspace(0.0, END, 41)
    return machine, simulate_general(machine, time, [step(9.0), sine(6.0, 4.0)], tolerance=1e-10)


def theirs(inductance: bool, step: float) -> np.ndarray:
    """(41, states): positions, speeds and currents; the voltage is held over a step, as it is in its middle."""
    engine = mujoco.MjModel.from_xml_string(in_mujoco(inductance, step))
    data, rows = mujoco.MjData(engine), []
    count = round(END / step)
    for k in range(count + 1):
        if k % (count // 40) == 0:
            rows.append([*data.qpos, *data.qvel, *data.act])
        data.ctrl[:] = 9.0, 6.0 * np.sin(2 * np.pi * 4.0 * (data.time + 0.5 * step))
        mujoco.mj_step(engine, data)
    return np.array(rows)


@pytest.mark.slow  # compiles a machine of its own by the general way
@pytest.mark.parametrize("inductance", [True, False])
def test_an_arm_with_two_motors_moves_as_in_mujoco(inductance: bool) -> None:
    """MuJoCo's currents go by first order in the step: two steps tell what none would give."""
    machine, found = ours(inductance)
    names = machine.kernel.states
    assert names[:4] == ("j0.q", "j1.q", "j0.qd", "j1.qd")
    coarse, fine = theirs(inductance, STEP), theirs(inductance, STEP / 2)
    largest = np.abs(found.states).max(axis=0)
    assert np.all(largest[:2] > 0.2)
    off = [np.abs(rows - found.states).max(axis=0) / largest for rows in (coarse, fine, 2 * fine - coarse)]
    assert np.all(off[0] < 1e-3)
    if inductance:
        np.testing.assert_allclose(off[1] / off[0], 0.5, atol=0.05)
    assert np.all(off[2] < 1e-6)
