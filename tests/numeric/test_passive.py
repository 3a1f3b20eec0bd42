"""A cart with a pole that nothing drives: forces held from sample to sample, and a coarse encoder on the pole."""

from __future__ import annotations

import math
from dataclasses import replace
from types import MappingProxyType

import numpy as np
import pytest
from numpy.typing import NDArray

from symdyn.compiler import compile_robot, robot_from_text
from symdyn.numeric.conditions import conditions
from symdyn.numeric.diagnose import diagnose
from symdyn.numeric.findings import Verdict
from symdyn.numeric.inquiry import Inquiry
from symdyn.numeric.observation import observe
from symdyn.numeric.recording import Recording
from symdyn.numeric.rounding import ended_at_steps, with_resolutions
from symdyn.numeric.setting import prepare
from symdyn.numeric.workbench import Workbench
from symdyn.spec.records import Quantity, Robot, Side

Array = NDArray[np.float64]

MODEL = """
[robot]
name = "cart-pole"
gravity = [0, 9.81, 0]

[parameters]
m_c = "0.5 kg"
m_p = "0.25 kg"
l = "0.3 m"
J = "0.0065 kg m^2"
b_c = "5 N s/m"

[dh]
rows = [["90 deg", "q", 0, "90 deg"], ["q", 0, 0, 0]]

[[joint]]
name = "cart"
link = { mass = "m_c" }

[[joint]]
name = "pole"
passive = true
link = { mass = "m_p", com = ["l", 0, 0], inertia = { zz = "J" } }

[[effect]]
type = "viscous_friction"
at = "cart"
coefficient = "b_c"
"""
PIVOT = """
[[effect]]
type = "viscous_friction"
at = "pole"
coefficient = "0.002 N m s/rad"
"""

M_C, M_P, L, J, B_C, B_P, G = 0.57, 0.23, 0.33, 0.0079, 4.3, 0.0024, 9.81  # the truth
STEP, FINE, COUNT = 4e-3, 32, 3000
STEPS = {"cart": 2e-5, "pole": 2.0 * math.pi / 4096}  # of the encoders


@pytest.fixture(scope="module")
def robot() -> Robot:
    return robot_from_text(MODEL + PIVOT, "cart-pole.toml")


def record(seed: int, dry: float = 0.0, of_pole: float = B_P, pushed: float = 0.0) -> Recording:
    """A crane that follows a sum of sines; symplectic Euler at 0.125 ms.

    ``dry`` is friction of the cart (N), ``of_pole`` of the pole's pivot (N m s/rad). With ``pushed`` (N/m) it follows
    nothing: that times the sines is the force.
    """
    rng = np.random.default_rng(seed)
    time = STEP * np.arange(COUNT)
    frequencies = rng.uniform(0.15, 2.0, 6)
    sizes = rng.uniform(0.5, 1.0, 6) / frequencies
    wanted = np.sin(2.0 * np.pi * np.outer(time, frequencies) + rng.uniform(0.0, 6.28, 6)) @ (0.2 * sizes / sizes.sum())
    wanted = (wanted - wanted[0]) * np.clip(time / 0.5, 0.0, 1.0)
    quickly = np.gradient(wanted, STEP)
    x = v = q = w = 0.0
    h, shown = STEP / FINE, np.zeros((COUNT, 3))
    for k in range(COUNT):
        force = pushed * wanted[k] or 100.0 * (wanted[k] - x) + 6.0 * (quickly[k] - v)
        shown[k] = force, x, q
        for _ in range(FINE):
            a11, a12, a22 = M_C + M_P, M_P * L * math.cos(q), J + M_P * L**2
            cart = force - B_C * v - dry * math.tanh(v / 5e-3) + M_P * L * math.sin(q) * w**2
            pole = -of_pole * w - M_P * G * L * math.sin(q)
            a = (a22 * cart - a12 * pole) / (a11 * a22 - a12**2)
            e = (a11 * pole - a12 * cart) / (a11 * a22 - a12**2)
            v, w = v + h * a, w + h * e
            x, q = x + h * v, q + h * w
    channels = {(Quantity.EFFORT, "cart", Side.LINK): shown[:, 0]}
    for joint, column in (("cart", 1), ("pole", 2)):
        channels[Quantity.POSITION, joint, Side.LINK] = np.round(shown[:, column] / STEPS[joint]) * STEPS[joint]
    return Recording(f"run {seed}", time, MappingProxyType(channels), STEP, (slice(0, COUNT),), (), "0" * 64)


