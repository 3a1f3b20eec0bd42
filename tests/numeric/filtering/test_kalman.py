"""The compiled filter against a filter written by hand, and its sensitivities against differences."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import linalg

from symdyn.compiler import compile_robot, load_robot, robot_from_text
from symdyn.derive.coordinates import coordinates
from symdyn.emit.kernel import Kernel
from symdyn.numeric.filtering.beliefs import Belief, penalty
from symdyn.numeric.filtering.bench import DEAF, FilterBench, Noise
from symdyn.numeric.filtering.between import Between
from symdyn.numeric.filtering.late import the_other_way
from symdyn.numeric.filtering.measure import SURPRISE
from symdyn.numeric.filtering.noise_step import noise_step
from symdyn.numeric.filtering.scale import as_believed, of_force
from symdyn.numeric.filtering.signals import Signals

Array = NDArray[np.float64]

STEP, COUNT = 1e-3, 300
DUFFING = """
[robot]
name = "spring"
gravity = [0, 0, 0]

[parameters]
J = "0.1 kg m^2"
k = "4 N m/rad"
c = "40 N m/rad^3"

[dh]
rows = [ [ "q", 0, 0, 0 ] ]

[[joint]]
name = "axis"
link = { inertia = { about = "joint", zz = "J" } }

[[effect]]
type = "linear_spring"
at = "axis"
stiffness = "k"

[[effect]]
type = "hardening_spring"
at = "axis"
stiffness = "c"
"""


@pytest.fixture(scope="module")
def kernel() -> Kernel:
    """The drive of the 1986 paper, without its Coulomb friction: linear."""
    robot = load_robot("irb6-axis1")
    return compile_robot(robot, {c.address: 0.05 for c in coordinates(robot)}).kernel()


def made(kernel: Kernel, seed: int = 0) -> Signals:
    """Something like a recording of current, motor angle and tachometer."""
    rng = np.random.default_rng(seed)
    time = np.arange(COUNT) * STEP
    u = (3.0 * np.sin(20.0 * time) + rng.normal(0.0, 0.3, COUNT))[:, None]
    y = np.column_stack([np.sin(20.0 * time), 0.1 * time, 0.2 * np.cos(9.0 * time)])
    y += rng.normal(
        0.0, [0.05, 0.0005, 0.05], (COUNT, 3)
    )  # positions that begin with a leap would be taken for a speed
    states = list(kernel.states)
    index = np.array([states.index("axis1.motor.current"), states.index("axis1.motor.q"), len(states)])
    steps = np.append(np.full(COUNT - 1, STEP), np.nan)
    names = ("axis1.motor.current", "axis1.motor.q", "axis1.tachometer.voltage")
    size = len(kernel.coordinates)
    return Signals(time, u, y, index, names, steps, np.zeros(3), np.ones(size), np.full(size, 50.0))


def linear(kernel: Kernel) -> Array:
    p = kernel.values
    p[kernel.parameters.index("T_f")] = 0.0
    return p


def noise(kernel: Kernel, forces: int) -> Noise:
    """Of the sensors, and an unknown torque on the motor that the model's own Coulomb friction stands for here."""
    directions = np.zeros((len(kernel.parameters), forces))
    if forces:
        directions[kernel.parameters.index("K_T"), 0] = 1.0
    decay, power, most = (np.full(forces, value) for value in (30.0, 1e-4, np.inf))
    return Noise(np.array([1e-3, 1e-5, 1e-4]), directions, decay, power, most)


