"""Input delay: dead time between command and motor, as a Pade approximant."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import sympy as sp

from symdyn.physics.dead_time import DeadTime, dead_time
from symdyn.physics.effect import CIRCUIT, ELECTRICAL, Values
from symdyn.spec.records import Motion


@final
class InputDelay(DeadTime):
    """What the stages before it hand on comes late (``DeadTime``).

    A delay of whole samples belongs to a sampled controller, and is exact there.
    """

    identifier = "input_delay"
    title = "input delay"
    attaches_to = CIRCUIT
    motions = ELECTRICAL
    parameters = dead_time((Motion.ELECTRICAL,))
    passes = "V"
    proposable = True
    signature = "phase lag that grows with frequency at full amplitude"

    def amplified(self, p: Values, z: Sequence[sp.Expr], control: sp.Expr) -> sp.Expr:
        return self.late(z, control)
