"""C99: one header and one source, named after the robot."""

from __future__ import annotations

from symdyn.emit.c_source import TEMPLATES, c_files
from symdyn.emit.target import Target

TARGET = Target("c", "C99, one header and one source", c_files, TEMPLATES)
