"""The bundled machines as parameters of tests: what costs in proportion to the coordinates waits for the slow run."""

from __future__ import annotations

import pytest

from symdyn.compiler import load_robot
from symdyn.derive.coordinates import coordinates
from symdyn.spec.machines import machine_names

FEW = 4  # coordinates up to which every function is checked in every form, digit by digit, in every run

MACHINES = [
    pytest.param(name, marks=() if len(coordinates(load_robot(name))) <= FEW else pytest.mark.slow)
    for name in machine_names()
]
