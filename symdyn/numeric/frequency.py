"""The linear model of a compiled kernel at an operating point, as a python-control system."""

from __future__ import annotations

import control
import numpy as np
from numpy.typing import NDArray

from symdyn.emit.kernel import Kernel

Array = NDArray[np.float64]


def linear_model(kernel: Kernel, x: Array | None = None, u: Array | None = None) -> control.StateSpace:
    """A, B, C, D of the kernel at state ``x`` (nx,) and input ``u`` (nu,), both zero by default.

    Signals carry the kernel's names with dots written as underscores (python-control's rule). A
    robot without sensors shows its whole state.
    """
    x = np.zeros(len(kernel.states)) if x is None else x
    u = np.zeros(len(kernel.inputs)) if u is None else u
    a = kernel.state_derivative_state_jacobian(x, u)
    b = kernel.state_derivative_input_jacobian(x, u)
    if kernel.outputs:
        c, d = kernel.output_state_jacobian(x, u), kernel.output_input_jacobian(x, u)
    else:
        c, d = np.eye(len(x)), np.zeros((len(x), len(u)))
    plain = [[name.replace(".", "_") for name in names] for names in (kernel.states, kernel.inputs)]
    shown = [name.replace(".", "_") for name in (kernel.outputs or kernel.states)]
    if not kernel.outputs:
        shown = [f"{name}_" for name in shown]
    return control.ss(a, b, c, d, states=plain[0], inputs=plain[1], outputs=shown, name=kernel.module.ROBOT)
