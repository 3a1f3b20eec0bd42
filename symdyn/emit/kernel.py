"""Kernel: compiled functions and their name tables; the one thing that crosses from symbols to numbers."""

from __future__ import annotations

import hashlib
import importlib.util
import os
import py_compile
import shutil
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from py_compile import PycInvalidationMode
from types import ModuleType
from typing import Any

import numpy as np
import platformdirs
from numpy.typing import NDArray

from symdyn.base.files import write_atomically

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Kernel:
    """A loaded kernel module. Functions compile when they are first called."""

    module: ModuleType
    given: tuple[float, ...] | None = None  # values in place of the module's

    def __getattr__(self, name: str) -> Callable[..., Any]:
        """A function of the module; AttributeError says so where only its form with a parameter vector exists."""
        function: Callable[..., Any] | None = getattr(self.module, name, None)
        if function is None:
            batch = "_batch" if name.endswith("_batch") else ""
            general = f"{name.removesuffix('_batch')}_p{batch}"
            use = f"; parameters are left free, so use {general}" if self.has(general) else ""
            raise AttributeError(f"the kernel of {self.module.ROBOT} has no {name}{use}")
        return function

    def has(self, function: str) -> bool:
        return hasattr(self.module, function)

    def rows(self, name: str, *arguments: Array) -> Array:
        """(m, ...) the function NAME or NAME_p of every row of its arguments; of NAME_p the last is the vector p.

        The same as NAME_batch, whose checks and reshaping take Numba half a second for every function: compiled
        code calls that one, Python this one.

        Raises ValueError where shapes differ from those of SHAPES, AttributeError where there is no such function.
        """
        compiled = getattr(self.module, f"_{name}_rows", None) or getattr(self, name)
        *expected, shape = self.module.SHAPES[name]
        shared, count = name.endswith("_p"), len(arguments[0])
        flat = []
        for i, (values, entries) in enumerate(zip(arguments, expected, strict=True)):
            wanted = entries if shared and i == len(expected) - 1 else (count, *entries)
            if np.shape(values) != wanted:
                raise ValueError(f"argument {i + 1} of {name} has the shape {np.shape(values)}, not {wanted}")
            # Numba compiles anew for arrays of any other kind.
            flat.append(np.require(values, np.float64, ["C", "W"]).reshape(-1))
        out = np.empty((count, *shape))
        compiled(*flat, out.reshape(-1), np.intp(0), count)
        return out

    @property
    def coordinates(self) -> tuple[str, ...]:
        return tuple(self.module.COORDINATES)

    @property
    def effort_units(self) -> tuple[str, ...]:
        return tuple(self.module.EFFORT_UNITS)

    @property
    def output_units(self) -> tuple[str, ...]:
        return tuple(self.module.OUTPUT_UNITS)

    @property
    def states(self) -> tuple[str, ...]:
        return tuple(self.module.STATES)

    @property
    def state_units(self) -> tuple[str, ...]:
        return tuple(self.module.STATE_UNITS)

    @property
    def inputs(self) -> tuple[str, ...]:
        return tuple(self.module.INPUTS)

    @property
    def input_units(self) -> tuple[str, ...]:
        return tuple(self.module.INPUT_UNITS)

    @property
    def outputs(self) -> tuple[str, ...]:
        return tuple(self.module.OUTPUTS)

    @property
    def parameters(self) -> tuple[str, ...]:
        return tuple(self.module.PARAMETERS)

    @property
    def parameter_units(self) -> tuple[str, ...]:
        return tuple(self.module.PARAMETER_UNITS)

    @property
    def values(self) -> Array:
        """Parameter values (a copy); nan where a parameter is left free."""
        return np.array(self.module.PARAMETER_VALUES if self.given is None else self.given)


def load(path: Path) -> Kernel:
    """Load a kernel module from a file; its name in ``sys.modules`` is made of its text.

    Not of its path: what Numba has stored beside it names the module, and a folder may be copied or moved.
    """
    name = _name(path.read_bytes())
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise ImportError(f"cannot load {path}")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # Numba's cache looks the module up
    spec.loader.exec_module(module)
    return Kernel(module)


def load_source(text: str) -> Kernel:
    """Load a kernel from its source, through a private cache keyed by content.

    The compiled functions that Numba stores beside it are pickles: the folder belongs to the user
    alone (mode 0700, owner checked), never the working directory and never a shared one. A cached
    file that is not the source any more goes, with all that was compiled from it.

    Raises PermissionError where others could write to the cache.
    """
    folder = _private(cache_root()) / _name(text.encode())
    path = folder / "kernel.py"
    if path.exists() and path.read_bytes() != text.encode():
        shutil.rmtree(folder)
    if not path.exists():
        folder.mkdir(mode=0o700, exist_ok=True)
        write_atomically(path, text)
    if not Path(importlib.util.cache_from_source(str(path))).exists():
        # Parsing is most of an import; a Python that is told to write no bytecode would do it every time.
        py_compile.compile(str(path), doraise=True, invalidation_mode=PycInvalidationMode.CHECKED_HASH)
    return load(path)


def _name(text: bytes) -> str:
    return f"symdyn_kernel_{hashlib.sha256(text).hexdigest()[:16]}"


def cache_root() -> Path:
    """Where kernels of users' robots live; SYMDYN_CACHE names another place."""
    named = os.environ.get("SYMDYN_CACHE")
    return Path(named) if named else Path(platformdirs.user_cache_dir("symdyn")) / "kernels"


def _private(folder: Path) -> Path:
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    status = folder.stat()
    if hasattr(os, "getuid") and (status.st_uid != os.getuid() or status.st_mode & 0o022):
        raise PermissionError(f"{folder} can be written by others; name a private folder with SYMDYN_CACHE")
    return folder
