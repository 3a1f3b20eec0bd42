"""Expands xacro, by the library of the extra ``xacro``. It evaluates what the file says: only for files you trust."""

from __future__ import annotations

import importlib.util
from pathlib import Path

from symdyn.base.errors import InputError, Problem, Where

_NEEDED = "pip install 'symdyn[xacro]', or expand it with ROS: xacro robot.urdf.xacro > robot.urdf"


def expanded(path: str | Path) -> str:
    """The URDF text that a xacro file stands for. InputError SD405 without the library, or where it fails."""
    where = Where(str(path))
    if importlib.util.find_spec("xacrodoc") is None:
        raise InputError(Problem("SD405", "reading xacro needs the extra `xacro`", where, _NEEDED))
    from xacrodoc import XacroDoc

    try:
        return str(XacroDoc.from_file(str(path)).to_urdf_string())
    except Exception as error:  # of many kinds: whatever a macro raises
        message = " ".join(str(error).split()) or type(error).__name__
        problem = Problem("SD405", f"xacro failed: {message}", where, "does `xacro` itself expand it?")
        raise InputError(problem) from None
