"""The linear model of the seed's drive against an independent computation from its printed parameters."""

from __future__ import annotations

import pytest

from symdyn.compiler import compile_robot, load_robot
from symdyn.derive.linearize import without_nonsmooth
from symdyn.numeric.frequency import extrema, linear_model, modes


@pytest.fixture(scope="module")
def system():  # type: ignore[no-untyped-def]
    return linear_model(compile_robot(without_nonsmooth(load_robot("irb6-axis1"))).kernel())


def test_poles(system) -> None:  # type: ignore[no-untyped-def]
    found = modes(system)
    assert system.nstates == 9
    real = sorted(m.pole.real for m in found if abs(m.pole.imag) < 1e-6)
    assert real == pytest.approx([-18277.8, -8.859, 0.0], rel=1e-4, abs=1e-4)
    pairs = [(m.frequency, m.damping) for m in found if m.pole.imag > 1e-6]
    assert [f for f, _ in pairs] == pytest.approx([15.17, 623.6, 1261.1], rel=5e-4)
    assert [z for _, z in pairs] == pytest.approx([0.116, 0.064, 0.105], abs=6e-4)


def test_peaks_and_anti_resonances(system) -> None:  # type: ignore[no-untyped-def]
    found = extrema(system, 5.0, 3000.0)
    assert [e.frequency for e in found if e.kind == "peak"] == pytest.approx([15.46, 628.4, 1221.7], rel=4e-4)
    assert [e.frequency for e in found if e.kind != "peak"] == pytest.approx([9.88, 395.0, 945.5], rel=6e-4)