def by_hand(kernel: Kernel, bench: FilterBench, p: Array) -> tuple[float, Array]:
    """(-log L, innovations) of the same linear machine by textbook formulas and SciPy's exponential.

    What surprises counts as Huber (1964) has it: in proportion to its size.
    """
    s, n = bench.signals, len(kernel.states)
    anywhere = np.arange(1.0, n + 1.0), np.zeros(1)  # but at a twist of zero, where a closed gap switches
    a, b = (getattr(kernel, f"state_derivative_{of}_jacobian_p")(*anywhere, p) for of in ("state", "input"))
    wide = np.zeros((n + 2, n + 2))  # state, input, slope of the input
    wide[:n, :n], wide[:n, n : n + 1], wide[n, n + 1] = a, b, 1.0
    phi = linalg.expm(wide * STEP)
    c = np.zeros((3, n))
    c[0, s.index[0]] = c[1, s.index[1]] = 1.0
    c[2] = kernel.output_state_jacobian_p(*anywhere, p)
    x, cov = bench._start.copy(), bench._spread.copy()
    loss, found = 0.0, np.zeros_like(s.y)
    for k in range(COUNT):
        for row in range(3):
            e = s.y[k, row] - c[row] @ x
            variance = c[row] @ cov @ c[row] + bench.noise.r[row]
            gain = cov @ c[row] / variance
            found[k, row] = e
            told = variance * max(1.0, abs(e) / (SURPRISE * np.sqrt(variance)))
            loss += 0.5 * (e**2 / told + np.log(told))
            x = x + gain * e
            cov = cov - np.outer(gain, gain) * variance
        if k + 1 < COUNT:
            slope = (s.u[k + 1, 0] - s.u[k, 0]) / STEP
            x = phi[:n] @ np.concatenate([x, [s.u[k, 0], slope]])
            cov = phi[:n, :n] @ cov @ phi[:n, :n].T
    return loss, found


def test_innovations_and_likelihood_are_those_of_a_textbook_filter(kernel: Kernel) -> None:
    p, bench = linear(kernel), FilterBench(kernel, made(kernel), noise(kernel, 0))
    done = bench.filtered(p)
    loss, found = by_hand(kernel, bench, p)
    # of innovations near 1; the start is known a million times worse than the sensors see, which rounds
    np.testing.assert_allclose(done.innovations, found, atol=5e-5)
    assert done.loss == pytest.approx(loss, rel=1e-4)


def test_sensitivities_of_a_simulation_are_its_differences(kernel: Kernel) -> None:
    """A filter that does not listen is a simulation: what the sensitivities leave out, changing gains, is zero."""
    deaf = Noise(np.full(3, DEAF), *(lambda x: (x.directions, x.decay, x.power, x.most))(noise(kernel, 0)))
    bench, p = FilterBench(kernel, made(kernel), deaf), linear(kernel)
    names = ("R", "K_E", "J_4", "c_3", "d_6", "K_Et")
    slopes = bench.filtered(p, names).slopes
    for i, name in enumerate(names):
        moved, size = [p.copy(), p.copy()], 1e-5 * p[bench.index[name]]
        moved[0][bench.index[name]] += size
        moved[1][bench.index[name]] -= size
        quotient = (bench.filtered(moved[0]).innovations - bench.filtered(moved[1]).innovations) / (2.0 * size)
        scale = np.abs(quotient).max(axis=0)
        # noise of the voltage moves the current within a step, eighteen times quicker than samples come
        np.testing.assert_allclose(slopes[:, :, i] / scale.max(), quotient / scale.max(), atol=5e-4)


