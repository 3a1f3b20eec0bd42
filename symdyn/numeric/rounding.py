"""Encoders whose steps leave most of what is left: nothing in a model is missing then, but what the encoder shows."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.encoder_steps import Steps, coarse, motion_above, rounded
from symdyn.numeric.explanation import Case, Explanation, Revised
from symdyn.numeric.findings import Estimate, Finding
from symdyn.numeric.inquiry import Inquiry
from symdyn.numeric.noise_floor import in_band, noise_density
from symdyn.numeric.observation import KEPT
from symdyn.numeric.position_spectrum import floor
from symdyn.numeric.recording_quality import steps_of
from symdyn.numeric.search import EARNS
from symdyn.numeric.setting import Setting
from symdyn.physics.effect import DISPLACEMENT
from symdyn.spec.monomials import value_of
from symdyn.spec.places import places
from symdyn.spec.records import Quantity

Array = NDArray[np.float64]

MOSTLY = 0.5  # of the power of what is left on held-out data
LESS = (1.0 - EARNS) ** 2  # of that power
ENCODER, RESOLUTION = "encoder", "resolution"


def below_steps(inquiry: Inquiry) -> Inquiry:
    """With the motion of joints taken below where it sinks into their encoder's steps, if that leaves less.

    Accelerations that are mostly steps make inertias too small, and what these leave then is taken for physics. Above
    that frequency positions tell nothing. Where less than half is left, that is what the recording lacked. Where most
    of the rest is quicker still, the band ends where all of that motion is kept: above, no equation that has this
    joint's acceleration can be tested. The others' motion is taken as in the whole band.
    """
    for joint, steps in _coarse(inquiry.setting):
        setting = inquiry.setting.below(joint, steps.motion)
        left = _left_below(inquiry, joint, steps.motion)
        if min(left) > LESS:
            continue
        edge = min(setting.given(), max(r.motion for r in setting.readings))
        if inquiry.motion is not None:  # the band ended for another joint
            edge = min(edge, inquiry.case.bench.edge)
        case = setting.case(edge, inquiry.motion)
        wide = replace(inquiry, setting=setting, case=case, current=case.explain())
        slow = _slow(wide, edge, steps)
        without = slow.explain()
        so = f"its motion is taken below {steps.motion:.3g} Hz"
        if _quicker(wide, without, joint, steps.size):
            so = f"nothing above {slow.bench.edge:.3g} Hz is tested"
            inquiry = replace(inquiry, motion=inquiry.motion or edge).noting(f"{_quicker_than(joint)}: {so}")
            case, given = slow, without
        elif left[0] > LESS:
            continue
        else:
            given = wide.current
        inquiry = replace(inquiry, origin=setting, first=case, given=given, setting=setting, case=case, current=given)
        if min(left) < 1.0 - MOSTLY:
            inquiry = _told(inquiry, joint, steps, 1.0 - min(left), so)
    return inquiry


def ended_at_steps(begun: Inquiry, found: Inquiry) -> Inquiry | None:
    """An inquiry begun again in a narrower band, where ``below_steps`` would have ended it had it known what was found.

    What a joint lacked was slow, and hid that most of the rest is an acceleration that its encoder does not show. None
    where that is not so.
    """
    for joint, steps in _coarse(begun.setting):
        edge = begun.case.bench.edge
        if begun.setting.readings[begun.setting.joints.index(joint)].motion < KEPT * edge:
            known = _slow(found, edge, steps).explain(found.current.found, found.current)
            if _quicker(found, known, joint, steps.size):
                case = _slow(begun, edge, steps)
                given = case.explain()
                so = f"{_quicker_than(joint)}: nothing above {case.bench.edge:.3g} Hz is tested"
                begun = replace(begun, motion=begun.motion or edge, first=case, given=given, case=case, current=given)
                return begun.noting(so)
    return None


def _slow(inquiry: Inquiry, edge: float, steps: Steps) -> Case:
    """That in the band where all of such an encoder's motion is kept."""
    return inquiry.setting.case(min(edge, KEPT * steps.motion), inquiry.motion or edge)


