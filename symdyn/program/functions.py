"""The functions of a kernel, each a program: all follow from inverse dynamics by calculus on programs."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import zip_longest

import sympy as sp

from symdyn.base import symbols
from symdyn.derive.composite import gravity
from symdyn.derive.coordinates import joint_coordinates
from symdyn.derive.equations import EquationsOfMotion
from symdyn.derive.steps import Step, Steps
from symdyn.program.builder import Builder
from symdyn.program.columns import Columns, columns
from symdyn.program.compose import inline
from symdyn.program.differentiate import differentiate
from symdyn.program.effort_tangent import effort_tangent
from symdyn.program.folding import fold
from symdyn.program.function import Function
from symdyn.program.kinematic_functions import kinematic_functions
from symdyn.program.lower import lower
from symdyn.program.smooth import smooth
from symdyn.program.solve import invert_symmetric, solve_symmetric
from symdyn.program.ssa import Argument, Op, Program
from symdyn.program.substitute import bind

__all__ = ["Function", "fold_parameters", "functions"]


def functions(
    equations: EquationsOfMotion, smoothing: float | Mapping[str, float] | None = None
) -> tuple[Function, ...]:
    """Every function of the kernel of one robot, parameters not yet folded in.

    ``smoothing``: width over which jumps are smoothed before anything is differentiated; with one for each
    coordinate (by address) those of friction, which is steep in speed, while contacts and limits stay as they are.
    """
    return _Functions(equations, smoothing).all()


def state_derivative(equations: EquationsOfMotion) -> Program:
    """d x / dt as a program of x, u and p alone, for those who need no other function."""
    work = _Functions(equations, None)
    forward = work.forward_dynamics(work.mass_matrix(), work.bias(work.affine()))
    return work.state_derivative(forward, work.driving())


class _Functions:
    def __init__(self, equations: EquationsOfMotion, smoothing: float | Mapping[str, float] | None) -> None:
        axes = equations.axes
        self.equations, self.smoothing = equations, smoothing
        if isinstance(smoothing, Mapping):
            self.smoothing = {str(a.qd): smoothing[a.address] for a in axes}
        self.q = Argument("q", tuple(str(a.q) for a in axes))
        self.qd = Argument("qd", tuple(str(a.qd) for a in axes))
        self.qdd = Argument("qdd", tuple(str(a.qdd) for a in axes))
        self.tau = Argument("tau", tuple(str(symbols.effort(i)) for i in range(1, len(axes) + 1)))
        self.z = tuple(str(s.symbol) for s in equations.states)
        self.x = Argument("x", (*self.q.symbols, *self.qd.symbols, *self.z))
        self.u = Argument("u", tuple(str(i.symbol) for i in equations.inputs))
        self.p = Argument("p", tuple(str(p) for p in equations.parameters))
        self.n = len(axes)

    def all(self) -> tuple[Function, ...]:
        equations = self.equations
        required, mass = self.required(), self.mass_matrix()
        affine = self.affine() if equations.loads else required
        energy = self.lower(
            "energy", (self.q, self.qd), (equations.kinetic, equations.potential), equations.energy_steps
        )
        actuation = self.actuation()
        driving = self.driving() if equations.loads else actuation
        forward = self.forward_dynamics(mass, self.bias(affine))
        state = self.state_derivative(forward, driving)
        tangent = effort_tangent(equations, self.smoothing)
        found = [
            Function(required, "Effort (n,) along each coordinate that the motion needs."),
            Function(self.transmitting(forward), "Acceleration (n,) under efforts tau."),
            Function(mass, "Mass matrix M (n, n): symmetric, positive definite."),
            Function(self.mass_matrix_inverse(mass), "Inverse of the mass matrix (n, n)."),
            Function(
                self.bias(required),
                "Effort (n,) at zero acceleration: Coriolis, centripetal, gravity, friction, springs.",
            ),
            Function(self.gravity(), "Effort (n,) that holds the arm against gravity."),
            Function(energy, "Kinetic and potential energy (2,) in J."),
            Function(actuation, "Effort (n,) that inputs and motor currents exert along each coordinate."),
            Function(state, "Time derivative of the state x = [q, qd, hidden states] under inputs u."),
            Function(
                self.inverse_jacobian(required, tangent),
                "d inverse_dynamics / d [q, qd], (n, 2 n)" + self.unless_loaded("qdd it is the mass matrix"),
            ),
            _solving(
                self.forward_jacobian(tangent),
                "d forward_dynamics / d [q, qd], (n, 2 n)"
                + self.unless_loaded("tau it is the inverse of the mass matrix"),
            ),
            _solving(
                self.drift_jacobian(tangent, driving),
                "A = d state_derivative / d x.",
            ),
            _solving(
                self.state_jacobian("state_derivative_input_jacobian", self.u, forward, mass, driving),
                "B = d state_derivative / d u.",
            ),
        ]
        if self.p.symbols:
            regressor = differentiate(required, self.p.symbols, "inverse_dynamics_parameter_jacobian")
            needed = differentiate(affine, self.p.symbols, "needed") if equations.loads else regressor
            found += [
                Function(regressor, "Regressor: d inverse_dynamics / d p, (n, number of parameters)."),
                _solving(
                    self.state_jacobian("state_derivative_parameter_jacobian", self.p, forward, mass, driving, needed),
                    "d state_derivative / d p.",
                ),
            ]
        if equations.sensors:
            output = self.lower("output", (self.x, self.u), [s.value for s in equations.sensors])
            found += [
                Function(output, "What the sensors show, in the order of OUTPUTS."),
                Function(differentiate(output, self.x.symbols, "output_state_jacobian"), "C = d output / d x."),
                Function(differentiate(output, self.u.symbols, "output_input_jacobian"), "D = d output / d u."),
            ]
            if self.p.symbols:
                by_parameters = differentiate(output, self.p.symbols, "output_parameter_jacobian")
                found.append(Function(by_parameters, "d output / d p."))
        found += kinematic_functions(equations)
        if self.z:
            rates = replace(self.rates(), name="hidden_state_derivative")
            found.append(Function(rates, "Time derivative of the hidden states alone, along a motion that is known."))
        return tuple(found)

    def lower(
        self, name: str, arguments: tuple[Argument, ...], outputs: Sequence[sp.Expr], steps: Sequence[Step] = ()
    ) -> Program:
        program = lower(name, (*arguments, self.p), steps, outputs, (len(outputs),))
        return program if self.smoothing is None else smooth(program, self.smoothing)

    def required(self) -> Program:
        """Inverse dynamics."""
        steps, efforts = self.equations.required()
        return self.lower("inverse_dynamics", (self.q, self.qd, self.qdd), efforts, steps)

    def affine(self) -> Program:
        """The same without what depends on loads, which is affine in accelerations."""
        steps, efforts = self.equations.of_effects()
        sums = [a + b for a, b in zip(self.equations.arm, efforts, strict=True)]
        return self.lower("affine", (self.q, self.qd, self.qdd), sums, (*self.equations.steps, *steps))

    def bias(self, required: Program) -> Program:
        """What is required at zero acceleration."""
        return _at_zero(replace(required, name="bias_force"), (self.qdd,))

    def actuation(self) -> Program:
        """Efforts of inputs and hidden states."""
        return self.lower("actuation", (self.x, self.u), self.equations.actuation())

    def driving(self) -> Program:
        """What friction that depends on loads leaves of them."""
        equations = self.equations
        return self.lower("actuation", (self.x, self.u), equations.transmitted(equations.actuation()))

    def transmitting(self, forward: Program) -> Program:
        """Forward dynamics, with the friction that depends on loads."""
        if not self.equations.loads:
            return forward
        builder = Builder()
        left = dict(zip(self.tau.symbols, inline(builder, self.transmitted()), strict=True))
        return builder.program(forward.name, forward.arguments, inline(builder, forward, left), forward.shape)

    def transmitted(self) -> Program:
        """What that friction leaves of efforts tau."""
        efforts = [symbols.effort(i) for i in range(1, self.n + 1)]
        return self.lower("transmitted", (self.q, self.qd, self.tau), self.equations.transmitted(efforts))

    def unless_loaded(self, words: str) -> str:
        return "." if self.equations.loads else f"; with respect to {words}."

    def mass_matrix(self) -> Program:
        """The arm's, by composite bodies, and what effects add to it (rotors): inertial forces are linear in qdd."""
        equations = self.equations
        arm = self.lower("mass_matrix", (self.q,), list(equations.arm_mass), equations.mass_steps)
        steps, efforts = equations.of_effects()
        effects = self.lower("effects", (self.q, self.qd, self.qdd), efforts, steps)
        added = _at_zero(differentiate(effects, self.qdd.symbols, "added"), (self.qd, self.qdd))
        builder = Builder()
        entries = zip(inline(builder, arm), inline(builder, added), strict=True)
        sums = [fold(builder, Op.ADD, pair, "inertia of the arm and of effects") for pair in entries]
        return builder.program("mass_matrix", (self.q, self.p), sums, (self.n, self.n))

    def gravity(self) -> Program:
        robot, steps = self.equations.robot, Steps()
        addresses = (coordinate.address for coordinate in joint_coordinates(robot))
        by_joint = dict(zip(addresses, gravity(robot, steps), strict=True))
        efforts = [by_joint.get(axis.address, sp.Integer(0)) for axis in self.equations.axes]
        return self.lower("gravity", (self.q,), efforts, steps.freeze())

    def mass_matrix_inverse(self, mass: Program) -> Program:
        builder = Builder()
        inverse = invert_symmetric(builder, _rows(inline(builder, mass), self.n))
        entries = [entry for row in inverse for entry in row]
        return builder.program("mass_matrix_inverse", (self.q, self.p), entries, (self.n, self.n))

    def forward_dynamics(self, mass: Program, bias: Program) -> Program:
        builder = Builder()
        rows = _rows(inline(builder, mass), self.n)
        forces = inline(builder, bias)
        solution = self.solved(builder, rows, [builder.input(symbol) for symbol in self.tau.symbols], forces)
        return builder.program("forward_dynamics", (self.q, self.qd, self.tau, self.p), solution, (self.n,))

    def solved(
        self, builder: Builder, mass: Sequence[Sequence[int]], efforts: Sequence[int], bias: Sequence[int]
    ) -> tuple[int, ...]:
        """Lines of the acceleration."""
        pairs = zip(efforts, bias, strict=True)
        right = [builder.intern(Op.SUB, pair, "effort less bias force") for pair in pairs]
        return solve_symmetric(builder, mass, right)

    def rates(self) -> Program:
        """Of the hidden states."""
        return self.lower("rates", (self.x, self.u), [s.rate / s.storage for s in self.equations.states])

    def state_derivative(self, forward: Program, actuation: Program) -> Program:
        builder = Builder()
        accelerations = self.accelerations(builder, forward, actuation)
        rates = inline(builder, self.rates())
        outputs = (*(builder.input(s) for s in self.qd.symbols), *accelerations, *rates)
        return builder.program("state_derivative", (self.x, self.u, self.p), outputs, (len(outputs),))

    def accelerations(self, builder: Builder, forward: Program, actuation: Program) -> tuple[int, ...]:
        """Lines of forward dynamics under the efforts of inputs and hidden states."""
        efforts = inline(builder, actuation)
        return inline(builder, forward, dict(zip(self.tau.symbols, efforts, strict=True)))

    def inverse_jacobian(self, required: Program, tangent: Program) -> Program:
        if self.equations.loads:
            wrt = (*self.q.symbols, *self.qd.symbols)
            return differentiate(required, wrt, "inverse_dynamics_state_jacobian")
        builder = Builder()
        rows = _rows(inline(builder, tangent), 3 * self.n + 1)
        outputs = [entry for row in rows for entry in row[: 2 * self.n]]
        arguments = (self.q, self.qd, self.qdd, self.p)
        return builder.program("inverse_dynamics_state_jacobian", arguments, outputs, (self.n, 2 * self.n))

    def forward_jacobian(self, tangent: Program) -> Columns:
        builder, driven = Builder(), []
        efforts: Sequence[int] = [builder.input(symbol) for symbol in self.tau.symbols]
        if self.equations.loads:
            left, wrt = self.transmitted(), (*self.q.symbols, *self.qd.symbols)
            efforts = inline(builder, left)
            driven = _columns(inline(builder, differentiate(left, wrt, "driven")), self.n)
        mass, needed = self.forward_tangent(builder, tangent, efforts)
        arguments = (self.q, self.qd, self.tau, self.p)
        right = self.implicit(builder, needed, driven)
        return columns(builder, "forward_dynamics_state_jacobian", arguments, mass, right)

    def forward_tangent(
        self, builder: Builder, tangent: Program, efforts: Sequence[int]
    ) -> tuple[list[Sequence[int]], list[tuple[int, ...]]]:
        """Rows of M, and columns of d inverse_dynamics / d [q, qd] at the acceleration under ``efforts``."""
        rows, n = _rows(inline(builder, tangent), 3 * self.n + 1), self.n
        mass = [row[2 * n : 3 * n] for row in rows]
        accelerations = self.solved(builder, mass, efforts, [row[3 * n] for row in rows])
        given = dict(zip(self.qdd.symbols, accelerations, strict=True))
        return mass, _columns(inline(builder, tangent, given), n)[: 2 * n]

    def drift_jacobian(self, tangent: Program, actuation: Program) -> Columns:
        """d state_derivative / d x."""
        builder = Builder()
        mass, needed = self.forward_tangent(builder, tangent, inline(builder, actuation))
        return self.rates_jacobian("state_derivative_state_jacobian", self.x, builder, mass, actuation, needed)

    def state_jacobian(
        self,
        name: str,
        wrt: Argument,
        forward: Program,
        mass: Program,
        actuation: Program,
        tangent: Program | None = None,
    ) -> Columns:
        """d state_derivative / d ``wrt``; ``tangent`` is inverse dynamics' own derivative, where there is one."""
        builder = Builder()
        accelerations = self.accelerations(builder, forward, actuation)
        given = dict(zip(self.qdd.symbols, accelerations, strict=True))
        rows = _rows(inline(builder, mass), self.n)
        needed = _columns(inline(builder, tangent, given), self.n) if tangent is not None else []
        return self.rates_jacobian(name, wrt, builder, rows, actuation, needed)

    def rates_jacobian(
        self,
        name: str,
        wrt: Argument,
        builder: Builder,
        mass: Sequence[Sequence[int]],
        actuation: Program,
        needed: Sequence[Sequence[int]],
    ) -> Columns:
        driven = _columns(inline(builder, differentiate(actuation, wrt.symbols, "driven")), self.n)
        right = self.implicit(builder, needed, driven)
        zero, one = builder.constant(0.0), builder.constant(1.0)
        speeds = [one if symbol == own else zero for own in self.qd.symbols for symbol in wrt.symbols]
        rates = inline(builder, differentiate(self.rates(), wrt.symbols, "rates"))
        return columns(builder, name, (self.x, self.u, self.p), mass, right, speeds, rates)

    def implicit(
        self, builder: Builder, needed: Sequence[Sequence[int]], driven: Sequence[Sequence[int]] = ()
    ) -> list[tuple[int, ...]]:
        """Right sides of the implicit function theorem: M d qdd / d w = d actuation / d w - d inverse_dynamics / d w.

        ``needed`` are the columns of the latter, ``driven`` of the former; what either lacks is zero.
        """
        none = (builder.constant(0.0),) * self.n
        pairs = zip_longest(driven, needed, fillvalue=none)
        return [
            tuple(fold(builder, Op.SUB, pair, "derivative of effort") for pair in zip(plus, minus, strict=True))
            for plus, minus in pairs
        ]


