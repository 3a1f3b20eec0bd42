"""The mass matrix of a robot's links as numbers, by Jacobians: enough to see whether it is positive definite."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from symdyn.spec.monomials import value_of
from symdyn.spec.records import Convention, InertiaAbout, Joint, JointKind, Link, Monomial, Placement, Robot

Array = npt.NDArray[np.float64]
Values = Mapping[str, float | None]

_TINY = 1e-12  # of the largest; below, an inertia is rounding
_DEPENDENT = 1e-10  # of the scaled matrix, the smallest eigenvalue of a singular one
_POSES = 3
_POSITION = ("com_x", "com_y", "com_z")


@dataclass(frozen=True, slots=True)
class Deficiency:
    """A joint about which there is no inertia, or a negative one."""

    joint: int
    is_negative: bool


def deficient_joint(robot: Robot) -> Deficiency | None:
    """Where the mass matrix is not positive definite in any pose, None where it is in one or numbers are free.

    The links' inertia and the rotors fixed to a joint count, and effects that add inertia there.
    """
    values: Values = {parameter.name: parameter.value for parameter in robot.parameters}
    if any(value is None or not np.isfinite(value) for value in values.values()):
        return None
    poses = np.random.default_rng(0).uniform(-1.5, 1.5, (_POSES, len(robot.joints)))
    added = np.diag([_added(robot, joint, values) for joint in robot.joints])
    with np.errstate(all="ignore"):
        found = [_deficient(mass_matrix(robot, pose, values) + added) for pose in poses]
    return found[0] if None not in found else None


def mass_matrix(robot: Robot, q: Array, values: Values) -> Array:
    """(n, n) of the links, what they carry, and the tool, without drives."""
    n = len(robot.joints)
    total = np.zeros((n, n))
    spins, slides, arms = np.zeros((3, n)), np.zeros((3, n)), np.zeros((3, n))
    frame = np.eye(4)
    for i, joint in enumerate(robot.joints):
        before, after = _steps(joint, robot.convention, float(q[i]), values)
        axis_frame = frame @ before
        frame = axis_frame @ after
        turns = joint.kind is JointKind.REVOLUTE
        (spins if turns else slides)[:, i] = axis_frame[:3, 2]
        arms[:, i] = axis_frame[:3, 3]
        bodies = [(joint.link, frame), *((link, frame) for link in _carried(robot, joint))]
        if robot.tool is not None and i == n - 1:
            bodies.append((robot.tool.link, frame @ _placed(robot.tool.placement, values)))
        for link, at in bodies:
            total += _of_body(link, at, spins, slides, arms, values)
    return total


def _of_body(link: Link, frame: Array, spins: Array, slides: Array, arms: Array, values: Values) -> Array:
    mass, com = _number(link.mass, values), np.array([_number(c, values) for c in link.com])
    xx, yy, zz, xy, xz, yz = (_number(entry, values) for entry in link.inertia)
    tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    if link.about is InertiaAbout.JOINT:
        tensor = tensor - mass * (com @ com * np.eye(3) - np.outer(com, com))
    rotation, centre = frame[:3, :3], frame[:3, :3] @ com + frame[:3, 3]
    linear = slides + np.cross(spins, centre[:, None] - arms, axis=0)
    result: Array = mass * linear.T @ linear + spins.T @ rotation @ tensor @ rotation.T @ spins
    return result


def _deficient(matrix: Array) -> Deficiency | None:
    """The coordinate that the matrix fails to be positive definite about."""
    scale = np.abs(np.diag(matrix))
    if not np.isfinite(matrix).all():
        return None
    if scale.min() <= _TINY * scale.max():
        return Deficiency(int(scale.argmin()), False)
    eigenvalues, vectors = np.linalg.eigh(matrix / np.sqrt(np.outer(scale, scale)))
    if eigenvalues[0] >= _DEPENDENT:
        return None
    return Deficiency(int(np.abs(vectors[:, 0]).argmax()), bool(eigenvalues[0] <= -_DEPENDENT))


def _steps(joint: Joint, convention: Convention, q: float, values: Values) -> tuple[Array, Array]:
    """From the previous frame to one whose z is the joint's axis, from there to the link's frame."""
    place = joint.placement
    turns = joint.kind is JointKind.REVOLUTE
    moved = _along(2, q if turns else 0.0, 0.0 if turns else q)
    if isinstance(place, Placement):
        return _placed(place, values), moved
    theta, d, a, alpha = (_number(entry, values) for entry in (place.theta, place.d, place.a, place.alpha))
    about_z, about_x = _along(2, theta, d) @ moved, _along(0, alpha, a)
    return (np.eye(4), about_z @ about_x) if convention is Convention.STANDARD else (about_x, about_z)


def _along(axis: int, angle: float, distance: float) -> Array:
    """A screw: turn about and step along x (0) or z (2)."""
    matrix = np.eye(4)
    first, second = (axis + 1) % 3, (axis + 2) % 3
    matrix[first, first] = matrix[second, second] = np.cos(angle)
    matrix[second, first] = np.sin(angle)
    matrix[first, second] = -np.sin(angle)
    matrix[axis, 3] = distance
    return matrix


def _placed(placement: Placement, values: Values) -> Array:
    matrix = np.eye(4)
    matrix[:3, :3] = placement.rotation
    matrix[:3, 3] = [_number(entry, values) for entry in placement.position]
    return matrix


def _added(robot: Robot, joint: Joint, values: Values) -> float:
    """Inertia that acts at the joint itself: of rotors fixed to it, through the ratio, and of effects there."""
    total = sum(
        _number(value, values) for e in robot.effects if e.at == joint.name for k, value in e.values if k == "inertia"
    )
    if joint.drive is not None:
        ratio = _number(joint.drive.ratio, values)
        total += ratio**2 * sum(_number(r.inertia, values) for r in joint.drive.rotors if r.fixed_to_joint)
    return total


def _carried(robot: Robot, joint: Joint) -> Iterator[Link]:
    """The point masses that effects put on the link: those with a mass and its position."""
    for declared in robot.effects:
        given = dict(declared.values)
        if declared.at == joint.name and {"mass", *_POSITION} <= given.keys():
            x, y, z = (given[name] for name in _POSITION)
            yield Link(given["mass"], (x, y, z))


def _number(monomial: Monomial, values: Values) -> float:
    value = value_of(monomial, values)
    return 0.0 if value is None else value
