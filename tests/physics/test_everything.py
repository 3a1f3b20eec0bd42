"""All effects in one machine: energy adds up, they survive their file, they print, and the linear part is smooth."""

from __future__ import annotations

from functools import cache

import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st
from mpmath import mpf, workdps

from symdyn.base import symbols
from symdyn.compiler import robot_from_text
from symdyn.derive.equations import EquationsOfMotion, equations_of_motion
from symdyn.derive.linearize import without_nonsmooth
from symdyn.derive.ports import Attachment
from symdyn.derive.power import of_kind, power_flows
from symdyn.emit.latex import document
from symdyn.emit.plain_text import equations as in_plain_text
from symdyn.physics import catalogue, schemas
from symdyn.physics.effect import PORT
from symdyn.program.differentiate import differentiate
from symdyn.program.evaluate import evaluate
from symdyn.program.functions import functions
from symdyn.program.lower import lower
from symdyn.program.ssa import Program
from symdyn.spec.toml_writer import to_toml

from .everything import everything

DIGITS = 40
NUMBER = st.floats(-2, 2).map(lambda value: round(value, 6))


@cache
def machine() -> tuple[EquationsOfMotion, dict[str, Program], list[float]]:
    """Its equations, the programs of its functions and the values of its parameters."""
    robot = everything()
    equations = equations_of_motion(robot)
    values = [p.value for p in robot.parameters if p.value is not None]
    return equations, {f.name: f.program for f in functions(equations)}, values


def test_it_has_them_all() -> None:
    equations, *_ = machine()
    transmissions = {"backlash", "kinematic_error"}  # which are in the ports of the others
    assert {item.effect.identifier for item in equations.attachments} == set(catalogue()) - transmissions


def received(item: Attachment) -> sp.Expr:
    """Power that an effect gives to the motion and to its own store, but for what its energies account for."""
    effect, values, port = item.effect, item.values, item.port
    resisting = sp.diff(effect.dissipation(PORT, values), PORT.v)
    force = port.located(effect.force(PORT, values) - resisting)
    force += effect.state_force(port, values, item.states, item.control)
    stored = effect.stored_energy(values, item.states)
    rates = effect.rates(port, values, item.states, item.control)
    kept = [sp.diff(stored, z) * r.change / r.storage for z, r in zip(item.states, rates, strict=True)]
    return sp.Add(force * port.v, *kept)


@cache
def book_keeping() -> tuple[Program, Program]:
    """(energy in hidden states, power that all effects and inputs give) as programs of x, u, p."""
    equations, programs, _ = machine()
    x, u, p = programs["state_derivative"].arguments
    items = equations.attachments
    stored = sum((i.effect.stored_energy(i.values, i.states) for i in items), sp.Integer(0))
    given = sum((received(i) for i in items), sp.Integer(0))
    given += sum(
        (f * a.qd for i in equations.inputs for f, a in zip(i.force, equations.axes, strict=True)), sp.Integer(0)
    )
    made = [lower(name, (x, u, p), (), [law], (1,)) for name, law in (("stored", stored), ("given", given))]
    return made[0], made[1]


@settings(max_examples=10, deadline=None)
@given(st.data())
def test_energy_changes_by_what_effects_give(data: st.DataObject) -> None:
    """By a central difference along the motion, in forty digits."""
    equations, programs, p = machine()
    n, count = len(equations.axes), len(programs["state_derivative"].arguments[0].symbols)
    x = data.draw(st.lists(NUMBER, min_size=count, max_size=count))
    u = data.draw(st.lists(NUMBER, min_size=2, max_size=2))
    stored, given_power = book_keeping()

    def energy(state: list[mpf]) -> mpf:
        mechanical = evaluate(programs["energy"], {"q": state[:n], "qd": state[n : 2 * n], "p": p}, dps=DIGITS)
        return sum(mechanical) + evaluate(stored, {"x": state, "u": u, "p": p}, dps=DIGITS)[0]

    rates = evaluate(programs["state_derivative"], {"x": x, "u": u, "p": p}, dps=DIGITS)
    with workdps(DIGITS):
        h = mpf(10) ** -16
        later, earlier = ([a + sign * h * rate for a, rate in zip(x, rates, strict=True)] for sign in (1, -1))
        change = (energy(later) - energy(earlier)) / (2 * h)
    expected = evaluate(given_power, {"x": x, "u": u, "p": p}, dps=DIGITS)[0]
    assert abs(change - expected) <= 1e-12 * max(1, abs(expected))


