"""The arms that are compared: rigid bodies alone, as symdyn's robots and as plain numbers for the others."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from symdyn.compiler import load_robot
from symdyn.spec.monomials import value_of
from symdyn.spec.number_paths import number_paths
from symdyn.spec.records import Convention, DHRow, InertiaAbout, JointKind, Link, Monomial, Robot

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Arm:
    """A serial arm of revolute joints without drives and effects."""

    robot: Robot

    @property
    def name(self) -> str:
        return self.robot.name

    @property
    def joints(self) -> int:
        return len(self.robot.joints)

    @cached_property
    def gravity(self) -> Array:
        return np.array([self._value(g) for g in self.robot.gravity])

    @cached_property
    def numbers(self) -> Array:
        """(n, 22), a row per joint, as chain.hpp reads them: every joint turns about z of its placement."""
        rows, reached = [], np.eye(4)  # reached: the last link's frame, seen from the last joint
        for joint in self.robot.joints:
            row = joint.placement
            if not isinstance(row, DHRow) or joint.kind is not JointKind.REVOLUTE:
                raise ValueError(f"{self.name}, {joint.name}: only revolute joints in DH rows are compared")
            theta, d, a, alpha = (self._value(m) for m in (row.theta, row.d, row.a, row.alpha))
            along_z, along_x = _screw(2, theta, d), _screw(0, alpha, a)
            standard = self.robot.convention is Convention.STANDARD
            before, after = (np.eye(4), along_z @ along_x) if standard else (along_x @ along_z, np.eye(4))
            placement = reached @ before
            rows.append([*placement[:3, :3].ravel(), *placement[:3, 3], *self._body(joint.link, after)])
            reached = after
        return np.array(rows)

    def pin_model(self, pin: Any) -> Any:
        """The same numbers as a model of Pinocchio's wheel."""
        model = pin.Model()
        model.gravity.linear = self.gravity
        parent = 0
        for i, row in enumerate(self.numbers, 1):
            placement = pin.SE3(row[:9].reshape(3, 3), row[9:12])
            parent = model.addJoint(parent, pin.JointModelRZ(), placement, f"joint{i}")
            xx, xy, yy, xz, yz, zz = row[16:]
            inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
            model.appendBodyToJoint(parent, pin.Inertia(row[12], row[13:16], inertia), pin.SE3.Identity())
        return model

    def _body(self, link: Link, frame: Array) -> list[float]:
        """Mass, centre of mass, inertia about it, in the joint's frame, from which the link's is seen."""
        mass, com = self._value(link.mass), np.array([self._value(c) for c in link.com])
        xx, yy, zz, xy, xz, yz = (self._value(entry) for entry in link.inertia)
        tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        if link.about is InertiaAbout.JOINT:
            tensor = tensor - mass * (com @ com * np.eye(3) - np.outer(com, com))
        turn = frame[:3, :3]
        t = turn @ tensor @ turn.T
        return [mass, *(turn @ com + frame[:3, 3]), t[0, 0], t[0, 1], t[1, 1], t[0, 2], t[1, 2], t[2, 2]]

    @cached_property
    def _values(self) -> Mapping[str, float | None]:
        return {p.name: p.value for p in self.robot.parameters}

    def _value(self, monomial: Monomial) -> float:
        value = value_of(monomial, self._values)
        if value is None:
            raise ValueError(f"{self.name} has parameters without a value")
        return value


def bundled(name: str) -> Arm:
    """A bundled machine without its drives, friction and whatever parameters only these have."""
    robot = load_robot(name)
    rigid = replace(robot, joints=tuple(replace(j, drive=None) for j in robot.joints), effects=(), channels=None)
    used = {factor for _, monomial in number_paths(rigid) for factor, _ in monomial.factors}
    return Arm(replace(rigid, parameters=tuple(p for p in robot.parameters if p.name in used)))


def generic(joints: int) -> Arm:
    """A random arm in which no number is zero and no axes are parallel; the same one every time."""
    rng = np.random.default_rng(joints)
    template = load_robot("panda")
    made = []
    for i in range(joints):
        theta, d, a, alpha, mass, *com = (Monomial(float(v)) for v in rng.uniform(0.1, 1.0, 8))
        spread = rng.uniform(-0.3, 0.3, (3, 3))
        tensor = spread @ spread.T + 0.1 * np.eye(3)
        entries = (tensor[0, 0], tensor[1, 1], tensor[2, 2], tensor[0, 1], tensor[0, 2], tensor[1, 2])
        x, y, z = com
        link = Link(mass, (x, y, z), tuple(Monomial(float(e)) for e in entries), InertiaAbout.COM)  # type: ignore[arg-type]
        row = DHRow(theta, d, a, alpha)
        made.append(replace(template.joints[0], name=f"joint{i + 1}", placement=row, link=link))
    gravity = (Monomial(0.0), Monomial(0.0), Monomial(-9.81))
    text = f"generic{joints}"
    return Arm(replace(template, name=text, joints=tuple(made), parameters=(), gravity=gravity, text=text, where=None))


def _screw(axis: int, angle: float, distance: float) -> Array:
    """Turn about an axis and shift along it, (4, 4); quarter turns are exact."""
    found, (i, j) = np.eye(4), ((axis + 1) % 3, (axis + 2) % 3)
    quarters = angle / (math.pi / 2)
    exact = math.isclose(quarters, round(quarters), abs_tol=1e-12)
    c, s = ((1, 0), (0, 1), (-1, 0), (0, -1))[round(quarters) % 4] if exact else (math.cos(angle), math.sin(angle))
    found[i, i], found[i, j], found[j, i], found[j, j] = c, -s, s, c
    found[axis, 3] = distance
    return found
