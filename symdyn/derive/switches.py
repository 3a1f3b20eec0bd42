"""A machine as a hybrid automaton: every jump and kink becomes a mode that is held between events."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence, Set
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Any

import sympy as sp

from symdyn.base import symbols
from symdyn.base.errors import InputError, Problem
from symdyn.base.nonsmooth import clip, deadzone, outside, pushing, sign_of, step
from symdyn.derive.clocks import Clock, clocks
from symdyn.derive.equations import EquationsOfMotion
from symdyn.derive.forces import Contribution
from symdyn.derive.loads import under
from symdyn.derive.power import PowerFlow, power_flows

ZERO, HALF = sp.Integer(0), sp.Rational(1, 2)


class SwitchKind(StrEnum):
    """What changes at an event.

    Friction: the mode is the sign of a speed, or, at rest, the share of its limit that the friction
    takes (Filippov). Contact: the flank that is engaged, or 0 in the gap. Limit: the bound that holds, or 0 inside.
    """

    FRICTION = "friction"
    CONTACT = "contact"
    LIMIT = "limit"


@dataclass(frozen=True, slots=True)
class Switch:
    """One mode variable: ``mode`` is its symbol, ``argument`` the speed, the twist, or what is limited.

    ``bounds`` are those of the argument at which a contact or a limit changes. ``presses`` are the forces
    with which the flanks of a contact press at the lower and at the upper bound, negative where they would pull.
    """

    kind: SwitchKind
    name: str
    mode: sp.Symbol
    argument: sp.Expr
    bounds: tuple[sp.Expr, sp.Expr] = (ZERO, ZERO)
    presses: tuple[sp.Expr, sp.Expr] = (ZERO, ZERO)


@dataclass(frozen=True, slots=True)
class HybridEquations:
    """Equations without jumps: in each mode they are smooth. Switches stand by kind, in the order of SwitchKind.

    ``flows`` tell where the energy goes, in a mode; a friction that sticks has speed zero and takes none.
    What clocks do is not of any mode, and keeps its jumps and kinks.
    """

    equations: EquationsOfMotion
    switches: tuple[Switch, ...]
    flows: tuple[PowerFlow, ...]
    clocks: tuple[Clock, ...] = ()

    def of_kind(self, kind: SwitchKind) -> tuple[Switch, ...]:
        return tuple(s for s in self.switches if s.kind is kind)


def hybrid_equations(equations: EquationsOfMotion) -> HybridEquations:
    """Replace every non-smooth primitive by its value in a mode.

    Raises InputError (SD451) for a jump that is no function of a speed, and for nested clearances.
    """
    flows, loaded = power_flows(equations), [c in equations.loaded for c in equations.contributions]
    equations = _under_effort(equations)
    found = _Finder(equations)
    for name, expression in _expressions(equations):
        found.look(name, expression)
    order = {kind: k for k, kind in enumerate(SwitchKind)}
    switches = tuple(sorted(found.switches, key=lambda s: order[s.kind]))
    names = {s.mode: symbols.mode(i) for i, s in enumerate(switches, start=1)}
    smooth = [
        replace(
            s,
            mode=names[s.mode],
            argument=found.smooth(s.argument).xreplace(names),
            bounds=_pair(lambda e: found.smooth(e).xreplace(names), s.bounds),
            presses=_pair(lambda e: e.xreplace(names), s.presses),
        )
        for s in switches
    ]

    def in_mode(expression: sp.Expr) -> sp.Expr:
        return found.smooth(expression).xreplace(names)

    flows = tuple(
        replace(
            f, supplied=in_mode(f.supplied), dissipated=sp.expand_mul(in_mode(f.dissipated)), stored=in_mode(f.stored)
        )
        for f in flows
    )
    frictions = {s.mode for s in smooth if s.kind is SwitchKind.FRICTION}
    mapped = _mapped(equations, in_mode)
    contributions = tuple(
        replace(c, actuation=tuple(_straight(f, frictions, c) for f in c.actuation)) if depends else c
        for depends, c in zip(loaded, mapped.contributions, strict=True)
    )
    return HybridEquations(replace(mapped, contributions=contributions), tuple(smooth), flows, clocks(equations))


def _under_effort(equations: EquationsOfMotion) -> EquationsOfMotion:
    """Friction that depends on loads as it follows from efforts, and so acts with inputs and hidden states."""
    sizes = under(equations.actuation(), equations.loads)

    def moved(item: Contribution) -> Contribution:
        acting = tuple(a + sp.sympify(b).xreplace(sizes) for a, b in zip(item.actuation, item.applied, strict=True))
        return replace(item, applied=(ZERO,) * len(acting), actuation=acting)

    loaded = equations.loaded
    changed = tuple(moved(c) if c in loaded else c for c in equations.contributions)
    return replace(equations, contributions=changed, loads=())


def _straight(force: sp.Expr, frictions: Set[sp.Symbol], item: Contribution) -> sp.Expr:
    """What is right for either direction of slip, and a straight line between: at rest only its ends are laws.

    Raises InputError (SD451) where another friction has a share in the load.
    """
    modes = sorted(sp.sympify(force).free_symbols & frictions, key=str)
    if len(modes) > 1:
        raise InputError(
            Problem("SD451", f"{item.attachment.origin}: its load depends on the friction of another place",
                    hint="simulate with --smoothing, which replaces jumps by slopes")
        )  # fmt: skip
    for mode in modes:
        force = sum(((1 + s * mode) * HALF * force.subs(mode, s) for s in (1, -1)), ZERO)
    return force


def _expressions(equations: EquationsOfMotion) -> Iterator[tuple[str, sp.Expr]]:
    """All that may jump, with the place it belongs to; inner arguments come before what contains them."""
    for state in equations.states:
        yield state.name.rpartition(".")[0], state.rate
    for item in equations.contributions:
        for expression in (*item.applied, *item.actuation, *item.inertial):
            yield item.attachment.address, expression
    for drive in equations.inputs:
        for expression in drive.force:
            yield drive.name, expression


def _mapped(equations: EquationsOfMotion, change: Callable[[Any], Any]) -> EquationsOfMotion:
    def contribution(item: Contribution) -> Contribution:
        inertial, applied, actuation = (
            tuple(map(change, part)) for part in (item.inertial, item.applied, item.actuation)
        )
        return replace(item, inertial=inertial, applied=applied, actuation=actuation)

    return replace(
        equations,
        contributions=tuple(map(contribution, equations.contributions)),
        states=tuple(replace(s, rate=change(s.rate)) for s in equations.states),
        inputs=tuple(replace(i, force=tuple(map(change, i.force))) for i in equations.inputs),
    )


class _Finder:
    """Collects switches, one for each distinct argument, and the value of each primitive in their modes."""

    def __init__(self, equations: EquationsOfMotion) -> None:
        self.velocities = [axis.qd for axis in equations.axes]
        self.switches: list[Switch] = []
        self.values: dict[sp.Basic, sp.Expr] = {}

    def look(self, name: str, expression: sp.Expr) -> None:
        atoms = sp.sympify(expression).atoms(sign_of, step, outside, deadzone, pushing, clip)
        for atom in sorted(atoms, key=lambda a: (sp.count_ops(a), sp.default_sort_key(a))):
            if atom not in self.values:
                self.values[atom] = self._value(name, atom, expression)

    def smooth(self, expression: sp.Expr) -> sp.Expr:
        """The expression in modes; from the inside out, because primitives contain primitives."""
        previous = None
        while previous != expression:
            previous, expression = expression, sp.sympify(expression).xreplace(self.values)
        return expression

    def _value(self, name: str, atom: sp.Expr, whole: sp.Expr) -> sp.Expr:
        if isinstance(atom, (sign_of, step)):
            sign = self._friction(name, atom.args[0])
            return sign if isinstance(atom, sign_of) else (1 + sign) / 2
        if isinstance(atom, clip):
            x, low, high = atom.args
            mode = self._limit(name, x, low, high)
            return _held(x, low, high, mode)
        if isinstance(atom, pushing):
            return sp.Integer(1)  # the mode of the contact says so
        x, s = atom.args
        mode = self._contact(name, x, s, whole) or self._limit(name, x, -s, s)
        return mode**2 if isinstance(atom, outside) else mode**2 * x - mode * s

    def _friction(self, name: str, speed: sp.Expr) -> sp.Expr:
        lever = sp.Matrix([sp.diff(speed, v) for v in self.velocities])
        straight = sp.expand(speed - lever.dot(self.velocities)) == 0 and not lever.has(*self.velocities)
        if not straight or lever.is_zero_matrix:
            raise InputError(
                Problem("SD451", f"a jump at {name} does not follow the sign of a speed: {speed}",
                        hint="simulate with --smoothing, which replaces jumps by slopes")
            )  # fmt: skip
        for known in self.switches:
            if known.kind is SwitchKind.FRICTION:
                for sign in (1, -1):
                    if sp.expand(known.argument - sign * speed) == 0:
                        return sign * known.mode
        return self._add(Switch(SwitchKind.FRICTION, name, self._symbol(), speed))

    def _limit(self, name: str, x: sp.Expr, low: sp.Expr, high: sp.Expr) -> sp.Expr:
        for known in self.switches:
            if known.kind is SwitchKind.LIMIT and known.argument == x and known.bounds == (low, high):
                return known.mode
        return self._add(Switch(SwitchKind.LIMIT, name, self._symbol(), x, (low, high)))

    def _contact(self, name: str, x: sp.Expr, s: sp.Expr, whole: sp.Expr) -> sp.Expr | None:
        """The mode of the contact of this gap, if its flanks cannot pull."""
        for known in self.switches:
            if known.kind is SwitchKind.CONTACT and known.argument == x:
                return known.mode
        gates = [g for g in whole.atoms(pushing) if isinstance(g.args[1], deadzone) and g.args[1].args == (x, s)]
        if not gates:
            return None
        force = gates[0].args[0]
        presses = []
        for side in (-1, 1):
            engaged = {deadzone(x, s): x - side * s, outside(x, s): sp.Integer(1)}
            press = -side * force.xreplace(engaged)
            if press.has(deadzone, outside, pushing, sign_of):
                raise InputError(
                    Problem("SD451", f"two clearances act on one shaft at {name}",
                            hint="their clearances add: declare one backlash with the sum")
                )  # fmt: skip
            presses.append(press)
        return self._add(Switch(SwitchKind.CONTACT, name, self._symbol(), x, (-s, s), (presses[0], presses[1])))

    def _symbol(self) -> sp.Symbol:
        return sp.Dummy(f"mode_{len(self.switches)}", real=True)

    def _add(self, switch: Switch) -> sp.Symbol:
        self.switches.append(switch)
        return switch.mode


def _held(x: sp.Expr, low: sp.Expr, high: sp.Expr, mode: sp.Expr) -> sp.Expr:
    """x inside, a bound outside."""
    above = ZERO if high is sp.oo else high * mode * (mode + 1) * HALF
    below = ZERO if low is -sp.oo else low * mode * (mode - 1) * HALF
    return x * (1 - mode**2) + above + below


def _pair(change: Callable[[sp.Expr], sp.Expr], pair: Sequence[sp.Expr]) -> tuple[sp.Expr, sp.Expr]:
    return change(pair[0]), change(pair[1])
