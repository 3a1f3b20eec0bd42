"""The plants of the blind benchmark are right by themselves, and share nothing with symdyn."""

from __future__ import annotations

import ast
import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import integrate, linalg

from benchmarks.blind import axis, chain, geared, laws, two_link
from benchmarks.blind.motions import CONTROL, multisine

FOLDER = Path(laws.__file__).parent
FORCES = st.floats(-5.0, 5.0)
LEVELS = st.floats(0.0, 3.0)


def row(**values: float) -> np.ndarray:
    out = np.zeros(laws.WIDTH)
    for name, value in values.items():
        out[laws.COLUMN[name]] = value
    return out


@pytest.mark.parametrize("path", sorted(FOLDER.glob("*.py")), ids=lambda path: path.stem)
def test_imports_nothing_of_symdyn_but_what_runs_tasks(path: Path) -> None:
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0
            found.add(node.module or "")
    own = {name for name in found if name.partition(".")[0] == "symdyn"}
    assert own == ({"symdyn.numeric.executor"} if path.stem in ("run", "__main__") else set())


def test_the_columns_have_their_names() -> None:
    given_names = {
        "VISCOUS": "viscous",
        "LEVEL_N": "level_negative",
        "RIPPLE_N": "ripple_order",
        "HUM_F": "hum_frequency",
    }
    assert {laws.NAMES[getattr(laws, constant)] for constant in given_names} == set(given_names.values())
    assert len(laws.COLUMN) == laws.WIDTH


@given(st.tuples(FORCES, FORCES), st.tuples(LEVELS, LEVELS), st.tuples(LEVELS, LEVELS), st.floats(-0.9, 0.9))
def test_dry_friction_is_set_valued(
    speeds: tuple[float, float], forwards: tuple[float, float], backwards: tuple[float, float], coupling: float
) -> None:
    """Where something moves friction is at its level against the motion; where it is at rest, anything between."""
    mobility = 0.1 * np.array([[1.0, coupling], [coupling, 2.0]])
    v, up, down, force = np.array(speeds), np.array(forwards), np.array(backwards), np.zeros(2)
    laws.hold(v, mobility, up, down, force)
    np.testing.assert_allclose(v, np.array(speeds) + mobility @ force, atol=1e-9)
    for i in range(2):
        assert -up[i] - 1e-12 <= force[i] <= down[i] + 1e-12
        if v[i] > 1e-6:
            assert force[i] == pytest.approx(-up[i], abs=1e-9)
        elif v[i] < -1e-6:
            assert force[i] == pytest.approx(down[i], abs=1e-9)


@pytest.mark.parametrize(
    ("values", "energy"),
    [
        ({"spring": 2.0, "spring_rest": 0.3}, lambda x: (x - 0.3) ** 2),
        ({"cubic": 2.0}, lambda x: 0.5 * x**4),
        (
            {"ripple_cosine": 0.4, "ripple_sine": 0.7, "ripple_order": 5.0},
            lambda x: (0.7 * math.cos(5 * x) - 0.4 * math.sin(5 * x)) / 5,
        ),
        ({"unbalance_moment": 1.3, "unbalance_phase": 0.4}, lambda x: -1.3 * math.cos(0.4 - x)),
        (
            {
                "balance_stiffness": 30.0, "balance_anchor": 0.3, "balance_arm": 0.15, "balance_free": 0.12,
                "balance_centre": 1.2,
            },
            lambda x: 15.0 * (math.dist((0.3, 0.0), (0.15 * math.cos(1.2 - x), 0.15 * math.sin(1.2 - x))) - 0.12) ** 2,
        ),
    ],
    ids=lambda value: next(iter(value)) if isinstance(value, dict) else "",
)  # fmt: skip
def test_forces_that_store_energy_follow_from_it(values: dict[str, float], energy: Callable[[float], float]) -> None:
    p, h = row(**values), 1e-6
    for x in np.linspace(-1.5, 1.5, 7):
        force = laws.smooth_force(p, x, 0.7, 0.0, np.zeros(laws.STATES))
        assert force == pytest.approx((energy(x - h) - energy(x + h)) / (2 * h), rel=1e-6, abs=1e-8)


