"""Emitted C, compiled into a library whose functions take arrays."""

from __future__ import annotations

import ctypes
import os
import shutil
import subprocess
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from pathlib import Path

import numpy as np

from symdyn.compiler import Compiled, compile_robot, load_robot
from symdyn.emit.c_source import c_files
from symdyn.emit.forms import Form
from symdyn.emit.kernel import Kernel
from symdyn.program.ssa import Program

STRICT = ("-std=c99", "-Wall", "-Wextra", "-Wshadow", "-Werror", "-pedantic", "-O2")
SANITIZERS = "-fsanitize=undefined,address"
# Of the largest entry of a result: the same operations in the same order. Where compilers fuse multiplications
# and additions, 18 were seen.
ULPS = 64
Array = np.ndarray
Machine = Callable[[str], Compiled]
Machines = Callable[[str], Kernel]
Build = Callable[[Mapping[str, str]], "Library"]


def compilers() -> list[str]:
    """cc, gcc and clang as far as they are there, each once though it may have two names."""
    found = {os.path.realpath(path): name for name in ("cc", "gcc", "clang") if (path := shutil.which(name))}
    return sorted(found.values())


def run(*command: object) -> str:
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True, timeout=1800)
    assert done.returncode == 0, f"{done.stderr}\n{done.stdout}"
    return done.stdout


class Library:
    """A compiled source, its functions called with arrays."""

    def __init__(self, folder: Path, files: Mapping[str, str], compiler: str, flags: Sequence[str] = ()) -> None:
        for name, text in files.items():
            (folder / name).write_text(text, encoding="utf-8")
        self.source = next(folder.glob("*.c"))
        self.path = folder / "library.so"
        compiled = folder / "library.o"
        run(compiler, *STRICT, *flags, "-fPIC", "-c", self.source, "-o", compiled)
        # Linked with -ffast-math, gcc makes the whole process lose its subnormal numbers.
        linking = [flag for flag in flags if flag != "-ffast-math"]
        run(compiler, *linking, "-shared", compiled, "-o", self.path, "-lm")
        self.loaded = ctypes.CDLL(str(self.path))

    def __call__(self, name: str, arguments: Sequence[Array], shape: tuple[int, ...]) -> Array:
        return self._filled(name, [], arguments, shape)

    def many(self, name: str, count: int, arguments: Sequence[Array], shape: tuple[int, ...]) -> Array:
        """A batch, or its structure of arrays: results of ``count`` states in an array of ``shape``."""
        return self._filled(name, [ctypes.c_size_t(count)], arguments, shape)

    def _filled(
        self, name: str, first: Sequence[ctypes.c_size_t], arguments: Sequence[Array], shape: tuple[int, ...]
    ) -> Array:
        out = np.full(shape, 77.0)
        function = getattr(self.loaded, f"{self.source.stem}_{name}")
        function.restype = None
        function(*first, *(array.ctypes.data_as(ctypes.c_void_p) for array in (*arguments, out)))
        return out

    def texts(self, table: str, count: int) -> tuple[str, ...]:
        """The entries of a list, which must end where it says."""
        entries = (ctypes.c_char_p * (count + 1)).in_dll(self.loaded, f"{self.source.stem}_{table}")
        assert entries[count] is None
        return tuple((entry or b"").decode() for entry in entries[:count])


@cache
def two_link() -> Compiled:
    return compile_robot(load_robot("two-link"))


def files_of(of: Compiled, forms: Sequence[Form] | None = None) -> Mapping[str, str]:
    return c_files(of.equations, of.forms if forms is None else forms)


def of_programs(*found: Program) -> Mapping[str, str]:
    """Programs as the functions f_0, f_1, ... of a robot."""
    return files_of(two_link(), [Form(f"f_{k}", "One.", program, ()) for k, program in enumerate(found)])
