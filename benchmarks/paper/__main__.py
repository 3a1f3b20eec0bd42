"""Writes docs/paper.md and docs/paper/*.svg.

python -m benchmarks.paper
"""

from __future__ import annotations

import argparse
from pathlib import Path

from benchmarks.paper.page import FIGURES, page
from benchmarks.paper.study import study

DOCS = Path(__file__).resolve().parent.parent.parent / "docs"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=DOCS, help="the folder to write to (default: docs)")
    folder = parser.parse_args().out
    found = study()
    (folder / "paper").mkdir(parents=True, exist_ok=True)
    for name, draw in FIGURES.items():
        (folder / "paper" / name).write_text(draw(found), encoding="utf-8")
    (folder / "paper.md").write_text(page(found), encoding="utf-8")


if __name__ == "__main__":
    main()
