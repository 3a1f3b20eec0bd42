"""The whole pipeline on one page: robot -> equations -> programs -> source -> kernel."""

from __future__ import annotations

import hashlib
import json
import math
import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import astuple, dataclass, field, fields, replace
from functools import cached_property
from pathlib import Path

from symdyn import __version__
from symdyn.base.errors import InputError, NumericalError, Problem
from symdyn.base.files import write_atomically
from symdyn.base.linear_system import Array, LinearFamily
from symdyn.base.memory import collector_paused
from symdyn.derive.clocks import require_continuous
from symdyn.derive.equations import EquationsOfMotion, equations_of_motion
from symdyn.derive.linearize import without_nonsmooth, without_null_effects
from symdyn.derive.switches import hybrid_equations
from symdyn.emit import latex, markdown
from symdyn.emit.forms import Form, forms
from symdyn.emit.hybrid_source import hybrid_source
from symdyn.emit.kernel import Kernel, load_source
from symdyn.emit.kernel_source import kernel_source
from symdyn.emit.target import Target
from symdyn.emit.targets import DEFAULT_TARGET, target
from symdyn.emit.templates import digest
from symdyn.physics import schemas
from symdyn.physics.loops import continuous, periods, without_loops
from symdyn.program.cost import Cost
from symdyn.program.functions import functions
from symdyn.program.hybrid_functions import has_steady_drag, hybrid_functions, is_affine
from symdyn.program.linear_family import linear_family
from symdyn.program.optimize import CostRow, notable
from symdyn.program.sampling_check import too_slow
from symdyn.spec.machines import machine_file
from symdyn.spec.records import Robot
from symdyn.spec.robot_reader import read_any
from symdyn.spec.toml_reader import read_robot_text
from symdyn.spec.toml_source import read_text
from symdyn.spec.toml_writer import to_toml
from symdyn.spec.urdf_chain import WHOLE, Chain
from symdyn.spec.urdf_writer import write_back
from symdyn.spec.xml_source import LARGEST_XML

EQUATIONS, MANIFEST = "equations.tex", "manifest.json"
FITTED = frozenset(  # what a fit to measured motion and effort evaluates
    {
        "inverse_dynamics",
        "inverse_dynamics_parameter_jacobian",
        "mass_matrix",
        "actuation",
        "hidden_state_derivative",
    }
)
_ROW = re.compile(r"\[[^][{}]*\]")  # an innermost list of JSON: a row of a table, which belongs on one line


@dataclass(frozen=True)
class Compiled:
    """Everything that follows from one robot; ``kernel()`` loads its compiled functions."""

    robot: Robot
    equations: EquationsOfMotion = field(repr=False)
    forms: tuple[Form, ...] = field(repr=False)

    def _repr_markdown_(self) -> str:
        """What a notebook shows."""
        return markdown.document(self.equations)

    @cached_property
    def source(self) -> str:
        """The Numba module."""
        return kernel_source(self.equations, self.forms)

    def kernel(self) -> Kernel:
        return load_source(self.source)


def load_robot(model: str | Path, chain: Chain = WHOLE) -> Robot:
    """Read a robot from a file (TOML, URDF, xacro), or a bundled machine by its name ("two-link").

    ``chain`` chooses from the tree of a URDF. Raises InputError with every problem found in the file.
    """
    return load_with_warnings(model, chain)[0]


def load_with_warnings(model: str | Path, chain: Chain = WHOLE) -> tuple[Robot, tuple[Problem, ...]]:
    """The same, with what is doubtful in the file."""
    return read_any(machine_file(model), schemas(), chain)


def robot_from_text(text: str, file: str) -> Robot:
    return read_robot_text(text, file, schemas())


def robot_to_toml(robot: Robot) -> str:
    """A robot as the text of a robot.toml, which reads back as the same robot."""
    return to_toml(robot, schemas())


def robot_into_urdf(robot: Robot, urdf: str | Path, chain: Chain = WHOLE) -> str:
    """The text of a URDF with the robot's inertials, damping and friction; every other byte is kept.

    Raises InputError where the robot has what a URDF cannot say, or is not the one of this URDF.
    """
    return write_back(read_text(urdf, LARGEST_XML), str(urdf), robot, schemas(), chain)


def compile_robot(
    robot: Robot,
    smoothing: float | Mapping[str, float] | None = None,
    only: Collection[str] | None = None,
) -> Compiled:
    """Derive, build and optimise the programs. Nothing is printed, or compiled by Numba, before it is asked for.

    ``smoothing`` replaces jumps by slopes of that width, for solvers that cannot locate events; with a width for
    each coordinate, by its address, those of friction alone, for filters. Functions beside ``only`` these, by
    name, are left out: most of the time goes into optimising them.
    """
    with collector_paused():
        equations = equations_of_motion(robot)
        if smoothing is not None:
            require_continuous(equations, "a simulation with smoothing")
        chosen = [f for f in functions(equations, smoothing) if only is None or f.name in only]
        return Compiled(robot, equations, forms(equations, chosen))


