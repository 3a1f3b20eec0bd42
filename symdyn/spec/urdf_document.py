"""A URDF as records, element by element: its links and joints, in their own frames, before any tree is made of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from symdyn.base.wording import did_you_mean, quoted
from symdyn.spec.findings import Findings
from symdyn.spec.records import Limits
from symdyn.spec.rotations import Array, from_rpy
from symdyn.spec.urdf_values import UrdfValues
from symdyn.spec.xml_source import Element, XmlSource, at

MOVING = ("revolute", "continuous", "prismatic")
KINDS = (*MOVING, "fixed", "floating", "planar")
_RIGHT_ANGLE = np.pi / 2
_ENTRIES = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
_PRODUCTS = _ENTRIES[3:]
NOWHERE = (0.0, 0.0, 0.0)

Item = TypeVar("Item")


@dataclass(frozen=True, eq=False)
class UrdfInertial:
    """Mass, centre of mass (3,) in the link's frame, tensor (3, 3) about it in the axes ``rotation`` (3, 3)."""

    element: Element
    mass: float
    com: Array
    rotation: Array
    tensor: Array


@dataclass(frozen=True, eq=False)
class UrdfLink:
    name: str
    element: Element
    inertial: UrdfInertial | None


@dataclass(frozen=True, eq=False)
class UrdfJoint:
    """``origin`` (4, 4) places the joint, and the child at zero, in the parent; ``axis`` (3,) is a unit vector."""

    name: str
    kind: str
    parent: str
    child: str
    element: Element
    origin: Array
    axis: Array
    limits: Limits | None
    damping: float
    friction: float
    mimics: str | None


@dataclass(frozen=True, eq=False)
class UrdfDocument:
    source: XmlSource
    name: str
    links: dict[str, UrdfLink]
    joints: dict[str, UrdfJoint]


def read_document(source: XmlSource, findings: Findings) -> UrdfDocument | None:
    """The links and joints of a file; None where its root is no <robot>. What is wrong is added to the findings."""
    root, values = source.root, UrdfValues(findings)
    if root.name != "robot":
        hint = "MJCF and SDF are not read" if root.name in ("mujoco", "sdf") else ""
        findings.error(at(root), "SD416", f"the root is <{root.name}>, expected <robot>", hint)
        return None
    for element in root.walk():
        if element.name.startswith("xacro:"):
            hint = "name the file .urdf.xacro and install symdyn[xacro], or expand it: xacro file.xacro > file.urdf"
            findings.error(at(element), "SD405", f"<{element.name}> is xacro, which is not expanded", hint)
            return None
    name = root.attributes.get("name")
    return UrdfDocument(
        source,
        name.value if name is not None else "",
        _by_name(root.all("link"), values, _read_link),
        _by_name(root.all("joint"), values, _read_joint),
    )


def _by_name(
    elements: tuple[Element, ...], values: UrdfValues, read: Callable[[str, Element, UrdfValues], Item | None]
) -> dict[str, Item]:
    found: dict[str, Item] = {}
    places: dict[str, Element] = {}
    for element in elements:
        name = values.text(element, "name")
        if name is None:
            continue
        if name in places:
            there = values.findings.where(at(places[name].attributes["name"]))
            values.findings.error(
                at(element.attributes["name"]),
                "SD406",
                f"{element.name} {quoted(name)} is there twice, first at {there}",
            )
            continue
        places[name] = element
        item = read(name, element, values)
        if item is not None:
            found[name] = item
    return found


def _read_link(name: str, element: Element, values: UrdfValues) -> UrdfLink:
    inertial = only_child(element, "inertial", values.findings)
    return UrdfLink(name, element, _read_inertial(inertial, values) if inertial is not None else None)


def _read_inertial(element: Element, values: UrdfValues) -> UrdfInertial | None:
    findings = values.findings
    origin = only_child(element, "origin", findings)
    mass_element, inertia = (only_child(element, name, findings) for name in ("mass", "inertia"))
    if mass_element is None:
        findings.error(at(element), "SD411", "<inertial> has no <mass>", '<mass value="1.5"/>')
        return None
    mass = values.number(mass_element, "value")
    if mass < 0:
        findings.error(at(mass_element.attributes["value"]), "SD203", f"mass is {mass:g}, must not be negative")
    entries = dict.fromkeys(_ENTRIES, 0.0)
    if inertia is None:
        findings.warning(at(element), "SD410", "<inertial> has no <inertia>: taken as a point mass")
    else:
        entries = {e: values.number(inertia, e, 0.0 if e in _PRODUCTS else None) for e in _ENTRIES}
    xx, yy, zz, xy, xz, yz = entries.values()
    tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return UrdfInertial(element, mass, values.three(origin, "xyz", NOWHERE), _rotation(origin, values), tensor)