def test_sensitivities_of_a_machine_that_bends_are_its_differences() -> None:
    """A spring that stiffens tenfold in a swing of forty samples: the Jacobian at a step's start is not that of the
    step. Stiffnesses whose slopes are a few per cent off are told apart where nothing tells them apart."""
    spring = compile_robot(robot_from_text(DUFFING, "spring.toml")).kernel()
    count, step = 400, 5e-3
    time = step * np.arange(count)
    u, steps = 4.0 * np.sin(5.0 * time)[:, None], np.append(np.full(count - 1, step), np.nan)
    s = Signals(
        time, u, np.full((count, 1), 0.3), np.array([0]), ("axis.q",), steps, np.zeros(1), np.ones(1), np.ones(1)
    )
    deaf = Noise(np.array([DEAF]), np.zeros((len(spring.parameters), 0)), *np.zeros((3, 0)))
    bench, p = FilterBench(spring, s, deaf, between=Between.HELD), spring.values
    slopes = bench.filtered(p, ("J", "k", "c")).slopes[:, 0]
    for i, name in enumerate(("J", "k", "c")):
        runs = []
        for size in (-1e-5, 1e-5):
            moved = p.copy()
            moved[bench.index[name]] *= 1.0 + size
            runs.append(bench.filtered(moved).innovations[:, 0])
        quotient = (runs[1] - runs[0]) / (2e-5 * p[bench.index[name]])
        off = np.sqrt(np.mean((slopes[:, i] - quotient) ** 2) / np.mean(quotient**2))
        assert off < 0.005


def test_steps_across_a_kink_are_those_of_many_short_ones(kernel: Kernel) -> None:
    """Coulomb friction turns within 0.05 rad/s, which the motor crosses in a part of a step."""
    deaf, s = replace(noise(kernel, 0), r=np.full(3, DEAF)), made(kernel)
    p, start, rows = kernel.values, np.zeros(len(kernel.states)), (0, COUNT)
    once, often = (FilterBench(kernel, s, deaf, substeps=substeps).simulated(p, start, *rows) for substeps in (1, 64))
    without = FilterBench(kernel, s, deaf).simulated(linear(kernel), start, *rows)
    friction = np.abs(without - often).max(axis=0)
    assert np.all(np.abs(once - often).max(axis=0) < 1e-4 * friction)


def test_a_kink_widens_what_comes_after_it_however_many_parts_a_step_has(kernel: Kernel) -> None:
    """Only the part with the kink in it does. In every part, all variances would be 0.5 % larger; of one sample, at the
    start, they are off by up to 4 % however that is cut."""
    s, quiet, p = made(kernel), noise(kernel, 0), kernel.values
    shown = FilterBench(kernel, s, quiet).simulated(p, np.zeros(len(kernel.states)), 0, COUNT)
    s = replace(s, y=shown)  # nothing surprises
    once, often = (FilterBench(kernel, s, quiet, substeps=parts).filtered(p) for parts in (1, 16))
    off = np.abs(once.variances / often.variances - 1.0)
    assert off.mean() < 1e-3
    assert off.max() < 0.05


def test_the_size_of_all_forces_is_that_believed_and_moves_nothing(kernel: Kernel) -> None:
    """Voltage in, motion out: forces and masses may all be larger by one factor, unknown forces along with them."""
    p = kernel.values
    names = tuple(
        name
        for name, unit in zip(kernel.parameters, kernel.parameter_units, strict=True)
        if of_force(unit) and p[kernel.parameters.index(name)] > 0.0
    )
    noisy = noise(kernel, 1)
    noisy.directions[:] = 0.0
    noisy.directions[kernel.parameters.index("T_f"), 0] = 1.0
    bench = FilterBench(kernel, made(kernel), noisy)
    where = [bench.index[name] for name in names]
    beliefs = {name: Belief(positive=True, centre=float(np.log(p[bench.index[name]])), spread=0.4) for name in names}
    heavy = p.copy()
    heavy[where] *= 2.0
    larger = bench.with_noise(replace(noisy, power=4.0 * noisy.power))
    loss = larger.filtered(heavy).loss
    # the start, known a million times worse than the sensors see, rounds; a force not scaled along moves it by 0.008
    assert loss == pytest.approx(bench.filtered(p).loss, rel=1e-7)
    scaled, found, lower = as_believed(larger, heavy, loss + penalty(heavy, bench.index, beliefs), beliefs)
    np.testing.assert_allclose(found, p, rtol=1e-12)
    assert scaled.noise.power == pytest.approx(noisy.power)
    assert lower == pytest.approx(loss, rel=1e-7)
    del beliefs[names[0]]  # one that is known tells the size of all
    assert as_believed(larger, heavy, loss, beliefs)[1] is heavy


