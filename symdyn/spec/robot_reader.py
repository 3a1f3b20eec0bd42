"""Reads a robot from a file of any kind, by its suffix: .toml, .urdf, .xacro."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from symdyn.base.errors import InputError, Problem, Where
from symdyn.spec import toml_reader
from symdyn.spec.effect_schema import EffectSchema
from symdyn.spec.records import Robot
from symdyn.spec.toml_source import read_text
from symdyn.spec.urdf_chain import WHOLE, Chain
from symdyn.spec.urdf_reader import read_urdf, read_urdf_text
from symdyn.spec.xacro_files import expanded

URDF, XACRO = ".urdf", ".xacro"


def read_any(
    path: str | Path, catalogue: Mapping[str, EffectSchema], chain: Chain = WHOLE
) -> tuple[Robot, tuple[Problem, ...]]:
    """The robot, and what is doubtful in its file. InputError with every problem found.

    ``chain`` chooses from the tree of a URDF; a TOML file is a chain already (SD415).
    """
    suffix = Path(path).suffix.lower()
    if suffix == URDF:
        return read_urdf(path, catalogue, chain)
    if suffix == XACRO:
        read_text(path)  # tells what is wrong with the file itself
        return read_urdf_text(expanded(path), f"{path} (expanded)", catalogue, chain)
    if chain != WHOLE:
        problem = Problem("SD415", "base, tip and lock_others choose from the tree of a URDF", Where(str(path)))
        raise InputError(problem)
    return toml_reader.read_with_warnings(path, catalogue)
