"""Writes a robot's numbers back into the URDF that it came from: inertials, damping, friction, and nothing else."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from symdyn.base.errors import InputError, Problem, Where
from symdyn.base.wording import listed, quoted
from symdyn.spec.effect_schema import EffectSchema
from symdyn.spec.inertias import Inertial, cleaned, joined, without
from symdyn.spec.monomials import value_of
from symdyn.spec.records import InertiaAbout, Joint, Link, Monomial, Placement, Robot
from symdyn.spec.rotations import Array
from symdyn.spec.urdf_chain import WHOLE, Chain, Segment
from symdyn.spec.urdf_document import UrdfInertial, UrdfLink
from symdyn.spec.urdf_reader import read_chain
from symdyn.spec.urdf_robot import DYNAMICS, aligned, bodies, build_robot, own_inertial
from symdyn.spec.xml_edit import XmlEdits
from symdyn.spec.xml_source import Element

Catalogue = Mapping[str, EffectSchema]
Values = Mapping[str, float | None]

_SAME = 1e-12  # relative: what differs by less went through turns of frames, and is kept as it is written
_ENTRIES = (("ixx", 0, 0), ("ixy", 0, 1), ("ixz", 0, 2), ("iyy", 1, 1), ("iyz", 1, 2), ("izz", 2, 2))
_EFFECTS = {effect: (attribute, key) for attribute, effect, key in DYNAMICS}


def write_back(text: str, file: str, robot: Robot, catalogue: Catalogue, chain: Chain = WHOLE) -> str:
    """The URDF text with the robot's masses, inertias and joint friction; every other byte is kept.

    ``robot`` was read from this URDF with this ``chain``, and has other numbers since. Where a link has others
    fixed to it, the change of the whole goes to the first of them that has an inertial. InputError SD421 where
    the robot is another, or has what a URDF cannot say; SD107 where a number is left free.
    """
    mark = "\ufeff" if text.startswith("\ufeff") else ""
    text = text.removeprefix("\ufeff")
    document, selected, findings = read_chain(text, file, chain)
    given = build_robot(document, selected, catalogue, findings)
    old: Values = {parameter.name: parameter.value for parameter in given.parameters}
    new: Values = {parameter.name: parameter.value for parameter in robot.parameters}
    _refuse_others(robot, given, file)
    _refuse_moved(_geometry(robot, new, file), _geometry(given, old, file), file)
    edits = XmlEdits(text)
    for segment, before, after in zip(selected.segments, given.joints, robot.joints, strict=True):
        _write_body(segment, _inertial(before.link, old, file), _inertial(after.link, new, file), edits, file)
        _write_dynamics(
            segment.joint.element, _friction(given, before, old, file), _friction(robot, after, new, file), edits
        )
    return mark + edits.apply()


def _refuse_others(robot: Robot, given: Robot, file: str) -> None:
    """SD421: what is not in the URDF's language, or not of this robot."""
    problems = []
    if [(j.name, j.kind) for j in robot.joints] != [(j.name, j.kind) for j in given.joints]:
        names = listed(quoted(joint.name) for joint in given.joints)
        problems.append(f"the joints of {quoted(robot.name)} are not those of this URDF: {names}")
    hint = "keep it as robot.toml, which says all that symdyn knows"
    for effect in robot.effects:
        if effect.type not in _EFFECTS or "." in effect.at:
            problems.append(f"a URDF cannot say {quoted(effect.type)} at {quoted(effect.at)}")
    for joint in robot.joints:
        if joint.drive is not None or joint.actuator is not None:
            problems.append(f"a URDF cannot say the drive of {quoted(joint.name)}")
    if robot.tool is not None and not robot.tool.link.mass.is_zero:
        problems.append("a URDF has no tool apart from its links")
    if problems:
        raise InputError([Problem("SD421", problem, Where(file), hint) for problem in problems])


def _geometry(robot: Robot, values: Values, file: str) -> list[Array]:
    """Numbers that a write-back cannot change: gravity, and the placement of each joint and of the base."""
    found = [np.array([_number(entry, values, file) for entry in robot.gravity])]
    for placement in (*(joint.placement for joint in robot.joints), robot.base or Placement()):
        if isinstance(placement, Placement):
            position = np.array([_number(entry, values, file) for entry in placement.position])
            found.append(np.column_stack([position, placement.rotation]))
    return found


def _refuse_moved(new: list[Array], old: list[Array], file: str) -> None:
    if len(new) != len(old) or not all(_close(a, b) for a, b in zip(new, old, strict=True)):
        message = (
            "gravity or the placement of a joint is not that of this URDF; only inertials and friction are written"
        )
        raise InputError(Problem("SD421", message, Where(file), "change the geometry in the URDF itself"))