@given(st.floats(-2.0, 2.0), st.floats(1e-4, 0.1))
@settings(max_examples=30)
def test_bristles_move_as_their_equation_says(v: float, duration: float) -> None:
    """Dahl's bristle in many small steps of the midpoint rule, and in one of ours."""
    p, z = row(dahl_stiffness=40.0, dahl_level=0.5), np.zeros(laws.STATES)
    z[1] = 0.004
    out, expected, steps = np.zeros(laws.STATES), 0.004, 2000
    laws.advance_states(p, v, z, duration, out)
    for _ in range(steps):
        middle = expected + 0.5 * duration / steps * (v - 80.0 * abs(v) * expected)
        expected += duration / steps * (v - 80.0 * abs(v) * middle)
    assert out[1] == pytest.approx(expected, rel=1e-5, abs=1e-9)


@given(st.floats(1.0, 60.0), st.floats(0.0, 0.5), st.floats(-2.0, 2.0))
@settings(max_examples=30)
def test_an_elastic_load_moves_as_the_exponential_of_its_matrix(w: float, zeta: float, v: float) -> None:
    """In 2000 steps of 25 us; and what it takes up comes out of the force on its place."""
    p, z, out = row(load_inertia=0.3, load_frequency=w, load_damping=zeta), np.zeros(laws.STATES), np.zeros(laws.STATES)
    z[4:] = 0.01, -0.3
    matrix = np.array([[0.0, -1.0, v], [w * w, -2.0 * zeta * w, 2.0 * zeta * w * v], [0.0, 0.0, 0.0]])
    expected = linalg.expm(0.05 * matrix) @ np.array([0.01, -0.3, 1.0])
    pushed, h = 0.0, 25e-6
    for _ in range(2000):
        before = laws.smooth_force(p, 0.0, v, 0.0, z)
        laws.advance_states(p, v, z, h, out)
        z[:] = out
        pushed += 0.5 * h * (before + laws.smooth_force(p, 0.0, v, 0.0, z))
    np.testing.assert_allclose(z[4:], expected[:2], rtol=1e-5, atol=1e-6)
    assert pushed == pytest.approx(-0.3 * (z[5] + 0.3), rel=1e-4, abs=1e-6)


BODY = np.array([1.08, 0.864, 0.25, 0.2, 0.022644, 0.0116352])


def arm_energy(q: np.ndarray, v: np.ndarray) -> float:
    """Of two bars in the plane, from the speeds of their centres."""
    m1, m2, r1, r2, i1, i2 = BODY
    ends = np.array([math.cos(q[0]), math.sin(q[0])]), np.array([math.cos(q.sum()), math.sin(q.sum())])
    turned = [np.array([-e[1], e[0]]) for e in ends]
    one, two = r1 * turned[0] * v[0], two_link.L1 * turned[0] * v[0] + r2 * turned[1] * v.sum()
    kinetic = 0.5 * (m1 * one @ one + i1 * v[0] ** 2 + m2 * two @ two + i2 * v.sum() ** 2)
    return kinetic + 9.81 * (m1 * r1 * ends[0][1] + m2 * (two_link.L1 * ends[0][1] + r2 * ends[1][1]))


@given(st.tuples(FORCES, FORCES), st.tuples(FORCES, FORCES))
@settings(max_examples=30)
def test_the_arm_keeps_its_energy(q: tuple[float, float], v: tuple[float, float]) -> None:
    """Without torque, friction and effects the energy of the exact motion does not change."""
    state, p, h = np.array([*q, *v]), np.zeros((2, laws.WIDTH)), 1e-5
    force, mobility = np.zeros(2), np.zeros((2, 2))
    two_link._force(BODY, 9.81, p, state[:2], state[2:], 0.0, np.zeros((2, laws.STATES)), np.zeros(2), force)
    two_link._mobility(BODY, p, state[:2], 1.0, mobility)
    rate = np.concatenate([state[2:], mobility @ force])
    ahead, behind = state + h * rate, state - h * rate
    slope = (arm_energy(ahead[:2], ahead[2:]) - arm_energy(behind[:2], behind[2:])) / (2 * h)
    assert slope == pytest.approx(0.0, abs=1e-4 * (1.0 + np.abs(rate).max() ** 2))


