"""Equations of motion as LaTeX for people: amsmath, long ones split, every term traceable."""

from __future__ import annotations

from collections.abc import Set

import sympy as sp

from symdyn.base import symbols
from symdyn.derive.equations import EquationsOfMotion
from symdyn.derive.lagrange import LagrangeCoefficients, readable, textbook_coefficients
from symdyn.emit.latex_names import Printer
from symdyn.emit.latex_notation import notation
from symdyn.emit.latex_recursion import recursion
from symdyn.emit.latex_text import Equation, escape, listed, ordered, signed
from symdyn.emit.templates import render

TEMPLATES = ("latex/equations.tex.j2", "latex/coefficients.tex.j2", "latex/recursion.tex.j2")
READABLE_JOINTS = 3  # beyond this, Lagrange in closed form is no longer for people


def equations_of_motion(equations: EquationsOfMotion) -> tuple[Equation, ...]:
    """One equation per coordinate, then one per load that friction depends on, then one per hidden state.

    Up to three joints the arm stands in Lagrange's textbook form; of larger arms the
    document shows the recursion.
    """
    printer = Printer(equations)
    found = [Equation(place, signed(printer, left), signed(printer, right)) for place, left, right in sides(equations)]
    count = len(equations.states)
    for i, state in enumerate(equations.states, start=len(found) - count):
        rate = rf"\dot{{{printer(state.symbol)}}}"
        left = (rate if state.storage == 1 else rf"{printer(state.storage)} \, {rate}",)
        found[i] = Equation(state.name, left, found[i].right)
    return tuple(found)


def sides(equations: EquationsOfMotion) -> list[tuple[str, list[sp.Expr], list[sp.Expr]]]:
    """(place, left terms, right terms) of every equation: inertia, velocity terms and gravity = forces."""
    arm = _arm_terms(equations)
    found = []
    for k, axis in enumerate(equations.axes):
        left = [*arm[k], *_inertial_terms(equations, k)]
        right = [term for c in equations.contributions for term in sp.Add.make_args(c.applied[k])]
        right += [c.actuation[k] for c in equations.contributions]
        right += [i.force[k] for i in equations.inputs]
        found.append((axis.address, left, right))
    for load in equations.loads:
        k = load.axis
        needed = [*arm[k], *sp.Add.make_args(load.needed - equations.arm[k])]
        found.append((f"load of {equations.axes[k].address}", [load.symbol], needed))
    for state in equations.states:
        rate = sp.Symbol(f"{state.symbol}_dot", real=True)
        found.append((state.name, [state.storage * rate], list(sp.Add.make_args(state.rate))))
    return found


def terms_with(equations: EquationsOfMotion, parameters: Set[str]) -> frozenset[str]:
    """The signed LaTeX of the terms in which one of the named parameters stands: what a diagnosis added."""
    marked = {symbols.parameter(name) for name in parameters}
    printer = Printer(equations)
    return frozenset(
        text
        for _, left, right in sides(equations)
        for term in (*left, *right)
        if term.free_symbols & marked
        for text in signed(printer, [term])
    )


def coefficients(equations: EquationsOfMotion) -> tuple[Equation, ...]:
    """The non-zero B_ij, C_ijk and D_i of the arm (seed eq. 9), simplified."""
    if len(equations.robot.joints) > READABLE_JOINTS:
        return ()
    printer = Printer(equations)
    found = []
    lagrange = _lagrange(equations)
    numbers = range(1, len(lagrange.axes) + 1)
    for i in numbers:
        for j in numbers:
            if j >= i and lagrange.B[i - 1, j - 1] != 0:
                found.append(_coefficient(printer, f"B_{{{i}{j}}}", lagrange.B[i - 1, j - 1]))
    for i in numbers:
        for j in numbers:
            for k in numbers:
                if k >= j and lagrange.C[i - 1][j - 1, k - 1] != 0:
                    found.append(_coefficient(printer, f"C_{{{i}{j}{k}}}", lagrange.C[i - 1][j - 1, k - 1]))
    for i in numbers:
        if lagrange.D[i - 1] != 0:
            found.append(_coefficient(printer, f"D_{{{i}}}", lagrange.D[i - 1]))
    return tuple(found)


