"""Times the generated kernels beside Pinocchio (wheel, C++) and Pinocchio traced by CasADi, and counts what they cost.

    python -m benchmarks.speed                            (or: make bench)
    python -m benchmarks.speed --write docs/speed.md      also writes the page and its plot

Everyone is checked against everyone else to 1e-10 first. Needs the extra `bench`, and gcc or clang; what is missing
is said and left out. The first run builds C++ for some minutes.
"""

from __future__ import annotations

import argparse
import json
import os
from dataclasses import asdict
from itertools import pairwise
from pathlib import Path

from benchmarks.speed.arms import bundled
from benchmarks.speed.chains import chain_costs, plot
from benchmarks.speed.costs import costs
from benchmarks.speed.kernels import Bench
from benchmarks.speed.measure import measure
from benchmarks.speed.native import Rival, rivals
from benchmarks.speed.report import Result, machine, ratios, tables
from symdyn.program.cost import Cost

try:
    import pinocchio as pin  # type: ignore[import-untyped]
except ImportError:
    pin = None

ROBOTS = ("puma560", "panda")
PLOT = "inverse_dynamics_by_joints.svg"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=30, help="rounds, each of all contestants (default: 30)")
    parser.add_argument("--json", type=Path, help="write everything that was measured to this file")
    parser.add_argument("--write", type=Path, help="write the page to this file, and the plot beside it")
    arguments = parser.parse_args()
    results = {name: _result(name, arguments.rounds) for name in ROBOTS}
    chains = chain_costs()
    page = _page(results, chains, arguments.rounds)
    print(page)
    if arguments.json:
        arguments.json.write_text(json.dumps(_facts(results, chains), indent=1) + "\n", encoding="utf-8")
    if arguments.write:
        arguments.write.write_text(page, encoding="utf-8")
        counted = {name: result.costs.operations["inverse_dynamics"] for name, result in results.items()}
        arms = {name: (bundled(name).joints, cost) for name, cost in counted.items()}
        plot(chains, arms, arguments.write.with_name(PLOT))


def _result(name: str, rounds: int) -> Result:
    arm = bundled(name)
    print(f"{name}: deriving, compiling", flush=True)
    compiled, spent = costs(arm)
    found = list(rivals(arm))
    others = [r for r in found if isinstance(r, Rival)]
    missing = [str(r) for r in found if not isinstance(r, Rival)]
    if pin is None:
        missing.append("pin is not installed: pip install '.[bench]'")
    bench = Bench(arm, compiled.kernel(), pin)
    bench.check(others)
    print(f"{name}: all agree; timing", flush=True)
    timings = measure(list(bench.contestants(others)), rounds)
    timings += measure(list(bench.large(others)), max(3, rounds // 6))
    return Result(timings, spent, missing)


def _page(results: dict[str, Result], chains: dict[int, Cost], rounds: int) -> str:
    counts = [(c.multiplications, c.additions) for c in chains.values()]
    steps = [(b[0] - a[0], b[1] - a[1]) for a, b in pairwise(counts)]
    lines = [
        "# Speed",
        "",
        "Written by `python -m benchmarks.speed --write docs/speed.md`; edits are lost. In brackets what was asked.",
        "Rigid arms, without drives and friction, because that is what Pinocchio has. Everyone agreed with",
        "Pinocchio's wheel to 1e-10 in 1000 random states first. Medians of",
        f"{rounds} rounds, in which all contestants take turns, in time of the thread (of the clock for all cores).",
        "Of several builds of a rival the fastest counts.",
        "",
        f"Machine: {machine()}; load when measured: {os.getloadavg()[0]:.1f}.",
        "",
        tables(results),
        "",
        "## Operations against joints",
        "",
        "Inverse dynamics of random arms in which no number is zero and no axes are parallel or meet.",
        f"From three joints on, a joint more costs {_range([s[0] for s in steps[1:]])} multiplications",
        f"and {_range([s[1] for s in steps[1:]])} additions: the growth is linear.",
        "",
        f"![Operations of inverse dynamics against the number of joints]({PLOT})",
        "",
        f"| joints | {' | '.join(map(str, chains))} |",
        f"| --- |{' ---: |' * len(chains)}",
        f"| multiplications | {' | '.join(str(m) for m, _ in counts)} |",
        f"| additions | {' | '.join(str(a) for _, a in counts)} |",
    ]
    return "\n".join(lines) + "\n"


def _range(values: list[int]) -> str:
    return str(min(values)) if min(values) == max(values) else f"{min(values)} to {max(values)}"


def _facts(results: dict[str, Result], chains: dict[int, Cost]) -> dict[str, object]:
    return {
        "machine": machine(),
        "robots": {name: asdict(result) for name, result in results.items()},
        "ratios": [
            {
                "what": label,
                "reached": {n: c[0] for n, c in cells.items()},
                "asked": {n: c[1] for n, c in cells.items()},
            }
            for label, cells in ratios(results)
        ],
        "chains": {n: asdict(cost) for n, cost in chains.items()},
    }


if __name__ == "__main__":
    main()
