"""Where the motion of a joint sinks into its encoder's steps: looked for in octaves, up to the edge of the band."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from symdyn.numeric import rounding
from symdyn.numeric.inquiry import Inquiry

STEPS, EDGE = 1.7, 25.0  # Hz: where the motion sinks into the steps, and where the band ends


def inquiry(asked: list[float], left: dict[float, float]) -> Inquiry:
    """One whose residual, of 1 N m, is ``left`` (N m) with the motion of a joint taken below so many Hz."""

    def below(joint: str, motion: float) -> Any:
        asked.append(motion)
        after = SimpleNamespace(heldout=np.full((100, 1), left.get(motion, 1.0)))
        return SimpleNamespace(case=lambda *_: SimpleNamespace(explain=lambda: after))

    given = SimpleNamespace(heldout=np.ones((100, 1)), weight=np.ones(1))
    case = SimpleNamespace(bench=SimpleNamespace(edge=EDGE))
    return cast(Inquiry, SimpleNamespace(given=given, case=case, band=(EDGE,), setting=SimpleNamespace(below=below)))


@pytest.mark.parametrize(
    ("left", "octaves", "share"),
    [
        ({STEPS: 0.9}, 1, 0.81),  # at once
        ({STEPS: 1.1, 4.0 * STEPS: 0.8}, 3, 0.64),  # some of the motion is below, and taken with the steps
        ({STEPS: 0.99, 2.0 * STEPS: 0.98}, 4, 0.9604),  # nowhere by 3 %: asked up to the edge
    ],
)
def test_octaves_are_asked_until_less_is_left(
    monkeypatch: pytest.MonkeyPatch, left: dict[float, float], octaves: int, share: float
) -> None:
    monkeypatch.setattr(rounding, "_with_room", lambda _: np.array([True]))
    asked: list[float] = []
    found = rounding._left_below(inquiry(asked, left), "j1", STEPS)
    assert asked == [STEPS * 2.0**k for k in range(octaves)]
    assert min(found) == pytest.approx(share)
    assert len(found) == octaves
