"""The robot as frozen data: what a TOML file says, checked, in SI units, with named parameters."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum
from fractions import Fraction
from html import escape

from symdyn.base.errors import Where


class Motion(StrEnum):
    """What a place moves in; it decides the units of the effects attached there."""

    ROTATIONAL = "rotational"
    TRANSLATIONAL = "translational"
    ELECTRICAL = "electrical"


class PlaceKind(StrEnum):
    """Where an effect may attach."""

    JOINT = "joint"
    INERTIA = "inertia"
    SHAFT = "shaft"
    CIRCUIT = "circuit"


@dataclass(frozen=True, slots=True)
class Place:
    """An address in the robot: ``"axis1"`` (a joint) or ``"axis1.motor"`` (an element of its drive)."""

    address: str
    kind: PlaceKind
    motion: Motion


@dataclass(frozen=True, slots=True)
class Parameter:
    """A named number in SI units; ``value`` is None when it is left free (symbolic)."""

    name: str
    value: float | None
    unit: str
    latex: str
    meaning: str = ""
    where: Where | None = None


@dataclass(frozen=True, slots=True)
class Monomial:
    """``coefficient * product(parameter ** power)``: every number of a robot, as written in its file.

    A structural zero has coefficient 0 and no factors; a plain number that is no parameter (a DH
    twist of 90 degrees) has no factors either.
    """

    coefficient: Fraction | float
    factors: tuple[tuple[str, int], ...] = ()

    @property
    def is_zero(self) -> bool:
        return self.coefficient == 0


ZERO = Monomial(Fraction(0))
ONE = Monomial(Fraction(1))


class JointKind(StrEnum):
    REVOLUTE = "revolute"
    PRISMATIC = "prismatic"


class Convention(StrEnum):
    """Denavit-Hartenberg: standard (frame at the link's far end) or modified (Craig; at its near end)."""

    STANDARD = "standard"
    MODIFIED = "modified"


@dataclass(frozen=True, slots=True)
class DHRow:
    """One row of a DH table; the column of the joint variable holds its offset."""

    theta: Monomial
    d: Monomial
    a: Monomial
    alpha: Monomial


Three = tuple[float, float, float]
Rotation = tuple[Three, Three, Three]
IDENTITY: Rotation = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


@dataclass(frozen=True, slots=True)
class Placement:
    """A frame fixed in another: ``position`` of its origin there, ``rotation`` from its axes to the other's.

    A joint so placed turns about, or slides along, the z axis of this frame; its link's frame is the
    frame moved with it. Entries of ``rotation`` that are 0 or +-1 are exactly so.
    """

    position: tuple[Monomial, Monomial, Monomial] = (ZERO, ZERO, ZERO)
    rotation: Rotation = IDENTITY


class InertiaAbout(StrEnum):
    COM = "com"
    JOINT = "joint"  # the origin of the link's frame, axes parallel to it


@dataclass(frozen=True, slots=True)
class Link:
    """Inertial parameters in the link's frame: mass, centre of mass, inertia tensor entries.

    ``inertia`` is (xx, yy, zz, xy, xz, yz): entries of the tensor (products with their sign as in
    the matrix), about the centre of mass or about the frame's origin.
    """

    mass: Monomial = ZERO
    com: tuple[Monomial, Monomial, Monomial] = (ZERO, ZERO, ZERO)
    inertia: tuple[Monomial, Monomial, Monomial, Monomial, Monomial, Monomial] = (ZERO,) * 6
    about: InertiaAbout = InertiaAbout.COM


@dataclass(frozen=True, slots=True)
class Rotor:
    """A lumped inertia of a drive train; ``fixed_to_joint``: it has no coordinate of its own."""

    name: str
    inertia: Monomial
    fixed_to_joint: bool = False


JOINT_END = "joint"  # the name by which a shaft or motor refers to the link side of its drive


@dataclass(frozen=True, slots=True)
class Shaft:
    """A spring and damper between two rotors (or the joint), seed fig. 6: c_i and d_i."""

    name: str
    start: str
    end: str
    stiffness: Monomial
    damping: Monomial


@dataclass(frozen=True, slots=True)
class Motor:
    """Permanent-magnet d.c. motor (seed fig. 5): the circuit, and the rotor that its torque acts on."""

    name: str
    at: str
    resistance: Monomial
    inductance: Monomial
    torque_constant: Monomial
    back_emf_constant: Monomial


@dataclass(frozen=True, slots=True)
class Drive:
    """A drive train: rotors and shafts in motor-side coordinates, ``ratio`` motor turns per joint turn.

    ``effort_at``: the rotor on which the effort of a joint without a motor acts; "": on the joint itself.
    """

    ratio: Monomial
    rotors: tuple[Rotor, ...]
    shafts: tuple[Shaft, ...]
    motor: Motor | None
    effort_at: str = ""


@dataclass(frozen=True, slots=True)
class Actuator:
    """A proportional actuator at the joint: effort = gain * input."""

    gain: Monomial
    input_unit: str  # "V", "A", ...


@dataclass(frozen=True, slots=True)
class Limits:
    """What a joint can do, in SI units: range, speed, effort; None: not given. The dynamics do not use them."""

    lower: float | None = None
    upper: float | None = None
    velocity: float | None = None
    effort: float | None = None


@dataclass(frozen=True, slots=True)
class Joint:
    """A joint and the link behind it, placed by a DH row or by a fixed placement in the previous link's frame."""

    name: str
    kind: JointKind
    placement: DHRow | Placement
    link: Link
    drive: Drive | None = None
    actuator: Actuator | None = None
    limits: Limits | None = None
    description: str = ""
    passive: bool = False  # nothing drives it: a bending link, a swing


@dataclass(frozen=True, slots=True)
class Tool:
    """What the last link carries: a frame fixed to it, and the body in that frame (massless: the frame alone)."""

    placement: Placement = Placement()
    link: Link = Link()


@dataclass(frozen=True, slots=True)
class EffectSpec:
    """An effect named at a place, with its parameter values (in the order of its declaration)."""

    type: str
    at: str
    values: tuple[tuple[str, Monomial], ...]
    where: Where | None = None


class Quantity(StrEnum):
    """What a channel of a recording measures."""

    POSITION = "position"
    VELOCITY = "velocity"
    EFFORT = "effort"  # torque or force
    VOLTAGE = "voltage"
    CURRENT = "current"
    REFERENCE = "reference"  # what a servo loop is asked to follow
    PARAMETER = "parameter"  # of the model, known: a load that one run has and another has not


class Side(StrEnum):
    LINK = "link"
    MOTOR = "motor"
    OUTPUT = "output"  # between a drive and its joint: what a torque sensor there shows


@dataclass(frozen=True, slots=True)
class Channel:
    """One column of a recording: SI value = sign * scale * factor(unit) * column."""

    column: str
    quantity: Quantity
    joint: str  # or the parameter's name
    side: Side
    unit: str
    factor: float  # of the unit, to SI
    scale: float = 1.0
    sign: int = 1
    where: Where | None = None


@dataclass(frozen=True, slots=True)
class ChannelMap:
    """Which column is time, and what each other column measures."""

    time_column: str
    time_factor: float
    channels: tuple[Channel, ...]
    where: Where | None = None
    time_unit: str = "s"


@dataclass(frozen=True, slots=True)
class Robot:
    """A serial robot with its drives: the one input of every derivation.

    ``base`` places the frame that the first joint is placed in; None: that is the world's frame.
    """

    name: str
    description: str
    convention: Convention
    gravity: tuple[Monomial, Monomial, Monomial]  # acceleration of gravity in the world frame
    joints: tuple[Joint, ...]
    effects: tuple[EffectSpec, ...]
    parameters: tuple[Parameter, ...]
    channels: ChannelMap | None = None
    text: str = field(default="", repr=False)  # the TOML it was read from: a diagnosis edits this, comments kept
    where: Where | None = None
    base: Placement | None = None
    tool: Tool | None = None

    def _repr_markdown_(self) -> str:
        """What a notebook shows: the joints in a table."""
        rows = [
            f"| {joint.name} | {joint.kind} | {'yes' if joint.drive else 'no'} | "
            f"{', '.join(e.type for e in self.effects if e.at.partition('.')[0] == joint.name)} |"
            for joint in self.joints
        ]
        head = ["| joint | kind | drive | effects |", "| --- | --- | --- | --- |"]
        return "\n".join([f"**{self.name}**: {escape(self.description)}", "", *head, *rows, ""])
