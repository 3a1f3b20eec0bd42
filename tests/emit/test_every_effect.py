"""Every effect of the catalogue as code: Python, Numba and C against the reference evaluator."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest

from symdyn.compiler import Compiled, compile_robot
from symdyn.emit.kernel import Kernel
from symdyn.program.functions import functions
from tests.emit.c_library import Build, files_of
from tests.emit.test_c import assert_same
from tests.emit.test_kernel import assert_close, assert_same_compiled, call, parameters, random_arguments, reference
from tests.physics.everything import everything


@cache
def machine() -> Compiled:
    return compile_robot(everything())


@pytest.fixture
def interpreted(interpret: Callable[[Compiled], Kernel]) -> Kernel:
    return interpret(machine())


def test_every_function_equals_the_reference(interpreted: Kernel) -> None:
    for i, function in enumerate(functions(machine().equations)):
        program, arguments = function.program, random_arguments(function.program, i)
        for values, form in ((interpreted.values, "{}"), (parameters(interpreted, i), "{}_p")):
            wanted = reference(program, arguments, values)
            name = form.format(function.name)
            assert_close(call(interpreted, name, arguments, values), wanted, name)


def test_c_equals_python(build: Build, interpreted: Kernel) -> None:
    wanted = {"actuation", "output", "state_derivative", "state_derivative_p", "output_p"}
    forms = [form for form in machine().forms if form.name in wanted]
    assert len(forms) == len(wanted)
    assert_same(build(files_of(machine(), forms)), interpreted, forms)


@pytest.mark.parametrize("name", ["output", "actuation"])
def test_what_numba_compiles_equals_python(name: str, interpreted: Kernel) -> None:
    program = next(f.program for f in functions(machine().equations) if f.name == name)
    assert_same_compiled(machine().kernel(), interpreted, program, ("{}", "{}_p_batch"))
    steps = np.asarray(machine().kernel().output(*(v[0] for v in random_arguments(program).values())))
    assert np.isfinite(steps).all()
