"""An axis taken for rigid, of which part is behind a spring: told from the motor's torque and angle alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import linalg, signal

from symdyn.compiler import parametric_kernel, robot_from_text
from symdyn.numeric.diagnose import diagnose
from symdyn.numeric.encoder_steps import coarse
from symdyn.numeric.findings import Verdict
from symdyn.numeric.forward import first_that_earns
from symdyn.numeric.inquiry import Inquiry
from symdyn.numeric.memory import remembered
from symdyn.numeric.recording import Recording
from symdyn.numeric.search import Search
from symdyn.numeric.setting import prepare
from symdyn.numeric.swinging import started, swings
from symdyn.spec.records import Quantity, Robot, Side

from .pendulum import recording

Array = NDArray[np.float64]

POSITION = Quantity.POSITION, "arm", Side.LINK
RATE, DURATION = 500.0, 12.0
MOTOR, LOAD, DRAG = 0.02, 0.03, 0.05  # kg m^2, kg m^2, N m s/rad
FREQUENCY, DAMPING = 2.0 * np.pi * 9.0, 0.03  # of the load while the motor is held
GAINS = 12.0, 0.8  # of the servo, N m/rad and N m s/rad
TOML = """[robot]
name = "axis"
gravity = [0, 0, "-9.81 m/s^2"]

[dh]
rows = [ ["q", 0, 0, 0] ]

[[joint]]
name = "arm"
link = { mass = "1 kg", com = [0, 0, 0], inertia = { zz = "0.04 kg m^2" } }

