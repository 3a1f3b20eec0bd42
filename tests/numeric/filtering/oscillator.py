"""A mass on a spring that a force drives quickly for its samples: the model, which is off, and its true numbers."""

from __future__ import annotations

MASS, DAMPING, SPRING = 2.0, 10.0, 5e4
RATE = 750.0  # Hz
MODEL = """
[robot]
name = "oscillator"
gravity = [0, 0, 0]

[parameters]
m = "2.3 kg"
c = "14 N s/m"
k = "8e4 N/m"

[dh]
rows = [[0, "q", 0, 0]]

[[joint]]
name = "mass"
link = { mass = "m" }

[[effect]]
type = "viscous_friction"
at = "mass"
coefficient = "c"

[[effect]]
type = "linear_spring"
at = "mass"
stiffness = "k"

[recording]
time = { column = "t", unit = "s" }

[[recording.channel]]
column = "x"
quantity = "position"
joint = "mass"
unit = "m"

[[recording.channel]]
column = "f"
quantity = "effort"
joint = "mass"
unit = "N"
"""
