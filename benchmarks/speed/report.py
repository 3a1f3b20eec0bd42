"""The tables of docs/speed.md, from what was measured."""

from __future__ import annotations

import platform
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import numba

from benchmarks.speed.costs import Costs
from benchmarks.speed.limit import OF_AN_ANGLE, nanoseconds_of_a_product, products
from benchmarks.speed.measure import Timing, best
from benchmarks.speed.native import CPP, FUNCTIONS
from benchmarks.speed.targets import ASKED, BATCH, CITED, LOOP, MILLION, ONCE, OPERATIONS, SECONDS

IN_PLACE, ALL_CORES = "symdyn, rows, in place", "all cores"
WORDS = {
    "inverse_dynamics": "inverse dynamics",
    "mass_matrix": "mass matrix",
    "forward_dynamics": "forward dynamics",
    "forward_dynamics_state_jacobian": "derivatives of forward dynamics",
}


@dataclass(frozen=True)
class Result:
    """All that was measured of one arm."""

    timings: list[Timing]
    costs: Costs
    unavailable: list[str]


Results = Mapping[str, Result]


def machine() -> str:
    """Processor, cores, compilers' target, versions of what was compared."""
    cpuinfo = Path("/proc/cpuinfo")
    lines = cpuinfo.read_text(encoding="utf-8").split("\n") if cpuinfo.exists() else []
    name = next((line.split(": ", 1)[1] for line in lines if line.startswith("model name")), platform.processor())
    flags = next((line for line in lines if line.startswith("flags")), "").split()
    wide = next((label for flag, label in (("avx512f", "AVX-512"), ("avx2", "AVX2")) if flag in flags), "")
    cores = numba.config.NUMBA_DEFAULT_NUM_THREADS
    parts = [
        f"{name} ({platform.machine()}{', ' + wide if wide else ''}), {cores} cores",
        f"Python {platform.python_version()}",
    ]
    parts += [f"{package} {_version(package)}" for package in ("numba", "numpy", "pin", "casadi")]
    return "; ".join(parts)


def ratios(results: Results) -> list[tuple[str, dict[str, tuple[float | None, float]]]]:
    """Per row of the table: what is compared, and by robot the ratio that was reached, and that was asked."""
    rows = []
    for asked in ASKED:
        label = f"{WORDS[asked.function]}, {asked.form}, against {asked.rival}"
        rows.append((label, {name: (_ratio(results[name], asked), asked.ratio[name]) for name in results}))
    return rows


def _ratio(result: Result, asked: object) -> float | None:
    form, function, rival = (getattr(asked, key) for key in ("form", "function", "rival"))
    ours = _ours(result, function, form)
    # Rivals have no batches: they run through the same states in a loop.
    theirs = best(result.timings, function, LOOP if form == BATCH else form, rival)
    return theirs.ns / ours.ns if ours and theirs else None


def _ours(result: Result, function: str, form: str) -> Timing | None:
    """The fastest on one thread."""
    return best([t for t in result.timings if not t.who.endswith(ALL_CORES)], function, form, "symdyn")


def tables(results: Results) -> str:
    return "\n\n".join((_asked(results), _cost_table(results), _limits(results), _cited(results), _times(results)))


def _asked(results: Results) -> str:
    lines = [
        "## Reached, and asked for",
        "",
        "Times faster, one thread. CasADi's C has common subexpressions shared (its option `cse`), and of\n"
        "several ways to a value (Pinocchio's derivatives or CasADi's, world or joint frames) the cheapest.",
        "",
        *_header("", results),
    ]
    for label, cells in ratios(results):
        lines.append(_line(label, [_compared(*cell) for cell in cells.values()]))
    return "\n".join(lines)


def _compared(reached: float | None, asked: float) -> str:
    if reached is None:
        return f"not measured ({asked:g})"
    return f"{reached:.1f} ({asked:g})" + ("" if reached >= asked else ", short")


def _cost_table(results: Results) -> str:
    lines = ["## Before it runs", "", *_header("", results)]
    for name in FUNCTIONS:
        cells = []
        for robot, result in results.items():
            cost = result.costs.operations[name]
            asked = " ({} + {})".format(*OPERATIONS[robot]) if name == "inverse_dynamics" else ""
            cells.append(f"{cost.multiplications} + {cost.additions}{asked}")
        lines.append(_line(f"{WORDS[name]}: multiplications + additions", cells))
    words = (
        "derive and emit all functions, s of processor",
        "first compilation of seven functions, s of processor",
        "the same from the cache, s of processor",
    )
    for k, word in enumerate(words):
        reached = {robot: (r.costs.derive, r.costs.compile, r.costs.load)[k] for robot, r in results.items()}
        lines.append(_line(word, [f"{value:.1f} ({SECONDS[robot][k]:g})" for robot, value in reached.items()]))
    return "\n".join(lines)


