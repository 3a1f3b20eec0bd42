"""A generated kernel needs math, numpy and numba, and nothing else."""

from __future__ import annotations

import ast
import json
import math
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from symdyn.spec.machines import machine_names

GENERATED = Path(__file__).parents[2] / "generated"

USE = """
import json, sys

class Refused:  # as on a machine where neither was ever installed
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in ("symdyn", "sympy", "jinja2", "scipy"):
            raise ModuleNotFoundError(f"{name} is not here", name=name)

sys.meta_path.insert(0, Refused())
try:
    import symdyn
except ModuleNotFoundError:
    pass
else:
    sys.exit("symdyn can be imported")

import numpy as np
from generated.two_link.kernel import inverse_dynamics

tau = inverse_dynamics(np.array([0.3, -0.7]), np.array([0.5, 1.1]), np.array([-0.2, 0.9]))
print(json.dumps({"tau": tau.tolist(), "modules": sorted({name.partition(".")[0] for name in sys.modules})}))
"""


def two_link_by_hand() -> list[float]:
    """The same torques from the textbook's formula (Spong, Hutchinson, Vidyasagar, section 7.3)."""
    g, l1, m1, m2, r1, r2, i1, i2 = 9.81, 0.5, 1.08, 0.864, 0.25, 0.2, 0.022644, 0.0116352
    (q1, q2), (v1, v2), (a1, a2) = (0.3, -0.7), (0.5, 1.1), (-0.2, 0.9)
    m11 = m1 * r1**2 + i1 + m2 * (l1**2 + r2**2 + 2 * l1 * r2 * math.cos(q2)) + i2
    m12 = m2 * (r2**2 + l1 * r2 * math.cos(q2)) + i2
    h = m2 * l1 * r2 * math.sin(q2)
    g2 = m2 * r2 * g * math.cos(q1 + q2)
    g1 = (m1 * r1 + m2 * l1) * g * math.cos(q1) + g2
    return [
        m11 * a1 + m12 * a2 - h * (2 * v1 * v2 + v2**2) + g1,
        m12 * a1 + (m2 * r2**2 + i2) * a2 + h * v1**2 + g2,
    ]


def test_a_copy_of_the_folder_works_where_symdyn_is_not(tmp_path: Path) -> None:
    ignored = shutil.ignore_patterns("__pycache__")
    shutil.copytree(GENERATED, tmp_path / "generated", ignore=ignored)
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    done = subprocess.run(
        [sys.executable, "-c", USE], cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    shown = json.loads(done.stdout)
    assert shown["tau"] == pytest.approx(two_link_by_hand(), rel=1e-12)
    assert {"numpy", "numba"} <= set(shown["modules"])
    assert not {"symdyn", "sympy"} & set(shown["modules"])


@pytest.mark.parametrize("machine", machine_names())
def test_imports_math_numpy_and_numba_alone(machine: str) -> None:
    tree = ast.parse((GENERATED / machine.replace("-", "_") / "kernel.py").read_text(encoding="utf-8"))
    found = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            found += [(alias.name, alias.asname) for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0
            found += [(f"{node.module}.{alias.name}", alias.asname) for alias in node.names]
    assert sorted(found, key=str) == [
        ("math", None),
        ("numba.config", None),
        ("numba.core.cgutils.ir", None),
        ("numba.extending.intrinsic", None),
        ("numba.njit", None),
        ("numba.prange", None),
        ("numba.types", None),
        ("numpy", "np"),
    ]


@pytest.mark.parametrize("machine", machine_names())
def test_calls_arithmetic_alone(machine: str) -> None:
    """Nothing in a kernel can reach a file, a process or an interpreter."""
    tree = ast.parse((GENERATED / machine.replace("-", "_") / "kernel.py").read_text(encoding="utf-8"))
    own = {node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)}
    own |= {  # made by a function of the kernel
        ast.unparse(node.targets[0])
        for node in tree.body
        if isinstance(node, ast.Assign) and isinstance(node.value, ast.Call) and ast.unparse(node.value.func) in own
    }
    called = {ast.unparse(node.func) for node in ast.walk(tree) if isinstance(node, ast.Call)}
    allowed = {"njit", "prange", "intrinsic", "np.empty", "np.zeros", "np.array", "np.asarray", "np.intp"}
    allowed |= {"range", "abs", "min", "max", "len", "zip", "enumerate", "list", "tuple", "isinstance", "function"}
    allowed |= {"vector", "made._getvalue"}  # a type of Numba, which makes a signature; the value of one of its records
    allowed |= {"ValueError", "TypeError", "bit_length", "move", "turns", "reversed", "sorted", "dict", "times", "less"}
    # What _sincos, the transposition and Jacobians' last step are made of: instructions of LLVM, and values for them.
    instructions = ("math.", "builder.", "ir.", "types.", "context.", "kind.")
    methods = ("reshape", "ravel", "bit_length", "as_pointer", "append")
    rest = {name for name in called - own - allowed if not name.startswith(instructions)}
    rest = {name for name in rest if not name.endswith(tuple(f").{m}" for m in methods))}
    rest -= {f"{array}.{method}" for array in ("out", "q") for method in ("reshape", "ravel")}
    assert called & own
    assert not rest