def test_a_gap_starts_anew_and_a_missing_sample_is_left_out(kernel: Kernel) -> None:
    s = made(kernel)
    s.steps[149] = np.nan
    s.y[50, 1] = np.nan
    done = FilterBench(kernel, s, noise(kernel, 0)).filtered(linear(kernel))
    assert done.innovations[50, 1] == 0.0
    assert done.variances[50, 1] == 1.0
    assert np.all(np.isfinite(done.states))
    assert done.variances[150, 0] == pytest.approx(done.variances[0, 0])


def test_an_unknown_force_widens_the_innovations(kernel: Kernel) -> None:
    s, p, loud = made(kernel), linear(kernel), np.full(3, 1e2)  # nothing surprises
    quiet = FilterBench(kernel, s, replace(noise(kernel, 0), r=loud)).filtered(p)
    driven = FilterBench(kernel, s, replace(noise(kernel, 1), r=loud)).filtered(p)
    assert np.all(driven.variances[10:] >= quiet.variances[10:] * (1 - 1e-9))
    assert driven.states.shape[1] == quiet.states.shape[1] + 1


@pytest.mark.parametrize("between", [Between.HELD, Between.STRAIGHT])
def test_an_input_that_is_late_by_whole_samples_is_the_shifted_recording(kernel: Kernel, between: Between) -> None:
    s, late = made(kernel), 3
    shifted = replace(s, u=np.vstack([np.repeat(s.u[:1], late, axis=0), s.u[:-late]]))
    plain = FilterBench(kernel, shifted, noise(kernel, 0), between).filtered(linear(kernel))
    bench = FilterBench(kernel, s, noise(kernel, 0), between, delays=("late",))
    done = bench.filtered(np.append(linear(kernel), late * STEP))
    np.testing.assert_allclose(done.innovations, plain.innovations, rtol=1e-9, atol=1e-12)


def test_a_held_input_that_is_late_by_a_part_of_a_sample_jumps_there(kernel: Kernel) -> None:
    """Against samples four times as close, a quarter of them measured."""
    s = made(kernel)
    y = np.full((4 * COUNT, 3), np.nan)
    y[::4] = s.y
    u = np.repeat(s.u, 4, axis=0)
    steps = np.append(np.full(4 * COUNT - 1, STEP / 4), np.nan)
    fine = replace(s, time=np.arange(4 * COUNT) * STEP / 4, u=np.vstack([np.repeat(u[:1], 5, axis=0), u[:-5]]), y=y)
    plain = FilterBench(kernel, replace(fine, steps=steps), noise(kernel, 0), Between.HELD)
    bench = FilterBench(kernel, s, noise(kernel, 0), Between.HELD, delays=("late",))
    bench._start[:], bench._spread[:] = plain._start, plain._spread
    p = np.append(linear(kernel), 1.25 * STEP)
    done = bench.filtered(p)
    expected = plain.filtered(linear(kernel))
    np.testing.assert_allclose(done.innovations, expected.innovations[::4], rtol=1e-7, atol=1e-9)


def test_a_held_input_is_half_a_sample_late_by_itself(kernel: Kernel) -> None:
    """A delay that was found goes along when inputs are held instead of straight, and none becomes negative."""
    straight = FilterBench(kernel, made(kernel), noise(kernel, 0), Between.STRAIGHT, delays=("late", "later"))
    p = np.append(linear(kernel), [0.2 * STEP, 3.5 * STEP])
    held = the_other_way(straight.with_inputs(Between.HELD), p, straight.between)
    np.testing.assert_allclose(held[-2:], [0.0, 3.0 * STEP])
    back = the_other_way(straight, held, Between.HELD)
    np.testing.assert_allclose(back[-2:], [0.0, 3.5 * STEP])  # one that is not there stays so
    np.testing.assert_array_equal(held[:-2], p[:-2])


