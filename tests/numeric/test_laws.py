"""Columns of candidate laws along a recording, and where a fit within bounds refuses one."""

from __future__ import annotations

import numpy as np
import pytest

from symdyn.numeric.diagnose import diagnose
from symdyn.numeric.setting import prepare

from .pendulum import ARM, GRAVITY, MASS, TURNING, Array, motion, pendulum, record, recording

NOISY = 1e-3  # rad


def test_a_load_does_not_hold_the_noise_of_positions() -> None:
    """In a band as wide as the motion: differentiated twice, the noise above it would be a tenth of the load."""
    noise = np.random.default_rng(0).standard_normal((2, 10_000))
    runs = []
    for seed in (1, 2):
        clean = record(seed)
        q, tau = clean.channels.values()
        runs.append(recording(clean.time, q + NOISY * noise[seed - 1], tau))
    setting = prepare(pendulum(), *runs, lambda _: None)
    laws = setting.case(setting.seen.cutoff).laws
    load = laws.load(0, setting.kernel.values)
    q, _, a = motion(1, runs[0].time)
    needed = TURNING * a + MASS * GRAVITY * ARM * np.cos(q)
    inner = slice(500, -500)  # without the ends of the filter
    assert np.std(load[inner] - needed[inner]) < 0.02 * np.std(needed)


def test_a_probe_without_its_laws_is_an_inertia_of_one() -> None:
    """What an effect exerts is what its probe needs beside the acceleration."""
    setting = prepare(pendulum(), record(1), record(2), lambda _: None)
    seen = setting.seen
    assert len(setting.probes) > 1
    for probe in setting.probes.values():
        needed = probe.kernel.rows("inverse_dynamics_p", seen.q, seen.qd, seen.qdd, probe.kernel.values)
        np.testing.assert_array_equal(needed, seen.qdd)


@pytest.mark.slow
def test_a_law_that_a_fit_would_take_beyond_its_bounds_is_refused() -> None:
    """No gear takes 1.3 times what it transmits."""

    def missing(t: Array, q: Array, v: Array, a: Array) -> Array:
        return 1.3 * np.abs(TURNING * a + MASS * GRAVITY * ARM * np.cos(q)) * np.sign(v)

    found = diagnose(pendulum(), record(1, missing), record(2, missing))
    assert "load_dependent_friction" not in {f.effect for f in found.findings}
    assert "load-dependent friction at arm would fit only with a value outside its bounds" in found.alarms
