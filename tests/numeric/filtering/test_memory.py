"""Friction that remembers its motion or its heat, and what a missing force follows: in single runs of the filter."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from symdyn.numeric.filtering.between import Between
from symdyn.numeric.filtering.hypotheses import HYSTERESIS, WARMING, memories
from symdyn.numeric.filtering.judged import Explanation, explained
from symdyn.numeric.filtering.likelihood import fit
from symdyn.numeric.filtering.memory import _rise, lasting
from symdyn.numeric.filtering.model import Model, natural_force, prepare, with_latent, without_latent
from symdyn.numeric.filtering.when import when
from symdyn.spec.records import Robot
from tests.numeric.filtering.drive import record


def as_given(robot: Robot, folder: Path, **concealed: float) -> tuple[Model, Explanation]:
    """The model as given, with an unknown force at its joint, roughly fitted."""
    training, heldout = (record(folder / f"{seed}.csv", robot, seed, **concealed) for seed in (1, 2))
    model = prepare(robot, training, heldout)
    latent = next(x for x in model.latents if x.place == "axis")
    power = 1e-3 * natural_force(model, model.training, latent.direction) ** 2
    bench = model.bench(model.training, with_latent(without_latent(model, model.training), latent, power), Between.HELD)
    done = fit(bench, model.values, model.beliefs, settled=2.0, most=12)
    return model, explained(model, (), model.beliefs, done)


def test_friction_that_jumps_is_no_loop(robot: Robot, tmp_path: Path) -> None:
    model, given = as_given(robot, tmp_path, coulomb=0.03)
    (loop,) = (x for x in lasting(model, given) if x.laws is HYSTERESIS)
    assert loop.gain > 20.0
    assert loop.beyond < 10.0


def test_a_loop_shows_its_distance_and_what_the_force_follows(robot: Robot, tmp_path: Path) -> None:
    model, given = as_given(robot, tmp_path, dahl=0.03, distance=0.05)
    (loop,) = (x for x in lasting(model, given) if x.laws is HYSTERESIS)
    assert loop.latent.place == "axis"
    assert loop.beyond > 100.0
    assert 0.02 < loop.shape[0] < 0.12
    assert when(model, given, loop.latent)[0] == "reversal"


def test_what_remembers_already_is_not_asked_to_remember_once_more(robot: Robot, tmp_path: Path) -> None:
    model, given = as_given(robot, tmp_path, dahl=0.03, distance=0.05)
    (dahl,) = memories(robot, "axis", {"dahl_friction": "stiffness"})
    found = lasting(model, replace(given, found=((dahl, None),)))
    assert {(x.laws is HYSTERESIS, x.latent.place) for x in found} == {(False, "axis")}


@pytest.mark.parametrize("name", ["axis.circuit"])
def test_nothing_is_said_of_when_in_a_circuit(robot: Robot, name: str, tmp_path: Path) -> None:
    model, given = as_given(robot, tmp_path)
    latent = next(x for x in model.latents if x.place == name)
    assert not np.any(latent.motion)
    assert when(model, given, latent) == ()


def test_heat_is_told_from_no_heat(robot: Robot, tmp_path: Path) -> None:
    """What viscous friction there is beyond the model's does not fade: no memory, then."""
    model, given = as_given(robot, tmp_path)
    (warm,) = (x for x in lasting(model, given) if x.laws is WARMING)
    assert warm.beyond < 10.0
    assert len(warm.shape) == 2


def test_friction_heats_itself_to_where_as_much_flows_off() -> None:
    """At a steady speed: T = v^2 R exp(-T / T_0), whatever the heat capacity, and slower with more of it."""
    v, steps = np.full(4001, 2.0), np.append(np.full(4000, 0.01), 0.0)
    quick, slow = (_rise(v, steps, capacity, 3.0, 20.0) for capacity in (0.1, 1.0))
    assert quick[-1] == pytest.approx(12.0 * np.exp(-quick[-1] / 20.0), rel=1e-6)
    assert slow[-1] == pytest.approx(quick[-1], rel=1e-3)
    assert np.all(slow[1:2000] < quick[1:2000])
    assert slow[1] == pytest.approx(4.0 * 0.01 / 1.0, rel=0.01)
