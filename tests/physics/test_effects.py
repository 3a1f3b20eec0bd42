"""Every effect of the catalogue keeps what it declares: units, null values, dissipation, conservation, completeness."""

from __future__ import annotations

import inspect
import math
import pkgutil
from collections.abc import Mapping, Sequence
from fractions import Fraction
from functools import cache
from typing import final

import pytest
import sympy as sp
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from mpmath import mpf, workdps

from symdyn.base import symbols
from symdyn.base.latex_check import is_safe_latex
from symdyn.base.units import parse_unit
from symdyn.compiler import robot_from_text
from symdyn.physics import catalogue, effects, schemas
from symdyn.physics.effect import EFFORT, MECHANICAL, MOVING, PORT, Effect, Port, Values, unit_at
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
    p = letters(effect)
    z = states(effect, p)
    if len(z) != len(effect.rates(PORT, p, z, CONTROL)):
        missing.append("a rate for each hidden state")
    missing += [f"LaTeX of {s.name}" for s in effect.hidden_states(p) if not is_safe_latex(s.latex)]
    if not any(p.null is not None for p in effect.parameters):
        missing.append("a parameter whose null value removes it")
    for p in effect.parameters:
        missing += [f"unit 1 of {p.name}, a count" for _ in range(p.is_count and set(p.units.values()) != {"1"})]
        missing += [f"meaning of {p.name}" for _ in range(not p.meaning.strip())]
        missing += [f"LaTeX of {p.name}" for _ in range(not is_safe_latex(p.latex))]
        bounds = [b for b in (p.lower, p.null, p.upper) if b is not None]
        missing += [f"null value of {p.name} within its bounds" for _ in range(bounds != sorted(bounds))]
        for place in effect.attaches_to:
            wanted = motions()[place] & effect.motions
            missing += [f"unit of {p.name} at a {m} {place}" for m in sorted(wanted - set(p.units))]
        missing += [f"no unit of {p.name} at a {m} place" for m in sorted(set(p.units) - effect.motions)]
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


def unbalanced(
    effect: Effect, motion: Motion, numbers: Mapping[sp.Symbol, Fraction], scales: Mapping[str, Fraction]
) -> list[str]:
    """The laws that do not follow a change of base units."""
    units = scalings(effect, motion)
    scaled = {symbol: value * factor(units[symbol], scales) for symbol, value in numbers.items()}
    wrong = []
    for what, law, unit in laws(effect, motion):
        with workdps(DIGITS):
            expected = value_of(law, numbers) * in_digits(factor(unit, scales))
            if not abs(value_of(law, scaled) - expected) <= abs(expected) * mpf(10) ** -20 + ROUNDING:
                wrong.append(what)
    return wrong


ATTACHED = [
    pytest.param(identifier, motion, id=f"{identifier}-{motion}")
    for identifier, effect in catalogue().items()
    for motion in (Motion.ROTATIONAL, Motion.TRANSLATIONAL)
    if motion in effect.motions and MECHANICAL & effect.attaches_to
    if any(motion in motions()[kind] for kind in effect.attaches_to)
] + [
    pytest.param(identifier, Motion.ELECTRICAL, id=f"{identifier}-electrical")
    for identifier, effect in catalogue().items()
    if PlaceKind.CIRCUIT in effect.attaches_to
]


@pytest.mark.parametrize(("identifier", "motion"), ATTACHED)
@settings(max_examples=15, deadline=None)
@given(data=st.data())
def test_units_balance(identifier: str, motion: Motion, data: st.DataObject) -> None:
    effect = catalogue()[identifier]
    numbers = data.draw(situations(effect))
    assume(all(numbers[symbols.parameter(p.name)] != 0 for p in effect.parameters if p.zero_is_structural))
    assert unbalanced(effect, motion, numbers, data.draw(SCALES)) == []


