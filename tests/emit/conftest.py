"""The bundled machines, compiled once per run; their kernels as plain Python, where nothing waits for LLVM."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path

import numba
import pytest

from symdyn.compiler import Compiled, compile_robot, load_robot
from symdyn.emit.kernel import Kernel, load
from tests.emit.c_library import Build, Library, compilers

Interpret = Callable[[Compiled], Kernel]


@pytest.fixture(scope="session")
def compiled() -> Callable[[str], Compiled]:
    """A bundled machine by name, derived and printed."""
    return cache(lambda name: compile_robot(load_robot(name)))


@pytest.fixture(scope="session")
def interpret(tmp_path_factory: pytest.TempPathFactory) -> Interpret:
    """The kernel of the same source with ``njit`` doing nothing: every function of it in no time."""

    def kernel(of: Compiled) -> Kernel:
        path = tmp_path_factory.mktemp("interpreted") / "kernel.py"
        path.write_text(of.source, encoding="utf-8")
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(numba.core.config, "DISABLE_JIT", 1)
            return load(path)

    return kernel


@pytest.fixture(scope="session")
def interpreted(compiled: Callable[[str], Compiled], interpret: Interpret) -> Callable[[str], Kernel]:
    return cache(lambda name: interpret(compiled(name)))


@pytest.fixture(params=compilers() or [pytest.param("cc", marks=pytest.mark.skip(reason="no C compiler is here"))])
def compiler(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture
def build(compiler: str, tmp_path: Path) -> Build:
    numbers = itertools.count()

    def library(files: Mapping[str, str]) -> Library:
        folder = tmp_path / str(next(numbers))  # a library is loaded once by its path
        folder.mkdir()
        return Library(folder, files, compiler)

    return library
