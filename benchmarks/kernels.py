"""Times the generated kernel of the two-link arm beside Pinocchio's Python wheel, in one process.

    python benchmarks/kernels.py            (or: make bench)

Rounds of all contestants are interleaved, so that a change of clock speed hits them alike; the table shows medians,
and ratios are what counts. Both are checked against each other first. Without ``pin`` only the kernel is timed.
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Callable

import numpy as np
from numba import njit
from numpy.typing import NDArray

from symdyn.compiler import compile_robot, load_robot
from symdyn.emit.kernel import Kernel

try:
    import pinocchio as pin  # type: ignore[import-untyped]
except ImportError:
    pin = None

Array = NDArray[np.float64]
Contestant = Callable[[], object]

STATES = 6400
CALLS = 2000  # of one function from Python, in one round
ONCE, LOOP, BATCH, WHEEL = "called from Python", "compiled loop", "batch", "pin, called from Python"
FUNCTIONS = ("inverse_dynamics", "mass_matrix", "forward_dynamics")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=50, help="rounds, each of all contestants (default: 50)")
    rounds = parser.parse_args().rounds
    kernel = compile_robot(load_robot("two-link")).kernel()
    random = np.random.default_rng(0)
    q, qd, third = (random.uniform(-np.pi, np.pi, (STATES, 2)) for _ in range(3))
    contestants: dict[tuple[str, str], tuple[Contestant, int]] = {}
    for name in FUNCTIONS:
        arguments = (q,) if name == "mass_matrix" else (q, qd, third)
        contestants |= {(name, how): entry for how, entry in _kernel_forms(kernel, name, arguments).items()}
        if pin is not None:
            contestants[name, WHEEL] = (_pin_form(kernel, name, arguments), CALLS)
    print(table(measure(contestants, rounds)))
    print(f"\nns per state, median of {rounds} rounds; two-link arm, {STATES} states in loop and batch.")
    if pin is None:
        print("pin is not installed, so nothing is compared: pip install pin")
    else:
        print("In brackets: how many times as fast as the wheel, which can only be called from Python, state by state.")


def _kernel_forms(kernel: Kernel, name: str, arguments: tuple[Array, ...]) -> dict[str, tuple[Contestant, int]]:
    one, batch = getattr(kernel, name), getattr(kernel, f"{name}_batch")
    first = tuple(np.ascontiguousarray(a[0]) for a in arguments)
    loop = _loop(one, len(arguments))

    def call() -> None:
        for _ in range(CALLS):
            one(*first)

    return {
        ONCE: (call, CALLS),
        LOOP: (lambda: loop(*arguments), STATES),
        BATCH: (lambda: batch(*arguments), STATES),
    }


def _loop(one: Callable[..., Array], count: int) -> Callable[..., float]:
    """One state after the other from compiled code, as a controller or an integrator calls it."""

    @njit
    def of_one(a):  # type: ignore[no-untyped-def]
        total = 0.0
        for k in range(a.shape[0]):
            total += one(a[k])[0, 0]
        return total

    @njit
    def of_three(a, b, c):  # type: ignore[no-untyped-def]
        total = 0.0
        for k in range(a.shape[0]):
            total += one(a[k], b[k], c[k])[0]
        return total

    return of_one if count == 1 else of_three  # type: ignore[no-any-return]


def _pin_form(kernel: Kernel, name: str, arguments: tuple[Array, ...]) -> Contestant:
    model = _pin_model(dict(zip(kernel.parameters, kernel.values, strict=True)))
    data = model.createData()
    function = {"inverse_dynamics": pin.rnea, "mass_matrix": pin.crba, "forward_dynamics": pin.aba}[name]
    for k in range(10):
        theirs = function(model, data, *(a[k] for a in arguments))
        theirs = np.triu(theirs) + np.triu(theirs, 1).T if theirs.ndim == 2 else theirs  # crba fills one triangle
        np.testing.assert_allclose(getattr(kernel, name)(*(a[k] for a in arguments)), theirs, rtol=1e-9, atol=1e-9)
    first = tuple(a[0].copy() for a in arguments)

    def call() -> None:
        for _ in range(CALLS):
            function(model, data, *first)

    return call


def _pin_model(p: dict[str, float]):  # type: ignore[no-untyped-def]
    """The arm of machines/two-link.toml, built by hand."""
    model = pin.Model()
    model.gravity.linear = np.array([0.0, -p["g"], 0.0])
    parent, reach = 0, 0.0
    for i in (1, 2):
        placement = pin.SE3(np.eye(3), np.array([reach, 0.0, 0.0]))
        parent = model.addJoint(parent, pin.JointModelRZ(), placement, f"joint{i}")
        # In the plane only the inertia about z matters; the other two keep the tensor a possible one.
        inertia = np.diag([p[f"I_{i}"], p[f"I_{i}"], p[f"I_{i}"]])
        link = pin.Inertia(p[f"m_{i}"], np.array([p[f"r_{i}"], 0.0, 0.0]), inertia)
        model.appendBodyToJoint(parent, link, pin.SE3.Identity())
        reach = p["l_1"]
    return model


def measure(contestants: dict[tuple[str, str], tuple[Contestant, int]], rounds: int) -> dict[tuple[str, str], float]:
    """Nanoseconds per state: medians over interleaved rounds; the first, which compiles, is not counted."""
    samples: dict[tuple[str, str], list[float]] = {key: [] for key in contestants}
    for number in range(rounds + 1):
        for key, (run, states) in contestants.items():
            start = time.perf_counter_ns()
            run()
            if number:
                samples[key].append((time.perf_counter_ns() - start) / states)
    return {key: statistics.median(values) for key, values in samples.items()}


def table(times: dict[tuple[str, str], float]) -> str:
    """A Markdown table; in brackets, how many times as fast as the wheel."""
    columns = list(dict.fromkeys(how for _, how in times))
    lines = [f"| | {' | '.join(columns)} |", f"| --- |{' ---: |' * len(columns)}"]
    for name in FUNCTIONS:
        cells = []
        for how in columns:
            ratio = times[name, WHEEL] / times[name, how] if (name, WHEEL) in times and how != WHEEL else None
            cells.append(f"{times[name, how]:.0f}" + (f" ({ratio:.1f} x)" if ratio is not None else ""))
        lines.append(f"| {name} | {' | '.join(cells)} |")
    return "\n".join(lines)


if __name__ == "__main__":
    main()
