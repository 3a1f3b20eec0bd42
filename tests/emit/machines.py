"""The bundled machines as parameters of tests: what is costly in proportion to the joints waits for the slow run."""

from __future__ import annotations

import pytest

from symdyn.compiler import load_robot
from symdyn.spec.machines import machine_names

FEW = 2  # joints up to which every function is checked in every form, digit by digit, in every run

MACHINES = [
    pytest.param(name, marks=() if len(load_robot(name).joints) <= FEW else pytest.mark.slow)
    for name in machine_names()
]
