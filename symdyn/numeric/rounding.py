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
from symdyn.numeric.recording import ChannelKey, Recording
from symdyn.numeric.recording_quality import steps_of
from symdyn.numeric.setting import Setting
from symdyn.physics.effect import DISPLACEMENT
from symdyn.spec.places import places
from symdyn.spec.records import Quantity

Array = NDArray[np.float64]

MOSTLY = 0.5  # of the power of what is left on held-out data, and of what is quick in the positions
ENCODER, RESOLUTION = "encoder", "resolution"
APART = (3.0 - 3.0**0.5) / 6.0  # of a step: rounding errors that far apart on the scale are not correlated


def with_resolutions(inquiry: Inquiry) -> Inquiry:
    """With a finding for each encoder that the model gives no steps, and whose steps tell most of what is left.

    Every encoder has steps. Those that hide something are most of what trembles in its positions, and are looked for at
    the joints where the noise of the efforts leaves them room to be most of what is left.

    What rounding does is measured: the positions, smoothed, go the same way to the residual as they are, and rounded to
    another scale with the same steps. The difference is like what the encoder's own rounding left: a sawtooth, whose
    power is where it is in the band, however slowly the joint turns.
    """
    setting, case, current = inquiry.setting, inquiry.case, inquiry.current
    told = _with_room(inquiry)
    known = {e.at for e in setting.robot.effects if e.type == ENCODER and RESOLUTION in dict(e.values)}
    at = {place.address: place for place in places(setting.robot)}
    for joint in setting.joints:
        used = setting.heldout.key(Quantity.POSITION, joint)
        steps = None if used is None else steps_of(setting.heldout.channels[used])
        if used is None or steps is None or joint in known or not np.any(current.heldout[:, told]):
            continue
        recording, edge = setting.heldout, case.judge.observation.cutoff
        smooth = _smoothed(recording, recording.channels[used], edge)
        rounded = (np.round(smooth / steps[0] + APART) - APART) * steps[0]
        noise, own = (x - _smoothed(recording, x, edge) for x in (recording.channels[used], rounded))
        if np.sum(own**2) < MOSTLY * np.sum(noise**2):
            continue  # the encoder trembles by more than its steps
        ends = [
            (case.residual(_shown(setting, used, x).case(*inquiry.band).judged, current) * current.weight)[:, told]
            for x in (smooth, rounded)
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


def _with_room(inquiry: Inquiry) -> NDArray[np.bool_]:
    """(n,) where steps may be most of what is left, held out, beside the noise of the joint's effort."""
    judge, current = inquiry.case.judge, inquiry.current
    noise = in_band(noise_density(judge, current.fit.p), judge)
    return np.asarray((1.0 - MOSTLY) * np.mean(current.heldout**2, axis=0) > noise**2)


def _smoothed(recording: Recording, values: Array, cutoff: float) -> Array:
    """(N,) without what is quicker."""
    smooth = values.copy()
    for part in recording.segments:
        smooth[part] = low_pass(smooth[part], 1.0 / recording.sample_time, cutoff)
    return smooth


def _shown(setting: Setting, key: ChannelKey, values: Array) -> Setting:
    """The same setting, with other values in this channel of its held-out recording."""
    recording = setting.heldout
    return replace(setting, heldout=replace(recording, channels={**recording.channels, key: values}), _shown={})
