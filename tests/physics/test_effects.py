"""Every effect of the catalogue keeps what it declares: units, null values, dissipation, conservation, completeness."""

from __future__ import annotations

import inspect
import math
import pkgutil
from collections.abc import Mapping
from fractions import Fraction
from functools import cache
from typing import final

import pytest
import sympy as sp
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from symdyn.base import symbols
from symdyn.base.latex_check import is_safe_latex
from symdyn.base.units import parse_unit
from symdyn.compiler import robot_from_text
from symdyn.physics import catalogue, effects, schemas
from symdyn.physics.effect import EFFORT, MECHANICAL, MOVING, PORT, Effect, Port, Values
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
EFFORT_UNIT = {Motion.ROTATIONAL: "N m", Motion.TRANSLATIONAL: "N"}
SPEED_UNIT = {Motion.ROTATIONAL: "rad/s", Motion.TRANSLATIONAL: "m/s"}
DISPLACEMENT_UNIT = {Motion.ROTATIONAL: "rad", Motion.TRANSLATIONAL: "m"}
STATE, CONTROL = symbols.hidden(1), symbols.control(1)

every_effect = pytest.mark.parametrize("identifier", catalogue())


@cache
def motions() -> Mapping[PlaceKind, frozenset[Motion]]:
    """The motions that each kind of place can have."""
    text = MACHINE + JOINT.format(name="turns") + JOINT.format(name="slides")
    found = [(place.kind, place.motion) for place in places(robot_from_text(text, "machine"))]
    return {kind: frozenset(motion for k, motion in found if k is kind) for kind in PlaceKind}


def letters(effect: Effect) -> Values:
    return {p.name: symbols.parameter(p.name) for p in effect.parameters}


def at_null(effect: Effect) -> Values:
    """The parameters with their null values in place; those that have none stay letters."""
    return {p.name: symbols.parameter(p.name) if p.null is None else symbols.number(p.null) for p in effect.parameters}


def along(effect: Effect, p: Values) -> sp.Expr:
    """The whole force along the port, energies included; that of a hidden state is apart."""
    from_energy = sp.diff(effect.potential_energy(PORT, p), PORT.x) + sp.diff(effect.dissipation(PORT, p), PORT.v)
    return effect.force(PORT, p) - from_energy


def overridden(effect: Effect) -> set[str]:
    return {name for name in HOOKS if getattr(type(effect), name) is not getattr(Effect, name)} - {"schema"}


# Completeness.


def shortcomings(effect: Effect) -> list[str]:
    """What a declaration lacks."""
    kind = type(effect)
    missing = [name for name in ("title", "source") if not getattr(kind, name, "").strip()]
    if effect.proposable and not effect.signature.strip():
        missing.append("signature")
    missing += [f"docstring of {kind.__module__}" for _ in range(not (inspect.getmodule(kind).__doc__ or "").strip())]
    missing += [f"effect {other}" for other in effect.rivals if other not in catalogue() or other == effect.identifier]
    if effect.builds_on is not None and effect.builds_on not in catalogue():
        missing.append(f"effect {effect.builds_on}")
    if not effect.attaches_to:
        missing.append("places")
    if not overridden(effect):
        missing.append("physics: no hook is defined")
    if "dissipation" in overridden(effect) and not effect.dissipative:
        missing.append("dissipative: it has a Rayleigh function")
    if ("hidden_state" in overridden(effect)) != ("storage_and_rate" in overridden(effect)):
        missing.append("hidden state with its rate")
    if not any(p.null is not None for p in effect.parameters):
        missing.append("a parameter whose null value removes it")
    for p in effect.parameters:
        missing += [f"meaning of {p.name}" for _ in range(not p.meaning.strip())]
        missing += [f"LaTeX of {p.name}" for _ in range(not is_safe_latex(p.latex))]
        bounds = [b for b in (p.lower, p.null, p.upper) if b is not None]
        missing += [f"null value of {p.name} within its bounds" for _ in range(bounds != sorted(bounds))]
        for place in effect.attaches_to:
            missing += [f"unit of {p.name} at a {m} {place}" for m in motions()[place] if m not in p.units]
    names = [p.name for p in effect.parameters]
    missing += [f"another name for {name}" for name in {n for n in names if names.count(n) > 1}]
    return missing


@every_effect
def test_declaration_is_complete(identifier: str) -> None:
    assert shortcomings(catalogue()[identifier]) == []


def test_a_poor_declaration_is_found() -> None:
    assert set(shortcomings(Poor())) >= {
        "source",
        "signature",
        "effect gremlins",
        "effect nothing_known",
        "physics: no hook is defined",
        "meaning of size",
        "LaTeX of size",
        "unit of size at a translational joint",
        "null value of size within its bounds",
    }


def test_each_kind_of_place_was_seen() -> None:
    assert all(motions()[kind] for kind in PlaceKind)
    assert motions()[PlaceKind.JOINT] == {Motion.ROTATIONAL, Motion.TRANSLATIONAL}


