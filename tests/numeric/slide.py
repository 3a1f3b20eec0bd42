"""A mass that slides, and is braked by its speed alone."""

from __future__ import annotations

SLIDE = """
[robot]
name = "slide"
gravity = [0, 0, 0]

[parameters]
m = "2.5 kg"
b = "1.5 N s/m"

[dh]
rows = [[0, "q", 0, 0]]

[[joint]]
name = "arm"
link = { mass = "m" }

[[effect]]
type = "viscous_friction"
at = "arm"
coefficient = "b"
"""