def _write_body(segment: Segment, old: Inertial, new: Inertial, edits: XmlEdits, file: str) -> None:
    """Bring the change of a whole body to one of its links."""
    if _is_same(old, new):
        return
    found = bodies(segment)
    if not found:
        _add_inertial(segment, new, edits)
        return
    link, own = next((each for each in found if each[1].mass), found[0])
    inertial = link.inertial
    assert inertial is not None
    changed = without(new, joined(body for _, body in found if body is not own)) if len(found) > 1 else new
    place = next(place for other, place in segment.links if other is link)
    changed = changed.seen_from(_inverse(aligned(segment).T @ place))
    if changed.mass < 0:
        message = f"link {quoted(link.name)} would get a negative mass, {changed.mass:g} kg, for the links fixed to it"
        raise InputError(Problem("SD421", message, Where(file), "the whole is lighter than what it is made of"))
    _write_inertial(inertial, changed, edits)


def _write_inertial(inertial: UrdfInertial, changed: Inertial, edits: XmlEdits) -> None:
    known = own_inertial(inertial)
    element = inertial.element
    mass, origin, inertia = (element.first(name) for name in ("mass", "origin", "inertia"))
    if mass is not None and not _close(known.mass, changed.mass):
        edits.set(mass, "value", _text(changed.mass))
    if not _close(known.com, changed.com):
        xyz = " ".join(map(_text, changed.com))
        if origin is not None:
            edits.set(origin, "xyz", xyz)
        else:
            edits.add(element, "origin", {"xyz": xyz})
    if _close(known.tensor, changed.tensor):
        return
    tensor = cleaned(inertial.rotation.T @ changed.tensor @ inertial.rotation)
    if inertia is None:
        edits.add(element, "inertia", {name: _text(tensor[i, k]) for name, i, k in _ENTRIES})
        return
    size = float(np.abs(tensor).max())
    for name, i, k in _ENTRIES:
        if abs(inertial.tensor[i, k] - tensor[i, k]) > _SAME * size:
            edits.set(inertia, name, _text(tensor[i, k]))


def _add_inertial(segment: Segment, new: Inertial, edits: XmlEdits) -> None:
    link: UrdfLink = segment.links[0][0]
    body = new.seen_from(aligned(segment))
    parts = (
        f'<origin xyz="{" ".join(map(_text, body.com))}"/>',
        f'<mass value="{_text(body.mass)}"/>',
        "<inertia " + " ".join(f'{name}="{_text(body.tensor[i, k])}"' for name, i, k in _ENTRIES) + "/>",
    )
    edits.add_text(link.element, f"<inertial>{''.join(parts)}</inertial>")


def _write_dynamics(joint: Element, old: Mapping[str, float], new: Mapping[str, float], edits: XmlEdits) -> None:
    changed = {name: _text(new[name]) for name in new if not _close(old[name], new[name])}
    dynamics = joint.first("dynamics")
    if dynamics is None and changed:
        edits.add(joint, "dynamics", changed)
    elif dynamics is not None:
        for name, text in changed.items():
            edits.set(dynamics, name, text)


def _friction(robot: Robot, joint: Joint, values: Values, file: str) -> dict[str, float]:
    """Damping and friction at a joint; several effects of one kind add up."""
    total = {attribute: 0.0 for attribute, _ in _EFFECTS.values()}
    for effect in robot.effects:
        if effect.at == joint.name:
            attribute, key = _EFFECTS[effect.type]
            total[attribute] += _number(dict(effect.values)[key], values, file)
    return total


def _inertial(link: Link, values: Values, file: str) -> Inertial:
    mass, *com = (_number(entry, values, file) for entry in (link.mass, *link.com))
    xx, yy, zz, xy, xz, yz = (_number(entry, values, file) for entry in link.inertia)
    body = Inertial(mass, np.array(com), np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]))
    if link.about is InertiaAbout.COM:
        return body
    return Inertial(body.mass, body.com, 2 * body.tensor - body.about(np.zeros(3)))


def _number(monomial: Monomial, values: Values, file: str) -> float:
    value = value_of(monomial, values)
    if value is None:
        names = listed(quoted(name) for name, _ in monomial.factors)
        raise InputError(Problem("SD107", f"parameter {names} is left free", Where(file), "a URDF holds numbers"))
    return value


def _inverse(place: Array) -> Array:
    result = np.eye(4)
    result[:3, :3] = place[:3, :3].T
    result[:3, 3] = -place[:3, :3].T @ place[:3, 3]
    return result


def _is_same(old: Inertial, new: Inertial) -> bool:
    return old.mass == new.mass and np.array_equal(old.com, new.com) and np.array_equal(old.tensor, new.tensor)


def _close(old: float | Array, new: float | Array) -> bool:
    size = max(float(np.abs(old).max()), float(np.abs(new).max()))
    return bool(np.abs(np.asarray(old) - np.asarray(new)).max() <= _SAME * size)


def _text(value: float) -> str:
    return repr(float(value))
