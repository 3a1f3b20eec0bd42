"""The functions of a hybrid machine: its rates and guards in a mode, and their derivatives, each a program."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import sympy as sp

from symdyn.derive.equations import EquationsOfMotion
from symdyn.derive.power import ENERGY_KINDS, of_kind
from symdyn.derive.steps import Step
from symdyn.derive.switches import HybridEquations, Switch, SwitchKind
from symdyn.program.differentiate import differentiate
from symdyn.program.function import Function
from symdyn.program.functions import state_derivative
from symdyn.program.lower import lower
from symdyn.program.ssa import Argument, Op, Program

MODES = "s"
BY_PARAMETERS = "_parameter_jacobian"


def hybrid_functions(hybrid: HybridEquations) -> tuple[Function, ...]:
    """Functions of x, u, the modes s (in the order of the switches) and the parameters p.

    Modes of frictions are numbers in [-1, 1]; those of contacts and limits -1, 0 or 1.
    """
    equations = hybrid.equations
    modes = tuple(s.mode for s in hybrid.switches)
    derivative = state_derivative(replace(equations, parameters=(*equations.parameters, *modes)))
    x, u, _ = arguments = derivative.arguments
    slips = tuple(str(s.mode) for s in hybrid.of_kind(SwitchKind.FRICTION))
    guards = lower("guards", arguments, (), _guards(hybrid), (len(_guards(hybrid)),))
    bounds = _bounds(hybrid)
    bounds_program = lower("bounds", arguments, (), bounds, (len(bounds),))
    found = [
        Function(derivative, "Time derivative of x in a mode."),
        Function(differentiate(derivative, x.symbols, "state_derivative_state_jacobian"), "d state_derivative / d x."),
        Function(differentiate(derivative, u.symbols, "state_derivative_input_jacobian"), "d state_derivative / d u."),
        Function(
            differentiate(derivative, slips, "state_derivative_friction_jacobian"),
            "d state_derivative / d modes of the frictions; state_derivative is affine in them.",
        ),
        Function(
            guards, "What decides the modes: speeds, twists, presses at upper then lower flanks, unlimited values."
        ),
        Function(differentiate(guards, x.symbols, "guards_state_jacobian"), "d guards / d x."),
        Function(differentiate(guards, u.symbols, "guards_input_jacobian"), "d guards / d u."),
        Function(
            bounds_program,
            "What guards are compared with: clearances, then lower, then upper limits.",
        ),
    ]
    found += [Function(lower(name, arguments, steps, e, (len(e),)), doc) for name, steps, e, doc in _energy(hybrid)]
    affine = is_affine(found)
    if affine:
        found += _sensitivity(equations, (derivative, guards, bounds_program))
    if equations.sensors:
        output = lower("output", arguments, (), [s.value for s in equations.sensors], (len(equations.sensors),))
        found.append(Function(output, "What the sensors show, in the order of OUTPUTS."))
    if hybrid.clocks:
        times = [time for clock in hybrid.clocks for time in (clock.period, clock.delay)]
        new = [clock.values.get(z, z) for clock in hybrid.clocks for z in (s.symbol for s in equations.states)]
        count = len(hybrid.clocks)
        periods = lower("clocks", arguments, (), times, (count, 2))
        updates = lower("updates", arguments, (), new, (count, len(equations.states)))
        found += [
            Function(periods, "Period and delay of each clock in s."),
            Function(updates, "The hidden states after each clock has gone off alone."),
        ]
        if affine:
            by_state = differentiate(updates, x.symbols, "updates_state_jacobian")
            found += [Function(by_state, "d updates / d x."), *_sensitivity(equations, (periods, updates))]
    split = (x, u, Argument(MODES, tuple(map(str, modes))), Argument("p", tuple(map(str, equations.parameters))))
    return tuple(Function(replace(f.program, arguments=split), f.doc) for f in found if f.program.outputs)


def _energy(hybrid: HybridEquations) -> Iterator[tuple[str, Sequence[Step], list[sp.Expr], str]]:
    flows = hybrid.flows
    supplied, dissipated, stored = (list(of_kind(flows, kind).values()) for kind in ENERGY_KINDS)
    yield "supplied_power", (), supplied, "Power in W that each of SUPPLIED takes from a supply."
    yield "dissipated_power", (), dissipated, "Power in W that each of DISSIPATED turns to heat."
    yield "stored_energy", hybrid.equations.energy_steps, stored, "Energy in J that each of STORED holds."


def _sensitivity(equations: EquationsOfMotion, programs: Sequence[Program]) -> Iterator[Function]:
    """Derivatives by the parameters, for exact sensitivities; large arms, which are not affine, do without."""
    for program in programs:
        if equations.parameters and program.outputs:
            name = f"{program.name}{BY_PARAMETERS}"
            yield Function(
                differentiate(program, list(map(str, equations.parameters)), name), f"d {program.name} / d p."
            )


def is_affine(functions: Sequence[Function]) -> bool:
    """Whether rates and guards are affine in state and input in every mode: their derivatives know neither.

    What is sampled need not be: it is evaluated, not integrated.
    """
    deciding = [f for f in functions if f.name.startswith(("state_derivative_", "guards_")) or f.name == "bounds"]
    return not any(_knows(f.program, ("x", "u")) for f in deciding if not f.name.endswith(BY_PARAMETERS))


def has_steady_drag(functions: Sequence[Function]) -> bool:
    """Whether the same share of a friction's limit does the same to the rates in every state and under every input."""
    return not any(f.name == "state_derivative_friction_jacobian" and _knows(f.program, ("x", "u")) for f in functions)


def _knows(program: Program, names: Sequence[str]) -> bool:
    symbols = {s for a in program.arguments if a.name in names for s in a.symbols}
    alive = set(program.outputs)
    for i in range(len(program.nodes) - 1, -1, -1):
        if i in alive:
            node = program.nodes[i]
            if node.op is Op.INPUT and node.name in symbols:
                return True
            alive.update(node.args)
    return False


def _guards(hybrid: HybridEquations) -> list[sp.Expr]:
    contacts = hybrid.of_kind(SwitchKind.CONTACT)
    return [
        *(s.argument for s in hybrid.of_kind(SwitchKind.FRICTION)),
        *(s.argument for s in contacts),
        *(s.presses[1] for s in contacts),
        *(s.presses[0] for s in contacts),
        *(s.argument for s in hybrid.of_kind(SwitchKind.LIMIT)),
    ]


def _bounds(hybrid: HybridEquations) -> list[sp.Expr]:
    limits = hybrid.of_kind(SwitchKind.LIMIT)
    return [
        *(s.bounds[1] for s in hybrid.of_kind(SwitchKind.CONTACT)),
        *(_finite(s, 0) for s in limits),
        *(_finite(s, 1) for s in limits),
    ]


def _finite(switch: Switch, side: int) -> sp.Expr:
    """A bound that is not there, as the largest double."""
    bound = switch.bounds[side]
    return bound if bound.is_finite is not False else sp.Integer((-1 + 2 * side) * 10**300)
