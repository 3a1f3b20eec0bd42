"""What a diagnosis is given, and compiles once: robot, recordings, candidates; cases in any analysis band from it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from symdyn.base.errors import InputError, Problem
from symdyn.emit.kernel import Kernel
from symdyn.numeric.band import analysis_band, band_of
from symdyn.numeric.candidates import Candidate, bounds, candidates
from symdyn.numeric.carried import frictions
from symdyn.numeric.cut import UNCUT, Part
from symdyn.numeric.explanation import Case, Explanation, Revised, own_parameters
from symdyn.numeric.fitting import fit, joint_weight
from symdyn.numeric.kept import Kept
from symdyn.numeric.known import check_separable
from symdyn.numeric.laws import Laws
from symdyn.numeric.mechanics import at_joints, mechanical_kernel
from symdyn.numeric.observation import Observation, imposed_joints, observe
from symdyn.numeric.position_spectrum import WHOLE
from symdyn.numeric.probe import Key, Probe, probes
from symdyn.numeric.reading import Reading, declared
from symdyn.numeric.readings import read
from symdyn.numeric.recording import Recording
from symdyn.numeric.sizes import sizes
from symdyn.numeric.workbench import Workbench
from symdyn.spec.effect_schema import Scan
from symdyn.spec.records import Quantity, Robot

LEAST_TRAVEL = 1e-9  # rad or m
DERIVATIVE_ROOM = 5.0  # positions are low-passed this far above the band (Gautier, Janot: five times the dynamics)


@dataclass(frozen=True, slots=True, eq=False)
class Setting:
    robot: Robot
    kernel: Kernel
    own: tuple[str, ...]  # the model's own parameters that a fit moves
    probes: Mapping[Key, Probe]
    proposed: tuple[Candidate, ...]
    training: Recording
    heldout: Recording
    seen: Observation  # training, as its channels show it, without an analysis band
    readings: tuple[Reading, ...]  # of each joint
    revised: tuple[Revised, ...] = ()  # what readings and robot were told wrong
    held: frozenset[str] = frozenset()  # what the model is right about
    part: Part = UNCUT  # what ``robot`` is of the one in its text
    sparing: bool = False  # as observations are
    _shown: dict[tuple[str, float], Observation] = field(default_factory=dict)  # by recording and band
    _forces: dict[tuple[float, float], dict[tuple[bool, int, Reading], Kept]] = field(default_factory=dict)

    @property
    def joints(self) -> list[str]:
        return [joint.name for joint in self.robot.joints]

    @property
    def whole(self) -> Laws:
        """Training, without an analysis band."""
        return self._of(Workbench(self.kernel, read(self.seen, self.readings)))

    def case(self, cutoff: float, motion: float | None = None) -> Case:
        """Both recordings in the band below ``cutoff`` Hz; ``motion`` is that of the positions, the same if None.

        An effort that follows the angle may change far more quickly than the motion itself is seen to.
        """
        room = self._room(cutoff, motion)
        return Case(self.robot, self._laws(True, cutoff, room), self._laws(False, cutoff, room), self.own, self.revised)

    def training_laws(self, cutoff: float, motion: float | None = None) -> Laws:
        """Those of the case, without the other recording."""
        return self._laws(True, cutoff, self._room(cutoff, motion))

    def _room(self, cutoff: float, motion: float | None) -> float:
        """Hz below which positions are differentiated: a band wider than the motion would let in their noise."""
        return DERIVATIVE_ROOM * cutoff if motion is None else min(DERIVATIVE_ROOM * motion, self.seen.cutoff)

    def anew(self, **changes: Any) -> Setting:
        """With these fields changed, and without what was worked out of them as they were."""
        return replace(self, **changes, _shown={}, _forces={})

    def with_revision(self, revised: Revised) -> Setting:
        """In place of what was revised there before."""
        others = tuple(r for r in self.revised if (r.effect, r.place) != (revised.effect, revised.place))
        return replace(self, revised=(*others, revised))

    def below(self, joint: str, motion: float) -> Setting:
        """With the motion of that joint taken below so many Hz."""
        readings, i = list(self.readings), self.joints.index(joint)
        readings[i] = replace(readings[i], motion=motion)
        return replace(self, readings=tuple(readings))

    def earlier(self, delay: float) -> Setting:
        """With all efforts taken ``delay`` (s) earlier than they were."""
        return replace(self, readings=tuple(replace(r, late=r.late + delay) for r in self.readings))

    def trembling(self, noise: NDArray[np.float64]) -> Setting:
        """With such noise (N, n) on the positions that were recorded for training."""
        channels = dict(self.training.channels)
        for joint, values in zip(self.joints, noise.T, strict=True):
            key = self.training.key(Quantity.POSITION, joint)
            if key is not None:
                channels[key] = channels[key] + values
        moved = replace(self.training, channels=MappingProxyType(channels))
        return self.anew(training=moved)

    def given(self) -> float:
        """Edge (Hz) of the band that holds what the model as given leaves."""
        bench = self.whole.bench
        robot, alike = self.robot, joint_weight(bench.reference, bench.reference)
        start = fit(bench, self.kernel.values, self.own, alike, bounds(robot), sizes(robot))
        return analysis_band(bench.raw_residual(start.p), bench.observation).cutoff

    def left(self, current: Explanation) -> float:
        """Edge (Hz) of the band that holds what an explanation leaves."""
        whole = self.whole
        case, seen = Case(self.robot, whole, whole, self.own), whole.bench.observation
        return analysis_band(case.residual(whole, current), seen, WHOLE * seen.rate).cutoff

    def _laws(self, training: bool, cutoff: float, room: float) -> Laws:
        key = "training" if training else "heldout", room
        if key not in self._shown:
            recording = self.training if training else self.heldout
            self._shown[key] = observe(self.robot, self.kernel, recording, room)
        seen = replace(read(self._shown[key], self.readings), sparing=self.sparing)
        return self._of(Workbench(self.kernel, seen, band_of(cutoff, seen.rate)), self._known(training, cutoff, room))

    def _known(self, training: bool, cutoff: float, room: float) -> list[Kept]:
        """Of each joint, as its motion is read: of two bands, the later one's is kept."""
        if (cutoff, room) not in self._forces:
            self._forces.clear()
        known = self._forces.setdefault((cutoff, room), {})
        moved = (Reading(gain=r.gain, offset=r.offset, motion=r.motion) for r in self.readings)
        return [known.setdefault((training, joint, motion), Kept()) for joint, motion in enumerate(moved)]

    def _of(self, bench: Workbench, known: list[Kept] | None = None) -> Laws:
        return Laws(self.probes, bench, self.joints, frictions(self.robot), self.seen.cutoff, known)


