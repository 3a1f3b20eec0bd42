"""Friction with a memory beside a spring: each is most of what is left until the other is known."""

from __future__ import annotations

from pathlib import Path

import pytest

from symdyn.numeric.diagnose import diagnose
from symdyn.numeric.filtering.hypotheses import HYSTERESIS, memories, without_memory
from symdyn.spec.records import Robot
from tests.numeric.filtering.drive import record

LEVEL, YIELD, SPRING = 0.037, 0.34, 0.009


def test_a_whole_number_makes_another_law(robot: Robot) -> None:
    laws = memories(robot, "axis", HYSTERESIS)
    told = [(law.effect, dict(law.counts).get("exponent")) for law in laws]
    assert told == [
        ("dahl_friction", None),
        ("bouc_wen_hysteresis", 1.0),
        ("bouc_wen_hysteresis", 2.0),
        ("lugre_friction", None),
        ("hardening_hysteresis", None),
    ]


def test_friction_gives_way_to_a_loop_and_a_spring_does_not() -> None:
    assert without_memory(HYSTERESIS) == {"coulomb_friction", "stribeck_friction"}


@pytest.mark.slow  # whole diagnoses
@pytest.mark.parametrize("shape", [0.6, 1.0])
def test_a_loop_and_a_spring_are_told_together(robot: Robot, tmp_path: Path, shape: float) -> None:
    """Without the spring Dahl's law does as well as Bouc-Wen's, and a soft transmission better than either."""
    concealed = {"dahl": LEVEL, "distance": YIELD, "shape": shape, "spring": SPRING}
    found = diagnose(robot, *(record(tmp_path / f"{seed}.csv", robot, seed, **concealed) for seed in (1, 2)))
    told = {f.effect: {name: value for name, value in f.parameters.items() if value.se} for f in found.findings}
    wanted = {"linear_spring": {"stiffness": SPRING}}
    if shape == 1.0:
        wanted["dahl_friction"] = {"stiffness": LEVEL / YIELD, "level": LEVEL}
    else:
        wanted["bouc_wen_hysteresis"] = {"level": LEVEL, "yield_displacement": YIELD, "shape": shape}
    assert set(told) == set(wanted)
    for effect, values in wanted.items():
        for name, value in values.items():
            se = told[effect][name].se
            assert se is not None
            assert abs(told[effect][name].value - value) < 3.0 * se < 0.2 * value, name
    assert found.noise_floor is not None
    assert found.after.heldout < 1.05 * found.noise_floor.errors.heldout
    assert not found.remaining.structured
