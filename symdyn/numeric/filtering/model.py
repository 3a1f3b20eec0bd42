"""One machine on one recording, ready to be filtered: kernel with every hypothesis in it, signals, beliefs."""

from __future__ import annotations

import math
from collections.abc import Sequence, Set
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from symdyn.compiler import compile_robot
from symdyn.emit.kernel import Kernel
from symdyn.numeric.candidates import Candidate, bounds
from symdyn.numeric.filtering.beliefs import Belief, Beliefs
from symdyn.numeric.filtering.bench import FASTEST, WHITE, FilterBench, Noise
from symdyn.numeric.filtering.between import Between
from symdyn.numeric.filtering.driving import per_unit
from symdyn.numeric.filtering.gears import usual_speeds
from symdyn.numeric.filtering.hypotheses import augmented, delays, free_parameters, hypotheses
from symdyn.numeric.filtering.places import Latent, is_push, latents
from symdyn.numeric.filtering.signals import Signals, seen_by, signals
from symdyn.numeric.filtering.twists import with_twists
from symdyn.numeric.filtering.windows import white
from symdyn.numeric.gearing import joint_of
from symdyn.numeric.known import known_names
from symdyn.numeric.recording import Recording
from symdyn.spec.effect_schema import Scan
from symdyn.spec.monomials import parameter_of
from symdyn.spec.places import places
from symdyn.spec.records import PlaceKind, Robot

Array = NDArray[np.float64]

PRIOR = 0.4  # standard deviation of the logarithm of a given parameter: a data sheet's word, "off by up to 30 %"
RECIPROCAL = 0.05  # of that of K_T / K_E: iron losses and the armature's own field take a few per cent of the torque
SHARPNESS = 5e-5  # width over which friction turns, as part of the usual speed
FIRST_NOISE = 1e-2  # of each channel's deviation: a start, fitted then
FIRST_INPUT = 1e-3  # of each input's deviation, likewise
FIRST_FORCE = 1e-6  # of the square of what moves the machine: noise of its equations, likewise, and at most
FIRST_DECAY = 20.0  # 1/s of a latent force, likewise
FASTEST_STEP = 2e-3  # s: longer samples are filtered in substeps


@dataclass(frozen=True, slots=True)
class Freed:
    """A rotor that was fixed to its joint, and turns by itself now: the shaft between, and its parameters."""

    joint: str
    rotor: str
    shaft: str
    stiffness: str
    damping: str


@dataclass(frozen=True, slots=True)
class Lagging:
    """A sensor of the model that got a lag: its effect, where, and the parameter (in the effect, in the kernel)."""

    effect: str
    at: str
    name: str
    parameter: str


@dataclass(frozen=True, slots=True, eq=False)
class Model:
    """``robot`` as given (with an ammeter where a current was measured), its kernel with all ``proposed`` in it."""

    robot: Robot
    kernel: Kernel
    proposed: tuple[Candidate, ...]
    latents: tuple[Latent, ...]
    beliefs: Beliefs
    training: Signals
    heldout: Signals
    delays: tuple[str, ...] = ()  # parameters beyond the kernel's: by how much each of its inputs comes late
    freed: tuple[Freed, ...] = ()
    lagging: tuple[Lagging, ...] = ()

    @property
    def values(self) -> Array:
        """(np + delays,) of the model as given: every hypothesis at its null value."""
        return np.append(self.kernel.values, np.zeros(len(self.delays)))

    @property
    def electrical(self) -> frozenset[str]:
        """Parameters of resistances and inductances."""
        motors = [joint.drive.motor for joint in self.robot.joints if joint.drive and joint.drive.motor]
        return frozenset(n for m in motors for value in (m.resistance, m.inductance) for n, _ in value.factors)

    def unit(self, name: str) -> str:
        return "s" if name in self.delays else self.kernel.parameter_units[self.kernel.parameters.index(name)]

    def bench(self, of: Signals, noise: Noise, between: Between) -> FilterBench:
        step = float(np.nanmedian(of.steps))
        substeps = max(1, math.ceil(step / FASTEST_STEP - 1e-9))
        return FilterBench(self.kernel, of, noise, between, substeps, self.delays)


