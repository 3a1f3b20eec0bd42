"""Physical sense of a robot's numbers, as far as they are known: signs, inertias, gears, motor constants."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from symdyn.base.wording import quoted
from symdyn.spec.findings import Findings
from symdyn.spec.mass_matrix import deficient_joint
from symdyn.spec.monomials import value_of
from symdyn.spec.number_paths import number_paths
from symdyn.spec.records import InertiaAbout, Link, Monomial, Motor, Robot, Shaft
from symdyn.spec.structure import check_zero
from symdyn.spec.toml_positions import KeyPath

_NOT_NEGATIVE = frozenset({"mass", "inertia", "stiffness", "damping", "resistance", "inductance"})
_ROUNDING = 1e-6  # relative; numbers in files are printed ones
_CONSTANTS_APART = 0.2

Values = dict[str, float | None]
Tensor = npt.NDArray[np.float64]  # shape (3, 3)


def check_physics(robot: Robot, findings: Findings) -> None:
    """Add what cannot be (errors) and what is doubtful (warnings)."""
    values: Values = {parameter.name: parameter.value for parameter in robot.parameters}
    for path, monomial in number_paths(robot):
        value = value_of(monomial, values)
        if path[0] in ("joint", "tool") and path[-1] in _NOT_NEGATIVE and value is not None and value < 0:
            findings.error(path, "SD203", f"{path[-1]} is {value:g}, must not be negative")
    if robot.tool is not None:
        _check_inertia(robot.tool.link, "tool", ("tool", "inertia"), values, findings)
    places = {effect.at for effect in robot.effects}
    for i, joint in enumerate(robot.joints):
        path = ("joint", i)
        _check_inertia(joint.link, joint.name, (*path, "link", "inertia"), values, findings)
        if joint.drive is not None:
            _check_ratio(joint.drive.ratio, (*path, "drive", "ratio"), values, findings)
            for k, shaft in enumerate(joint.drive.shafts):
                held = f"{joint.name}.{shaft.name}" in places
                _check_shaft(shaft, held, (*path, "drive", "shafts", k, "stiffness"), values, findings)
            if joint.drive.motor is not None:
                _check_motor(joint.drive.motor, (*path, "drive", "motor"), values, findings)

    check_mass_matrix(robot, findings)


def check_mass_matrix(robot: Robot, findings: Findings) -> None:
    """Refuse a robot that cannot be accelerated sensibly: SD214."""
    if findings.has_errors:  # what could not be read counts as zero
        return
    found = deficient_joint(robot)
    if found is None:
        return
    name = quoted(robot.joints[found.joint].name)
    message = f"the mass matrix is singular about joint {name} in every pose: nothing there has inertia"
    hint = f"give {name}, or a link behind it, mass and inertia, or a rotor that is fixed to the joint"
    if found.is_negative:
        message = f"the mass matrix is negative about joint {name} in every pose: it would move against every push"
        hint = f"look at the inertia of {name} and of the links behind it: a principal moment is negative"
    elif all(joint.link.mass.is_zero for joint in robot.joints):
        hint = "no link of this robot has mass: is the file for display only?"
    findings.error(("joint", found.joint, "link"), "SD214", message, hint)


def _check_inertia(link: Link, name: str, path: KeyPath, values: Values, findings: Findings) -> None:
    tensor = _tensor(link, values)
    if tensor is None or not tensor.any():
        return
    doubt = doubtful_moments(tensor, name)
    if doubt is not None and doubt[0] == "SD212":
        findings.warning(path, *doubt)
        return
    written = sum(not entry.is_zero for entry in link.inertia[:3])
    if link.about is InertiaAbout.JOINT and written == 3:
        shifted = _about_com(tensor, link, values)
        if shifted is None:
            return
        moments = np.linalg.eigvalsh(shifted)
        if moments[0] < -_ROUNDING * np.trace(tensor):
            findings.warning(
                path,
                "SD213",
                f"the centre of mass of {quoted(name)} is too far out for this inertia about the joint",
                f"about its centre of mass a principal moment would be {moments[0]:g} kg m^2",
            )
            return
    elif link.about is InertiaAbout.JOINT or written < 2:
        return  # a model of one axis: only what that axis feels is given
    elif doubt is not None:
        findings.warning(path, *doubt)


def doubtful_moments(tensor: Tensor, name: str) -> tuple[str, str, str] | None:
    """(code, message, hint) for a tensor that no body has: SD212 a negative moment, SD211 one too large.

    Both are warnings, in files of every kind: published tables, public URDFs and fitted values have such tensors, and
    equations hold for them. What makes the mass matrix negative is refused (SD214).
    """
    small, middle, large = (float(moment) for moment in np.linalg.eigvalsh(tensor))
    if small < -_ROUNDING * max(abs(small), abs(large)):
        return (
            "SD212",
            f"the inertia of {quoted(name)} has a negative principal moment, {small:g} kg m^2",
            "products of inertia stand with their sign as in the matrix",
        )
    if small + middle < large * (1 - _ROUNDING):
        return (
            "SD211",
            f"no body has the principal moments of {quoted(name)}: {small:.4g} + {middle:.4g} < {large:.4g} kg m^2,"
            f" by {100 * (1 - (small + middle) / large):.2g} %",
            "each is at most the sum of the other two",
        )
    return None


def _tensor(link: Link, values: Values) -> Tensor | None:
    entries = [value_of(entry, values) for entry in link.inertia]
    known = [entry for entry in entries if entry is not None and math.isfinite(entry)]
    if len(known) < len(entries):
        return None
    xx, yy, zz, xy, xz, yz = known
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def _about_com(tensor: Tensor, link: Link, values: Values) -> Tensor | None:
    """Huygens-Steiner: from the joint to the centre of mass."""
    mass = value_of(link.mass, values)
    coordinates = [value_of(coordinate, values) for coordinate in link.com]
    known = [coordinate for coordinate in coordinates if coordinate is not None]
    if mass is None or len(known) < len(coordinates):
        return None
    com = np.array(known)
    with np.errstate(over="ignore", invalid="ignore"):
        shifted: Tensor = tensor - mass * (com @ com * np.eye(3) - np.outer(com, com))
    return shifted if np.isfinite(shifted).all() else None


def _check_ratio(ratio: Monomial, path: KeyPath, values: Values, findings: Findings) -> None:
    value = value_of(ratio, values)
    if value == 0:
        findings.error(path, "SD231", "the gear ratio is 0", "motor turns per joint turn; 1 where there is no gear")
    elif value is not None and abs(value) < 1:
        findings.warning(
            path,
            "SD231",
            f"the gear ratio is {value:g}: the joint turns faster than its motor",
            f"ratio is motor turns per joint turn; {1 / value:.6g}?",
        )


def _check_shaft(shaft: Shaft, held: bool, path: KeyPath, values: Values, findings: Findings) -> None:
    """``held``: by an effect at the shaft, such as the friction of a clutch."""
    if held or value_of(shaft.stiffness, values) != 0:
        return
    name, ends = quoted(shaft.name), f"{quoted(shaft.start)} and {quoted(shaft.end)}"
    hint = "a shaft that is stiff beside the others is left out: fix the rotor to the joint (fixed_to_joint = true)"
    if value_of(shaft.damping, values) == 0:
        findings.error(path, "SD203", f"the stiffness of {name} is 0: nothing holds {ends} together", hint)
    else:
        findings.warning(path, "SD203", f"the stiffness of {name} is 0: {ends} may turn apart for ever", hint)


def _check_motor(motor: Motor, path: KeyPath, values: Values, findings: Findings) -> None:
    inductance = value_of(motor.inductance, values)
    check_zero("inductance", motor.inductance, inductance, (*path, "inductance"), findings)
    if motor.inductance.is_zero and value_of(motor.resistance, values) == 0:
        findings.error(
            (*path, "resistance"), "SD203", "a circuit needs a resistance or an inductance", "both of this motor are 0"
        )
    torque, back_emf = (value_of(constant, values) for constant in (motor.torque_constant, motor.back_emf_constant))
    if torque is None or back_emf is None or not torque or not back_emf:
        return
    apart = abs(torque - back_emf) / max(abs(torque), abs(back_emf))
    if apart > _CONSTANTS_APART:
        findings.warning(
            (*path, "back_emf_constant"),
            "SD232",
            f"torque constant {torque:g} and back-EMF constant {back_emf:g} are {100 * apart:.0f} % apart in SI units",
            "an ideal motor has them equal; is one of them per rpm, or per thousand rpm?",
        )
