"""Reference delay: dead time between what asks for a position and the servo loop that follows it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import sympy as sp

from symdyn.physics.dead_time import DeadTime, dead_time
from symdyn.physics.effect import DISPLACEMENT, MOVING, Port, Unit, Values
from symdyn.spec.records import Motion


@final
class ReferenceDelay(DeadTime):
    """The reference of the position servo or position loop of this joint comes late (``DeadTime``).

    It acts ahead of every loop, wherever it is declared: what a bus or a queue of commands does.
    """

    identifier = "reference_delay"
    title = "reference delay"
    attaches_to = MOVING
    parameters = dead_time((Motion.ROTATIONAL, Motion.TRANSLATIONAL))
    passes = DISPLACEMENT
    proposable = True
    stage = -1
    signature = "the machine follows late by the same time, however slow its loop is"

    @classmethod
    def reference_unit(cls) -> Unit:
        return DISPLACEMENT

    def controls(self, port: Port, p: Values, z: Sequence[sp.Expr], control: sp.Expr) -> sp.Expr:
        return self.late(z, control)
