"""The shape of a robot's TOML file: which tables and keys it may hold, and their types."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, PlainValidator, model_validator
from pydantic_core import PydanticCustomError

from symdyn.spec.records import Quantity, Side

Scalar = int | float | str


# error types of the validators below, and their codes
OWN_ERRORS = {"no_number": "SD202", "not_finite": "SD201", "no_text": "SD202", "no_sign": "SD202"}
NUMBER_ERRORS = ("no_number", "not_finite")


def _number(value: object) -> Scalar:
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        expected = 'expected a number, "number unit" or a parameter, found {kind}'
        raise PydanticCustomError("no_number", expected, _kind(value))
    if not isinstance(value, str):
        _require_finite(value)
    return value


def _finite(value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise PydanticCustomError("no_number", "expected a plain number, found {kind}", _kind(value))
    _require_finite(value)
    return float(value)


def _text(value: object) -> str:
    if not isinstance(value, str):
        raise PydanticCustomError("no_text", "expected a text, found {kind}", _kind(value))
    if not value.isprintable():
        raise PydanticCustomError("no_text", "a text stands on one line, without control characters")
    return value


def _sign(value: object) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or value not in (1, -1):
        raise PydanticCustomError("no_sign", "expected 1 or -1")
    return value


def _require_finite(value: float) -> None:
    try:
        finite = math.isfinite(value)
    except OverflowError:  # an integer beyond the largest float
        finite = False
    if not finite:
        raise PydanticCustomError("not_finite", "a number must be finite")


def _kind(value: object) -> dict[str, Any]:
    kinds = {bool: "a boolean", int: "an integer", float: "a number", str: "a text", list: "an array", dict: "a table"}
    return {"kind": kinds.get(type(value), "a date or time")}


Number = Annotated[Scalar, PlainValidator(_number)]  # SI, "number unit", or a monomial over [parameters]
Finite = Annotated[float, PlainValidator(_finite)]
Text = Annotated[str, PlainValidator(_text)]
Sign = Annotated[int, PlainValidator(_sign)]
ThreeNumbers = Annotated[list[Number], Field(min_length=3, max_length=3)]
ThreeFinite = Annotated[list[Finite], Field(min_length=3, max_length=3)]


class _Table(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class RobotTable(_Table):
    name: Text
    description: Text = ""
    gravity: ThreeNumbers


class ParameterEntry(_Table):
    """``12``, ``"12 kg"``, ``{ value = .., unit = .., latex = .., meaning = .. }``, or ``{ free = "kg" }``."""

    value: Number | None = None
    unit: Text | None = None
    free: Text | None = None
    latex: Text | None = None
    meaning: Text = ""

    @model_validator(mode="before")
    @classmethod
    def _bare_value(cls, entry: object) -> object:
        return entry if isinstance(entry, dict) else {"value": entry}


class DHTable(_Table):
    convention: Literal["standard", "modified"] = "standard"
    rows: list[list[Number]]


class PlacementTable(_Table):
    """``xyz`` with either ``rpy`` or the ``rotation`` matrix."""

    xyz: ThreeNumbers = [0, 0, 0]
    rpy: ThreeNumbers | None = None
    rotation: Annotated[list[ThreeFinite], Field(min_length=3, max_length=3)] | None = None


class BaseTable(_Table):
    placement: PlacementTable


class InertiaTable(_Table):
    about: Literal["com", "joint"] = "com"
    xx: Number = 0
    yy: Number = 0
    zz: Number = 0
    xy: Number = 0
    xz: Number = 0
    yz: Number = 0


class LinkTable(_Table):
    mass: Number = 0
    com: ThreeNumbers = [0, 0, 0]
    inertia: InertiaTable = InertiaTable()


class ToolTable(LinkTable):
    placement: PlacementTable = PlacementTable()


class RotorTable(_Table):
    name: Text
    inertia: Number
    fixed_to_joint: bool = False


class ShaftTable(_Table):
    name: Text
    start: Text = Field(alias="from")
    end: Text = Field(alias="to")
    stiffness: Number
    damping: Number = 0


class MotorTable(_Table):
    name: Text
    at: Text
    resistance: Number
    inductance: Number = 0  # neglected: the current is no state
    torque_constant: Number
    back_emf_constant: Number


class DriveTable(_Table):
    ratio: Number = 1
    rotors: list[RotorTable] = []
    shafts: list[ShaftTable] = []
    motor: MotorTable | None = None
    effort_at: Text | None = None


class ActuatorTable(_Table):
    gain: Number


class LimitsTable(_Table):
    lower: Number | None = None
    upper: Number | None = None
    velocity: Number | None = None
    effort: Number | None = None


class JointTable(_Table):
    name: Text
    description: Text = ""
    kind: Literal["revolute", "prismatic"] | None = None
    placement: PlacementTable | None = None
    link: LinkTable = LinkTable()
    drive: DriveTable | None = None
    actuator: ActuatorTable | None = None
    limits: LimitsTable | None = None
    passive: bool = False


class EffectTable(_Table):
    """``type``, ``at``, and the parameters of that type of effect as further keys."""

    model_config = ConfigDict(extra="allow")
    __pydantic_extra__: dict[str, Number] = Field(init=False)

    type: Text
    at: Text


class TimeTable(_Table):
    column: Text
    unit: Text


class ChannelTable(_Table):
    column: Text
    quantity: Literal[*(quantity.value for quantity in Quantity)]  # type: ignore[valid-type]
    joint: Text = ""
    parameter: Text = ""
    side: Literal[*(side.value for side in Side)] = "link"  # type: ignore[valid-type]
    unit: Text
    scale: Finite = 1.0
    sign: Sign = 1


class RecordingTable(_Table):
    time: TimeTable
    channel: Annotated[list[ChannelTable], Field(min_length=1)]


class RobotFile(_Table):
    robot: RobotTable
    parameters: dict[str, ParameterEntry] = {}
    base: BaseTable | None = None
    dh: DHTable | None = None
    joint: Annotated[list[JointTable], Field(min_length=1)]
    tool: ToolTable | None = None
    effect: list[EffectTable] = []
    recording: RecordingTable | None = None


class ChannelMapFile(_Table):
    recording: RecordingTable