def _solving(ending: Columns, doc: str) -> Function:
    return Function(ending.whole(), doc, ending if ending.wide else None)


def _rows(entries: Sequence[int], width: int) -> list[Sequence[int]]:
    return [entries[i : i + width] for i in range(0, len(entries), width)]


def _columns(entries: Sequence[int], rows: int) -> list[tuple[int, ...]]:
    """Of a matrix whose entries come row by row."""
    width = len(entries) // rows
    return [tuple(entries[i * width + k] for i in range(rows)) for k in range(width)]


def _at_zero(program: Program, arguments: tuple[Argument, ...]) -> Program:
    """The program with whole arguments set to zero and gone from its signature."""
    zero = {symbol: 0.0 for argument in arguments for symbol in argument.symbols}
    return bind(program, zero, drop=tuple(argument.name for argument in arguments))


def fold_parameters(function: Function, values: Sequence[float]) -> Function:
    """The function with numbers for its parameters; raises ValueError if one of them is not finite (left free)."""
    parameters = next(a for a in function.program.arguments if a.name == "p")
    if not all(math.isfinite(value) for value in values):
        raise ValueError("a parameter is left free")
    given = dict(zip(parameters.symbols, values, strict=True))
    if function.columns is not None:
        return _solving(function.columns.bound(given, ("p",)), function.doc)
    return Function(bind(function.program, given, drop=("p",)), function.doc)
