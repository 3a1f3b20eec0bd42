"""What a diagnosis is given, and compiles once: robot, recordings, candidates; cases in any analysis band from it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from symdyn.compiler import compile_robot
from symdyn.emit.kernel import Kernel
from symdyn.numeric.band import analysis_band, band_of
from symdyn.numeric.candidates import Candidate, bounds, candidates
from symdyn.numeric.explanation import Case, Explanation, own_parameters
from symdyn.numeric.fitting import fit, joint_weight
from symdyn.numeric.laws import Laws
from symdyn.numeric.observation import observe
from symdyn.numeric.probe import Probe, probes
from symdyn.numeric.recording import Recording
from symdyn.numeric.workbench import Workbench
from symdyn.spec.records import Motion, Robot

DERIVATIVE_ROOM = 5.0  # positions are low-passed this far above the band (Gautier, Janot: five times the dynamics)


@dataclass(frozen=True, slots=True, eq=False)
class Setting:
    robot: Robot
    kernel: Kernel
    own: tuple[str, ...]  # the model's own parameters that a fit moves
    probes: Mapping[Motion, Probe]
    proposed: tuple[Candidate, ...]
    training: Recording
    heldout: Recording
    whole: Laws  # training, without an analysis band

    def case(self, cutoff: float, motion: float | None = None) -> Case:
        """Both recordings in the band below ``cutoff`` Hz; ``motion`` is that of the positions, the same if None.

        An effort that follows the angle may change far more quickly than the motion itself is seen to.
        """
        room = DERIVATIVE_ROOM * (cutoff if motion is None else motion)
        training, heldout = (self._laws(recording, cutoff, room) for recording in (self.training, self.heldout))
        return Case(self.robot, training, heldout, self.own)

    def given(self) -> float:
        """Edge (Hz) of the band that holds what the model as given leaves."""
        bench = self.whole.bench
        start = fit(
            bench, self.kernel.values, self.own, joint_weight(bench.reference, bench.reference), bounds(self.robot)
        )
        return analysis_band(bench.raw_residual(start.p), bench.observation).cutoff

    def left(self, current: Explanation) -> float:
        """Edge (Hz) of the band that holds what an explanation leaves."""
        case = Case(self.robot, self.whole, self.whole, self.own)
        seen = self.whole.bench.observation
        return analysis_band(case.residual(self.whole, current), seen, 0.4 * seen.rate).cutoff

    def _laws(self, recording: Recording, cutoff: float, room: float) -> Laws:
        seen = observe(self.robot, self.kernel, recording, room)
        return Laws(self.probes, Workbench(self.kernel, seen, band_of(cutoff, seen.rate)), self.whole.joints)


def prepare(robot: Robot, training: Recording, heldout: Recording, progress: Callable[[str], None]) -> Setting:
    """Derive, compile, observe."""
    proposed = candidates(robot)
    progress(f"deriving and compiling {robot.name}, and {len(proposed)} candidate effects")
    kernel, known = compile_robot(robot).kernel(), probes(proposed)
    bench = Workbench(kernel, observe(robot, kernel, training))
    whole = Laws(known, bench, [joint.name for joint in robot.joints])
    return Setting(robot, kernel, own_parameters(robot, bench), known, proposed, training, heldout, whole)