[[effect]]
type = "viscous_friction"
at = "arm"
coefficient = "0.06 N m s/rad"
"""
EFFECT = """
[[effect]]
type = "elastic_load"
at = "arm"
inertia = "0.03 kg m^2"
frequency = "56.5487 rad/s"
damping_ratio = 0.03
"""


def axis(more: str = "") -> Robot:
    return robot_from_text(TOML + more, "axis.toml")


def measured(seed: int, elastic: bool) -> Recording:
    """Two bodies, or one, under a servo whose torque is held over each sample: exact from sample to sample."""
    rng = np.random.default_rng(seed)
    stiffness, damper = LOAD * FREQUENCY**2, 2.0 * DAMPING * FREQUENCY * LOAD
    a, b = np.zeros((4, 4)), np.zeros((4, 1))  # q, its speed; the load's
    a[0, 1] = a[2, 3] = 1.0
    if elastic:
        a[1] = np.array([-stiffness, -DRAG - damper, stiffness, damper]) / MOTOR
        a[3] = np.array([stiffness, damper, -stiffness, -damper]) / LOAD
        b[1] = 1.0 / MOTOR
    else:
        a[1, 1], b[1] = -DRAG / (MOTOR + LOAD), 1.0 / (MOTOR + LOAD)
    step = linalg.expm(np.block([[a, b], [np.zeros((1, 5))]]) / RATE)
    time = np.arange(int(RATE * DURATION)) / RATE
    frequency = 0.1 * np.arange(1, 120)
    size = 0.3 / (1.0 + (frequency / 1.5) ** 2) * rng.uniform(0.5, 1.5, len(frequency))
    turns = 2.0 * np.pi * np.outer(time, frequency) + rng.uniform(0.0, 2.0 * np.pi, len(frequency))
    wanted, speed = np.sin(turns) @ size, np.cos(turns) @ (2.0 * np.pi * frequency * size)
    q, tau, state = np.empty(len(time)), np.empty(len(time)), np.array([wanted[0], speed[0], wanted[0], speed[0]])
    for k in range(len(time)):
        q[k] = state[0]
        tau[k] = GAINS[0] * (wanted[k] - state[0]) + GAINS[1] * (speed[k] - state[1])
        state = step[:4, :4] @ state + step[:4, 4] * tau[k]
    return recording(time, q + rng.normal(0.0, 2e-5, len(q)), tau + rng.normal(0.0, 2e-2, len(q)), f"run {seed}")


def in_steps(shown: Recording, step: float) -> Recording:
    return replace(shown, channels={**shown.channels, POSITION: np.round(shown.channels[POSITION] / step) * step})


def test_driven_along_a_motion_it_is_the_linear_system_that_it_is() -> None:
    kernel, time = parametric_kernel(axis(EFFECT)), np.arange(4000) / RATE
    rng = np.random.default_rng(1)
    v = signal.sosfiltfilt(signal.butter(4, 20.0, fs=RATE, output="sos"), rng.normal(size=len(time)))
    system = signal.StateSpace(
        [[0.0, -1.0], [FREQUENCY**2, -2.0 * DAMPING * FREQUENCY]],
        [[1.0], [2.0 * DAMPING * FREQUENCY]],
        [[-LOAD * FREQUENCY**2, 2.0 * LOAD * DAMPING * FREQUENCY]],
        [[-2.0 * LOAD * DAMPING * FREQUENCY]],
    )
    _, wanted, _ = signal.lsim(system, v, time, X0=[0.0, v[0]])
    q = np.cumsum(v) / RATE
    found = remembered(kernel, q[:, None], v[:, None], time, (slice(0, len(time)),), kernel.values)[:, 0]
    np.testing.assert_allclose(found, wanted, atol=1e-5 * np.ptp(wanted))


def test_what_it_does_because_of_its_beginning_dies_away_at_its_own_rate() -> None:
    kernel, time = parametric_kernel(axis(EFFECT)), np.arange(1000) / RATE
    assert swings(kernel, kernel.values)
    assert not swings(parametric_kernel(axis()), np.zeros(0))
    forces = started(kernel, time, (slice(0, 400), slice(400, 1000)), kernel.values)[:, 0]
    assert forces.shape == (1000, 4)
    assert not forces[400:, :2].any()
    assert not forces[:400, 2:].any()
    swing = FREQUENCY * np.sqrt(1.0 - DAMPING**2)
    decay = np.exp(-DAMPING * FREQUENCY * time[:600])
    for column in forces[400:, 2:].T:  # both are sums of one decaying sine and cosine
        waves = np.stack([decay * np.sin(swing * time[:600]), decay * np.cos(swing * time[:600])], axis=1)
        left = column - waves @ np.linalg.lstsq(waves, column, rcond=None)[0]
        assert np.abs(left).max() < 1e-5 * np.abs(column).max()


@pytest.mark.slow
def test_a_rigid_axis_recorded_almost_without_noise_lacks_nothing() -> None:
    found = diagnose(axis(), measured(1, elastic=False), measured(2, elastic=False))
    assert found.verdict is Verdict.COMPLETE
    assert not found.findings
    assert found.model["arm_inertia_zz"].value == pytest.approx(MOTOR + LOAD, rel=2e-3)


@pytest.mark.parametrize("elastic", [False, True])
def test_what_makes_up_for_a_filter_of_the_motion_is_no_load(elastic: bool) -> None:
    """The motion is taken below where it sinks into steps, which is the band's edge: near it accelerations lack what
    the efforts have.
    """
    runs = [in_steps(measured(seed, elastic), 3e-3) for seed in (3, 4)]
    steps = coarse(runs[1], POSITION)
    assert steps is not None
    setting = prepare(axis(), *runs, lambda _: None).below("arm", steps.motion)
    case = setting.case(steps.motion)
    given = case.explain()
    inquiry = Inquiry(setting, case, given, setting, case, given)
    (load,) = (c for c in setting.proposed if c.effect == "elastic_load")
    trial = Search(case.laws, given.fit.p, given.training, given.design, given.weight).trial(load)
    assert trial.p_value < 1e-6  # the training data alone take either for one
    assert (first_that_earns(inquiry, [trial])[0] is not None) is elastic


@pytest.mark.slow
def test_an_elastic_load_is_told_with_its_inertia_and_frequency() -> None:
    runs = measured(1, elastic=True), measured(2, elastic=True)
    found = diagnose(axis(), *runs)
    assert found.verdict is Verdict.MISSING_PHYSICS
    (finding,) = found.findings
    values = {name: e.value for name, e in finding.parameters.items()}
    assert finding.effect == "elastic_load"
    assert values["inertia"] == pytest.approx(LOAD, rel=5e-3)
    assert values["frequency"] == pytest.approx(FREQUENCY, rel=2e-3)
    assert values["damping_ratio"] == pytest.approx(DAMPING, rel=0.02)
    assert found.model["arm_inertia_zz"].value == pytest.approx(MOTOR, rel=0.01)
    assert found.after.heldout < 1.5 * found.noise_floor.errors.heldout < 0.1 * found.before.heldout
    again = diagnose(found.diagnosed, *runs)  # what was written is the machine
    assert again.verdict is Verdict.COMPLETE
    assert not again.findings
