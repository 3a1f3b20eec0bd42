"""Builds the wheel, installs it in a fresh environment outside the checkout, and uses it from there.

    python scripts/wheel_test.py

Nothing of the checkout is on the path of what it runs: a template or a recording that the wheel lacks shows here.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path

CHECKOUT = Path(__file__).resolve().parent.parent

# Run without symdyn: a kernel needs numpy and numba alone.
USE_KERNEL = """
import importlib.util, sys
sys.modules["symdyn"] = None
spec = importlib.util.spec_from_file_location("kernel", sys.argv[1])
kernel = importlib.util.module_from_spec(spec)
sys.modules["kernel"] = kernel
spec.loader.exec_module(kernel)
import numpy as np
effort = kernel.inverse_dynamics(np.array([0.3, 0.4]), np.array([0.1, -0.2]), np.array([1.0, 2.0]))
assert effort.shape == (2,) and np.all(np.isfinite(effort)) and np.any(effort != 0), effort
print("inverse_dynamics:", effort)
"""
WHERE_FROM = """
import pathlib, symdyn, sys
home = pathlib.Path(symdyn.__file__).resolve()
assert home.is_relative_to(pathlib.Path(sys.prefix).resolve()), home
print("symdyn", symdyn.__version__, "from the wheel")
"""


def main() -> None:
    with tempfile.TemporaryDirectory(prefix="symdyn-wheel-") as temporary:
        folder = Path(temporary).resolve()
        elsewhere = folder / "elsewhere"
        elsewhere.mkdir()
        environment = _clean_environment(folder / "cache")

        def run(*command: object) -> None:
            words = [str(word) for word in command]
            print("$", Path(words[0]).name, *("..." if "\n" in word else word for word in words[1:]), flush=True)
            subprocess.run(words, cwd=elsewhere, env=environment, check=True)

        pip = ("-m", "pip", "--disable-pip-version-check", "--quiet")
        run(sys.executable, *pip, "wheel", "--no-deps", "--wheel-dir", folder / "dist", CHECKOUT)
        (wheel,) = (folder / "dist").glob("symdyn-*.whl")
        run(sys.executable, "-m", "venv", folder / "venv")
        binaries = folder / "venv" / ("Scripts" if os.name == "nt" else "bin")
        python, symdyn = binaries / "python", binaries / "symdyn"
        run(python, *pip, "install", wheel)

        run(python, "-c", WHERE_FROM)
        run(symdyn, "--help")
        run(symdyn, "check", "two-link")
        run(symdyn, "generate", "two-link", "--out", "generated")
        (kernel,) = (elsewhere / "generated").rglob("kernel.py")
        run(python, "-I", "-c", USE_KERNEL, kernel)
        run(symdyn, "demo")
        if not list(elsewhere.rglob("*.html")):
            raise SystemExit("symdyn demo wrote no report")
    print("the wheel works outside the checkout")


def _clean_environment(cache: Path) -> Mapping[str, str]:
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "VIRTUAL_ENV"))}
    return {**kept, "SYMDYN_CACHE": str(cache)}


if __name__ == "__main__":
    main()
