"""Writes the page of cost tables from the manifests of generated robots.

python scripts/cost_tables.py generated docs/costs.md
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

COUNTS = ("multiplications", "additions", "divisions", "trigonometric")
HEAD = ("multiplications", "additions", "divisions", "sin, cos, tan", "lines")
FOLLOWED = "inverse_dynamics"  # the function whose passes are shown one by one
INTRODUCTION = """\
# What the generated functions cost

Written by `make docs` from the manifests in [generated/](../generated); edits are lost. Operations of one call with the
parameters folded in; with the vector `p` (`NAME_p`) in brackets. A change of sign counts as an addition. Lines are all
operations, those of the columns and the rest (`sqrt`, `tanh`, `sign`, ...): a line of the program each. What the
functions give is in [kernels.md](kernels.md), what they take in nanoseconds in [speed.md](speed.md).
"""
PASSES = """\
## Inverse dynamics, pass by pass

With the parameters folded in, after each pass. Passes go round until a whole round earns nothing.
"""


def page(folder: Path) -> str:
    """The text of the page for a folder of generated robots."""
    manifests = [json.loads(path.read_text(encoding="utf-8")) for path in sorted(folder.glob("*/manifest.json"))]
    parts = [INTRODUCTION]
    parts += [f"## {m['robot']}\n\n{_table(('function', *HEAD), _functions(m))}" for m in manifests]
    parts.append(PASSES)
    parts += [
        f"### {m['robot']}, inverse dynamics\n\n{_table(('pass', 'round', *HEAD), _passes(m))}" for m in manifests
    ]
    return "\n".join(parts)


def _functions(manifest: Mapping[str, Any]) -> Iterator[Sequence[str]]:
    costs = manifest["costs"]
    for name in costs:
        if name.endswith("_p"):
            continue
        folded, general = (_cells(manifest, costs[form][-1]) for form in (name, f"{name}_p"))
        yield (f"`{name}`", *(f"{a} ({b})" for a, b in zip(folded, general, strict=True)))


def _passes(manifest: Mapping[str, Any]) -> Iterator[Sequence[str]]:
    for row in manifest["costs"][FOLLOWED]:
        known = dict(zip(manifest["cost_columns"], row, strict=True))
        yield (str(known["pass_name"]).replace("_", " "), str(known["round"]), *map(str, _cells(manifest, row)))


def _cells(manifest: Mapping[str, Any], row: Sequence[int | str]) -> list[int]:
    known = dict(zip(manifest["cost_columns"], row, strict=True))
    counts = [int(known[name]) for name in COUNTS]
    return [*counts, sum(counts) + int(known["other"])]


def _table(head: Sequence[str], rows: Iterator[Sequence[str]]) -> str:
    words = next(k for k, title in enumerate(head) if title == HEAD[0])
    rule = ["---"] * words + ["---:"] * (len(head) - words)
    return "".join(f"| {' | '.join(row)} |\n" for row in (head, rule, *rows))


def main(folder: Path, target: Path) -> int:
    if not any(folder.glob("*/manifest.json")):
        print(f"no manifests in {folder}; write them with: make generate", file=sys.stderr)
        return 1
    target.write_text(page(folder), encoding="utf-8")
    print(f"written: {target}")
    return 0


if __name__ == "__main__":
    sys.exit(main(*map(Path, sys.argv[1:])))