def prepare(
    robot: Robot,
    training: Recording,
    heldout: Recording,
    progress: Callable[[str], None],
    fixed: frozenset[str] = frozenset(),
    part: Part = UNCUT,
) -> Setting:
    """Derive, compile, observe. Parameters ``fixed`` stay as the model gives them; ``robot`` is that ``part`` of it."""
    progress(f"deriving and compiling {robot.name}, and its candidate effects")
    kernel = mechanical_kernel(robot)
    training, heldout = (at_joints(robot, recording) for recording in (training, heldout))
    _check_alike(robot, training, heldout)
    seen, readings = observe(robot, kernel, training), declared(robot)
    joints = [joint.name for joint in robot.joints]
    proposed = tuple(
        c for c in candidates(robot) if part.has(c.effect, c.place.address) and _can_be_told(c, seen, joints)
    )
    fitted = own_parameters(robot, Workbench(kernel, read(seen, readings)))
    own = tuple(name for name in fitted if name not in fixed)
    if seen.known is not None:
        check_separable(seen.known, kernel, (seen.q, seen.qd, seen.qdd), own)
    known = probes((*proposed, *(friction.law for friction in frictions(robot))))
    return Setting(robot, kernel, own, known, proposed, training, heldout, seen, readings, held=fixed, part=part)


def _check_alike(robot: Robot, training: Recording, heldout: Recording) -> None:
    """Raise InputError (SD520) where one lacks an effort that the other holds: what one shows, the other must test."""
    lacks, lacks_there = (set(imposed_joints(robot, recording)) for recording in (training, heldout))
    for recording, missing in ((training, lacks - lacks_there), (heldout, lacks_there - lacks)):
        if missing:
            message = f"recording '{recording.name}' holds no effort of joint '{min(missing)}', and the other one does"
            where = robot.channels.where if robot.channels else None
            raise InputError(Problem("SD520", message, where, "record it in both, or map it in neither"))


def _can_be_told(candidate: Candidate, seen: Observation, joints: Sequence[str]) -> bool:
    """Not by a recording in which the joint stands, if it is a law in speed or distance; nor one that holds no effort
    of it.

    Nor where no effort acts, if it could take the place of gravity: then nothing would have a size, and no weight at
    all would fit best. What swings is told by an effort: of a joint that nothing drives only accelerations are left,
    which are the noise of its positions.
    """
    joint = joints.index(candidate.place.address)
    if not seen.tested[joint] or (candidate.swings and not np.any(seen.tau[:, joint])):
        return False
    travel = float(np.ptp(seen.measured[:, joint]))
    weightless = not np.any(seen.tau) and any(s.scan is Scan.ANGLE for s in candidate.shapes)
    return not weightless and (travel >= LEAST_TRAVEL or not candidate.shapes)
