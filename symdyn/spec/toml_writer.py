"""Writes a robot as the TOML text that reads back as the same robot."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields, replace

from symdyn.base.errors import InputError, Problem
from symdyn.base.latex_check import is_safe_latex
from symdyn.base.names import latex_of, with_subscripts
from symdyn.spec.effect_schema import EffectSchema
from symdyn.spec.number_paths import number_paths
from symdyn.spec.numbers import Slot
from symdyn.spec.places import places
from symdyn.spec.records import (
    Channel,
    ChannelMap,
    DHRow,
    Drive,
    EffectSpec,
    InertiaAbout,
    Joint,
    JointKind,
    Limits,
    Link,
    Monomial,
    Parameter,
    Placement,
    Quantity,
    Robot,
    Rotation,
)
from symdyn.spec.rotations import as_record, from_rpy
from symdyn.spec.slots import MOMENTS, com_slots, effect_slot, gravity_slots, inertia_slots, mass_slot, position_slots

Catalogue = Mapping[str, EffectSchema]

_RIGHT = {0: "0", 1: '"90 deg"', 2: '"180 deg"', -1: '"-90 deg"'}
_QUARTERS = tuple(_RIGHT)


def to_toml(robot: Robot, catalogue: Catalogue) -> str:
    """The robot's file, anew: comments of the one it was read from are not in it.

    Numbers that are a literal's own parameter stand in place; all others are named in [parameters].
    """
    return _Writer(robot, catalogue).text()


class _Writer:
    def __init__(self, robot: Robot, catalogue: Catalogue) -> None:
        self.robot, self.catalogue = robot, catalogue
        self._by_name = {parameter.name: parameter for parameter in robot.parameters}
        self._uses = Counter(name for _, monomial in number_paths(robot) for name, _ in monomial.factors)
        self._in_place: set[str] = set()

    def text(self) -> str:
        head = self._head()
        body = [self._base(), self._dh(), *self._joints(), self._tool(), *self._effects(), self._recording()]
        return "\n".join(block for block in (head, self._parameters(), *body) if block)  # parameters: what is left

    def _head(self) -> str:
        described = f"description = {_quote(self.robot.description)}\n" if self.robot.description else ""
        gravity = self._list(self.robot.gravity, gravity_slots())
        return f"[robot]\nname = {_quote(self.robot.name)}\n{described}gravity = {gravity}\n"

    def _parameters(self) -> str:
        """What does not stand in place: known when all else is written."""
        lines = [f"{p.name} = {_entry(p)}\n" for p in self.robot.parameters if p.name not in self._in_place]
        return "[parameters]\n" + "".join(lines) if lines else ""

    def _number(self, monomial: Monomial, slot: Slot | None = None, *, keep_zero: bool = False) -> str:
        if monomial.is_zero:
            return "0"
        if slot is not None and len(monomial.factors) == 1:
            parameter = self._by_name[monomial.factors[0][0]]
            is_bare = monomial.factors[0][1] == 1 and monomial.coefficient == 1 and self._uses[parameter.name] == 1
            if is_bare and (parameter.value or keep_zero) and _is_literal_of(slot, parameter):
                self._in_place.add(parameter.name)
                return repr(parameter.value)
        return _monomial(monomial)

    def _list(self, monomials: Sequence[Monomial], slots: Sequence[Slot]) -> str:
        return f"[{', '.join(self._number(m, s) for m, s in zip(monomials, slots, strict=True))}]"

    def _base(self) -> str:
        if self.robot.base is None:
            return ""
        return f"[base]\nplacement = {self._placement(self.robot.base, 'base')}\n"

    def _placement(self, placement: Placement, owner: str) -> str:
        parts = []
        if not all(coordinate.is_zero for coordinate in placement.position):
            parts.append(f"xyz = {self._list(placement.position, position_slots((), owner))}")
        if placement.rotation != Placement().rotation:
            parts.append(_rotation(placement.rotation))
        return f"{{ {', '.join(parts)} }}" if parts else "{}"

    def _dh(self) -> str:
        rows = [joint.placement for joint in self.robot.joints if isinstance(joint.placement, DHRow)]
        if not rows:
            return ""
        if len(rows) < len(self.robot.joints):
            raise InputError(Problem("SD105", "a file has DH rows for all joints, or for none"))
        lines = [f"         [{', '.join(_cells(joint))}]" for joint in self.robot.joints]
        return f'[dh]\nconvention = "{self.robot.convention}"\nrows = [\n' + ",\n".join(lines) + "\n]\n"

    def _joints(self) -> Iterator[str]:
        for joint in self.robot.joints:
            lines = [f"[[joint]]\nname = {_quote(joint.name)}"]
            if joint.description:
                lines.append(f"description = {_quote(joint.description)}")
            if isinstance(joint.placement, Placement):
                if joint.kind is JointKind.PRISMATIC:
                    lines.append(f'kind = "{joint.kind}"')
                lines.append(f"placement = {self._placement(joint.placement, joint.name)}")
            if joint.passive:
                lines.append("passive = true")
            parts = self._link(joint.link, joint.name)
            if parts:
                lines.append(f"link = {{ {', '.join(parts)} }}")
            if joint.limits is not None:
                lines.append(f"limits = {_limits(joint.limits)}")
            if joint.actuator is not None:
                lines.append(f"actuator = {{ gain = {self._number(joint.actuator.gain)} }}")
            if joint.drive is not None:
                lines.append(self._drive(joint.drive))
            yield "\n".join(lines) + "\n"

    def _link(self, link: Link, owner: str) -> list[str]:
        parts = []
        if not link.mass.is_zero:
            parts.append(f"mass = {self._number(link.mass, mass_slot((), owner))}")
        if not all(coordinate.is_zero for coordinate in link.com):
            parts.append(f"com = {self._list(link.com, com_slots((), owner))}")
        about = [] if link.about is InertiaAbout.COM else [f'about = "{link.about}"']
        entries = [
            f"{entry} = {self._number(moment, slot)}"
            for entry, moment, slot in zip(MOMENTS, link.inertia, inertia_slots((), owner), strict=True)
            if not moment.is_zero
        ]
        if about or entries:
            parts.append(f"inertia = {{ {', '.join((*about, *entries))} }}")
        return parts

    def _drive(self, drive: Drive) -> str:
        lines = ["", "[joint.drive]", f"ratio = {self._number(drive.ratio)}"]
        rotors = [
            f"{{ name = {_quote(r.name)}, inertia = {self._number(r.inertia)}"
            + (", fixed_to_joint = true }" if r.fixed_to_joint else " }")
            for r in drive.rotors
        ]
        shafts = [
            f"{{ name = {_quote(s.name)}, from = {_quote(s.start)}, to = {_quote(s.end)}, "
            f"stiffness = {self._number(s.stiffness)}, damping = {self._number(s.damping)} }}"
            for s in drive.shafts
        ]
        for key, items in (("rotors", rotors), ("shafts", shafts)):
            if items:
                lines += [f"{key} = [", *(f"  {item}," for item in items), "]"]
        if drive.effort_at:
            lines.append(f"effort_at = {_quote(drive.effort_at)}")
        if drive.motor is not None:
            m = drive.motor
            constants = ("resistance", "inductance", "torque_constant", "back_emf_constant")
            numbers = ", ".join(f"{key} = {self._number(getattr(m, key))}" for key in constants)
            lines.append(f"motor = {{ name = {_quote(m.name)}, at = {_quote(m.at)}, {numbers} }}")
        return "\n".join(lines)

    def _tool(self) -> str:
        tool = self.robot.tool
        if tool is None:
            return ""
        return "\n".join(
            ["[tool]", f"placement = {self._placement(tool.placement, 'tool')}", *self._link(tool.link, "tool"), ""]
        )

    def _effects(self) -> Iterator[str]:
        by_address = {place.address: place for place in places(self.robot)}
        for effect in self.robot.effects:
            schema = self.catalogue[effect.type]
            slots = {p.name: effect_slot((), p, schema, by_address[effect.at]) for p in schema.parameters}
            yield self._effect(effect, slots)

    def _effect(self, effect: EffectSpec, slots: Mapping[str, Slot]) -> str:
        values = [f"{key} = {self._number(value, slots[key], keep_zero=True)}" for key, value in effect.values]
        return "\n".join(["[[effect]]", f'type = "{effect.type}"', f'at = "{effect.at}"', *values, ""])

    def _recording(self) -> str:
        channels = self.robot.channels
        return (
            "" if channels is None else "\n".join(["[recording]", _time(channels), *map(_channel, channels.channels)])
        )


def _is_literal_of(slot: Slot, parameter: Parameter) -> bool:
    """Whether a plain number in this place would become this very parameter."""
    latex = with_subscripts(slot.symbol, slot.owner) if slot.owner else slot.symbol
    literal = Parameter(slot.automatic_name, parameter.value, slot.unit, latex, slot.meaning)
    return replace(parameter, where=None) == literal


def _monomial(monomial: Monomial) -> str:
    """``"-1/2 * m l^2"``; a plain number without quotes. The star keeps ``2 * m`` from being two metres."""
    coefficient = monomial.coefficient
    if not monomial.factors:
        return repr(float(coefficient))
    names = " ".join(name if power == 1 else f"{name}^{power}" for name, power in monomial.factors)
    if abs(coefficient) == 1:
        return f'"{"-" if coefficient < 0 else ""}{names}"'
    return f'"{coefficient} * {names}"'


def _cells(joint: Joint) -> Iterator[str]:
    row = joint.placement
    assert isinstance(row, DHRow)
    moving = "theta" if joint.kind is JointKind.REVOLUTE else "d"
    for field in fields(row):
        constant: Monomial = getattr(row, field.name)
        text = _monomial(constant) if not constant.is_zero else "0"
        if field.name != moving:
            yield text
        elif constant.is_zero:
            yield '"q"'
        else:
            bare = text.strip('"')
            yield f'"q {"-" if bare.startswith("-") else "+"} {bare.lstrip("-")}"'


def _rotation(rotation: Rotation) -> str:
    """Right angles as such, where they give the matrix; else the matrix, which loses no digit."""
    for yaw in _QUARTERS:
        for pitch in _QUARTERS:
            for roll in _QUARTERS:
                if _turned(roll, pitch, yaw) == rotation:
                    return f"rpy = [{_RIGHT[roll]}, {_RIGHT[pitch]}, {_RIGHT[yaw]}]"
    return f"rotation = [{', '.join(repr(list(row)) for row in rotation)}]"


def _turned(roll: int, pitch: int, yaw: int) -> Rotation:
    right_angle = 1.5707963267948966
    return as_record(from_rpy(roll * right_angle, pitch * right_angle, yaw * right_angle))


def _limits(limits: Limits) -> str:
    given = {field.name: getattr(limits, field.name) for field in fields(limits)}
    return "{ " + ", ".join(f"{key} = {value!r}" for key, value in given.items() if value is not None) + " }"


def _entry(parameter: Parameter) -> str:
    latex = parameter.latex if parameter.latex != latex_of(parameter.name) and is_safe_latex(parameter.latex) else ""
    extra = [
        f"{key} = {_quote(text)}" for key, text in (("latex", latex), ("meaning", parameter.meaning)) if text
    ]  # fmt: skip
    if parameter.value is None:
        return f"{{ {', '.join((f'free = {_quote(parameter.unit)}', *extra))} }}"
    if not extra:
        return repr(parameter.value) if parameter.unit == "1" else f'"{parameter.value!r} {parameter.unit}"'
    unit = [] if parameter.unit == "1" else [f"unit = {_quote(parameter.unit)}"]
    return f"{{ {', '.join((f'value = {parameter.value!r}', *unit, *extra))} }}"


def _time(channels: ChannelMap) -> str:
    return f"time = {{ column = {_quote(channels.time_column)}, unit = {_quote(channels.time_unit)} }}\n"


def _channel(channel: Channel) -> str:
    lines = [
        "[[recording.channel]]",
        f"column = {_quote(channel.column)}",
        f'quantity = "{channel.quantity}"',
        *_where(channel),
        f"unit = {_quote(channel.unit)}",
        f"scale = {channel.scale!r}",
        f"sign = {channel.sign}",
        "",
    ]
    return "\n".join(lines)


def _where(channel: Channel) -> list[str]:
    if channel.quantity is Quantity.PARAMETER:
        return [f"parameter = {_quote(channel.joint)}"]
    return [f"joint = {_quote(channel.joint)}", f'side = "{channel.side}"']


def _quote(text: str) -> str:
    return json.dumps(text, ensure_ascii=False)
