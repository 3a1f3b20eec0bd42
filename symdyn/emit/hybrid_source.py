"""The source of a hybrid machine's module: its functions in a mode, its switches, and the integrator around them."""

from __future__ import annotations

from collections.abc import Sequence

from symdyn.derive.power import ENERGY_KINDS, of_kind
from symdyn.derive.switches import HybridEquations, SwitchKind
from symdyn.emit.forms import Form
from symdyn.emit.kernel_source import kernel_source
from symdyn.emit.tables import name_tables
from symdyn.emit.templates import render

NEEDED = (
    "state_derivative", "state_derivative_friction_jacobian", "guards", "guards_state_jacobian", "bounds", "updates",
)  # fmt: skip


def hybrid_source(hybrid: HybridEquations, forms: Sequence[Form], affine: bool, steady_drag: bool) -> str:
    """A kernel module whose functions take the modes ``s``; AFFINE tells whether each mode is affine in x and u.

    STEADY_DRAG tells whether what the frictions do to the rates depends on the modes alone.

    The integrator is that of templates/numba/simulation_*.py.j2; it is left out where parameters are free.
    """
    tables = {
        "SWITCHES": repr(tuple(s.name for s in hybrid.switches)),
        "SWITCH_KINDS": repr(tuple(str(s.kind) for s in hybrid.switches)),
        "AFFINE": repr(affine),
        "STEADY_DRAG": repr(steady_drag),
    }
    tables |= {kind.upper(): repr(tuple(of_kind(hybrid.flows, kind))) for kind in ENERGY_KINDS}
    kernel = kernel_source(hybrid.equations, forms, tables)
    names = {form.name for form in forms}
    if "state_derivative" not in names:
        return kernel
    found = name_tables(hybrid.equations)
    hidden = len(hybrid.equations.states)
    switches = (len(hybrid.of_kind(kind)) for kind in SwitchKind)
    sizes = [len(found["STATES"]), len(found["INPUTS"]), hidden, len(hybrid.clocks), *switches]
    stubs = [_NOTHING.format(name) for name in NEEDED if name not in names]
    own = {"sizes": ", ".join(map(str, sizes)), "stubs": "".join(stubs)}
    modes, steps, events = (
        render(f"numba/simulation_{part}.py.j2", _DECORATORS | (own if part == "modes" else {}))
        for part in ("modes", "steps", "events")
    )
    return kernel.rstrip("\n") + "\n" + modes + steps + events


_DECORATORS = {
    "compiled": '@njit(cache=True, nogil=True, error_model="numpy")',  # for batches in threads
    "inlined": '@njit(cache=True, forceinline=True, error_model="numpy")',  # arrays are dear as arguments
}
_NOTHING = '''

@njit(forceinline=True)
def _{0}(x, u, s, out, k, S, turns):
    pass


@njit(cache=True)
def {0}_into(x, u, s, out):
    """Has no entries."""
'''