# The registry.


def test_one_effect_per_file_named_as_its_file() -> None:
    files = sorted(module.name for module in pkgutil.iter_modules(effects.__path__))
    assert [type(effect).__module__.rpartition(".")[2] for effect in catalogue().values()] == files
    assert list(catalogue()) == files


def test_effects_come_in_alphabetical_order_under_their_own_names() -> None:
    assert list(catalogue()) == sorted(catalogue())
    assert all(effect.identifier == identifier for identifier, effect in catalogue().items())


@every_effect
def test_readers_of_files_see_what_is_declared(identifier: str) -> None:
    effect, schema = catalogue()[identifier], schemas()[identifier]
    assert (schema.identifier, schema.title) == (identifier, effect.title)
    assert (schema.attaches_to, schema.parameters) == (effect.attaches_to, effect.parameters)


# Units: multiply the base units by any factors; every law must follow, each number by its own dimension.

_FACTOR = st.fractions(Fraction(1, 5), 5, max_denominator=5)
SCALES = st.fixed_dictionaries(dict.fromkeys(("mass", "length", "time", "current"), _FACTOR))


def exact(value: Fraction) -> sp.Rational:
    return sp.Rational(value.numerator, value.denominator)


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
    fixed = {symbols.parameter(p.name): within_bounds(p) for p in effect.parameters}
    return st.fixed_dictionaries({PORT.x: moving, PORT.v: moving, STATE: moving, CONTROL: moving, **fixed})


def factor(unit: str, scales: Mapping[str, Fraction]) -> Fraction:
    """What a number in this unit is multiplied by when the base units shrink by ``scales``."""
    product = Fraction(1)
    for base, power in parse_unit(unit).dimension:
        product *= scales[base] ** power
    return product


def laws(effect: Effect, motion: Motion) -> list[tuple[str, sp.Expr, str]]:
    """(what, expression, unit) of everything that the effect computes."""
    p, push = letters(effect), EFFORT_UNIT[motion]
    found = [
        ("kinetic energy", effect.kinetic_energy(PORT, p), "J"),
        ("potential energy", effect.potential_energy(PORT, p), "J"),
        ("Rayleigh function", effect.dissipation(PORT, p), "W"),
        ("force", effect.force(PORT, p), push),
        ("whole force", along(effect, p), push),
        ("force of the hidden state", effect.state_force(PORT, p, STATE), push),
    ]
    state, sensor, through = effect.hidden_state(), effect.sensor(PORT, p), effect.transmission(PORT, p)
    if state is not None:
        storage, rate = effect.storage_and_rate(PORT, p, STATE, CONTROL)
        found.append(("rate of the hidden state", rate / storage, f"{state.unit}/s"))
    if sensor is not None:
        found.append(("sensor", sensor.value, sensor.unit))
    if through is not None:
        found += [("displacement let through", through.x, DISPLACEMENT_UNIT[motion])]
        found += [("speed let through", through.v, SPEED_UNIT[motion])]
    return found


def unbalanced(
    effect: Effect, motion: Motion, numbers: Mapping[sp.Symbol, Fraction], scales: Mapping[str, Fraction]
) -> list[str]:
    """The laws that do not follow a change of base units."""
    units = {symbols.parameter(p.name): p.units[motion] for p in effect.parameters}
    units |= {PORT.x: DISPLACEMENT_UNIT[motion], PORT.v: SPEED_UNIT[motion]}
    state, control = effect.hidden_state(), effect.input_unit()
    units |= {STATE: state.unit if state else "1", CONTROL: control or "1"}
    before = {symbol: exact(value) for symbol, value in numbers.items()}
    after = {symbol: exact(value * factor(units[symbol], scales)) for symbol, value in numbers.items()}
    wrong = []
    for what, law, unit in laws(effect, motion):
        expected = sp.N(law.subs(before, simultaneous=True) * exact(factor(unit, scales)), 30)
        found = sp.N(law.subs(after, simultaneous=True), 30)
        if not abs(found - expected) <= abs(expected) * sp.Rational(1, 10**20):
            wrong.append(what)
    return wrong


ATTACHED = [
    pytest.param(identifier, motion, id=f"{identifier}-{motion}")
    for identifier, effect in catalogue().items()
    for motion in (Motion.ROTATIONAL, Motion.TRANSLATIONAL)
    if any(motion in motions()[kind] for kind in effect.attaches_to)
]


@pytest.mark.parametrize(("identifier", "motion"), ATTACHED)
@settings(max_examples=15, deadline=None)
@given(data=st.data())
def test_units_balance(identifier: str, motion: Motion, data: st.DataObject) -> None:
    effect = catalogue()[identifier]
    numbers = data.draw(situations(effect))
    assume(numbers.get(symbols.parameter("inductance")) != 0)  # a circuit without it has no rate
    assert unbalanced(effect, motion, numbers, data.draw(SCALES)) == []


