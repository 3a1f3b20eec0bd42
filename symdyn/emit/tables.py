"""What each entry of each vector is, with its unit: the tables that every target prints."""

from __future__ import annotations

import math
from collections.abc import Mapping

from symdyn.derive.equations import EquationsOfMotion


def name_tables(equations: EquationsOfMotion) -> Mapping[str, tuple[str, ...]]:
    """Names and units by the name of the table, such as "STATES" and "STATE_UNITS"."""
    axes, parameters = equations.axes, equations.robot.parameters
    return {
        "COORDINATES": tuple(a.address for a in axes),
        "COORDINATE_UNITS": tuple(a.unit for a in axes),
        "EFFORT_UNITS": tuple(a.effort_unit for a in axes),
        "STATES": (
            *(f"{a.address}.q" for a in axes),
            *(f"{a.address}.qd" for a in axes),
            *(s.name for s in equations.states),
        ),
        "STATE_UNITS": (
            *(a.unit for a in axes),
            *(f"{a.unit}/s" for a in axes),
            *(s.unit for s in equations.states),
        ),
        "INPUTS": tuple(i.name for i in equations.inputs),
        "INPUT_UNITS": tuple(i.unit for i in equations.inputs),
        "OUTPUTS": tuple(s.name for s in equations.sensors),
        "OUTPUT_UNITS": tuple(s.unit for s in equations.sensors),
        "PARAMETERS": tuple(p.name for p in parameters),
        "PARAMETER_UNITS": tuple(p.unit for p in parameters),
    }


def parameter_values(equations: EquationsOfMotion) -> tuple[float, ...]:
    """Values in the order of PARAMETERS; nan where one is left free."""
    return tuple(math.nan if p.value is None else float(p.value) for p in equations.robot.parameters)


def free_parameters(equations: EquationsOfMotion) -> tuple[str, ...]:
    return tuple(p.name for p in equations.robot.parameters if p.value is None)


def about(equations: EquationsOfMotion) -> str:
    """One sentence on the robot, without characters that could end a comment or a string around it."""
    robot = equations.robot
    description = "".join(c for c in robot.description if c.isprintable())
    return f"Kernel of {robot.name}: {description}".replace("\\", "/").replace('"', "'")
