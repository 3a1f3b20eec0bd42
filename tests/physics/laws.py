"""The laws of an effect as expressions with units, and numbers to put into them."""

from __future__ import annotations

import inspect
from collections.abc import Mapping, Sequence
from fractions import Fraction
from functools import cache

import pytest
import sympy as sp
from hypothesis import strategies as st
from mpmath import mpf, workdps

from symdyn.base import symbols
from symdyn.base.units import parse_unit
from symdyn.compiler import robot_from_text
from symdyn.physics import catalogue
from symdyn.physics.effect import PORT, Effect, Values, unit_at
from symdyn.physics.servo_loop import ServoLoop
from symdyn.program.evaluate import evaluate
from symdyn.program.lower import lower
from symdyn.program.ssa import Argument, Program
from symdyn.spec.effect_schema import ParameterSchema
from symdyn.spec.places import places
from symdyn.spec.records import Motion, PlaceKind

# One joint of each kind, each with a whole drive: every kind of place in every motion that it can have.
MACHINE = """\
[robot]
name = "both-kinds"
gravity = [0, 0, 0]

[dh]
rows = [ ["q", 0, 0, 0], [0, "q", 0, 0] ]
"""
JOINT = """
[[joint]]
name = "{name}"
link = {{ mass = 1, inertia = {{ zz = 1 }} }}

[joint.drive]
ratio = 10
rotors = [ {{ name = "motor", inertia = 1 }} ]
shafts = [ {{ name = "belt", from = "motor", to = "joint", stiffness = 1, damping = 1 }} ]
motor = {{ name = "circuit", at = "motor", resistance = 1, inductance = 1, torque_constant = 1, back_emf_constant = 1 }}
"""

HOOKS = tuple(name for name, _ in inspect.getmembers(Effect, inspect.isfunction) if not name.startswith("_"))
# In a circuit a voltage takes the place of the force, the charge that of the displacement.
EFFORT_UNIT = {Motion.ROTATIONAL: "N m", Motion.TRANSLATIONAL: "N", Motion.ELECTRICAL: "V"}
SPEED_UNIT = {Motion.ROTATIONAL: "rad/s", Motion.TRANSLATIONAL: "m/s", Motion.ELECTRICAL: "A"}
DISPLACEMENT_UNIT = {Motion.ROTATIONAL: "rad", Motion.TRANSLATIONAL: "m", Motion.ELECTRICAL: "A s"}
CONTROL = symbols.control(1)
DIGITS, ROUNDING = 40, 1e-30

every_effect = pytest.mark.parametrize("identifier", catalogue())


@cache
def motions() -> Mapping[PlaceKind, frozenset[Motion]]:
    """The motions that each kind of place can have."""
    text = MACHINE + JOINT.format(name="turns") + JOINT.format(name="slides")
    found = [(place.kind, place.motion) for place in places(robot_from_text(text, "machine"))]
    return {kind: frozenset(motion for k, motion in found if k is kind) for kind in PlaceKind}


def letters(effect: Effect) -> Values:
    """Symbols for the parameters; counts, which decide the structure, are three."""
    return {p.name: sp.Integer(3) if p.is_count else symbols.parameter(p.name) for p in effect.parameters}


def at_null(effect: Effect) -> Values:
    """The parameters with their null values in place; those that have none stay letters."""
    nulls = {p.name: symbols.number(p.null) for p in effect.parameters if p.null is not None}
    return letters(effect) | nulls


def states(effect: Effect, p: Values) -> tuple[sp.Symbol, ...]:
    return tuple(symbols.hidden(k) for k, _ in enumerate(effect.hidden_states(p), start=1))


def along(effect: Effect, p: Values) -> sp.Expr:
    """The whole force along the port, energies included; that of a hidden state is apart."""
    from_energy = sp.diff(effect.potential_energy(PORT, p), PORT.x) + sp.diff(effect.dissipation(PORT, p), PORT.v)
    return effect.force(PORT, p) - from_energy


def overridden(effect: Effect) -> set[str]:
    return {name for name in HOOKS if getattr(type(effect), name) is not getattr(Effect, name)} - {"schema"}


_FACTOR = st.fractions(Fraction(1, 5), 5, max_denominator=5)
SCALES = st.fixed_dictionaries(dict.fromkeys(("mass", "length", "time", "current", "temperature"), _FACTOR))


def exact(value: Fraction) -> sp.Rational:
    return sp.Rational(value.numerator, value.denominator)


def in_digits(value: Fraction) -> mpf:
    with workdps(DIGITS):
        return mpf(value.numerator) / value.denominator


@cache
def lowered(law: sp.Expr) -> tuple[tuple[sp.Symbol, ...], Program]:
    """The symbols that a law holds, and the program that computes it of them."""
    held = tuple(sorted(law.free_symbols, key=str))
    return held, lower("law", (Argument("v", tuple(map(str, held))),), (), (law,), (1,))


def value_of(law: sp.Expr, numbers: Mapping[sp.Symbol, Fraction]) -> mpf:
    """In forty digits."""
    held, program = lowered(sp.sympify(law))
    (value,) = evaluate(program, {"v": [in_digits(numbers[symbol]) for symbol in held]}, dps=DIGITS)
    return value