def test_a_wrong_unit_is_found() -> None:
    numbers = {PORT.x: Fraction(1), PORT.v: Fraction(2), STATE: Fraction(0), CONTROL: Fraction(0)}
    numbers[symbols.parameter("coefficient")] = Fraction(3)
    scales = {"mass": Fraction(1), "length": Fraction(1), "time": Fraction(2), "current": Fraction(1)}
    assert unbalanced(Pusher(), Motion.ROTATIONAL, numbers, scales) == ["force", "whole force"]


# Null values, dissipation, conservation.


@every_effect
def test_null_values_remove_it_exactly(identifier: str) -> None:
    effect = catalogue()[identifier]
    p = at_null(effect)
    assert effect.kinetic_energy(PORT, p) == 0
    assert effect.potential_energy(PORT, p) == 0
    assert along(effect, p) == 0
    assert effect.state_force(PORT, p, STATE) == 0
    sensor, through = effect.sensor(PORT, p), effect.transmission(PORT, p)
    assert sensor is None or sensor.value == 0
    assert through is None or through == PORT


@every_effect
def test_other_values_do_not_remove_it(identifier: str) -> None:
    effect = catalogue()[identifier]
    p = letters(effect)
    sensor, through = effect.sensor(PORT, p), effect.transmission(PORT, p)
    present = [effect.kinetic_energy(PORT, p), along(effect, p), effect.state_force(PORT, p, STATE)]
    present += [sensor.value] if sensor is not None else []
    present += [through.x - PORT.x] if through is not None else []
    assert any(law != 0 for law in present)


def power(effect: Effect, numbers: Mapping[sp.Symbol, Fraction]) -> sp.Expr:
    law = along(effect, letters(effect)) * PORT.v
    return sp.N(law.subs({symbol: exact(value) for symbol, value in numbers.items()}, simultaneous=True), 30)


DISSIPATIVE = [identifier for identifier, effect in catalogue().items() if effect.dissipative]


@pytest.mark.parametrize("identifier", DISSIPATIVE)
@settings(max_examples=25, deadline=None)
@given(data=st.data())
def test_what_dissipates_never_gives_energy(identifier: str, data: st.DataObject) -> None:
    effect = catalogue()[identifier]
    assert effect.potential_energy(PORT, letters(effect)) == effect.kinetic_energy(PORT, letters(effect)) == 0
    assert effect.hidden_state() is None
    assert power(effect, data.draw(situations(effect))) <= 0


def test_a_friction_that_pushes_is_found() -> None:
    assert power(Pusher(), {PORT.v: Fraction(2), symbols.parameter("coefficient"): Fraction(3)}) > 0


CONSERVATIVE = [
    identifier
    for identifier, effect in catalogue().items()
    if "potential_energy" in overridden(effect) and not effect.dissipative
]


@pytest.mark.parametrize("identifier", CONSERVATIVE)
@settings(max_examples=10, deadline=None)
@given(data=st.data())
def test_what_has_a_potential_does_no_work_around_a_closed_path(identifier: str, data: st.DataObject) -> None:
    """Out and back by other speeds: x(s) = a + b cos s + c sin s + e sin 2 s, by the rule that is exact for waves."""
    effect = catalogue()[identifier]
    numbers = {symbol: exact(value) for symbol, value in data.draw(situations(effect)).items()}
    del numbers[PORT.x], numbers[PORT.v]
    a, b, c, e = (data.draw(st.floats(-0.5, 0.5)) for _ in range(4))
    force = sp.lambdify((PORT.x, PORT.v), along(effect, letters(effect)).subs(numbers), "math")
    count = 400
    work = scale = 0.0
    for k in range(count):
        s = 2 * math.pi * k / count
        x = a + b * math.cos(s) + c * math.sin(s) + e * math.sin(2 * s)
        v = -b * math.sin(s) + c * math.cos(s) + 2 * e * math.cos(2 * s)
        work += force(x, v) * v / count
        scale += abs(force(x, v) * v) / count
    assert abs(work) <= 1e-9 * max(scale, 1e-3)


# Two declarations that are wrong, so that the checks above are known to see.


@final
class Poor(Effect):
    identifier = "poor"
    title = "poor effect"
    attaches_to = MOVING
    parameters = (ParameterSchema("size", {Motion.ROTATIONAL: "N m"}, r"\input{x}", " ", null=-1.0, lower=0.0),)
    source = ""
    rivals = ("gremlins",)
    builds_on = "nothing_known"
    proposable = True


@final
class Pusher(Effect):
    """Pushes with the motion, and its coefficient has the unit of a force."""

    identifier = "pusher"
    title = "friction of the wrong sign and unit"
    attaches_to = MECHANICAL
    parameters = (ParameterSchema("coefficient", EFFORT, "F", "coefficient", lower=0.0),)
    source = "nowhere"
    dissipative = True

    def force(self, port: Port, p: Values) -> sp.Expr:
        return p["coefficient"] * port.v
