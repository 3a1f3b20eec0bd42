"""Emitted kernels equal the reference evaluator in every form, and obey mechanics."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from mpmath import mp, mpf

from symdyn.compiler import Compiled, compile_robot, load_robot, robot_from_text
from symdyn.emit.kernel import Kernel
from symdyn.program.evaluate import evaluate
from symdyn.program.functions import Function, functions
from symdyn.program.ssa import Program
from symdyn.spec.monomials import value_of
from symdyn.spec.records import Robot
from tests.emit.machines import MACHINES

FORMS = ("{}", "{}_p", "{}_batch", "{}_p_batch")
ROWS = 3
Machine = Callable[[str], Compiled]
Machines = Callable[[str], Kernel]
Interpret = Callable[[Compiled], Kernel]

pytestmark = pytest.mark.parametrize("machine", MACHINES)


def parameters(kernel: Kernel, seed: int = 0) -> np.ndarray:
    """Other values than those in the file; what is 0 there, is not."""
    rng = np.random.default_rng([seed, 1])
    values = kernel.values
    return np.where(values == 0.0, 0.05, values) * rng.uniform(0.8, 1.2, len(values))


def random_arguments(program: Program, seed: int = 0) -> dict[str, np.ndarray]:
    """(ROWS, size) of every argument but p, away from 0 where friction jumps."""
    rng = np.random.default_rng([seed, 2])
    found = {}
    for argument in program.arguments:
        shape = (ROWS, len(argument.symbols))
        found[argument.name] = rng.choice((-1.0, 1.0), shape) * rng.uniform(0.2, 1.3, shape)
    found.pop("p")
    return found


def reference(program: Program, arguments: Mapping[str, np.ndarray], p: np.ndarray) -> np.ndarray:
    """(ROWS, *shape) by the slow evaluator, 30 digits, nothing optimised."""
    rows = [
        evaluate(program, {**{name: values[k].tolist() for name, values in arguments.items()}, "p": p.tolist()})
        for k in range(ROWS)
    ]
    return np.array(rows, dtype=float).reshape(ROWS, *program.shape)


def call(kernel: Kernel, name: str, arguments: Mapping[str, np.ndarray], p: np.ndarray) -> np.ndarray:
    """(ROWS, *shape) of a kernel function in the form that its name says."""
    function = getattr(kernel, name)
    last = (p,) if "_p" in name.removesuffix("_batch")[-2:] else ()
    if name.endswith("_batch"):
        return np.asarray(function(*arguments.values(), *last))
    return np.stack([function(*(values[k] for values in arguments.values()), *last) for k in range(ROWS)])


def assert_close(found: np.ndarray, wanted: np.ndarray, what: str, tolerance: float = 1e-11) -> None:
    """Equal up to what rounding does to numbers as large as the largest of them."""
    assert found.shape == wanted.shape, what
    scale = np.abs(wanted).max(initial=0.0)
    np.testing.assert_allclose(found, wanted, rtol=tolerance, atol=1e-2 * tolerance * scale, err_msg=what)


def at(kernel: Kernel, name: str, *arguments: Any) -> np.ndarray:
    return np.asarray(getattr(kernel, name)(*arguments))


def states(kernel: Kernel, count: int = 4, seed: int = 0) -> list[tuple[np.ndarray, ...]]:
    """Random (q, qd, qdd), away from jumps."""
    rng = np.random.default_rng([seed, 3])
    n = len(kernel.coordinates)
    return [tuple(rng.choice((-1, 1), (3, n)) * rng.uniform(0.2, 1.3, (3, n))) for _ in range(count)]


def frictionless(robot: Robot) -> Robot:
    return replace(robot, effects=())


def test_every_function_equals_the_reference_in_every_form(
    machine: str, compiled: Machine, interpreted: Machines
) -> None:
    kernel, found = interpreted(machine), functions(compiled(machine).equations)
    assert len(found) >= 13
    for i, function in enumerate(found):
        program, arguments = function.program, random_arguments(function.program, i)
        for values, general in ((kernel.values, False), (parameters(kernel, i), True)):
            wanted = reference(program, arguments, values)
            for form in FORMS:
                if ("_p" in form) == general:
                    name = form.format(function.name)
                    assert_close(call(kernel, name, arguments, values), wanted, name)


@pytest.mark.parametrize("function", ["inverse_dynamics", "state_derivative_state_jacobian"])
def test_compiled_functions_equal_interpreted_ones(
    machine: str, function: str, compiled: Machine, interpreted: Machines
) -> None:
    program = program_of(compiled(machine), function).program
    assert_same_compiled(compiled(machine).kernel(), interpreted(machine), program, (FORMS[0], FORMS[3]))


@pytest.mark.slow
def test_all_compiled_functions_equal_interpreted_ones(machine: str, compiled: Machine, interpreted: Machines) -> None:
    kernel = compiled(machine).kernel()
    for function in functions(compiled(machine).equations):
        assert_same_compiled(kernel, interpreted(machine), function.program, FORMS)


def assert_same_compiled(kernel: Kernel, plain: Kernel, program: Program, forms: tuple[str, ...]) -> None:
    arguments, p = random_arguments(program), parameters(kernel)
    for form in forms:
        name = form.format(program.name)
        assert hasattr(getattr(kernel, name), "py_func"), "not compiled"
        assert_close(call(kernel, name, arguments, p), call(plain, name, arguments, p), name, 1e-10)


def program_of(compiled: Compiled, name: str) -> Function:
    return next(f for f in functions(compiled.equations) if f.name == name)


def test_forward_dynamics_inverts_inverse_dynamics(machine: str, interpreted: Machines) -> None:
    kernel = interpreted(machine)
    for q, qd, qdd in states(kernel):
        tau = at(kernel, "inverse_dynamics", q, qd, qdd)
        # Rounding of stiff springs' efforts is amplified by one over the inertia.
        size = np.linalg.inv(at(kernel, "mass_matrix", q)) @ np.abs(at(kernel, "bias_force", q, qd))
        again = at(kernel, "forward_dynamics", q, qd, tau)
        np.testing.assert_allclose(again, qdd, rtol=1e-10, atol=1e-13 * np.abs(size).max())


def test_mass_matrix_and_bias_make_inverse_dynamics(machine: str, interpreted: Machines) -> None:
    kernel = interpreted(machine)
    for q, qd, qdd in states(kernel):
        mass = at(kernel, "mass_matrix", q)
        assert_close(mass, mass.T, "symmetry")
        assert np.linalg.eigvalsh(mass).min() > 0
        bias = at(kernel, "bias_force", q, qd)
        assert_close(mass @ qdd + bias, at(kernel, "inverse_dynamics", q, qd, qdd), machine)


def springs_at_rest(robot: Robot, kernel: Kernel, q: np.ndarray) -> np.ndarray:
    """Rotors where their joints put them."""
    numbers, place = {p.name: p.value for p in robot.parameters}, {c: k for k, c in enumerate(kernel.coordinates)}
    untwisted = q.copy()
    for joint in robot.joints:
        for rotor in joint.drive.rotors if joint.drive is not None else ():
            if not rotor.fixed_to_joint:
                ratio = value_of(joint.drive.ratio, numbers)
                untwisted[place[f"{joint.name}.{rotor.name}"]] = ratio * q[place[joint.name]]
    return untwisted


def test_gravity_is_the_bias_of_an_arm_at_rest(machine: str, interpret: Interpret) -> None:
    robot = load_robot(machine)
    kernel = interpret(compile_robot(frictionless(robot)))
    some = False
    for q, qd, _ in states(kernel):
        untwisted = springs_at_rest(robot, kernel, q)
        holding = at(kernel, "gravity", untwisted)
        assert_close(at(kernel, "bias_force", untwisted, np.zeros_like(qd)), holding, machine)
        some |= bool(np.any(holding))
    vertical = machine not in ("emps", "irb6-axis1")
    assert some == vertical


def energy_rate(of: Compiled, kernel: Kernel, x: np.ndarray, u: np.ndarray) -> float:
    """d(T + V)/dt along the motion: the energy's difference quotient in 60 digits, since stiff springs store much."""
    n = len(kernel.coordinates)
    program = program_of(of, "energy").program
    with mp.workdps(60):
        h = mpf(10) ** -25
        rate = [mpf(v) for v in at(kernel, "state_derivative", x, u).tolist()]
        ends = []
        for sign in (1, -1):
            y = [mpf(v) + sign * h * r for v, r in zip(x.tolist(), rate, strict=True)]
            ends.append(sum(evaluate(program, {"q": y[:n], "qd": y[n : 2 * n], "p": kernel.values.tolist()}, dps=60)))
        return float((ends[0] - ends[1]) / (2 * h))