def within_bounds(parameter: ParameterSchema) -> st.SearchStrategy[Fraction]:
    """Values between the bounds; well away from zero where the effect has no meaning there."""
    least = Fraction(-3) if parameter.lower is None else Fraction(repr(parameter.lower))
    most = Fraction(3) if parameter.upper is None else Fraction(repr(parameter.upper))
    if parameter.null is None:
        least = max(least, Fraction(1, 10))
    return st.fractions(least, most, max_denominator=20) if most > least else st.just(least)


def situations(effect: Effect) -> st.SearchStrategy[dict[sp.Symbol, Fraction]]:
    """Numbers for displacement, speed, hidden state, input and every parameter."""
    moving = st.fractions(-3, 3, max_denominator=20)
    fixed = {symbols.parameter(p.name): within_bounds(p) for p in effect.parameters if not p.is_count}
    assert PORT.start is not None
    free = (PORT.x, PORT.v, PORT.load, PORT.start.x, PORT.start.v, CONTROL, *states(effect, letters(effect)))
    return st.fixed_dictionaries(dict.fromkeys(free, moving) | fixed)


def factor(unit: str, scales: Mapping[str, Fraction]) -> Fraction:
    """What a number in this unit is multiplied by when the base units shrink by ``scales``."""
    product = Fraction(1)
    for base, power in parse_unit(unit).dimension:
        product *= scales[base] ** power
    return product


def laws(effect: Effect, motion: Motion) -> list[tuple[str, sp.Expr, str]]:
    """(what, expression, unit) of everything that the effect computes."""
    p, push = letters(effect), EFFORT_UNIT[motion]
    z = states(effect, p)
    found = [
        ("kinetic energy", effect.kinetic_energy(PORT, p), "J"),
        ("potential energy", effect.potential_energy(PORT, p), "J"),
        ("Rayleigh function", effect.dissipation(PORT, p), "W"),
        ("force", effect.force(PORT, p), push),
        ("whole force", along(effect, p), push),
        ("force of the hidden states", effect.state_force(PORT, p, z, CONTROL), push),
        ("stored energy", effect.stored_energy(p, z), "J"),
    ]
    for state, rate in zip(effect.hidden_states(p), effect.rates(PORT, p, z, CONTROL), strict=True):
        found.append((f"rate of {state.name}", rate.change / rate.storage, f"{unit_at(state.unit, motion)}/s"))
    sensor, through, body = effect.sensor(PORT, p, z), effect.transmission(PORT, p), effect.body(p)
    current, amplified = effect.current(PORT, p, z, CONTROL), effect.amplified(p, z, CONTROL)
    if sensor is not None:
        found.append(("sensor", sensor.value, unit_at(sensor.unit, motion)))
    if through is not None:
        found += [("displacement let through", through.x, DISPLACEMENT_UNIT[motion])]
        found += [("speed let through", through.v, SPEED_UNIT[motion])]
    if body is not None:
        found += [("mass", body.mass, "kg"), *(("position", entry, "m") for entry in body.position)]
    if current is not None:
        found.append(("current", current, "A"))
    if amplified is not None:
        found.append(("amplified input", amplified, push))
    return [*found, *loop_laws(effect, motion, p, z)]


def loop_laws(effect: Effect, motion: Motion, p: Values, z: Sequence[sp.Symbol]) -> list[tuple[str, sp.Expr, str]]:
    """Those of a servo loop, continuous too."""
    if not isinstance(effect, ServoLoop):
        return []
    unit = unit_at(effect.hands_on, motion)
    memory = z[: len(effect.memory(p))]
    found = [("output", effect.output(PORT, p, memory, CONTROL), unit)]
    found.append(("output that is held", effect.controls(PORT, p, z, CONTROL), unit))
    rates = effect.memory_rates(PORT, p, memory, CONTROL)
    for state, rate in zip(effect.memory(p), rates, strict=True):
        found.append((f"rate of {state.name}", rate, f"{unit_at(state.unit, motion)}/s"))
    for update in effect.updates(PORT, p, z, CONTROL):
        found += [("period", update.period, "s"), ("delay", update.delay, "s")]
        for state, value in zip(effect.hidden_states(p), update.values, strict=True):
            found.append((f"new {state.name}", value, unit_at(state.unit, motion)))
    return found


def scalings(effect: Effect, motion: Motion) -> dict[sp.Symbol, str]:
    """The unit of every symbol that a law may hold."""
    p = letters(effect)
    units = {symbols.parameter(s.name): s.units[motion] for s in effect.parameters}
    assert PORT.start is not None
    units |= dict.fromkeys((PORT.x, PORT.start.x), DISPLACEMENT_UNIT[motion])
    units |= dict.fromkeys((PORT.v, PORT.start.v), SPEED_UNIT[motion])
    declared = zip(states(effect, p), effect.hidden_states(p), strict=True)
    units |= {symbol: unit_at(state.unit, motion) for symbol, state in declared}
    reference = effect.reference_unit()
    steered = unit_at(reference, motion) if reference is not None else effect.input_unit() or EFFORT_UNIT[motion]
    return units | {PORT.load: EFFORT_UNIT[motion], CONTROL: steered}