def prepare(
    robot: Robot, training: Recording, heldout: Recording, more: Sequence[Candidate] = (), only: Sequence[str] = ()
) -> Model:
    """Derive and compile the machine with every hypothesis at its null value; match the channels to it.

    ``more`` are hypotheses with states of their own. Of the others those that ``only`` names by their labels, and
    the unknown forces, if it names any. Raises InputError as ``signals`` does.
    """
    seen = seen_by(robot, (training, heldout))
    proposed = (*(c for c in hypotheses(seen) if not only or c.label in only or is_push(c)), *more)
    whole = augmented(seen, proposed)
    at = tuple(p.address for p in places(seen) if p.kind in (PlaceKind.JOINT, PlaceKind.INERTIA))
    speeds = usual_speeds(seen, training, at)
    widths = {address: _rounded(SHARPNESS * speed) for address, speed in zip(at, speeds, strict=True)}
    kernel = compile_robot(whole, widths).kernel()
    known = known_names((training, heldout))
    beliefs = {name: belief for name, belief in _beliefs(seen, kernel).items() if name not in known}
    return Model(
        seen, kernel, proposed, latents(seen, kernel, proposed), beliefs,
        *with_twists(signals(seen, kernel, training), signals(seen, kernel, heldout)), delays(kernel, proposed),
    )  # fmt: skip


def holding(model: Model, held: Set[str]) -> Model:
    """The same, with parameters that it is right about: no fit moves what nothing is believed of."""
    return replace(model, beliefs={name: belief for name, belief in model.beliefs.items() if name not in held})


def without_latent(model: Model, signals: Signals) -> Noise:
    """Noise of sensors, inputs and of the equations of the joints (what their steps leave out), at a first guess."""
    r = np.maximum(signals.floor, (FIRST_NOISE * np.nanstd(signals.y, axis=0)) ** 2 + 1e-30)
    rows: list[tuple[Array, float, float, float, float]] = []  # direction, power, decay, most, shown
    driven, step = set(), float(np.nanmedian(signals.steps))
    for name, values in zip(model.kernel.inputs, signals.u.T, strict=True):
        joint = joint_of(model.robot, name)
        circuit = joint.drive.motor if joint.drive else None
        electrical = circuit is not None and name.endswith((".voltage", ".reference"))
        acts_on = joint.drive.effort_at if joint.drive else ""
        part = circuit.name if circuit is not None and electrical else acts_on
        at = f"{joint.name}.{part}" if part else joint.name
        found = next((x.direction for x in model.latents if x.place == at), None)
        if found is not None and values.any():
            size = FIRST_INPUT * float(np.std(values))
            direction = found * per_unit(model.kernel, name, size, found)
            at_most = min(float(white(values[:, None], signals.steps)[0]), float(np.var(values)))
            rows.append((direction, size**2, WHITE / step, math.inf, max(size**2, at_most)))
            driven.add(at)
    for joint in model.robot.joints:
        found = next((x.direction for x in model.latents if x.place == joint.name), None)
        if found is not None and joint.name not in driven:
            size = FIRST_FORCE * natural_force(model, signals, found) ** 2
            rows.append((found, size, FASTEST / step, size, size))
    columns = np.array([row[0] for row in rows]).reshape(len(rows), len(model.kernel.parameters)).T
    power, decay, most, shown = (np.array([row[i] for row in rows]) for i in range(1, 5))
    return Noise(r, np.ascontiguousarray(columns), decay, power, most, power, shown)


def as_it_begins(model: Model, bench: FilterBench) -> FilterBench:
    """The filter with noise of sensors and inputs as fits begin with it, and the unknown forces that it has."""
    return bench.with_noise(joined(without_latent(model, model.training), bench.noise))


def joined(quiet: Noise, unknown: Noise) -> Noise:
    """Noise of sensors and inputs, and beside it the unknown forces of another."""
    k = unknown.inputs
    pairs = ((getattr(quiet, x)[:k], getattr(unknown, x)[k:]) for x in ("power", "decay", "most"))
    power, decay, most = (np.concatenate(pair) for pair in pairs)
    return replace(unknown, r=quiet.r, power=power, decay=decay, most=most)


def natural_force(model: Model, signals: Signals, direction: Array) -> float:
    """The force that would cause the accelerations (or rates of current) that the recording is about."""
    kernel, n = model.kernel, len(model.kernel.coordinates)
    still = np.zeros(len(kernel.states)), np.zeros(len(kernel.inputs))
    rate = np.asarray(kernel.state_derivative_parameter_jacobian_p(*still, kernel.values)) @ direction
    geared = np.max(np.abs(signals.per_joint)) / np.abs(signals.per_joint)  # all as fast as the fastest part
    quick = np.nanstd(np.diff(signals.y, axis=0), axis=0) / np.nanmedian(signals.steps)
    speed = max(float(v * geared[i % n] if i < 2 * n else v) for v, i in zip(quick, signals.index, strict=True))
    mechanical = float(np.max(np.abs(rate[n : 2 * n]) * geared))
    if mechanical > 0:
        return 10.0 * speed / mechanical
    return float(np.max(np.std(signals.u, axis=0))) or 1.0