@pytest.mark.slow
def test_a_force_that_is_held_over_each_sample_is_no_fault(robot: Robot) -> None:
    found = diagnose(robot, record(1), record(2))
    assert found.verdict is Verdict.COMPLETE
    assert not found.findings
    (alarm,) = [alarm for alarm in found.alarms if "held from sample to sample" in alarm]
    assert "early" in alarm
    assert float(alarm.split()[1]) == pytest.approx(0.5 * STEP, rel=0.1)


@pytest.mark.slow
def test_noise_of_a_passive_joint_makes_it_no_lighter(robot: Robot) -> None:
    found = diagnose(robot, record(1, 0.8), record(2, 0.8))
    (finding,) = found.findings
    assert (finding.effect, finding.place) == ("coulomb_friction", "cart")
    assert finding.parameters["level"].value == pytest.approx(0.8, rel=0.05)
    values = {name: estimate.value for name, estimate in found.model.items()}
    assert values["m_p"] * values["l"] == pytest.approx(M_P * L, rel=0.05)


def test_what_an_encoder_does_not_show_is_not_tested_once_it_is_known_what_its_joint_lacks(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Friction of the pivot is most of what is left there at first, and afterwards what kicks of the cart do to it."""
    monkeypatch.setitem(STEPS, "pole", 2.0 * math.pi / 8192)
    runs = [record(seed, 3.0, 0.03, 60.0) for seed in (1, 2)]
    setting = prepare(robot_from_text(MODEL, "cart-pole.toml"), *runs, lambda _: None).below("pole", 8.0)
    case = setting.case(25.0)
    given = case.explain()
    begun = Inquiry(setting, case, given, setting, case, given)
    assert ended_at_steps(begun, begun) is None
    missing = {("coulomb_friction", "cart"), ("viscous_friction", "pole")}
    there = tuple((c, ()) for c in setting.proposed if (c.effect, c.place.address) in missing)
    again = ended_at_steps(begun, replace(begun, current=case.explain(there, given)))
    assert again is not None
    assert (again.setting, again.findings, again.motion) == (setting, (), 25.0)
    assert again.case.bench.edge < 5.0
    assert again.given is again.current
    assert "what is left at pole is quicker than its encoder can tell" in again.alarms[-1]


def test_steps_are_all_that_is_left_where_nothing_drives_and_no_physics(robot: Robot) -> None:
    setting = prepare(robot, record(1), record(2), lambda _: None)
    case = setting.case(10.0)
    given = case.explain()
    told = with_resolutions(Inquiry(setting, case, given, setting, case, given))
    assert told.alarms
    assert told.alarms[0].startswith("the steps of the encoder at pole leave")
    assert not told.findings
    (revised,) = told.case.revised  # the new model has them all the same
    assert revised.values["resolution"].value == pytest.approx(STEPS["pole"])


def test_inertia_of_a_passive_joint_and_its_slopes(robot: Robot) -> None:
    kernel = compile_robot(robot).kernel()
    bench = Workbench(kernel, observe(robot, kernel, record(1)))
    p, names = kernel.values, ("m_p", "l", "J", "m_c")
    assert bench.passive.joints == [1]
    assert bench.passive.inertia(p) == pytest.approx([1.0, 0.0065 + 0.25 * 0.3**2])
    whole = 0.0065 + 0.25 * 0.3**2
    wanted = np.array([[0.0, 0.0, 0.0, 0.0], [0.3**2 / whole, 2 * 0.25 * 0.3 / whole, 1 / whole, 0.0]])
    assert bench.passive.slopes(p, names) == pytest.approx(wanted)


def test_the_load_of_a_joint_that_nothing_drives_is_no_condition(robot: Robot) -> None:
    """What the model predicts there is all that is left, so that it would tell itself."""
    setting = prepare(robot, record(1), record(2), lambda _: None)
    case = setting.case(5.0)
    given = case.explain()
    loads = case.bench.effort - given.training, case.judge.effort - given.heldout
    told = {
        joint: {c.name for c in conditions(case.bench, case.judge, case.joints, j, loads, given.training[:, j])}
        for j, joint in enumerate(case.joints)
    }
    assert ["load" in names for names in told.values()] == [True, False]
