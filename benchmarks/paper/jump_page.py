"""The sections of docs/paper.md on friction and clearance."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from benchmarks.paper.jumps import (
    ACCELERATION,
    AMPLITUDES,
    ANGLE,
    ARM,
    BACK,
    CLEARANCE,
    HOLD,
    LIFT,
    SPEED,
    TOLERANCE,
    VOLTS,
    Jumps,
    turns,
)
from symdyn.numeric.hybrid.stepped_sine import SteppedSine
from symdyn.numeric.hybrid.trajectory import Event, HybridTrajectory
from symdyn.numeric.linear.response import Response

_EVEN = 1e-3

# `python -m benchmarks.paper --time`: two shared cores of an AMD Zen 5, set-up of the modes included.
MEASURED = (
    "Measured once, in November 2026, on one of two busy cores of an AMD Zen 5\n(`python -m benchmarks.paper --time`), "
    "with the set-up of the modes: the drive with its servo 270 times faster than real time for the step, 410 times\n"
    "for the sine; the arm with both drives 33 times."
)


def step_response(j: Jumps) -> str:
    full, friction = j.steps["friction and clearance"], j.steps["friction"]
    sticks = next(e.time for e in full.events if e.kind == "friction" and e.after == 0)
    rows = ["| | time | what happens |", "| --- | ---: | --- |"]
    rows += [f"| {k} | {1e3 * e.time:.3f} ms | {_told(e)} |" for k, e in enumerate(full.events, start=1)]
    lost = 100 * (1 - _top(friction) / _top(j.steps["linear part"]))
    return f"""A step of {VOLTS:g} V at the motor, taken back after {BACK:g} s. The paper does not print the clearance;
here S = {CLEARANCE:g} rad, on both sides of the middle. Friction takes {lost:.0f} % of the speed, and stops the motor
at {sticks:.3f} s, where the linear model would creep on. The clearance shows where the load overruns the drive: it
crosses the gap, and hits the other flank.

![Step response](paper/figure-11.svg)

The motor sticks for good: nothing moves it by a single bit, though the load still swings in its spring. Every event of
the run with clearance, located to 1e-11 s:

{chr(10).join(rows)}"""


def amplitudes(j: Jumps, linear: Response) -> str:
    rows = [
        "| amplitude | at 1 Hz | anti-resonance near | peak near | largest odd distortion |",
        "| --- | ---: | ---: | ---: | ---: |",
        f"| linear part | {_at(linear, 1.0):.1f} dB | {_low(linear):.1f} Hz | {_high(linear):.1f} Hz | |",
    ]
    for name, found in j.measured.items():
        odd = np.where(found.settled, found.odd, 0.0)
        rows.append(
            f"| {name} | {_at(found, 1.0):.1f} dB | {_low(found):.1f} Hz | {_high(found):.1f} Hz | "
            f"{100 * odd.max():.0f} % at {found.hertz[np.argmax(odd)]:.3g} Hz |"
        )
    return f"""The HP 5420A measured the real drive, which has friction; the response then depends on the size of the
signal. `symdyn frequency` with `--amplitude` simulates what such an analyser does: a sine at each frequency until the
drive repeats itself, then the harmonics of the tachometer's voltage, correlated exactly over a period. Here with
T_f and S = {CLEARANCE:g} rad at {", ".join(f"{a:g}" for a in AMPLITUDES[:-1])} and {AMPLITUDES[-1]:g} V:

![Frequency response at three amplitudes](paper/amplitudes.svg)

{chr(10).join(rows)}

Small signals lose most: friction holds the motor for part of every period. The clearance makes the flexspline softer
the smaller the motion, so that anti-resonance and mode 1 move down. The drive is odd-symmetric.
{_symmetry(j)} {_periodic(list(j.measured.values()))}"""


def two_axes(j: Jumps) -> str:
    states = j.arm.kernel.states
    both, alone = j.both, j.column
    arm = both.found.states[:, states.index("arm.q")]
    sag = both.asked[0, 1] - arm[0]
    error = np.abs(both.asked - both.found.states[:, [states.index("column.q"), states.index("arm.q")]]).max(axis=0)
    told = f"{TOLERANCE:.0e}".replace("e-0", "e-")
    held = alone.found.states[:, states.index("arm.q")]
    return f"""`{ARM}` is the arm with the drive of figure 6 on both axes, gravity, and a servo loop on each:
{len(states)} states, {len(j.arm.switches)} switches. The paper prints no numbers for it. Length and mass of the arm
are one, and the gear ratio {turns(j.arm):.4g} is the one at which the stretched arm is the load J_4 that the paper
prints. The equations are not linear between events, so that the general method integrates them (order 5,
{told} a step). After {HOLD:g} s at rest, with the arm {LIFT:g} rad above the horizontal, the column is asked to
turn by {ANGLE:g} rad and the arm by {-ANGLE:g}, both at {SPEED:g} rad/s and {ACCELERATION:g} rad/s²:

![The arm with both drives](paper/two-axes.svg)

Gravity keeps the arm {1e3 * sag:.1f} mrad below what it is asked, and presses its flexspline against one flank. Over
the run that clearance {_opened(both.found, "arm")}; that of the column, which has no such load,
{_opened(both.found, "column")}, and the column ends in small swings between its flanks. Largest differences
from what is asked: column {1e3 * error[0]:.1f} mrad, arm
{1e3 * error[1]:.1f} mrad. When the column alone moves, the centripetal torque lifts or lowers the arm by
{1e3 * (held.max() - held.min()):.2f} mrad."""


def how_long(j: Jumps) -> str:
    rows = ["| | states | seconds | events | proven steps, about |", "| --- | ---: | ---: | ---: | ---: |"]
    runs = {"open loop, figure 11": j.steps["friction and clearance"]}
    runs |= {f"servo loop, {name}": found for name, found in j.servo.items()}
    rows += [_run(name, len(j.drive.kernel.states), found) for name, found in runs.items()]
    rows.append(_run("arm with both drives", len(j.arm.kernel.states), j.both.found))
    return f""""Simulation time of the robot model is too long", section 6 says, for Coulomb friction and backlash. A
sign and a gap stop every integrator that does not know of them. symdyn makes them modes: between events the drive is a
linear system, propagated by its exponential, and a step only counts when every guard is proven to stay positive along
it. Servo loop: 50 V/rad, 0.5 V s/rad, ±24 V.

{chr(10).join(rows)}

For the arm, steps are those of the integration and nothing is proven: guards are watched at five points of every
step. {MEASURED}"""


def _symmetry(j: Jumps) -> str:
    """Whether the motion is as symmetric as the machine."""
    broken = [
        f"{100 * found.even[i]:.0f} % even harmonics at {found.hertz[i]:.3g} Hz and {name}"
        for name, found in j.measured.items()
        for i in np.flatnonzero(found.even > _EVEN)
    ]
    if not broken:
        return "So is its motion: there is no even distortion."
    return (
        f"Yet it may settle to a motion that is not, one of two that mirror each other: {', '.join(broken)}.\n"
        "Elsewhere there is no even distortion."
    )


def _periodic(measured: Sequence[SteppedSine]) -> str:
    count = sum(int(np.sum(~m.settled)) for m in measured)
    return (
        f"{count} points (circled) never repeat." if count else "At every point the motion repeats itself in the end."
    )


def _run(name: str, states: int, found: HybridTrajectory) -> str:
    return f"| {name} | {states} | {found.time[-1]:g} | {len(found.events)} | {float(f'{found.steps:.1e}'):.0f} |"


def _told(event: Event) -> str:
    if event.kind == "friction":
        return "the motor sticks" if event.after == 0 else "the motor sets off"
    side = "upper" if max(event.before, event.after) > 0 else "lower"
    if abs(event.after) == 1:
        return f"the {side} flanks meet"
    return f"the {side} flanks part" if abs(event.after) == 2 else "the twist comes back into the gap"


def _opened(found: HybridTrajectory, joint: str) -> str:
    met = sum(e.kind == "contact" and abs(e.after) == 1 and e.switch == f"{joint}.flexspline" for e in found.events)
    return f"opens and closes {met} times" if met > 1 else ("opens and closes once" if met else "never opens")


def _top(found: HybridTrajectory) -> float:
    """Speed of the motor when the voltage is taken back."""
    return float(found.states[np.searchsorted(found.time, BACK), 5])


def _at(found: Response | SteppedSine, hertz: float) -> float:
    return float(np.interp(np.log(hertz), np.log(found.hertz), 20 * np.log10(np.abs(found.values))))


def _low(found: Response | SteppedSine) -> float:
    inside = (found.hertz > 3.0) & (found.hertz < 14.0)
    return float(found.hertz[inside][np.argmin(np.abs(found.values[inside]))])


def _high(found: Response | SteppedSine) -> float:
    inside = (found.hertz > 10.0) & (found.hertz < 30.0)
    return float(found.hertz[inside][np.argmax(np.abs(found.values[inside]))])