def with_latent(noise: Noise, latent: Latent, power: float) -> Noise:
    """One unknown force more, besides the noise of sensors and inputs."""
    base = noise.quiet
    return replace(
        base,
        directions=np.column_stack([base.directions, latent.direction]),
        decay=np.append(base.decay, FIRST_DECAY),
        power=np.append(base.power, power),
        most=np.append(base.most, np.inf),
    )


def _beliefs(robot: Robot, kernel: Kernel) -> dict[str, Belief]:
    limits, either = bounds(robot), _of_either_sign(robot)
    found = {}
    for name in free_parameters(robot):
        value = float(kernel.values[kernel.parameters.index(name)])
        least = -math.inf if value <= 0.0 and name in either else 0.0
        lower, upper = limits.get(name, (least, math.inf))
        if value > 0.0 and lower >= 0.0:
            found[name] = Belief(positive=True, centre=math.log(value), spread=PRIOR)
        else:
            spread = PRIOR * abs(value) if value else math.inf
            found[name] = Belief(lower, upper, value, spread)
    for torque, emf in one_magnet(robot):
        if torque in found and emf in found and found[torque].positive and found[emf].positive:
            found[torque] = replace(found[torque], like=emf, apart=RECIPROCAL)
    return found


def _of_either_sign(robot: Robot) -> frozenset[str]:
    """Coordinates of centres of mass, and products of inertia."""
    links = [joint.link for joint in robot.joints] + ([robot.tool.link] if robot.tool is not None else [])
    values = [value for link in links for value in (*link.com, *link.inertia[3:])]
    return frozenset(name for value in values for name, _ in value.factors)


def one_magnet(robot: Robot) -> tuple[tuple[str, str], ...]:
    """Pairs of parameters that are one constant in SI units: torque per current, and back-EMF per speed.

    The power that a motor takes from its circuit, K_E omega I, is what it gives to its rotor, K_T I omega. Where no
    force was measured nothing else tells how large they all are.
    """
    motors = [joint.drive.motor for joint in robot.joints if joint.drive and joint.drive.motor]
    pairs = [(parameter_of(m.torque_constant), parameter_of(m.back_emf_constant)) for m in motors]
    return tuple(dict.fromkeys((torque, emf) for torque, emf in pairs if torque and emf and torque != emf))


def carried(model: Model, p: Array, fitted: FilterBench) -> tuple[Array, FilterBench]:
    """Parameters and noise of a fit, on the kernel of a ``model`` with more, or fewer, hypotheses in it."""
    values, names = model.values, (*model.kernel.parameters, *model.delays)
    for i, name in enumerate(names):
        if name in fitted.index:
            values[i] = p[fitted.index[name]]
    directions = np.zeros((len(model.kernel.parameters), len(fitted.noise.decay)))
    for i, name in enumerate(model.kernel.parameters):
        if name in fitted.index:
            directions[i] = fitted.noise.directions[fitted.index[name]]
    noise = replace(fitted.noise, directions=directions)
    return values, model.bench(model.training, noise, fitted.between)


def candidate_beliefs(candidate: Candidate, shape: float | None) -> dict[str, Belief]:
    """Of a candidate's parameters: the bounds of its declaration; a shape stays within a factor of two."""
    found = {}
    for schema in candidate.linear:
        lower = -math.inf if schema.lower is None else schema.lower
        upper = math.inf if schema.upper is None else schema.upper
        found[candidate.parameter(schema)] = Belief(lower, upper)
    if shape is not None and any(schema.scan is Scan.ANGLE for schema in candidate.shapes):
        found |= {candidate.parameter(schema): Belief() for schema in candidate.shapes}
    elif shape is not None:
        about = Belief(positive=True, centre=math.log(shape), spread=math.log(2.0))
        found |= {candidate.parameter(schema): about for schema in candidate.shapes}
    return found


def _rounded(value: float) -> float:
    """To 1, 2 or 5 times a power of ten: recordings that are alike share a kernel."""
    power = 10.0 ** math.floor(math.log10(value))
    return float(power * max(m for m in (1.0, 2.0, 5.0) if m * power <= value * (1 + 1e-12)))
