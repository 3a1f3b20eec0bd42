"""Batches compute several states with one instruction: a loop that stops vectorising only looks a little slow."""

from __future__ import annotations

import platform
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from symdyn.compiler import Compiled
from symdyn.emit.kernel import Kernel, load

pytestmark = pytest.mark.skipif(platform.machine() not in ("x86_64", "AMD64"), reason="reads the assembly of x86-64")
ARITHMETIC = re.compile(r"^\s+v?(?:mul|add|sub|fn?m(?:add|sub)\d*)(pd|sd)\s", re.MULTILINE)
BATCHES = ("batch", "soa")


@pytest.fixture
def fresh(tmp_path: Path) -> Callable[[Compiled], Kernel]:
    """A kernel that keeps no compiled files: assembly can be read of what was compiled in this process alone."""

    def kernel(of: Compiled) -> Kernel:
        path = tmp_path / "kernel.py"
        path.write_text(of.source.replace("cache=True, ", ""), encoding="utf-8")
        return load(path)

    return kernel


def assembly(kernel: Kernel, name: str, count: int) -> str:
    """Of a function of ``count`` vectors, as it is compiled for contiguous arrays."""
    function: Any = getattr(kernel, name)
    n = len(kernel.coordinates)
    function(*(np.zeros((n, 5) if name.endswith("_soa") else (5, n)) for _ in range(count)))
    (text,) = function.inspect_asm().values()
    return str(text)


def assert_vectorised(kernel: Kernel, of: Compiled, name: str, form: str) -> None:
    """LLVM keeps a scalar loop beside the vectorised one, in case arrays overlap: hence half."""
    program = next(f.program for f in of.forms if f.name == name)
    kinds = ARITHMETIC.findall(assembly(kernel, f"{name}_{form}", len(program.arguments)))
    packed, scalar = kinds.count("pd"), kinds.count("sd")
    cost = next(f.costs[-1].cost for f in of.forms if f.name == name)
    # A product and a sum may be one instruction.
    least = max(cost.multiplications, cost.additions)
    assert packed >= least, f"{name}_{form}: {packed} packed, {scalar} scalar, for {least} operations"
    assert packed >= 0.9 * scalar, f"{name}_{form}: {packed} packed, {scalar} scalar"


@pytest.mark.parametrize("form", BATCHES)
def test_inverse_dynamics_of_the_two_link_arm(
    form: str, compiled: Callable[[str], Compiled], fresh: Callable[[Compiled], Kernel]
) -> None:
    of = compiled("two-link")
    assert_vectorised(fresh(of), of, "inverse_dynamics", form)


@pytest.mark.slow
@pytest.mark.parametrize("form", BATCHES)
@pytest.mark.parametrize(
    "name", ["inverse_dynamics", "mass_matrix", "forward_dynamics", "forward_dynamics_state_jacobian"]
)
def test_the_panda(
    name: str, form: str, compiled: Callable[[str], Compiled], fresh: Callable[[Compiled], Kernel]
) -> None:
    of = compiled("panda")
    assert_vectorised(fresh(of), of, name, form)