def test_a_wrong_unit_is_found() -> None:
    numbers = {PORT.x: Fraction(1), PORT.v: Fraction(2), CONTROL: Fraction(0)}
    numbers[symbols.parameter("coefficient")] = Fraction(3)
    scales = dict.fromkeys(("mass", "length", "current", "temperature"), Fraction(1)) | {"time": Fraction(2)}
    assert unbalanced(Pusher(), Motion.ROTATIONAL, numbers, scales) == ["force", "whole force"]


# Null values, dissipation, conservation.


def traces(effect: Effect, p: Values) -> dict[str, sp.Expr]:
    """What the rest of the machine notices of the effect, each zero where it is as if absent."""
    z = states(effect, p)
    found = {
        "kinetic energy": effect.kinetic_energy(PORT, p),
        "potential energy": effect.potential_energy(PORT, p),
        "force": along(effect, p),
        "force of the hidden states": effect.state_force(PORT, p, z, CONTROL),
    }
    sensor, through, body = effect.sensor(PORT, p, z), effect.transmission(PORT, p), effect.body(p)
    amplified = effect.amplified(p, z, CONTROL)
    found["sensor"] = sensor.value if sensor is not None else sp.Integer(0)
    found["displacement let through"] = through.x - PORT.x if through is not None else sp.Integer(0)
    found["speed let through"] = through.v - PORT.v if through is not None else sp.Integer(0)
    found["mass"] = body.mass if body is not None else sp.Integer(0)
    found["input"] = amplified - CONTROL if amplified is not None else sp.Integer(0)
    if isinstance(effect, ServoLoop):
        found["output"] = effect.output(PORT, p, z[: len(effect.memory(p))], CONTROL)
    return found


@every_effect
def test_null_values_remove_it_exactly(identifier: str) -> None:
    effect = catalogue()[identifier]
    assert {what: law for what, law in traces(effect, at_null(effect)).items() if law != 0} == {}


@every_effect
def test_other_values_do_not_remove_it(identifier: str) -> None:
    effect = catalogue()[identifier]
    assert any(law != 0 for law in traces(effect, letters(effect)).values())


@every_effect
def test_each_parameter_matters(identifier: str) -> None:
    """To some law, or to whether there is a state at all."""
    effect = catalogue()[identifier]
    motion = min(motions()[min(effect.attaches_to)] & effect.motions)
    used = {symbol for _, law, _ in laws(effect, motion) for symbol in sp.sympify(law).free_symbols}
    assert {p.name for p in effect.parameters if not p.is_count and symbols.parameter(p.name) not in used} == set()


def power(effect: Effect, numbers: Mapping[sp.Symbol, Fraction]) -> mpf:
    """Given to the machine and put into store, per time: by hidden states too."""
    p = letters(effect)
    z = states(effect, p)
    law = (along(effect, p) + effect.state_force(PORT, p, z, CONTROL)) * PORT.v
    stored = effect.stored_energy(p, z)
    for symbol, rate in zip(z, effect.rates(PORT, p, z, CONTROL), strict=True):
        law += sp.diff(stored, symbol) * rate.change / rate.storage
    return value_of(law, numbers)


DISSIPATIVE = [identifier for identifier, effect in catalogue().items() if effect.dissipative]


@pytest.mark.parametrize("identifier", DISSIPATIVE)
@settings(max_examples=25, deadline=None)
@given(data=st.data())
def test_what_dissipates_never_gives_energy(identifier: str, data: st.DataObject) -> None:
    """In every state, and so along every trajectory: what comes back was put into store before."""
    effect = catalogue()[identifier]
    assert effect.potential_energy(PORT, letters(effect)) == effect.kinetic_energy(PORT, letters(effect)) == 0
    assert power(effect, data.draw(situations(effect))) <= ROUNDING


@every_effect
def test_what_is_stored_is_never_negative(identifier: str) -> None:
    effect = catalogue()[identifier]
    p = letters(effect)
    z = states(effect, p)
    positive = {symbol: sp.Symbol(symbol.name, positive=True) for symbol in p.values() if symbol.is_Symbol}
    assert sp.sympify(effect.stored_energy(p, z)).subs(positive).is_nonnegative


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
