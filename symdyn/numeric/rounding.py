"""Encoders whose steps leave most of what is left: nothing in a model is missing then, but what the encoder shows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.explanation import Revised
from symdyn.numeric.findings import Estimate, Finding
from symdyn.numeric.inquiry import Inquiry
from symdyn.numeric.noise_floor import in_band, noise_density
from symdyn.numeric.observation import low_pass
from symdyn.numeric.recording import ChannelKey
from symdyn.numeric.recording_quality import steps_of
from symdyn.numeric.setting import Setting
from symdyn.physics.effect import DISPLACEMENT
from symdyn.spec.places import places
from symdyn.spec.records import Quantity

MOSTLY = 0.5  # of the power of what is left on held-out data
ENCODER, RESOLUTION = "encoder", "resolution"
APART = (3.0 - 3.0**0.5) / 6.0  # of a step: rounding errors that far apart on the scale are not correlated


def with_resolutions(inquiry: Inquiry) -> Inquiry:
    """With a finding for each encoder that the model gives no steps, and whose steps tell most of what is left.

    Looked at are the joints where more is left than the noise of their efforts: every encoder has steps, and elsewhere
    they hide nothing.
    What rounding does is measured: the positions, smoothed, go the same way to the residual as they are, and rounded to
    another scale with the same steps. The difference is like what the encoder's own rounding left: a sawtooth, whose
    power is where it is in the band, however slowly the joint turns.
    """
    setting, case, current = inquiry.setting, inquiry.case, inquiry.current
    told = _above_noise(inquiry)
    known = {e.at for e in setting.robot.effects if e.type == ENCODER and RESOLUTION in dict(e.values)}
    at = {place.address: place for place in places(setting.robot)}
    for joint in setting.joints:
        used = setting.heldout.key(Quantity.POSITION, joint)
        steps = None if used is None else steps_of(setting.heldout.channels[used])
        if used is None or steps is None or joint in known or not np.any(current.heldout[:, told]):
            continue
        smooth, rounded = (_shown(setting, used, step, case.judge.observation.cutoff) for step in (0.0, steps[0]))
        ends = [
            (case.residual(shown.case(*inquiry.band).judged, current) * current.weight)[:, told]
            for shown in (smooth, rounded)
        ]
        share = float(np.sum((ends[1] - ends[0]) ** 2) / np.sum((current.heldout * current.weight)[:, told] ** 2))
        if share < MOSTLY:
            continue
        estimate = Estimate(*steps, DISPLACEMENT[at[joint].motion])
        earlier = next((r for r in setting.revised if (r.effect, r.place) == (ENCODER, joint)), None)
        values = {**(earlier.values if earlier else {}), RESOLUTION: estimate}
        setting = setting.with_revision(Revised(ENCODER, "encoder resolution", joint, values))
        error = case.errors(current).heldout  # stays: what rounding did is known in size, not in course
        found = Finding(ENCODER, "encoder resolution", joint, {RESOLUTION: estimate}, error, error, 0.0, ())
        words = f"the steps of the encoder at {joint} leave {100.0 * min(share, 1.0):.0f} % of what is left"
        inquiry = replace(inquiry, findings=(*inquiry.findings, found)).noting(f"{words}: nothing smaller can be told")
    case = replace(case, revised=setting.revised)
    return replace(inquiry, setting=setting, case=case)


def _above_noise(inquiry: Inquiry) -> NDArray[np.bool_]:
    """(n,) where more is left, held out, than the noise of the joint's effort leaves."""
    judge, current = inquiry.case.judge, inquiry.current
    left = np.sqrt(np.mean(current.heldout**2, axis=0))
    return np.asarray(left > in_band(noise_density(judge, current.fit.p), judge))


def _shown(setting: Setting, key: ChannelKey, step: float, cutoff: float) -> Setting:
    """The same setting, this channel of its held-out recording without what is quicker, and in such steps."""
    recording = setting.heldout
    smooth = recording.channels[key].copy()
    for part in recording.segments:
        smooth[part] = low_pass(smooth[part], 1.0 / recording.sample_time, cutoff)
    if step:
        smooth = (np.round(smooth / step + APART) - APART) * step
    return replace(setting, heldout=replace(recording, channels={**recording.channels, key: smooth}), _shown={})
