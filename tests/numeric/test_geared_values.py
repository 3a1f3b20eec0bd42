"""What an effect's numbers are at the other end of a gear: those with which it does the same there."""

from __future__ import annotations

import pytest
import sympy as sp

from symdyn.base import symbols
from symdyn.compiler import robot_from_text
from symdyn.numeric.findings import Estimate, Finding
from symdyn.numeric.geared_values import geared, with_elsewhere
from symdyn.physics import catalogue
from symdyn.physics.effect import MOVING, PORT, Effect
from symdyn.spec.records import Motion
from tests.physics.laws import along, states

RATIO = 30
ROBOT = """[robot]
name = "geared"
gravity = [0, 0, 0]

[dh]
rows = [["q", 0, 0, 0], [0, "q", 0, 0], ["q", 0, 0, 0]]
"""
JOINT = """
[[joint]]
name = "{name}"
link = {{ mass = 1, inertia = {{ zz = 1 }} }}

[joint.drive]
ratio = {ratio}
rotors = [{{ name = "motor", inertia = 1e-4, fixed_to_joint = true }}]
"""
JOINTS = (("turns", RATIO), ("slides", RATIO), ("against", -RATIO))
GEARED = robot_from_text(ROBOT + "".join(JOINT.format(name=name, ratio=r) for name, r in JOINTS), "geared.toml")
TIED = {"counterbalance_spring", "unbalance", "reference_delay"}  # to the weight, to a loop
LAWS = [name for name, law in catalogue().items() if law.proposable and law.attaches_to & MOVING and name not in TIED]


def numbers(law: Effect, motion: Motion) -> dict[str, Estimate]:
    """No two alike; a count is 2."""
    return {
        p.name: Estimate(2.0 if p.is_count else 0.3 + 0.1 * k, 0.01, p.units[motion])
        for k, p in enumerate(law.parameters)
    }


def laws(law: Effect, values: dict[str, Estimate]) -> tuple[sp.Expr, sp.Expr, tuple[sp.Expr, ...]]:
    """Force, kinetic energy, and the rates of hidden states, with these numbers."""
    p = {x.name: sp.Integer(2) if x.is_count else sp.Float(values[x.name].value) for x in law.parameters}
    z, control = states(law, p), symbols.control(1)
    rates = tuple(rate.change / rate.storage for rate in law.rates(PORT, p, z, control))
    return along(law, p) + law.state_force(PORT, p, z, control), law.kinetic_energy(PORT, p), rates


@pytest.mark.parametrize("joint", ["turns", "slides"])
@pytest.mark.parametrize("name", LAWS)
def test_it_does_the_same_there(name: str, joint: str) -> None:
    """A force that does the same work, the same energy, and hidden states that change alike."""
    law = catalogue()[name]
    own = numbers(law, Motion.ROTATIONAL if joint == "turns" else Motion.TRANSLATIONAL)
    there = geared(GEARED, name, own, joint, f"{joint}.motor")
    assert there is not None
    assert {k: e.unit for k, e in there.items()} == {p.name: p.units[Motion.ROTATIONAL] for p in law.parameters}
    hidden = law.hidden_states({p.name: sp.Integer(1) for p in law.parameters})
    moves = [1.0 if isinstance(state.unit, str) else RATIO for state in hidden]  # a deflection, or its speed
    (force, energy, rates), (beyond, same, faster) = laws(law, own), laws(law, there)
    for x, v, load in ((0.2, 0.3, 0.7), (-0.1, -0.4, -0.2), (0.05, -0.02, 0.3)):
        z = {symbols.hidden(k): 0.1 * k * x for k in range(1, len(hidden) + 1)}
        here = {PORT.x: x, PORT.v: v, PORT.load: load, **z}
        far = {PORT.x: RATIO * x, PORT.v: RATIO * v, PORT.load: load / RATIO}
        far |= {symbol: value * by for (symbol, value), by in zip(z.items(), moves, strict=True)}
        expected = [force / RATIO, energy, *(by * rate for by, rate in zip(moves, rates, strict=True))]
        for one, other in zip(expected, (beyond, same, *faster), strict=True):
            assert float(other.subs(far)) == pytest.approx(float(sp.sympify(one).subs(here)), rel=1e-9, abs=1e-15)


@pytest.mark.parametrize("name", LAWS)
def test_and_back_again(name: str) -> None:
    own = numbers(catalogue()[name], Motion.ROTATIONAL)
    there = geared(GEARED, name, own, "turns", "turns.motor")
    assert there is not None
    back = geared(GEARED, name, there, "turns.motor", "turns")
    assert back is not None
    for parameter, told in own.items():
        assert back[parameter].value == pytest.approx(told.value)
        assert back[parameter].se == pytest.approx(told.se)


def test_what_has_no_meaning_there_is_not_told() -> None:
    level = {"level": Estimate(2.0, None, "N m")}
    assert geared(GEARED, "coulomb_friction", level, "turns", "turns.motor") == {
        "level": Estimate(2.0 / RATIO, None, "N m")
    }
    assert geared(GEARED, "coulomb_friction", level, "turns", "slides") is None  # another joint
    assert geared(GEARED, "coulomb_friction", level, "base", "turns") is None  # no part of a drive
    assert geared(GEARED, "coulomb_friction", level, "against", "against.motor") is None
    assert geared(GEARED, "encoder", {"offset": Estimate(0.1, None, "rad")}, "turns", "turns.motor") is None
    assert geared(GEARED, "joint_compliance", {"stiffness": Estimate(0.1, None, "N m/rad")}, "turns", "turns") is None
    for tied in TIED:
        values = {p.name: Estimate(1.0, 0.1, "1") for p in catalogue()[tied].parameters}
        assert geared(GEARED, tied, values, "turns", "turns.motor") is None


def test_a_finding_has_its_numbers_at_all_rigid_parts() -> None:
    values = {"coefficient": Estimate(1.8, 0.09, "N m s/rad")}
    at = ("turns", "turns.motor", "slides")
    found = Finding("viscous_friction", "viscous friction", "turns", values, 0.1, 0.01, 0.0, (), group=at)
    told = with_elsewhere(GEARED, found).elsewhere
    assert list(told) == ["turns.motor"]
    assert told["turns.motor"]["coefficient"].value == pytest.approx(0.002)
    assert told["turns.motor"]["coefficient"].se == pytest.approx(0.0001)
