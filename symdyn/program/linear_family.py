"""The linear model at an operating point as a function of the parameters: arrays, with exact derivatives.

Nothing is compiled: one pass over the programs of the Jacobians, forward mode carrying all parameters at once,
takes milliseconds. Code of d A / d p would have (states^2 x parameters) outputs, most of them zero.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symdyn.base import symbols
from symdyn.base.errors import NumericalError, Problem
from symdyn.base.linear_system import Derivatives, Element, LinearFamily, LinearSystem
from symdyn.derive.equations import EquationsOfMotion
from symdyn.derive.local_elements import LocalElement, local_elements
from symdyn.program.array_evaluate import evaluate_arrays
from symdyn.program.differentiate import differentiate
from symdyn.program.lower import lower
from symdyn.program.ssa import Argument, Program

Array = NDArray[np.float64]


def linear_family(equations: EquationsOfMotion, x: Array | None = None, u: Array | None = None) -> LinearFamily:
    """The linear models of a machine at state ``x`` (nx,) and input ``u`` (nu,), both zero by default.

    Its own parameter values are NaN where they are left free.
    """
    work = _Linearisation.of(equations)
    state = np.zeros(2 * work.n + work.m) if x is None else np.asarray(x, np.float64)
    control = np.zeros(len(equations.inputs)) if u is None else np.asarray(u, np.float64)
    parameters = equations.robot.parameters
    return LinearFamily(
        name=equations.robot.name,
        parameters=tuple(p.name for p in parameters),
        units=tuple(p.unit for p in parameters),
        meanings=tuple(p.meaning for p in parameters),
        values=np.array([np.nan if p.value is None else p.value for p in parameters]),
        at=lambda p: work.system(state, control, np.asarray(p, np.float64)),
        derivatives=lambda p: work.derivatives(state, control, np.asarray(p, np.float64)),
    )


@dataclass(frozen=True, slots=True)
class _Linearisation:
    """Programs of the balance r(q, qd, qdd, z, zd, u, p) = 0, its Jacobian, the sensors, and the elements.

    Rows of r: efforts needed less those supplied, then ``storage * zd - rate`` of the hidden states.
    """

    equations: EquationsOfMotion
    balance: Program
    jacobian: Program
    sensors: Program
    stores: Program
    declared: tuple[LocalElement, ...]

    @classmethod
    def of(cls, equations: EquationsOfMotion) -> _Linearisation:
        axes, states = equations.axes, equations.states
        rates = [symbols.hidden_rate(i) for i in range(1, len(states) + 1)]
        q = Argument("q", tuple(str(a.q) for a in axes))
        qd = Argument("qd", tuple(str(a.qd) for a in axes))
        qdd = Argument("qdd", tuple(str(a.qdd) for a in axes))
        z = Argument("z", tuple(str(s.symbol) for s in states))
        zd = Argument("zd", tuple(map(str, rates)))
        u = Argument("u", tuple(str(i.symbol) for i in equations.inputs))
        p = Argument("p", tuple(map(str, equations.parameters)))
        steps, needed = equations.required()
        rows = [a - b for a, b in zip(needed, equations.actuation(), strict=True)]
        rows += [s.storage * rate - s.rate for s, rate in zip(states, rates, strict=True)]
        balance = lower("balance", (q, qd, qdd, z, zd, u, p), steps, rows, (len(rows),))
        wrt = (*q.symbols, *qd.symbols, *z.symbols, *qdd.symbols, *zd.symbols, *u.symbols)
        shown = [s.value for s in equations.sensors]
        output = lower("output", (q, qd, z, u, p), (), shown, (len(shown),))
        declared = local_elements(equations)
        entries = [e for item in declared for e in (*item.lever, item.inertia, item.stiffness, item.damping)]
        stores = lower("elements", (q, qd, p), (), entries, (len(declared), len(axes) + 3))
        return cls(
            equations,
            balance,
            differentiate(balance, wrt, "balance_jacobian"),
            differentiate(output, (*q.symbols, *qd.symbols, *z.symbols, *u.symbols), "output_jacobian"),
            stores,
            declared,
        )

    @property
    def n(self) -> int:
        return len(self.equations.axes)

    @property
    def m(self) -> int:
        return len(self.equations.states)

    def system(self, x: Array, u: Array, p: Array) -> LinearSystem:
        inputs = self._point(x, u, p)
        jacobian, _ = evaluate_arrays(self.jacobian, inputs)
        shown, _ = evaluate_arrays(self.sensors, _only(self.sensors, inputs))
        e, f, h = self._descriptor(jacobian, 1.0)
        c, d = shown[:, : 2 * self.n + self.m], shown[:, 2 * self.n + self.m :]
        if not all(np.isfinite(matrix).all() for matrix in (e, f, h, c, d)):
            raise NumericalError(Problem("SD610", "the linear model has no finite coefficients at this point"))
        table, _ = evaluate_arrays(self.stores, _only(self.stores, inputs))
        n, equations = self.n, self.equations
        elements = tuple(
            Element(item.address, item.title, row[:n], *map(float, row[n:]))
            for item, row in zip(self.declared, table, strict=True)
        )
        at = [(a.address, a.unit) for a in equations.axes]
        names = [(f"{a}.q", unit) for a, unit in at] + [(f"{a}.qd", f"{unit}/s") for a, unit in at]
        names += [(s.name, s.unit) for s in equations.states]
        return LinearSystem(
            name=equations.robot.name,
            e=e, f=f, h=h, c=c, d=d,
            coordinates=tuple(a for a, _ in at),
            states=tuple(name for name, _ in names),
            state_units=tuple(unit for _, unit in names),
            inputs=tuple(i.name for i in equations.inputs),
            input_units=tuple(i.unit for i in equations.inputs),
            outputs=tuple(s.name for s in equations.sensors),
            output_units=tuple(s.unit for s in equations.sensors),
            drift=np.concatenate([inputs[name] for name in ("qd", "qdd", "zd")]),
            elements=elements,
        )  # fmt: skip

    def derivatives(self, x: Array, u: Array, p: Array) -> Derivatives:
        """With x and u held: where the machine accelerates there, the acceleration moves with the parameters, too."""
        inputs = self._point(x, u, p)
        n, along = self.n, np.eye(len(p))
        _, moved = evaluate_arrays(self.balance, inputs, {"p": along})
        rates = np.zeros((len(p), n + self.m))
        if moved.any():
            matrix, _ = evaluate_arrays(self.jacobian, inputs)
            inertia = matrix[:, 2 * n + self.m : 3 * n + 2 * self.m]
            rates = -_solved(inertia, moved.T).T
        directions = {"p": along, "qdd": rates[:, :n], "zd": rates[:, n:]}
        _, jacobians = evaluate_arrays(self.jacobian, inputs, directions)
        _, shown = evaluate_arrays(self.sensors, _only(self.sensors, inputs), {"p": along})
        parts = [self._descriptor(jacobian, 0.0) for jacobian in jacobians]
        width = 2 * n + self.m
        e, f, h = (np.array([part[k] for part in parts]).reshape(len(p), *shape) for k, shape in enumerate(
            ((width, width), (width, width), (width, len(u)))
        ))  # fmt: skip
        return Derivatives(e, f, h, shown[:, :, :width], shown[:, :, width:])

    def _point(self, x: Array, u: Array, p: Array) -> dict[str, Array]:
        """Arguments of the balance, with the accelerations that hold at x and u."""
        n, m = self.n, self.m
        inputs = {"q": x[:n], "qd": x[n : 2 * n], "z": x[2 * n :], "u": u, "p": p}
        inputs |= {"qdd": np.zeros(n), "zd": np.zeros(m)}
        left, _ = evaluate_arrays(self.balance, inputs)
        if np.any(left != 0.0):
            jacobian, _ = evaluate_arrays(self.jacobian, inputs)
            rates = -_solved(jacobian[:, 2 * n + m : 3 * n + 2 * m], left)
            inputs |= {"qdd": rates[:n], "zd": rates[n:]}
        return inputs

    def _descriptor(self, jacobian: Array, one: float) -> tuple[Array, Array, Array]:
        """e, f, h from the Jacobian of the balance; of a derivative of it with ``one`` = 0."""
        n, m = self.n, self.m
        width = 2 * n + m
        e, f = np.zeros((width, width)), np.zeros((width, width))
        h = np.zeros((width, jacobian.shape[1] - width - n - m))
        e[:n, :n] = one * np.eye(n)
        f[:n, n : 2 * n] = one * np.eye(n)
        e[n:, n:] = jacobian[:, width : width + n + m]
        f[n:] = -jacobian[:, :width]
        h[n:] = -jacobian[:, width + n + m :]
        return e, f, h


def _only(program: Program, inputs: Mapping[str, Array]) -> dict[str, Array]:
    return {argument.name: inputs[argument.name] for argument in program.arguments}


def _solved(matrix: Array, right: Array) -> Array:
    try:
        found = np.linalg.solve(matrix, right)
    except np.linalg.LinAlgError:
        found = np.full_like(right, np.nan)
    if not np.isfinite(found).all():
        message = "the accelerations at the operating point are not determined: an inertia or an inductance is zero"
        raise NumericalError(Problem("SD610", message))
    return np.asarray(found, np.float64)
