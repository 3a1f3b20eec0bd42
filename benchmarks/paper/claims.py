"""The claims of section 4.2, each with the numbers that decide it."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from benchmarks.paper.study import LOW, Study, cosine, first_felt, largest_change, peak_change

BANDS = ((0.1, 5.0), (5.0, 50.0), (50.0, 300.0), (300.0, 800.0), (800.0, 3000.0))
D_VERDICT = "confirmed; d_2 from 300 Hz on"
C_VERDICT = "corrected: they are felt from 100 to 200 Hz on"
LOW_VERDICT = "confirmed for J_4; of d_3 between 5 and 50 Hz alone"
FELT = 0.5  # dB: what is read off a printed plot


def claims(s: Study) -> str:
    """The table of claims; what is said and its verdict stand here, every number is computed."""
    rows = [
        (
            "L has only influence on mode 3",
            "nearly: it is a lag, of which mode 2 feels a third; no mode is shifted",
            _inductance,
        ),
        ("d_1 and d_2 influence the amplitude above 500 Hz, d_2 more than d_1", D_VERDICT, _dampers),
        ("c_1 and c_2 influence the behaviour above 500 Hz", C_VERDICT, _stiffnesses),
        ("mode 1 is influenced strongly by d_3, in amplitude only", "confirmed", partial(_mode_1, name="d_3")),
        ("... and by c_3", "confirmed: in frequency; its height hardly moves", partial(_mode_1, name="c_3")),
        ("J_4 and d_3 are slightly dependent", "confirmed", _dependence),
        ("J_4 and d_3 have much influence on the low-frequency behaviour", LOW_VERDICT, _low),
        ("d_4 to d_7 have no strong influence", "confirmed, d_6 the strongest", _weak),
        ("they may be replaced by d_5' = d_4 + d_5 + d_6 + d_7", "confirmed; d_7 because its value is 0", _lump),
    ]
    head = ["| the paper | verdict | numbers |", "| --- | --- | --- |"]
    return "\n".join(head + [f"| {claim} | {verdict} | {numbers(s)} |" for claim, verdict, numbers in rows])


def bands_table(s: Study) -> str:
    """Largest change in dB per band, of every parameter halved and doubled."""
    names = dict.fromkeys(v.parameter for v in s.varied.variations)
    head = " | ".join(f"{low:g} to {high:g} Hz" for low, high in BANDS)
    rows = [f"| parameter | {head} |", f"| --- |{' ---: |' * len(BANDS)}"]
    used = s.family.derivatives(s.family.values).used
    for name in names:
        if used[s.family.index(name)]:
            cells = " | ".join(f"{largest_change(s, name, low, high):.2f}" for low, high in BANDS)
            rows.append(f"| {name} | {cells} |")
    return "\n".join(rows)


def _inductance(s: Study) -> str:
    k = s.family.index("L")
    moved = max(abs(s.local.frequency_log[k, i]) for i, mode in enumerate(s.modes) if mode.pole.imag > 0)
    heights = [_heights(s, "L", peak) for peak in range(3)]
    return (
        f"halved and doubled, the peaks change by {'; '.join(heights)}; no mode moves by more than {100 * moved:.1f} % "
        f"of the change of L; above mode 3 it grows to {largest_change(s, 'L', 800, 3000):.1f} dB at 3 kHz"
    )


def _dampers(s: Study) -> str:
    parts = []
    for name in ("d_1", "d_2"):
        start = first_felt(s, name, FELT)
        parts.append(
            f"{name}: at most {largest_change(s, name, LOW, 200):.2f} dB below 200 Hz and "
            f"{largest_change(s, name, 500, 3000):.2f} dB above 500 Hz, "
            + (f"{FELT:g} dB from {start:.0f} Hz on" if start is not None else f"nowhere {FELT:g} dB")
        )
    return "; ".join(parts) + "; d_2 shapes the anti-resonance at 395 Hz, too"


def _stiffnesses(s: Study) -> str:
    parts = []
    for name in ("c_1", "c_2"):
        start = first_felt(s, name, FELT)
        assert start is not None
        parts.append(
            f"{name}: {FELT:g} dB from {start:.0f} Hz on, at most {largest_change(s, name, LOW, 50):.2f} dB below 50 Hz"
        )
    return "; ".join(parts)


def _mode_1(s: Study, name: str) -> str:
    k, i = s.family.index(name), next(i for i, mode in enumerate(s.modes) if mode.pole.imag > 0)
    shifts = [peak_change(s, name, factor, 0) for factor in (0.5, 2.0)]
    told = "; ".join(
        f"× {factor:g}: peak {100 * (shift[0] - 1):+.1f} % in frequency, {shift[1]:+.2f} dB in height"
        for factor, shift in zip((0.5, 2.0), shifts, strict=True)
        if shift is not None
    )
    damping = s.local.damping_log[k, i] / s.modes[i].damping
    return f"{told}; per %: frequency {_small(s.local.frequency_log[k, i])} %, damping ratio {_small(damping)} %"


def _dependence(s: Study) -> str:
    return (
        f"cosine between their sensitivities, 0.1 to 100 Hz: {cosine(s, 'J_4', 'd_3', 0.1, 100):.2f} "
        f"(J_4 and c_3: {cosine(s, 'J_4', 'c_3', 0.1, 100):.2f}, those are hard to tell apart)"
    )


def _low(s: Study) -> str:
    return "; ".join(
        f"{name}: {largest_change(s, name, 0.1, 5):.2f} dB below 5 Hz, "
        f"{largest_change(s, name, 5, 50):.1f} dB from 5 to 50 Hz"
        for name in ("J_4", "d_3")
    )


def _weak(s: Study) -> str:
    parts = [f"{name} {largest_change(s, name, LOW, 3000):.2f} dB" for name in ("d_4", "d_5", "d_6")]
    return f"halved or doubled, at most: {', '.join(parts)}; d_7 is 0"


def _lump(s: Study) -> str:
    parts = []
    for reduction in (s.control, s.whole):
        lump = next(g for g in reduction.lumps if g.into == "d_5")
        others = ", ".join(f"{name} {_percent(c.worst)}" for name, c in lump.alternatives if name != "d_5")
        parts.append(
            f"error of G up to {reduction.band.high:g} Hz: {_percent(lump.cost.worst)} (at {lump.cost.hertz:.0f} Hz), "
            f"cosine {lump.parallel:.4f}; into {others}"
        )
    return "; ".join(parts)


def _heights(s: Study, name: str, peak: int) -> str:
    moved: Sequence[tuple[float, float] | None] = [peak_change(s, name, factor, peak) for factor in (0.5, 2.0)]
    cells = [f"{m[1] + 0.0:+.2f}" if m is not None else "gone" for m in moved]
    return f"mode {peak + 1} {' and '.join('0.00' if c in ('+0.00', '-0.00') else c for c in cells)} dB"


def _small(value: float) -> str:
    return f"{round(value, 3) + 0.0:.3f}"


def _percent(value: float) -> str:
    return f"{100 * value:.2g} %"