def parametric_kernel(robot: Robot) -> Kernel:
    """The kernel with what a fit asks for alone, as functions of the parameters (``_p``), and the robot's values.

    Its source holds none: machines that differ in their numbers share what Numba compiled.
    """
    free = replace(robot, parameters=tuple(replace(p, value=None) for p in robot.parameters))
    values = tuple(math.nan if p.value is None else p.value for p in robot.parameters)
    return replace(compile_robot(free, only=FITTED).kernel(), given=values)


def compile_hybrid(robot: Robot) -> Kernel:
    """The kernel of a robot's simulation with located events: functions of state, input and mode.

    Effects that their parameters make vanish (a clearance of 0) are left out: they would switch for nothing.
    Raises InputError (SD451) for a jump that does not belong to friction, a contact or a limit, SD455 for a loop
    that its sampling alone makes unstable.
    """
    with collector_paused():
        _check_sampling(robot)
        hybrid = hybrid_equations(equations_of_motion(without_null_effects(robot)))
        found = hybrid_functions(hybrid)
        return load_source(
            hybrid_source(hybrid, forms(hybrid.equations, found), is_affine(found), has_steady_drag(found))
        )


def _check_sampling(robot: Robot) -> None:
    """Raise InputError (SD455) for loops that sampling alone makes unstable; at rest in the origin, and slipping."""
    sampled = periods(robot)
    if not sampled or any(p.value is None for p in robot.parameters):
        return
    loop, period = min(sampled, key=lambda pair: pair[1])
    smooth = without_nonsmooth(robot)
    closed, open_ = (linearise(each) for each in (continuous(smooth), without_loops(smooth)))
    try:
        models = closed.at(closed.values), open_.at(open_.values)
    except NumericalError:
        return  # no linear model there: nothing is known
    problem = too_slow(*models, period, f"{loop.type} at '{loop.at}'")
    if problem is not None:
        raise InputError(replace(problem, where=loop.where))


def linearise(robot: Robot, x: Array | None = None, u: Array | None = None) -> LinearFamily:
    """The linear models at state ``x`` and input ``u`` (zero by default), over the parameters; nothing is compiled.

    Effects that jump have slope zero or one there; ``without_nonsmooth`` takes them out.
    """
    with collector_paused():
        equations = equations_of_motion(robot)
        require_continuous(equations, "a linear model")
        return linear_family(equations, x, u)


def generate(robot: Robot, folder: Path, targets: Sequence[str] = (DEFAULT_TARGET,)) -> tuple[Path, ...]:
    """Write the files of every target (kernel.py), equations.tex and manifest.json; same robot, same bytes.

    Raises UsageError (SD012) for a target that does not exist, before anything is written.
    """
    chosen = [target(name) for name in dict.fromkeys(targets)]
    compiled = compile_robot(robot)
    files: dict[str, str] = {}
    for each in chosen:
        for name, text in each.emit(compiled.equations, compiled.forms).items():
            if name in (*files, EQUATIONS, MANIFEST):
                raise ValueError(f"target {each.name} writes {name}, and is not the only one")
            files[name] = text
    files[EQUATIONS] = latex.document(compiled.equations)
    files[MANIFEST] = _manifest(compiled, chosen, files)
    written = []
    for name, text in files.items():
        write_atomically(folder / name, text)
        written.append(folder / name)
    return tuple(written)


def _manifest(compiled: Compiled, targets: Sequence[Target], files: Mapping[str, str]) -> str:
    """What went in and what came out, by hash, and what each pass did; no dates, no paths."""
    templates = [name for each in targets for name in each.templates]
    facts = {
        "robot": compiled.robot.name,
        "symdyn": __version__,
        "model_sha256": _sha256(compiled.robot.text),
        "templates_sha256": digest(*templates, *latex.TEMPLATES),
        "files_sha256": {name: _sha256(text) for name, text in files.items()},
        "cost_columns": ["pass_name", "round", *(each.name for each in fields(Cost))],
        "costs": {form.name: [_cells(row) for row in notable(form.costs)] for form in compiled.forms},
    }
    return _ROW.sub(lambda row: " ".join(row[0].split()), json.dumps(facts, indent=1)) + "\n"


def _cells(row: CostRow) -> list[str | int]:
    return [row.pass_name, row.round, *astuple(row.cost)]


def _sha256(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()
