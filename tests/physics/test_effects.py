"""Every effect of the catalogue keeps what it declares: units, null values, dissipation, conservation, completeness."""

from __future__ import annotations

import inspect
import math
import pkgutil
from collections.abc import Mapping
from fractions import Fraction
from itertools import product
from typing import final

import pytest
import sympy as sp
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from mpmath import mpf, workdps

from symdyn.base import symbols
from symdyn.base.latex_check import is_safe_latex
from symdyn.physics import catalogue, effects, law_variables, schemas, with_play
from symdyn.physics.effect import EFFORT, MECHANICAL, MOVING, PORT, Effect, Port, Values
from symdyn.physics.servo_loop import ServoLoop
from symdyn.spec.effect_schema import ParameterSchema
from symdyn.spec.records import Motion, PlaceKind

from .laws import (
    CONTROL,
    DIGITS,
    ROUNDING,
    SCALES,
    along,
    at_null,
    every_effect,
    exact,
    factor,
    in_digits,
    laws,
    letters,
    motions,
    overridden,
    scalings,
    situations,
    states,
    value_of,
)

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
    missing += [f"LaTeX of {s.name}: its place is the subscript" for s in effect.hidden_states(p) if "_" in s.latex]
    if not any(p.null is not None for p in effect.parameters):
        missing.append("a parameter whose null value removes it")
    for s in effect.parameters:
        missing += [f"unit 1 of {s.name}, a count" for _ in range(s.is_count and set(s.units.values()) != {"1"})]
        missing += [f"meaning of {s.name}" for _ in range(not s.meaning.strip())]
        missing += [f"LaTeX of {s.name}" for _ in range(not is_safe_latex(s.latex))]
        bounds = [b for b in (s.lower, s.null, s.upper) if b is not None]
        missing += [f"null value of {s.name} within its bounds" for _ in range(bounds != sorted(bounds))]
        for place in effect.attaches_to:
            wanted = motions()[place] & effect.motions
            missing += [f"unit of {s.name} at a {m} {place}" for m in sorted(wanted - set(s.units))]
        missing += [f"no unit of {s.name} at a {m} place" for m in sorted(set(s.units) - effect.motions)]
    names = [named.name for named in (*effect.parameters, *effect.hidden_states(p))]
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
    elif (followed := effect.controls(PORT, p, z, CONTROL)) is not None:
        found["reference"] = followed - CONTROL
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
    stored = sp.sympify(effect.stored_energy(p, z)).subs(positive)
    known = stored.is_nonnegative
    if known is None:  # SymPy does not know that log(1 + x) <= x
        sizes, signed = (0.1, 1.0, 7.0), (-5.0, -0.2, 0.0, 0.01, 3.0)
        free = sorted(stored.free_symbols, key=str)
        choices = [sizes if symbol.is_positive else signed for symbol in free]
        values = sp.lambdify(free, stored, "math")
        known = all(values(*numbers) >= -1e-12 for numbers in product(*choices))
    assert known


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
        try:
            pull = force(x, v)
        except ZeroDivisionError:  # both ends of a spring in one point: its pull has no direction there
            assume(False)
        work += pull * v / count
        scale += abs(pull * v) / count
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


def test_laws_are_in_the_variables_that_their_equations_hold() -> None:
    variables = {name: set(law_variables(name)) for name in ("stribeck_friction", "torque_ripple", "hardening_spring")}
    assert variables == {
        "stribeck_friction": {"speed"},
        "torque_ripple": {"position"},
        "hardening_spring": {"position"},
    }
    assert not law_variables("dahl_friction")  # in a state of its own
    assert with_play() == {"backlash"}
