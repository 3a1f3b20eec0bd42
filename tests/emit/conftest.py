"""The bundled machines, compiled once per run; their kernels as plain Python, where nothing waits for LLVM."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numba
import pytest

from symdyn.compiler import Compiled, compile_robot, load_robot
from symdyn.emit.kernel import Kernel, load

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