def test_a_finer_step_of_the_arm_records_the_same() -> None:
    p = np.zeros((2, laws.WIDTH))
    p[0] = row(viscous=0.3, level_positive=0.4, level_negative=0.6, excess=0.3, stribeck_speed=0.15)
    p[1] = row(viscous=0.1, lugre_stiffness=8.0, lugre_damping=0.01, lugre_level=0.2, lugre_excess=0.1, lugre_speed=0.2)
    time = CONTROL * np.arange(1500)
    angles = np.column_stack([-0.8 + 0.5 * np.sin(4 * time), 0.3 + 0.6 * np.sin(6 * time)])
    speeds = np.column_stack([2.0 * np.cos(4 * time), 3.6 * np.cos(6 * time)])
    limit, noise = np.full(2, np.inf), np.zeros((1500, 2))
    coarse, fine = (
        two_link.simulate(BODY, p, limit, 9.81, angles, speeds, noise, steps)
        for steps in (two_link.STEPS, 4 * two_link.STEPS)
    )
    assert np.abs(coarse[0] - fine[0]).max() < 5e-6  # rad: below the finest encoder's step
    assert np.sqrt(np.mean((coarse[1] - fine[1]) ** 2, axis=0)).max() < 2e-3  # N m: far below any sensor's noise


def test_the_linear_drive_moves_as_its_matrix_says() -> None:
    """Without friction the chain is linear: its exact propagation under the voltages that were recorded."""
    inertia, springs = (
        np.array([34e-6, 41e-6, 196e-6, 372e-6]),
        np.array([[789.0, 1.2e-3], [1225.0, 0.068], [1.44, 1.6e-3]]),
    )
    resistance, inductance, constant = 1.6, 87e-6, 0.088
    time = CONTROL * np.arange(400)
    amplifier = np.zeros(len(chain.AMPLIFIER))
    amplifier[chain.LIMIT] = chain.SUPPLY
    motor = np.array([resistance, inductance, constant, constant])
    u, current, angle, tacho, load = chain.simulate(
        inertia, springs, np.zeros(len(chain.SHAFT)), amplifier, motor, np.zeros((4, laws.WIDTH)), 1, 0,
        np.sin(20 * time), 20 * np.cos(20 * time), np.zeros(400), np.zeros(400), 1, 50,
    )  # fmt: skip
    a, b = np.zeros((9, 9)), np.zeros((9, 1))
    a[:4, 4:8] = np.eye(4)
    for i, (c, d) in enumerate(springs):
        for sign, at in ((1.0, i), (-1.0, i + 1)):
            a[4 + at, [i, i + 1]] += sign / inertia[at] * np.array([-c, c])
            a[4 + at, [4 + i, 5 + i]] += sign / inertia[at] * np.array([-d, d])
    a[5, 8] = constant / inertia[1]
    a[8, 8], a[8, 5], b[8, 0] = -resistance / inductance, -constant / inductance, 1 / inductance
    whole = linalg.expm(CONTROL * np.block([[a, b], [np.zeros((1, 10))]]))
    state = np.concatenate([np.zeros(4), np.full(4, 20.0), [0.0]])
    expected = np.empty((400, 9))
    for k in range(400):
        expected[k] = state
        state = whole[:9, :9] @ state + whole[:9, 9] * u[k]
    for got, want in ((current, 8), (angle, 1), (tacho, 4), (load, 3)):
        scale = np.abs(expected[:, want]).max()
        assert np.abs(got - expected[:, want]).max() < 2e-3 * scale


def test_the_six_joint_arm_weighs_what_its_table_says() -> None:
    """MuJoCo's gravity torques, and the slope of the potential energy from the DH table."""
    mujoco = pytest.importorskip("mujoco", reason="the plant of the six-joint arm is MuJoCo's; install symdyn[blind]")
    from benchmarks.blind import six_joint

    true = {name: value for name, (value, _) in six_joint.SixJoint.truth.items()}
    model = mujoco.MjModel.from_xml_string(six_joint.mjcf(true, np.zeros(6)))
    data = mujoco.MjData(model)

    def energy(q: np.ndarray) -> float:
        frame, total = np.eye(4), 0.0
        for i, (d, a, alpha) in enumerate(six_joint.DH):
            c, s, ca, sa = math.cos(q[i]), math.sin(q[i]), math.cos(alpha), math.sin(alpha)
            frame = frame @ np.array(
                [[c, -s * ca, s * sa, a * c], [s, c * ca, -c * sa, a * s], [0.0, sa, ca, d], [0.0, 0.0, 0.0, 1.0]]
            )
            total += 9.81 * six_joint.MASS[i] * (frame @ np.array([*six_joint.COM[i], 1.0]))[2]
        return total

    for seed in range(5):
        q, h = np.random.default_rng(seed).uniform(-2.0, 2.0, 6), 1e-6
        data.qpos[:], data.qvel[:] = q, 0.0
        mujoco.mj_forward(model, data)
        slope = [(energy(q + h * e) - energy(q - h * e)) / (2 * h) for e in np.eye(6)]
        np.testing.assert_allclose(data.qfrc_bias, slope, atol=1e-5)


