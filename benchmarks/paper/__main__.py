"""Writes docs/paper.md and docs/paper/*.svg.

python -m benchmarks.paper
python -m benchmarks.paper --time  # instead: how long simulations take here, in multiples of real time
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

from benchmarks.paper.jumps import cases, jumps
from benchmarks.paper.page import FIGURES, page
from benchmarks.paper.study import study

DOCS = Path(__file__).resolve().parent.parent.parent / "docs"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=DOCS, help="the folder to write to (default: docs)")
    parser.add_argument("--time", action="store_true", help="measure simulations instead")
    arguments = parser.parse_args()
    if arguments.time:
        _measure()
        return
    folder: Path = arguments.out
    found = study()
    (folder / "paper").mkdir(parents=True, exist_ok=True)
    for name, draw in FIGURES.items():
        (folder / "paper" / name).write_text(draw(found), encoding="utf-8")
    (folder / "paper.md").write_text(page(found), encoding="utf-8")


def _measure() -> None:
    """Processor time, the best of nine; the first call, which compiles, does not count."""
    for name, (seconds, simulate) in cases(jumps()).items():
        simulate()
        taken = []
        for _ in range(9):
            before = time.process_time()
            found = simulate()
            taken.append(time.process_time() - before)
        print(f"{name}: {seconds / min(taken):.0f} x real time, {len(found.events)} events, {found.steps} steps")


if __name__ == "__main__":
    main()
