"""Reads [[effect]] blocks: a known type, at a place that it attaches to, with its parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from symdyn.base.wording import closest, did_you_mean, listed, quoted
from symdyn.spec.effect_schema import EffectSchema, ParameterSchema
from symdyn.spec.numbers import NumberReader
from symdyn.spec.records import EffectSpec, Monomial, Place
from symdyn.spec.schema import EffectTable, Scalar
from symdyn.spec.slots import effect_slot
from symdyn.spec.structure import check_count, check_zero
from symdyn.spec.toml_positions import KeyPath


def read_effects(
    tables: Sequence[EffectTable],
    places: Sequence[Place],
    catalogue: Mapping[str, EffectSchema],
    numbers: NumberReader,
) -> tuple[EffectSpec, ...]:
    """The effects in file order; those with a wrong type or place are left out, and told."""
    by_address = {place.address: place for place in places}
    read = (_read_effect(table, ("effect", i), by_address, catalogue, numbers) for i, table in enumerate(tables))
    return tuple(effect for effect in read if effect is not None)


def _read_effect(
    table: EffectTable,
    path: KeyPath,
    places: Mapping[str, Place],
    catalogue: Mapping[str, EffectSchema],
    numbers: NumberReader,
) -> EffectSpec | None:
    findings = numbers.findings
    schema = catalogue.get(table.type)
    if schema is None:
        findings.error(
            (*path, "type"), "SD104", f"no effect {quoted(table.type)}", did_you_mean(table.type, catalogue, "effects")
        )
        return None
    given = table.__pydantic_extra__
    known = [parameter.name for parameter in schema.parameters]
    misspelt = set()  # told once, not as missing too
    for key in given:
        if key not in known:
            misspelt.add(closest(key, known))
            hint = did_you_mean(key, known, "parameters")
            findings.error((*path, key), "SD104", f"{schema.identifier} has no {quoted(key)}", hint, key=True)
    place = places.get(table.at)
    if place is None:
        findings.error(
            (*path, "at"),
            "SD104",
            f"no place {quoted(table.at)}",
            f"{schema.identifier} attaches to: {_fitting(schema, places)}",
        )
        return None
    if place.kind not in schema.attaches_to or any(place.motion not in p.units for p in schema.parameters):
        findings.error(
            (*path, "at"),
            "SD109",
            f"{schema.identifier} does not attach to {quoted(table.at)}, a {place.kind}",
            f"it attaches to: {_fitting(schema, places)}",
        )
        return None
    values = tuple(
        (parameter.name, monomial)
        for parameter in schema.parameters
        if (parameter.name in given or parameter.name not in misspelt)
        and (monomial := _read_parameter(parameter, given.get(parameter.name), path, schema, place, numbers))
        is not None
    )
    return EffectSpec(schema.identifier, place.address, values, findings.where(path))


def _fitting(schema: EffectSchema, places: Mapping[str, Place]) -> str:
    return listed(p.address for p in places.values() if p.kind in schema.attaches_to) or "nothing in this robot"


def _read_parameter(
    parameter: ParameterSchema,
    value: Scalar | None,
    path: KeyPath,
    schema: EffectSchema,
    place: Place,
    numbers: NumberReader,
) -> Monomial | None:
    key_path = (*path, parameter.name)
    unit = parameter.units[place.motion]
    slot = effect_slot(path, parameter, schema, place)
    if value is None and parameter.default is not None:
        value = parameter.default
    if value is None:
        numbers.findings.error(
            key_path,
            "SD107",
            f"{schema.identifier} needs {quoted(parameter.name)}",
            f"{parameter.meaning}, in {unit}",
        )
        return None
    if parameter.is_count:
        monomial = numbers.read_plain(value, slot)
    else:
        monomial = numbers.read(value, slot, keep_zero=not parameter.zero_is_structural)
    known = numbers.value(monomial)
    if known is not None and not numbers.findings.is_blamed(key_path):
        _check_bounds(parameter, known, unit, key_path, numbers)
        if parameter.is_count:
            check_count(parameter.name, monomial, known, key_path, numbers.findings)
        if parameter.zero_is_structural:
            check_zero(parameter.name, monomial, known, key_path, numbers.findings)
    return monomial


def _check_bounds(parameter: ParameterSchema, value: float, unit: str, path: KeyPath, numbers: NumberReader) -> None:
    told = "" if unit == "1" else f" {unit}"
    if parameter.nonzero and value == 0:
        numbers.findings.error(path, "SD203", f"{parameter.name} is 0{told}, must not be zero: {parameter.meaning}")
    for bound, is_beyond, side in (
        (parameter.lower, parameter.lower is not None and value < parameter.lower, "at least"),
        (parameter.upper, parameter.upper is not None and value > parameter.upper, "at most"),
    ):
        if is_beyond:
            numbers.findings.error(
                path, "SD203", f"{parameter.name} is {value:g}{told}, must be {side} {bound:g}{told}"
            )