def _read_joint(name: str, element: Element, values: UrdfValues) -> UrdfJoint | None:
    findings = values.findings
    kind = values.text(element, "type")
    ends = [_end(element, end, values) for end in ("parent", "child")]
    if kind is not None and kind not in KINDS:
        hint = did_you_mean(kind, KINDS, "types")
        findings.error(at(element.attributes["type"]), "SD407", f"no joint type {quoted(kind)}", hint)
        return None
    parent, child = ends
    if kind is None or parent is None or child is None:
        return None
    origin = only_child(element, "origin", findings)
    transform = np.eye(4)
    transform[:3, :3], transform[:3, 3] = _rotation(origin, values), values.three(origin, "xyz", NOWHERE)
    dynamics, mimic = (only_child(element, tag, findings) for tag in ("dynamics", "mimic"))
    mimicked = mimic.attributes.get("joint") if mimic is not None else None
    return UrdfJoint(
        name,
        kind,
        parent,
        child,
        element,
        transform,
        _axis(element, kind, values),
        _limits(element, kind, values) if kind in MOVING else None,
        _not_negative(dynamics, "damping", values),
        _not_negative(dynamics, "friction", values),
        None if mimic is None else mimicked.value if mimicked is not None else "",
    )


def _end(element: Element, end: str, values: UrdfValues) -> str | None:
    found = only_child(element, end, values.findings)
    if found is None:
        values.findings.error(at(element), "SD411", f"<joint> has no <{end}>", f'<{end} link="..."/>')
        return None
    return values.text(found, "link")


def _axis(element: Element, kind: str, values: UrdfValues) -> Array:
    found = only_child(element, "axis", values.findings)
    axis = values.three(found, "xyz", (1.0, 0.0, 0.0))
    length = float(np.linalg.norm(axis))
    if length == 0 and found is not None and kind in MOVING:
        blamed = found.attributes["xyz"]
        values.findings.error(at(blamed), "SD408", "the axis is zero", 'a direction in the joint\'s frame: "0 0 1"')
    unit: Array = axis / length if length else np.array([0.0, 0.0, 1.0])
    return unit


def _limits(element: Element, kind: str, values: UrdfValues) -> Limits | None:
    found = only_child(element, "limit", values.findings)
    if found is None:
        return None
    given = {
        key: values.number(found, key, unlimited=True)
        for key in ("lower", "upper", "velocity", "effort")
        if key in found.attributes
    }
    for key in ("velocity", "effort"):
        if given.get(key, 0.0) < 0:
            blamed = at(found.attributes[key])
            values.findings.error(blamed, "SD409", f"{key} is {given[key]:g}, must not be negative")
    ranged = kind != "continuous" and ("lower" in given or "upper" in given)
    lower, upper = (given.get(key, 0.0) if ranged else None for key in ("lower", "upper"))  # URDF: 0 if left out
    if lower is not None and upper is not None and lower > upper:
        blamed = at(found.attributes.get("lower", found))
        values.findings.error(blamed, "SD409", f"the lower limit {lower:g} is above the upper limit {upper:g}")
    finite = [
        None if v is None or not np.isfinite(v) else v
        for v in (lower, upper, given.get("velocity"), given.get("effort"))
    ]
    return Limits(*finite) if any(v is not None for v in finite) else None


def _not_negative(element: Element | None, name: str, values: UrdfValues) -> float:
    value = values.number(element, name, 0.0) if element is not None else 0.0
    if element is not None and value < 0:
        values.findings.error(at(element.attributes[name]), "SD203", f"{name} is {value:g}, must not be negative")
    return value


def _rotation(origin: Element | None, values: UrdfValues) -> Array:
    angles = values.three(origin, "rpy", NOWHERE)
    apart = np.abs(angles - np.round(angles / _RIGHT_ANGLE) * _RIGHT_ANGLE)
    if origin is not None and ((apart > 1e-9) & (apart < 1e-3)).any():
        values.findings.warning(
            at(origin.attributes["rpy"]),
            "SD413",
            f"rpy {quoted(origin.attributes['rpy'].value)} is nearly a right angle, and is kept as it is",
            "write 1.5707963267948966: exact zeros and ones make the equations shorter",
        )
    return from_rpy(*angles)


def only_child(element: Element, name: str, findings: Findings) -> Element | None:
    """The child of that name, if there is one; a second one is an error."""
    found = element.all(name)
    if len(found) > 1:
        findings.error(at(found[1]), "SD406", f"<{element.name}> has two <{name}>")
    return found[0] if found else None
