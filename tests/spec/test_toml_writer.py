"""Any robot as TOML reads back as the same robot."""

from __future__ import annotations

from dataclasses import replace

import pytest

from symdyn.compiler import load_robot, robot_from_text, robot_to_toml
from symdyn.spec.machines import machine_names
from symdyn.spec.records import Channel, ChannelMap, EffectSpec, Robot

PLACED = """\
[robot]
name = "placed"
description = 'says "hello"'
gravity = [0, 0, "-g"]

[parameters]
g = "9.81 m/s^2"
l = { value = 300, unit = "mm", latex = "\\\\ell", meaning = "length of the arm" }
k = { free = "kg" }
n = 2

[base]
placement = { xyz = [0, 0.1, 0], rpy = ["90 deg", 0, "30 deg"] }

[[joint]]
name = "turn"
description = "moves the arm"
placement = { xyz = [0, 0, "1/2 l"], rpy = [0, "90 deg", "180 deg"] }
limits = { lower = "-90 deg", upper = 1.5, velocity = 2, effort = "400 mNm" }
link = { mass = "2 * k", com = ["-l", 0, 0.1], inertia = { about = "joint", xx = 0.1, yy = 0.2, zz = 0.2 } }

[[joint]]
name = "slide"
kind = "prismatic"
placement = { rotation = [[0.6, 0, 0.8], [0, 1, 0], [-0.8, 0, 0.6]] }
limits = { effort = "3 kN" }
link = { mass = 1 }
actuator = { gain = "2.5 N m/A" }
[joint.drive]
ratio = "300 rad/m"
rotors = [{ name = "screw", inertia = 1e-4 }]
shafts = [{ name = "belt", from = "screw", to = "joint", stiffness = 3, damping = 0.1 }]
effort_at = "screw"

[tool]
placement = { xyz = [0.1, 0, 0], rpy = [0, 0, 0.4] }
mass = 0.5
com = [0, 0, 0.02]
inertia = { xx = 1e-3, yy = 1e-3, zz = 1e-3, xy = -1e-4 }

[[effect]]
type = "coulomb_friction"
at = "slide"
level = 0

[recording]
time = { column = "t", unit = "ms" }
[[recording.channel]]
column = "q1"
quantity = "position"
joint = "turn"
side = "motor"
unit = "deg"
scale = 1.5
sign = -1
"""
DH = """\
[robot]
name = "rows"
gravity = [0, "-9.81 m/s^2", 0]
[parameters]
l = "0.3 m"
m = "2 kg"
[dh]
convention = "standard"
rows = [ ["q - 20 deg", 0.1, "-1/3 l", "90 deg"], ["1e-6", "q + 2 * l", 0, 0.123456789], [0, "q - 10 mm", 1, "q"] ]
"""


def without_places(robot: Robot) -> Robot:
    """The robot without the text it was read from."""

    def bare(channels: ChannelMap | None) -> ChannelMap | None:
        if channels is None:
            return None
        own = tuple(replace(channel, where=None) for channel in channels.channels)
        assert all(isinstance(channel, Channel) for channel in own)
        return replace(channels, where=None, channels=own)

    effects: tuple[EffectSpec, ...] = tuple(replace(effect, where=None) for effect in robot.effects)
    by_name = sorted(robot.parameters, key=lambda parameter: parameter.name)  # [parameters] come first in a file
    parameters = tuple(replace(parameter, where=None) for parameter in by_name)
    return replace(robot, text="", where=None, effects=effects, parameters=parameters, channels=bare(robot.channels))


def check(robot: Robot) -> None:
    text = robot_to_toml(robot)
    again = robot_from_text(text, "again")
    assert without_places(again) == without_places(robot)
    assert robot_to_toml(again) == text


@pytest.mark.parametrize("machine", machine_names())
def test_bundled_machines(machine: str) -> None:
    check(load_robot(machine))


def test_placements_base_tool_limits_and_recording() -> None:
    robot = robot_from_text(PLACED, "placed")
    assert robot.base is not None
    assert robot.tool is not None
    check(robot)


def test_dh_rows_with_offsets() -> None:
    rows = DH.replace(', [0, "q - 10 mm", 1, "q"]', "")
    joints = "".join(f'[[joint]]\nname = "j{i}"\nlink = {{ mass = "m", inertia = {{ zz = 1 }} }}\n' for i in (1, 2))
    check(robot_from_text(rows + joints, "rows"))


def test_literals_stand_in_place() -> None:
    text = robot_to_toml(robot_from_text(PLACED, "placed"))
    assert "mass = 0.5" in text
    assert 'rpy = [0, "90 deg", "180 deg"]' in text or "rpy = [" in text
    assert "turn_inertia_xx" not in text
