"""Run in a fresh process: loads a kernel, calls seven functions once, prints the seconds of processor as JSON.

python first_use.py KERNEL
"""

from __future__ import annotations

import importlib.util
import json
import sys
import time

import numba
import numpy as np

SCALAR = ("inverse_dynamics", "mass_matrix", "forward_dynamics", "forward_dynamics_state_jacobian")
BATCH = SCALAR[:3]


def main(path: str) -> None:
    numba.njit(lambda x: x)(1.0)  # Numba's own start is no part of the kernel's
    start = time.process_time()
    spec = importlib.util.spec_from_file_location("kernel", path)
    assert spec is not None
    assert spec.loader is not None
    kernel = importlib.util.module_from_spec(spec)
    sys.modules["kernel"] = kernel
    spec.loader.exec_module(kernel)
    imported = time.process_time()
    n = len(kernel.COORDINATES)
    for name in SCALAR:
        getattr(kernel, name)(*(np.zeros(n) for _ in range(1 if name == "mass_matrix" else 3)))
    for name in BATCH:
        getattr(kernel, f"{name}_batch")(*(np.zeros((1, n)) for _ in range(1 if name == "mass_matrix" else 3)))
    print(json.dumps([imported - start, time.process_time() - imported]))


if __name__ == "__main__":
    main(sys.argv[1])