def document(equations: EquationsOfMotion) -> str:
    """A complete LaTeX document: coordinates, parameters, equations, coefficients of the arm."""
    robot = equations.robot
    displayed = "\n\n".join(f"\\paragraph{{{escape(e.title)}}}\n{e.latex()}" for e in equations_of_motion(equations))
    rows = [
        f"${p.latex}$ & {'free' if p.value is None else _number(p.value)} & {escape(p.unit)} & {escape(p.meaning)} \\\\"
        for p in robot.parameters
    ]
    axes = [
        f"$q_{{{i}}}$ & {escape(axis.address)} & {escape(axis.unit)} \\\\" for i, axis in enumerate(equations.axes, 1)
    ]
    return render(
        "latex/equations.tex.j2",
        {
            "title": escape(robot.name),
            "description": escape(robot.description),
            "coordinates": "\n".join(axes),
            "parameters": "\n".join(rows) or "& & & \\\\",
            "equations": displayed,
            "notation": _notation(equations),
            "arm": _arm(equations),
        },
    )


def operators(equations: EquationsOfMotion) -> tuple[tuple[str, str], ...]:
    """(LaTeX, meaning) of the operators in the equations of motion."""
    return notation(term for _, left, right in sides(equations) for term in (*left, *right))


def _notation(equations: EquationsOfMotion) -> str:
    rows = [rf"${symbol}$ & {words} \\" for symbol, words in operators(equations)]
    if not rows:
        return ""
    return "\n".join([r"\paragraph{Notation}", r"\begin{longtable}{lp{115mm}}", *rows, r"\end{longtable}"])


def _arm(equations: EquationsOfMotion) -> str:
    """The rigid arm: coefficients of Lagrange's equations where people can read them, else the recursion."""
    if len(equations.robot.joints) > READABLE_JOINTS:
        return render("latex/recursion.tex.j2", {"recursion": recursion(equations)})
    return render("latex/coefficients.tex.j2", {"coefficients": listed(coefficients(equations)) or "All are zero."})


def _lagrange(equations: EquationsOfMotion) -> LagrangeCoefficients:
    return textbook_coefficients(equations.robot)


def _arm_terms(equations: EquationsOfMotion) -> list[list[sp.Expr]]:
    """Per coordinate, the arm's terms: B qdd, C qd qd, D in turn."""
    if len(equations.robot.joints) > READABLE_JOINTS:
        return [[symbols.arm_effort(k)] if term != 0 else [] for k, term in enumerate(equations.arm, start=1)]
    lagrange = _lagrange(equations)
    by_address = {axis.address: i for i, axis in enumerate(lagrange.axes)}
    found: list[list[sp.Expr]] = []
    for axis in equations.axes:
        i = by_address.get(axis.address)
        if i is None:
            found.append([])
            continue
        terms = [lagrange.B[i, j] * other.qdd for j, other in enumerate(lagrange.axes)]
        for j, first in enumerate(lagrange.axes):
            for k, second in enumerate(lagrange.axes[j:], start=j):
                count = 1 if k == j else 2
                terms.append(readable(count * lagrange.C[i][j, k]) * first.qd * second.qd)
        found.append([*terms, *sp.Add.make_args(lagrange.D[i])])
    return found


def _inertial_terms(equations: EquationsOfMotion, k: int) -> list[sp.Expr]:
    return [term for c in equations.contributions for term in sp.Add.make_args(c.inertial[k])]


def _coefficient(printer: Printer, name: str, value: sp.Expr) -> Equation:
    return Equation(name, (name,), signed(printer, ordered(value)))


def _number(value: float) -> str:
    mantissa, _, exponent = f"{value:.6g}".partition("e")
    return f"${mantissa}$" if not exponent else rf"${mantissa} \cdot 10^{{{int(exponent)}}}$"
