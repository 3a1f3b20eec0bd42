"""What the steps of an encoder do to a residual, beside what a law that does not hold leaves of it."""

from __future__ import annotations

import math
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from symdyn.compiler import robot_from_text
from symdyn.numeric.inquiry import Inquiry
from symdyn.numeric.recording import Recording
from symdyn.numeric.rounding import left_by_steps, with_resolutions
from symdyn.numeric.setting import prepare
from symdyn.spec.records import Quantity, Side

MODEL = """
[robot]
name = "disc"
gravity = [0, 0, 0]

[dh]
rows = [["q", 0, 0, 0]]

[[joint]]
name = "disc"
link = { inertia = { about = "joint", zz = "0.025 kg m^2" } }

[[effect]]
type = "viscous_friction"
at = "disc"
coefficient = "0.09 N m s/rad"
"""
INERTIA, VISCOUS, DRY, UNEVEN = 0.031, 0.12, 0.25, 0.6  # the truth: dry friction that differs along a turn
STEP, FINE, COUNT, TURN = 1e-3, 10, 10_000, 65_536


def record(seed: int) -> Recording:
    """A disc that turns back, and stands, many times a second; symplectic Euler."""
    rng = np.random.default_rng(seed)
    time = STEP * np.arange(COUNT)
    frequency = np.array([0.1, 0.35, 0.8, 1.7, 3.3, 6.1]) * (1.0 + 0.05 * rng.random(6))
    effort = 0.45 * np.sin(2.0 * np.pi * np.outer(time, frequency) + rng.uniform(0.0, 6.28, 6)).sum(axis=1)
    x, v, h, shown = 0.0, 0.0, STEP / FINE, np.zeros(COUNT)
    for k in range(COUNT):
        shown[k] = x
        for _ in range(FINE):
            v += h / INERTIA * (effort[k] - VISCOUS * v)
            v = math.copysign(max(abs(v) - h / INERTIA * DRY * (1.0 + UNEVEN * math.cos(x)), 0.0), v)
            x += h * v
    step = 2.0 * math.pi / TURN
    channels = {
        (Quantity.EFFORT, "disc", Side.LINK): effort + 0.01 * rng.standard_normal(COUNT),
        (Quantity.POSITION, "disc", Side.LINK): np.round(shown / step) * step,
    }
    return Recording(f"run {seed}", time, MappingProxyType(channels), STEP, (slice(0, COUNT),), (), "0" * 64)


def test_samples_that_count_in_one_rounding_alone_tell_nothing_of_steps() -> None:
    """Around reversals a joint seems to stand in one of the two, where all of its residual is left out."""
    setting = prepare(robot_from_text(MODEL, "disc.toml"), record(1), record(2), lambda _: None)
    case = setting.case(10.0)
    given = case.explain()
    coulomb = next(c for c in setting.proposed if c.effect == "coulomb_friction")
    found = replace(Inquiry(setting, case, given, setting, case, given), current=case.explain(((coulomb, ()),), given))
    left = float(np.sqrt(np.mean(found.current.heldout**2)))
    assert left > 0.05  # N m, of which steps of 1e-4 rad leave next to nothing
    told = with_resolutions(found)
    assert not told.findings, told.alarms
    text = f'{MODEL}\n[[effect]]\ntype = "encoder"\nat = "disc"\ngain = 1\nresolution = "{2.0 * math.pi / TURN} rad"\n'
    known = replace(found, setting=replace(setting, robot=robot_from_text(text, "disc.toml")))
    assert left_by_steps(known)[1][0] < 0.01 * left


def test_steps_show_in_what_was_found_as_in_the_model() -> None:
    """Rounding trembles in an acceleration, whether the model's inertia asks for it or one that was found."""
    steps = 2.0 * math.pi / TURN
    text = f'{MODEL}\n[[effect]]\ntype = "encoder"\nat = "disc"\ngain = 1\nresolution = "{steps} rad"\n'
    light = text.replace("0.025 kg m^2", "0.002 kg m^2")
    left = []
    for model, laws in ((text, {"coulomb_friction"}), (light, {"coulomb_friction", "added_inertia"})):
        setting = prepare(robot_from_text(model, "disc.toml"), record(1), record(2), lambda _: None)
        setting = replace(setting, own=setting.own if model is text else setting.own[1:])
        case = setting.case(40.0)
        given = case.explain()
        current = case.explain(tuple((c, ()) for c in setting.proposed if c.effect in laws), given)
        inquiry = replace(Inquiry(setting, case, given, setting, case, given), current=current)
        left.append(left_by_steps(inquiry)[1][0])
    assert left[0] > 0.0
    assert abs(left[1] / left[0] - 1.0) < 0.1
