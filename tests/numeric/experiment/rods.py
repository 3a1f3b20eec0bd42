"""A pendulum with one more effect, as the explanations of the tests have it."""

from __future__ import annotations

from functools import cache

import numpy as np

from symdyn.compiler import robot_from_text
from symdyn.numeric.experiment.explanations import Explained, explained
from symdyn.numeric.experiment.limits import JointLimits, Limits
from symdyn.numeric.experiment.separation import Noise

from ..pendulum import TOML

EFFECTS = {
    "offset": 'type = "force_offset"\noffset = "0.2 N m"',
    "spring": 'type = "linear_spring"\nstiffness = "0.6 N m/rad"\npreload = "0.1 N m"',
    "ripple": 'type = "torque_ripple"\ncosine = "0.2 N m"\nsine = "0.2 N m"\norder = 11',
    "coulomb": 'type = "coulomb_friction"\nlevel = "0.2 N m"',
    "asymmetric": 'type = "asymmetric_viscous_friction"\ndifference = "0.05 N m s/rad"',
    "stiffer": 'type = "linear_spring"\nstiffness = "0.9 N m/rad"\npreload = "0.2 N m"',
}
NOISE = Noise(np.array([0.02]), 20.0)  # N m, in a band of 10 Hz


def with_effect(name: str) -> str:
    """The pendulum's file with that effect."""
    block = f'[[effect]]\nat = "arm"\n{EFFECTS[name]}\n\n[recording]\n' if name else "[recording]\n"
    return TOML.replace("[recording]\n", block, 1)


@cache
def rod(name: str) -> Explained:
    return explained(robot_from_text(with_effect(name), f"{name or 'rod'}.toml"))


def limits(travel: float, velocity: float = 1.0, acceleration: float = 20.0, effort: float = np.inf) -> Limits:
    """About an angle of 0.3 rad."""
    return Limits((JointLimits(0.3 - travel / 2, 0.3 + travel / 2, velocity, acceleration, effort),))