def test_the_six_joint_arm_is_that_of_finer_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    """What an elastic load does to joint 4, whose states and positions must be of the same instants."""
    pytest.importorskip("mujoco", reason="the plant of the six-joint arm is MuJoCo's; install symdyn[blind]")
    from benchmarks.blind import six_joint

    true = {name: value for name, (value, _) in six_joint.SixJoint.truth.items()}
    own = [
        row(viscous=v, level_positive=f, level_negative=f)
        for v, f in zip(six_joint.VISCOUS, six_joint.DRY, strict=True)
    ]
    own[3] += row(load_inertia=0.25, load_frequency=12.0, load_damping=0.1)
    rng, free = np.random.default_rng(1), np.full(6, math.inf)
    x, v = multisine(rng, 1, 3.0, six_joint.CENTRE, six_joint.REACH)
    usual = six_joint._simulate(true, np.stack(own), free, x, v, np.zeros_like(x))
    monkeypatch.setattr(six_joint, "STEPS", 32)
    finer = six_joint._simulate(true, np.stack(own), free, x, v, np.zeros_like(x))
    off = [(a - b)[:, 3] for a, b in zip(usual, finer, strict=True)]
    assert np.std(off[0]) < 5e-5
    assert np.std(off[1]) < 1.5e-3 * np.std(finer[1][:, 3])


def test_the_axis_obeys_its_equation() -> None:
    """Mass, drag and dry friction make up the recorded force wherever the carriage does not turn round."""
    time = CONTROL * np.arange(2000)
    x, v = 0.3 * np.sin(4.0 * time), 1.2 * np.cos(4.0 * time)
    p = row(viscous=30.0, level_positive=8.0, level_negative=6.0)[None]
    shown, force = axis.simulate(50.0, p, np.inf, x, v, np.zeros(len(time)), 40)
    speed = (shown[2:] - shown[:-2]) / (2.0 * CONTROL)
    needed = 50.0 * np.diff(shown, 2) / CONTROL**2 + 30.0 * speed + np.where(speed > 0, 8.0, -6.0)
    moving = np.abs(speed) > 0.05
    np.testing.assert_allclose(force[1:-1][moving], needed[moving], atol=0.05)


def test_the_geared_arm_moves_as_its_equations_say() -> None:
    """Against an integration of the same torques with error control: weight, gear, play and friction of the speed."""
    n, count = geared.RATIO, 400
    true = {name: value for name, (value, _) in geared.TRUTH.items()}
    shaft = np.zeros(len(chain.SHAFT))
    shaft[chain.CUBIC], shaft[chain.CLEARANCE] = 0.5, 0.05
    p = np.stack([row(viscous=true["b"]), row(quadratic=0.4)])
    time = CONTROL * np.arange(count)
    reference, speeds = -0.4 + 0.5 * np.sin(4.0 * time), 2.0 * np.cos(4.0 * time)
    zero = np.zeros(count)
    torque, angle, output = geared.simulate(
        np.array(list(true.values())), shaft, p, reference, speeds, zero, zero, stride=1
    )

    def rate(_: float, x: np.ndarray, applied: float) -> list[float]:
        motor, arm, w, v = x
        twist = motor - n * arm
        touching = abs(twist) > shaft[chain.CLEARANCE]
        bent = twist - math.copysign(shaft[chain.CLEARANCE], twist) if touching else 0.0
        through = true["c"] * bent + true["d"] * (w - n * v) + 0.5 * bent**3 if touching else 0.0
        weight = true["m"] * 9.81 * true["a"]
        return [
            w,
            v,
            (applied - through - true["b"] * w) / true["J_m"],
            (n * through - weight * math.cos(arm) - 0.4 * v * abs(v)) / (true["J_a"] + true["m"] * true["a"] ** 2),
        ]

    x = np.array([angle[0], output[0], n * speeds[0], speeds[0]])
    for k in range(count - 1):
        done = integrate.solve_ivp(rate, (0.0, CONTROL), x, args=(torque[k],), rtol=1e-10, atol=1e-12)
        x = done.y[:, -1]
        assert x[:2] == pytest.approx([angle[k + 1], output[k + 1]], abs=2e-5)
    assert np.ptp(angle) > 5.0