def _quicker_than(joint: str) -> str:
    return f"what is left at {joint} is quicker than its encoder can tell"


def _left_below(inquiry: Inquiry, joint: str, motion: float) -> list[float]:
    """Share of the power that is left with the motion of a joint taken below so many Hz.

    Where that is not less, some of the motion was taken, too; that the rest is mostly steps is seen an octave above, or
    two, ... up to the band's edge.
    """
    before, room = inquiry.given, _with_room(inquiry)
    power = _power(before.heldout, before, room)
    found: list[float] = []
    while not found or (min(found) > LESS and motion < inquiry.case.bench.edge):
        after = inquiry.setting.below(joint, motion).case(*inquiry.band).explain()
        found.append(_power(after.heldout, before, room) / power if power > 0.0 else 1.0)
        motion *= 2.0
    return found


def _quicker(wide: Inquiry, slow: Explanation, joint: str, size: float) -> bool:
    """Whether most of what is left at a joint lies in the wide band alone, and is not what its steps do there.

    Above the frequency where its motion is known it is an acceleration that nobody saw, and acts on other joints, too.
    """
    i = wide.setting.joints.index(joint)
    ways = wide.current.heldout, slow.heldout, _by_steps(wide, joint, size, False)
    left, below, own = (float(np.mean(each[:, i] ** 2)) for each in ways)
    return max(below, own) < (1.0 - MOSTLY) * left


def with_resolutions(inquiry: Inquiry) -> Inquiry:
    """With a finding for each encoder that the model gives no steps, and whose steps tell most of what is left.

    Every encoder has steps. Those that hide something are most of what trembles in its positions, and are looked for at
    the joints where the noise of the efforts leaves them room to be most of what is left. What rounding does there is
    measured: positions, smoothed and rounded again, go to the residual as they are. Where nothing is left, they hide
    nothing. Where no effort is measured, noise of positions is all that is ever left: the model learns those steps, and
    an alarm tells them, but a machine whose rest they are lacks nothing.
    """
    current, room = inquiry.current, _with_room(inquiry)
    if inquiry.case.nothing_left(current):
        return inquiry
    for joint, steps in _coarse(inquiry.setting):
        left = _power(current.heldout, current, room)
        own = _power(_by_steps(inquiry, joint, steps.size, False), current, room)
        share = own / left if left > 0.0 else 0.0
        if MOSTLY <= share <= 1.0 / MOSTLY:  # more than is left was never there: where a joint stands, nothing trembles
            inquiry = _told(inquiry, joint, steps, share, "nothing smaller can be told")
    return inquiry


def left_by_steps(inquiry: Inquiry) -> tuple[Array, Array]:
    """(n,) root mean square of what the steps of encoders leave of the residual: training, held out.

    Of those that are known, by the model or found, and of those that the positions lie on and hardly tremble beyond.
    """
    sizes = [item for item in {**_mostly_steps(inquiry.setting), **_known(inquiry.setting)}.items() if item[1] > 0.0]
    none = np.zeros(len(inquiry.setting.joints))
    power = [
        sum((np.mean(_by_steps(inquiry, *item, training) ** 2, axis=0) for item in sizes), start=none)
        for training in (True, False)
    ]
    return np.sqrt(power[0]), np.sqrt(power[1])


def _mostly_steps(setting: Setting) -> dict[str, float]:
    """Joints and steps of the encoders whose noise is mostly that of their steps, which is even over its spectrum."""
    recording, found = setting.heldout, {}
    for joint in setting.joints:
        key = recording.key(Quantity.POSITION, joint)
        steps = None if key is None else steps_of(recording.channels[key])
        if key is None or steps is None:
            continue
        density = float(floor(recording.channels[key][:, None], recording.segments, 1.0 / recording.sample_time)[0])
        if steps[0] ** 2 / 12.0 >= MOSTLY * density * 0.5 / recording.sample_time:
            found[joint] = steps[0]
    return found


