"""Reads the limits of a joint: range, speed, effort."""

from __future__ import annotations

from symdyn.spec.field_units import FieldUnit, unit_of
from symdyn.spec.part_readers import JointContext
from symdyn.spec.plain_numbers import plain_number
from symdyn.spec.records import Limits
from symdyn.spec.schema import LimitsTable

_UNITS = {
    "lower": FieldUnit.POSITION,
    "upper": FieldUnit.POSITION,
    "velocity": FieldUnit.VELOCITY,
    "effort": FieldUnit.EFFORT,
}


def read_limits(table: LimitsTable, joint: JointContext) -> Limits:
    """SD113 for an empty range, SD203 for a negative speed or effort, added to the findings."""
    path, findings = (*joint.path, "limits"), joint.numbers.findings
    read = {
        key: None if value is None else plain_number(value, unit_of(field, joint.motion), (*path, key), findings)
        for key, field in _UNITS.items()
        for value in [getattr(table, key)]
    }
    lower, upper = read["lower"], read["upper"]
    if lower is not None and upper is not None and lower > upper:
        findings.error((*path, "lower"), "SD113", f"the lower limit {lower:g} is above the upper limit {upper:g}")
    for key in ("velocity", "effort"):
        value = read[key]
        if value is not None and value < 0:
            findings.error((*path, key), "SD203", f"{key} is {value:g}, must not be negative")
    return Limits(**read)