def test_the_file_that_is_written_reads_back() -> None:
    robot = everything()
    again = robot_from_text(to_toml(robot, schemas()), "again")
    assert [(e.type, e.at, e.values) for e in again.effects] == [(e.type, e.at, e.values) for e in robot.effects]
    assert {p.name: (p.value, p.unit) for p in again.parameters} == {
        p.name: (p.value, p.unit) for p in robot.parameters
    }


def test_all_is_printed() -> None:
    """Every parameter of every effect by its own LaTeX, but for what a stage hands to no motor; brackets close."""
    equations, *_ = machine()
    text = document(equations)
    assert text.count("{") == text.count("}")
    assert text.count(r"\left") == text.count(r"\right")
    laws = [sp.sympify(law) for c in equations.contributions for law in (*c.inertial, *c.applied, *c.actuation)]
    laws += [law for state in equations.states for law in (state.storage, state.rate)]
    shown = {symbol for law in laws for symbol in law.free_symbols}
    names = [p.latex for p in equations.robot.parameters if symbols.parameter(p.name) in shown]
    assert len(names) > 60
    assert [name for name in names if name not in text] == []
    assert len(in_plain_text(equations)) == len(equations.axes) + len(equations.states)


def test_the_linear_part_keeps_what_is_smooth() -> None:
    robot = without_nonsmooth(everything())
    kept = {e.type: e for e in robot.effects}
    jumping = {
        "amplifier_dead_zone",
        "amplifier_saturation",
        "asymmetric_coulomb_friction",
        "asymmetric_viscous_friction",
        "backlash",
        "coulomb_friction",
        "effort_saturation",
        "load_dependent_friction",
        "quadratic_drag",
        "stribeck_friction",
    }
    assert set(kept) == {e.type for e in everything().effects} - jumping
    assert dict(kept["encoder"].values)["resolution"].is_zero
    assert not dict(kept["encoder"].values)["gain"].is_zero


@settings(max_examples=20, deadline=None)
@given(st.data())
def test_power_in_and_out_is_the_growth_of_what_is_stored(data: st.DataObject) -> None:
    """Over all elements of the machine, by name: d stored/dt along its equations = supplied - dissipated."""
    _, programs, values = machine()
    x, u, _ = programs["state_derivative"].arguments
    state = {a.name: data.draw(st.lists(NUMBER, min_size=len(a.symbols), max_size=len(a.symbols))) for a in (x, u)}
    at = {**state, "p": values}
    with workdps(DIGITS):
        rate = evaluate(programs["state_derivative"], at, DIGITS)
        powers = [evaluate(flow_program(kind), at, DIGITS) for kind in ("supplied", "dissipated")]
        slopes = evaluate(differentiate(flow_program("stored"), x.symbols, "slopes"), at, DIGITS)
        n = len(x.symbols)
        growth = sum(slope * rate[k % n] for k, slope in enumerate(slopes))
        assert abs(growth - sum(powers[0]) + sum(powers[1])) < mpf(10) ** -20 * (1 + sum(map(abs, powers[0])))


@cache
def flow_program(kind: str) -> Program:
    equations, programs, _ = machine()
    entries = list(of_kind(power_flows(equations), kind).values())
    arguments = programs["state_derivative"].arguments
    return lower(kind, arguments, equations.energy_steps if kind == "stored" else (), entries, (len(entries),))