def test_a_force_with_a_course_of_its_own_is_a_parameter_that_changes(kernel: Kernel) -> None:
    """Sensitivities with a weight add up to those without."""
    bench, p = FilterBench(kernel, made(kernel), noise(kernel, 0)), linear(kernel)
    half = np.zeros((COUNT, 2))
    half[:150, 0], half[150:, 1] = 1.0, 1.0
    parts = bench.filtered(p, ("T_f", "T_f"), half).slopes
    whole = bench.filtered(p, ("T_f",)).slopes
    np.testing.assert_allclose(parts.sum(axis=2), whole[:, :, 0], rtol=1e-9, atol=1e-12 * np.abs(whole).max())
    assert not parts[:150, :, 1].any()
    assert parts[:150, :, 0].any()


@pytest.mark.parametrize(("forces", "near"), [(0, 1e-9), (1, 1e-2)])
def test_filters_side_by_side_are_those_that_run_alone(kernel: Kernel, forces: int, near: float) -> None:
    """A linear machine has one Jacobian, so sharing it loses nothing; the force here grows with the first's current."""
    bench, p = FilterBench(kernel, made(kernel), noise(kernel, forces)), linear(kernel)
    own = bench.noise
    others = [replace(own, r=2.0 * own.r), replace(own, power=30.0 * own.power, decay=2.0 * own.decay)]
    found = bench.beside(p, others)
    for each, beside in zip((own, *others), found, strict=True):
        alone = bench.with_noise(each).filtered(p)
        assert beside.loss == pytest.approx(alone.loss, rel=near)
        assert np.linalg.norm(beside.innovations - alone.innovations) < near * np.linalg.norm(alone.innovations)
        assert np.linalg.norm(beside.variances - alone.variances) < near * np.linalg.norm(alone.variances)
    for other in found[1 : 2 + forces]:
        assert np.max(np.abs(other.variances / found[0].variances - 1.0)) > 0.1


def test_a_machine_that_starts_in_motion_is_not_held_by_its_friction(kernel: Kernel) -> None:
    """Positions alone tell how fast; at rest dry friction has a slope that leaves no doubt of the speed."""
    s, p = made(kernel), kernel.values
    p[kernel.parameters.index("T_f")] = 0.05
    motor = list(kernel.states).index("axis1.motor.q")
    start = np.zeros(len(kernel.states))
    start[len(kernel.coordinates) : 2 * len(kernel.coordinates)] = 30.0
    shown = FilterBench(kernel, s, noise(kernel, 0)).simulated(p, start, 0, COUNT)
    alone = replace(s, y=shown[:, 1:2].copy(), index=np.array([motor]), names=s.names[1:2], floor=np.zeros(1))
    quiet = noise(kernel, 0)
    white = FilterBench(kernel, alone, replace(quiet, r=np.array([1e-8]))).filtered(p).white
    assert np.abs(white[:50]).max() < 3.0


def test_a_sensor_gets_back_the_noise_that_an_input_took_over(kernel: Kernel) -> None:
    p, rng = linear(kernel), np.random.default_rng(1)
    s, k = made(kernel), COUNT
    shown = FilterBench(kernel, s, noise(kernel, 0)).simulated(p, np.zeros(len(kernel.states)), 0, k)
    s = replace(s, y=shown + rng.normal(0.0, [1e-2, 1e-3, 1e-2], (k, 3)))
    start = replace(noise(kernel, 0), r=np.array([1e-14, 1e-6, 1e-4]))
    bench = FilterBench(kernel, s, start)
    loss = bench.filtered(p).loss
    for _ in range(8):
        bench, loss = noise_step(bench, p, loss)
    assert bench.noise.r[0] == pytest.approx(1e-4, rel=0.3)