def _limits(results: Results) -> str:
    """How far batches are from what the processor can do."""
    product = nanoseconds_of_a_product()
    lines = [
        "## What this processor allows", "",
        f"A product, with a sum or without, takes {product:.4f} ns of one thread and one state here where vectors are",
        f"full and nothing else is done. A sine with its cosine holds {OF_AN_ANGLE}. So no batch is faster than its",
        "products, and no ratio larger than Pinocchio's time over theirs. A processor that does a vector of eight at",
        "once, and not in two halves, allows twice as much.", "",
        _line("", ["products", "they take, ns", "batch, ns", "share", "C++ over them", "asked"]),
        "| --- |" + " ---: |" * 6,
    ]  # fmt: skip
    for asked in (a for a in ASKED if a.form == BATCH and a.rival == CPP):
        for robot, result in results.items():
            count = products(result.costs.operations[asked.function])
            ours, theirs = _ours(result, asked.function, BATCH), best(result.timings, asked.function, LOOP, CPP)
            least = count * product
            cells = [str(count), f"{least:.1f}"]
            cells += [f"{ours.ns:.1f}", f"{least / ours.ns:.0%}"] if ours else ["", ""]
            cells += [f"{theirs.ns / least:.0f}" if theirs else "", f"{asked.ratio[robot]:g}"]
            lines.append(_line(f"{robot}, {WORDS[asked.function]}", cells))
    lines += ["", f"On all cores, in place, by the clock: {_gains(results)}."]
    return "\n".join(lines)


def _gains(results: Results) -> str:
    """How much quicker a batch in place is on all cores."""
    found = []
    for robot, result in results.items():
        for form in (BATCH, MILLION):
            timed = [t for t in result.timings if (t.function, t.form) == ("inverse_dynamics", form)]
            ns = {t.who: t.ns for t in timed if t.who.startswith(IN_PLACE)}
            if len(ns) == 2:
                found.append(f"{ns[IN_PLACE] / ns[f'{IN_PLACE}, {ALL_CORES}']:.1f} times as fast ({robot}, {form})")
    return "; ".join(found)


def _cited(results: Results) -> str:
    lines = [
        "## Against figures from elsewhere", "",
        "What was asked was set beside times measured elsewhere, on 2 vCPU of an AMD Zen 5, November 2026. Those times",
        "in ns, over ours of this run: two machines, so no more than a hint. CasADi's derivatives took ten times as",
        "long as its forward dynamics there; the cheapest way, above, takes four to five times as long.", "",
        *_header("compiled loop", results),
    ]  # fmt: skip
    for rival, cited in CITED.items():
        for k, name in enumerate(FUNCTIONS):
            found = [(cited[robot][k], _ours(result, name, LOOP)) for robot, result in results.items()]
            cells = [f"{ns} / {t.ns:.0f} = {ns / t.ns:.1f}" if t else "" for ns, t in found]
            lines.append(_line(f"{WORDS[name]}, {rival}", cells))
    return "\n".join(lines)


def _times(results: Results) -> str:
    """Everything, in nanoseconds per state."""
    parts = []
    for robot, result in results.items():
        for form in (LOOP, BATCH, MILLION, ONCE):
            these = [t for t in result.timings if t.form == form]
            names = [name for name in FUNCTIONS if any(t.function == name for t in these)]
            lines = [
                f"## {robot}, {form}",
                "",
                "ns per state, medians.",
                "",
                *_header("", [WORDS[name] for name in names]),
            ]
            for who in dict.fromkeys(t.who for t in these):
                found = {t.function: t.ns for t in these if t.who == who}
                lines.append(_line(who, [f"{found[name]:.1f}" if name in found else "" for name in names]))
            parts.append("\n".join(lines))
        parts += result.unavailable
    return "\n\n".join(parts)


def _header(first: str, columns: Sequence[str] | Results) -> list[str]:
    return [_line(first, list(columns)), "| --- |" + " ---: |" * len(columns)]


def _line(first: str, cells: Sequence[str]) -> str:
    return f"| {first} | " + " | ".join(cells) + " |"


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed"
