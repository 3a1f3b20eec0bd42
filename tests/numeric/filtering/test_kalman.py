"""The compiled filter against a filter written by hand, and its sensitivities against differences."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import linalg

from symdyn.compiler import compile_robot, load_robot
from symdyn.emit.kernel import Kernel
from symdyn.numeric.filtering.bench import DEAF, FilterBench, Noise
from symdyn.numeric.filtering.signals import Signals

Array = NDArray[np.float64]

STEP, COUNT = 1e-3, 300


@pytest.fixture(scope="module")
def kernel() -> Kernel:
    """The drive of the 1986 paper, without its Coulomb friction: linear."""
    return compile_robot(load_robot("irb6-axis1"), 0.05, friction_only=True).kernel()


def made(kernel: Kernel, seed: int = 0) -> Signals:
    """Something like a recording of current, motor angle and tachometer."""
    rng = np.random.default_rng(seed)
    time = np.arange(COUNT) * STEP
    u = (3.0 * np.sin(20.0 * time) + rng.normal(0.0, 0.3, COUNT))[:, None]
    y = np.column_stack([np.sin(20.0 * time), 0.1 * time, 0.2 * np.cos(9.0 * time)]) + rng.normal(0, 0.05, (COUNT, 3))
    states = list(kernel.states)
    index = np.array([states.index("axis1.motor.current"), states.index("axis1.motor.q"), len(states)])
    steps = np.append(np.full(COUNT - 1, STEP), np.nan)
    names = ("axis1.motor.current", "axis1.motor.q", "axis1.tachometer.voltage")
    return Signals(time, u, y, index, names, steps, np.zeros(3))


def linear(kernel: Kernel) -> Array:
    p = kernel.values
    p[kernel.parameters.index("T_f")] = 0.0
    return p


def noise(kernel: Kernel, forces: int) -> Noise:
    """Of the sensors, and an unknown torque on the motor that the model's own Coulomb friction stands for here."""
    directions = np.zeros((len(kernel.parameters), forces))
    if forces:
        directions[kernel.parameters.index("K_T"), 0] = 1.0
    return Noise(np.array([1e-3, 1e-5, 1e-4]), directions, np.full(forces, 30.0), np.full(forces, 1e-4))


def by_hand(kernel: Kernel, bench: FilterBench, p: Array) -> tuple[float, Array]:
    """(-log L, innovations) of the same linear machine by textbook formulas and SciPy's exponential."""
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
            loss += 0.5 * (e**2 / variance + np.log(variance))
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
    deaf = Noise(np.full(3, DEAF), *(lambda x: (x.directions, x.decay, x.power))(noise(kernel, 0)))
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
        np.testing.assert_allclose(slopes[:, :, i] / scale.max(), quotient / scale.max(), atol=3e-3)


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
    s, p = made(kernel), linear(kernel)
    quiet = FilterBench(kernel, s, noise(kernel, 0)).filtered(p)
    driven = FilterBench(kernel, s, noise(kernel, 1)).filtered(p)
    assert np.all(driven.variances[10:] >= quiet.variances[10:] * (1 - 1e-9))
    assert driven.states.shape[1] == quiet.states.shape[1] + 1