def _coarse(setting: Setting) -> Iterator[tuple[str, Steps]]:
    """Joints whose encoder trembles by no more than its steps."""
    recording = setting.heldout
    for joint in setting.joints:
        key = recording.key(Quantity.POSITION, joint)
        steps = None if key is None else coarse(recording, key)
        if steps is not None:
            yield joint, steps


def _told(inquiry: Inquiry, joint: str, steps: Steps, share: float, so: str) -> Inquiry:
    """With those steps in the model, and where an effort acts with the finding; as it is, where they are known."""
    setting, case = inquiry.setting, inquiry.case
    if joint in _known(setting):
        return inquiry
    place = next(p for p in places(setting.robot) if p.address == joint)
    estimate = Estimate(steps.size, steps.standard_error, DISPLACEMENT[place.motion])
    earlier = next((r for r in setting.revised if (r.effect, r.place) == (ENCODER, joint)), None)
    values = {**(earlier.values if earlier else {}), RESOLUTION: estimate}
    setting = setting.with_revision(Revised(ENCODER, "encoder resolution", joint, values))
    error = case.errors(inquiry.current).heldout  # stays: what rounding did is known in size, not in course
    found = Finding(ENCODER, "encoder resolution", joint, {RESOLUTION: estimate}, error, error, 0.0, ())
    words = f"the steps of the encoder at {joint} leave {100.0 * min(share, 1.0):.0f} % of what is left"
    case = replace(case, revised=setting.revised)
    inquiry = replace(inquiry, setting=setting, case=case).noting(f"{words}: {so}")
    pushed = bool(np.any(case.bench.effort[:, setting.joints.index(joint)]))
    return replace(inquiry, findings=(*inquiry.findings, found)) if pushed else inquiry


def _known(setting: Setting) -> dict[str, float]:
    """Joints and steps of the encoders of which the model, or a finding, says them."""
    numbers = {p.name: p.value for p in setting.robot.parameters}
    steps = {
        e.at: value_of(dict(e.values)[RESOLUTION], numbers) or 0.0
        for e in setting.robot.effects
        if e.type == ENCODER and RESOLUTION in dict(e.values) and e.at in setting.joints
    }
    return steps | {r.place: r.values[RESOLUTION].value for r in setting.revised if RESOLUTION in r.values}


def _by_steps(inquiry: Inquiry, joint: str, size: float, training: bool) -> Array:
    """(K, n) what rounding the positions of a joint to such steps does to the residual.

    Where a joint seems to stand either way nothing is counted: the rest stands for that, too.
    """
    setting, case = inquiry.setting, inquiry.case
    recording = setting.training if training else setting.heldout
    key = recording.key(Quantity.POSITION, joint)
    assert key is not None
    counted = (case.laws if training else case.judged).bench.counted != 0.0
    ends, both = [], counted
    for x in rounded(recording, key, size, motion_above(recording, key, size)):
        shown = replace(recording, channels={**recording.channels, key: x})
        given = (shown, setting.heldout) if training else (setting.training, shown)
        other = setting.anew(training=given[0], heldout=given[1]).case(*inquiry.band)
        laws = other.laws if training else other.judged
        ends.append(case.residual(laws, inquiry.current))
        both = both & (laws.bench.counted != 0.0)
    share = np.sum(both, axis=0) / np.maximum(np.sum(counted, axis=0), 1)
    return np.asarray((ends[1] - ends[0]) * both / np.sqrt(np.where(share > 0.0, share, 1.0)))


def _power(residual: Array, of: Explanation, room: NDArray[np.bool_]) -> float:
    """Of all joints with ``room`` for steps, in the units that an explanation weighs them by."""
    return float(np.sum((residual * of.weight)[:, room] ** 2))


def _with_room(inquiry: Inquiry) -> NDArray[np.bool_]:
    """(n,) where steps may be most of what is left, held out, beside the noise of the joint's effort."""
    judge, current = inquiry.case.judge, inquiry.current
    noise = in_band(noise_density(judge, current.fit.p), judge)
    return np.asarray((1.0 - MOSTLY) * np.mean(current.heldout**2, axis=0) > noise**2)
