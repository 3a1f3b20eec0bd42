"""The laws of one effect as plain text, in the names of its own parameters: what `symdyn effects` shows."""

from __future__ import annotations

from collections.abc import Iterator

import sympy as sp

from symdyn.base import symbols
from symdyn.physics.effect import PORT, Effect, Values

_COUNT = 2  # states shown of an effect that has as many as a parameter says


def laws(effect: Effect) -> Iterator[tuple[str, str]]:
    """(quantity, law) of all that the effect declares, in x, v, load, the input u and its hidden states by name."""
    assert PORT.start is not None
    p = {s.name: sp.Integer(_COUNT) if s.is_count else symbols.local(s.name) for s in effect.parameters}
    states = effect.hidden_states(p)
    z = tuple(symbols.local(state.name) for state in states)
    control = symbols.local("u")
    names = {
        symbol: sp.Symbol(symbol.name.removeprefix("port_"))
        for symbol in (*p.values(), *z, control)
        if symbol.is_Symbol
    }
    names |= {PORT.x: sp.Symbol("x"), PORT.v: sp.Symbol("v"), PORT.load: sp.Symbol("load")}
    names |= {PORT.start.x: sp.Symbol("start_x"), PORT.start.v: sp.Symbol("start_v")}
    for what, law in _declared(effect, p, z, control):
        if law != 0:
            yield what, str(sp.sstr(sp.sympify(law, strict=True).xreplace(names)))


def _declared(effect: Effect, p: Values, z: tuple[sp.Symbol, ...], control: sp.Symbol) -> Iterator[tuple[str, sp.Expr]]:
    yield "kinetic energy", effect.kinetic_energy(PORT, p)
    yield "potential energy", effect.potential_energy(PORT, p)
    yield "dissipation function", effect.dissipation(PORT, p)
    yield "force", effect.force(PORT, p) + effect.state_force(PORT, p, z, control)
    for state, rate in zip(effect.hidden_states(p), effect.rates(PORT, p, z, control), strict=True):
        yield f"d {state.name} / dt", rate.change / rate.storage
    for update in effect.updates(PORT, p, z, control):
        for state, symbol, value in zip(effect.hidden_states(p), z, update.values, strict=True):
            when = "a delay after a sample" if update.delay != 0 else "at a sample"
            yield f"new {state.name}, {when}", value if value != symbol else sp.Integer(0)
    through, body = effect.transmission(PORT, p), effect.body(p)
    if through is not None:
        yield from (("x let through", through.x), ("v let through", through.v))
    if body is not None:
        yield from (("mass", body.mass), *zip("xyz", body.position, strict=True))
    amplified, sensor = effect.amplified(p, z, control), effect.sensor(PORT, p, z)
    if amplified is None:
        amplified = effect.controls(PORT, p, z, control)
    yield "handed on", amplified if amplified is not None else sp.Integer(0)
    yield "shown", sensor.value if sensor is not None else sp.Integer(0)
