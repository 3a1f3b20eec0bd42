"""What is to be reached: ratios and limits, and times of Pinocchio that were measured elsewhere."""

from __future__ import annotations

from dataclasses import dataclass

LOOP, BATCH, MILLION, ONCE = "compiled loop", "batch of 6400 states", "batch of 10^6 states", "one call from Python"
WHEEL = "pin wheel"


@dataclass(frozen=True)
class Asked:
    """At least so many times faster than a rival, by robot."""

    function: str
    form: str
    rival: str
    ratio: dict[str, float]


def _row(function: str, form: str, puma: tuple[float, float], panda: tuple[float, float]) -> tuple[Asked, Asked]:
    rivals = ("Pinocchio C++", "Pinocchio + CasADi C")
    first, second = (
        Asked(function, form, rival, {"puma560": a, "panda": b})
        for rival, a, b in zip(rivals, puma, panda, strict=True)
    )
    return first, second


ASKED = (
    *_row("inverse_dynamics", LOOP, (12, 3.5), (9, 3)),
    *_row("forward_dynamics", LOOP, (12, 3.2), (8.5, 2.6)),
    *_row("forward_dynamics_state_jacobian", LOOP, (9, 9), (3, 4)),
    *_row("inverse_dynamics", BATCH, (50, 14), (40, 13)),
    *_row("inverse_dynamics", MILLION, (30, 9), (28, 10)),
    *_row("forward_dynamics", BATCH, (55, 14), (35, 11)),
    Asked("inverse_dynamics", ONCE, WHEEL, {"puma560": 4, "panda": 4}),
    Asked("forward_dynamics_state_jacobian", ONCE, WHEEL, {"puma560": 4.8, "panda": 2.9}),
)

# (multiplications, additions) of inverse dynamics; seconds to derive and emit, to compile first, to import from cache.
OPERATIONS = {"puma560": (178, 142), "panda": (319, 296)}
SECONDS = {"puma560": (3.0, 10.0, 0.5), "panda": (5.0, 25.0, 0.5)}

# Measured elsewhere on 2 vCPU of an AMD Zen 5, November 2026, in ns per state, the fastest build: Pinocchio 4.1 in C++
# (clang -O3 -march=native), and Pinocchio traced by CasADi 3.8 into C. What is asked above was set beside these.
CITED = {
    "Pinocchio C++": {
        "puma560": (480, 319, 843, 1922),
        "panda": (572, 382, 1012, 2439),
    },
    "Pinocchio + CasADi C": {
        "puma560": (134, 114, 186, 1982),
        "panda": (195, 159, 285, 3374),
    },
}  # inverse dynamics, mass matrix, forward dynamics, derivatives of it
