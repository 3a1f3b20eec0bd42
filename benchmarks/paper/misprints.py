"""The misprints that a derivation exposes, derived here: eq. 21, and the damper that the assembled model loses."""

from __future__ import annotations

import sympy as sp

from benchmarks.paper.study import Study
from symdyn.base.symbols import parameter
from symdyn.compiler import load_robot
from symdyn.derive.equations import equations_of_motion
from symdyn.derive.lagrange import lagrange_coefficients
from symdyn.derive.linearize import without_nonsmooth
from symdyn.emit import plain_text

_THETA, _PHI_DOT, _THETA_DOT = sp.symbols("theta phi_dot theta_dot", real=True)
_MASS, _LENGTH, _GRAVITY = sp.symbols("m l g", positive=True)


def arm_terms(name: str) -> dict[str, sp.Expr]:
    """Torques of the two-d.o.f. arm from its Lagrange coefficients, theta counted from the upward vertical."""
    derived = lagrange_coefficients(load_robot(name))
    q2, qd1, qd2 = derived.axes[1].q, derived.axes[0].qd, derived.axes[1].qd
    names = {parameter("m"): _MASS, parameter("l"): _LENGTH, parameter("g"): _GRAVITY}
    names |= {q2: sp.pi / 2 - _THETA, qd1: _PHI_DOT, qd2: -_THETA_DOT}
    terms = {
        "centripetal torque on the arm (eq. 20)": derived.C[1][0, 0] * qd1**2,
        "Coriolis torque on the column (eq. 21)": (derived.C[0][0, 1] + derived.C[0][1, 0]) * qd1 * qd2,
        "gravity torque on the arm (eq. 22)": derived.D[1],
        "Coriolis torque on the arm": (derived.C[1][0, 1] + derived.C[1][1, 0]) * qd1 * qd2,
    }
    return {title: _double_angle(term.subs(names)) for title, term in terms.items()}


def arm_table() -> str:
    printed = {
        "centripetal torque on the arm (eq. 20)": "1/8 m l² ω² sin 2θ",
        "Coriolis torque on the column (eq. 21)": "1/8 m φ' θ' sin 2θ",
        "gravity torque on the arm (eq. 22)": "1/2 m g l sin θ",
        "Coriolis torque on the arm": '"much smaller"',
    }
    point, rod = arm_terms("irb6-arm"), arm_terms("irb6-arm-rod")
    rows = ["| | printed | derived, point mass at l/2 | derived, uniform rod |", "| --- | --- | --- | --- |"]
    rows += [f"| {title} | {printed[title]} | `{point[title]}` | `{rod[title]}` |" for title in printed]
    return "\n".join(rows)


def ratio_of_21() -> str:
    """Derived over printed."""
    title = "Coriolis torque on the column (eq. 21)"
    as_printed = _MASS * _PHI_DOT * _THETA_DOT * sp.sin(2 * _THETA) / 8
    return str(sp.simplify(arm_terms("irb6-arm")[title] / as_printed))


def drive_equations() -> str:
    """Eq. 14 to 17 with the circuit, as symdyn prints them."""
    equations = equations_of_motion(without_nonsmooth(load_robot("irb6-axis1")))
    return "\n".join(f"{place}:\n    {text}" for place, text in plain_text.equations(equations))


def lost_damper(s: Study) -> str:
    rows = ["| | d_2 on both sides | d_2 on J_3 alone, as assembled in print |", "| --- | ---: | ---: |"]
    for number, (whole, lost) in enumerate(zip(s.swinging, s.with_lost_damper(), strict=True), start=1):
        cells = [f"{mode.frequency:.5g} Hz, damping ratio {mode.damping:.3f}" for mode in (whole, lost)]
        rows.append(f"| mode {number} | {cells[0]} | {cells[1]} |")
    return "\n".join(rows)


def _double_angle(term: sp.Expr) -> sp.Expr:
    return sp.factor_terms(sp.fu(sp.expand_trig(term)))
