"""What a diagnosis proposes of a drive with hidden parts, as one machine."""

from __future__ import annotations

from symdyn.numeric.filtering.hypotheses import augmented, hypotheses
from symdyn.spec.records import Robot


def test_stages_of_an_amplifier_stand_in_the_order_in_which_a_signal_passes_them(robot: Robot) -> None:
    effects = [e.type for e in augmented(robot, hypotheses(robot)).effects if e.at == "axis.circuit"]
    stages = [name for name in effects if name.startswith("amplifier")]
    assert stages == ["amplifier_gain", "amplifier_offset", "amplifier_dead_zone", "amplifier_saturation"]