def random_state(kernel: Kernel, seed: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng([seed, 4])
    x = rng.choice((-1, 1), len(kernel.states)) * rng.uniform(0.2, 1.3, len(kernel.states))
    return x, rng.uniform(-5.0, 5.0, len(kernel.inputs))


def undamped(robot: Robot) -> Robot:
    """No effects, and no dampers along the shafts."""
    zero = {"d_1", "d_2", "d_3"}
    values = tuple(replace(p, value=0.0) if p.name in zero else p for p in robot.parameters)
    return replace(robot, effects=(), parameters=values)


def test_energy_changes_by_the_power_of_the_drives_alone(machine: str, interpret: Interpret) -> None:
    conservative = compile_robot(undamped(load_robot(machine)))
    kernel = interpret(conservative)
    n = len(kernel.coordinates)
    for seed in range(4):
        x, u = random_state(kernel, seed)
        power = float(at(kernel, "actuation", x, u) @ x[n : 2 * n])
        assert abs(power) > 1e-3
        assert energy_rate(conservative, kernel, x, u) == pytest.approx(power, rel=1e-9, abs=1e-9)


def test_friction_and_dampers_only_take_energy(machine: str, interpret: Interpret) -> None:
    robot = load_robot(machine)
    text = robot.text + "".join(
        f'\n[[effect]]\ntype = "{kind}"\nat = "{joint.name}"\n{name} = 0.5\n'
        for joint in robot.joints
        for kind, name in (("viscous_friction", "coefficient"), ("coulomb_friction", "level"))
        if (kind, joint.name) not in {(e.type, e.at) for e in robot.effects}
    )
    rubbing = compile_robot(robot_from_text(text, machine))
    kernel = interpret(rubbing)
    n = len(kernel.coordinates)
    for seed in range(4):
        x, u = random_state(kernel, seed)
        power = float(at(kernel, "actuation", x, u) @ x[n : 2 * n])
        assert energy_rate(rubbing, kernel, x, u) < power - 1e-3


JACOBIANS = {"state": ("x", "q", "qd"), "input": ("u",), "parameter": ("p",)}


def test_jacobians_equal_central_differences(machine: str, compiled: Machine, interpreted: Machines) -> None:
    """Differences of the reference evaluator in 60 digits: exact, as far as doubles can tell."""
    kernel = interpreted(machine)
    programs = {f.name: f.program for f in functions(compiled(machine).equations)}
    seen = set()
    for name, program in programs.items():
        base, _, kind = name.removesuffix("_jacobian").rpartition("_")
        if not name.endswith("_jacobian"):
            continue
        arguments = {a: v[0] for a, v in random_arguments(program).items()} | {"p": parameters(kernel)}
        over = [a.name for a in program.arguments if a.name in JACOBIANS[kind]]
        columns = [
            difference(programs[base], arguments, argument, i)
            for argument in over
            for i in range(len(arguments[argument]))
        ]
        wanted = np.stack(columns, axis=-1)
        found = at(kernel, f"{name}_p", *arguments.values())
        assert_close(found, wanted, name)
        if np.any(found):
            seen.add(kind)
    assert seen == set(JACOBIANS)


def difference(program: Program, arguments: Mapping[str, np.ndarray], argument: str, i: int) -> np.ndarray:
    """(shape of the function) derivative with respect to one entry of one argument."""
    with mp.workdps(60):
        h = mpf(10) ** -20 * mpf(max(abs(arguments[argument][i]), 1e-6))
        ends = []
        for sign in (1, -1):
            shifted = {a.name: [mpf(v) for v in arguments[a.name].tolist()] for a in program.arguments}
            shifted[argument][i] += sign * h
            ends.append(evaluate(program, shifted, dps=60))
        return np.array([float((a - b) / (2 * h)) for a, b in zip(*ends, strict=True)])


def test_arrays_of_a_wrong_size_are_refused(machine: str, compiled: Machine, interpreted: Machines) -> None:
    kernel = interpreted(machine)
    for function in functions(compiled(machine).equations):
        for form in FORMS:
            check_sizes(kernel, form.format(function.name), function.program)


def test_compiled_code_refuses_them_too(machine: str, compiled: Machine) -> None:
    """Numba itself checks no bounds: a short array would be read past its end."""
    check_sizes(
        compiled(machine).kernel(), "inverse_dynamics", program_of(compiled(machine), "inverse_dynamics").program
    )


def check_sizes(kernel: Kernel, name: str, program: Program) -> None:
    function = getattr(kernel, name)
    batch = name.endswith("_batch")
    sizes = {a.name: len(a.symbols) for a in program.arguments}
    names = list(inspect.signature(getattr(function, "py_func", function)).parameters)
    good = {n: np.ones((ROWS, sizes[n]) if batch and n != "p" else sizes[n]) for n in names}
    for wrong in names:
        rows = batch and wrong != "p"
        shapes = [(ROWS, sizes[wrong] + d) if rows else (sizes[wrong] + d,) for d in (-1, 1)]
        if rows and wrong != names[0]:
            shapes += [(ROWS - 1, sizes[wrong]), (ROWS + 1, sizes[wrong])]
        for shape in shapes:
            with pytest.raises(ValueError, match=f"{wrong} must have"):
                function(*(np.ones(shape) if n == wrong else good[n] for n in names))


def test_batches_made_in_python_are_the_same(machine: str, compiled: Machine, interpreted: Machines) -> None:
    kernel, rng = interpreted(machine), np.random.default_rng(3)
    for function in functions(compiled(machine).equations):
        for name in (function.name, f"{function.name}_p"):
            *sizes, shape = kernel.module.SHAPES[name]
            p = (kernel.values,) if name.endswith("_p") else ()
            states = [rng.uniform(-1.0, 1.0, (ROWS, *size)) for size in sizes[: len(sizes) - len(p)]]
            wanted = getattr(kernel, f"{name}_batch")(*states, *p)
            kept = [values.copy(order="F") for values in states]
            for values in (*kept, *p):
                values.flags.writeable = False
            found = kernel.rows(name, *kept, *p)
            assert found.shape == (ROWS, *shape)
            np.testing.assert_array_equal(found, wanted)


def test_batches_made_in_python_say_what_does_not_fit(machine: str, interpreted: Machines) -> None:
    kernel = interpreted(machine)
    n = len(kernel.coordinates)
    q, p = np.zeros((ROWS, n)), kernel.values
    assert kernel.rows("mass_matrix_p", q[:0], p).shape == (0, n, n)
    for arguments, wrong in (((q[:, 1:], p), 1), ((q, p[1:]), 2)):
        with pytest.raises(ValueError, match=rf"argument {wrong} of mass_matrix_p has the shape"):
            kernel.rows("mass_matrix_p", *arguments)
    with pytest.raises(ValueError, match="argument 2 of inverse_dynamics_p has the shape"):
        kernel.rows("inverse_dynamics_p", q, q[1:], q, p)
    with pytest.raises(AttributeError, match=r"has no dance$"):
        kernel.rows("dance", q)


def test_a_batch_may_be_empty(machine: str, interpreted: Machines) -> None:
    kernel = interpreted(machine)
    n = len(kernel.coordinates)
    assert kernel.mass_matrix_batch(np.zeros((0, n))).shape == (0, n, n)


def test_tables_say_what_each_entry_is(machine: str, compiled: Machine, interpreted: Machines) -> None:
    kernel, module = interpreted(machine), interpreted(machine).module
    n = len(kernel.coordinates)
    pairs = ("COORDINATE", "STATE", "INPUT", "OUTPUT", "PARAMETER")
    for table in pairs:
        names, units = getattr(module, f"{table}S"), getattr(module, f"{table}_UNITS")
        assert len(names) == len(units) == len(set(names))
    assert len(kernel.effort_units) == n
    assert kernel.states[: 2 * n] == tuple(f"{c}.{d}" for d in ("q", "qd") for c in kernel.coordinates)
    assert len(kernel.values) == len(kernel.parameters)
    assert np.all(np.isfinite(kernel.values))
    robot = compiled(machine).robot
    assert robot.name == machine == module.ROBOT
    assert kernel.parameters == tuple(p.name for p in robot.parameters)
    assert kernel.values.tolist() == [p.value for p in robot.parameters]
    assert at(kernel, "state_derivative", np.ones(len(kernel.states)), np.ones(len(kernel.inputs))).shape == (
        len(kernel.states),
    )
    for function in functions(compiled(machine).equations):
        for form in FORMS:
            assert getattr(kernel, form.format(function.name)).__doc__
    assert kernel.has("output") == bool(kernel.outputs)
    values = kernel.values
    values[:] = 0.0  # a copy: the kernel keeps its own
    assert np.any(kernel.values)


def test_a_free_parameter_leaves_the_general_forms_only(
    machine: str, interpret: Interpret, interpreted: Machines
) -> None:
    robot = load_robot(machine)
    left = next(p for p in robot.parameters if p.value)
    free = replace(robot, parameters=tuple(replace(p, value=None) if p is left else p for p in robot.parameters))
    result = compile_robot(free)
    kernel = interpret(result)
    assert np.isnan(kernel.values).tolist() == [name == left.name for name in kernel.parameters]
    for function in functions(result.equations):
        assert not kernel.has(function.name)
        assert not kernel.has(f"{function.name}_batch")
        assert kernel.has(f"{function.name}_p")
        assert kernel.has(f"{function.name}_p_batch")
    assert f"Left free, hence no form with parameters folded in: {left.name}." in (kernel.module.__doc__ or "")
    with pytest.raises(AttributeError, match=f"{machine} has no mass_matrix; .* left free, so use mass_matrix_p$"):
        _ = kernel.mass_matrix
    with pytest.raises(AttributeError, match=r"use mass_matrix_p_batch$"):
        _ = kernel.mass_matrix_batch
    with pytest.raises(AttributeError, match=r"has no dance$"):
        _ = kernel.dance
    # With the value given at run time it is the kernel of the complete robot.
    n = len(kernel.coordinates)
    p = np.array([q.value for q in robot.parameters])
    q = np.linspace(0.3, 0.9, n)
    assert_close(at(kernel, "mass_matrix_p", q, p), at(interpreted(machine), "mass_matrix", q), machine)
