"""The blind benchmark: plants the tool cannot see, questions, scores.

python -m benchmarks.blind [--machines two-link,..] [--level middle] [--cases 'PATTERN'] [--skip N] [--first N]

Records stand one per case in the output folder; a run that was stopped goes on where it was. Cases come in an order
drawn by lot, so that those done so far are a fair sample.
"""

from __future__ import annotations

import argparse
import shlex
import sys
from collections.abc import Sequence
from fnmatch import fnmatchcase
from pathlib import Path

from benchmarks.blind.cases import GROUPS, MACHINES, Case, all_cases
from benchmarks.blind.report import PLOT, SCORES, write_report
from benchmarks.blind.run import Setting, kept, run_all
from benchmarks.blind.sensors import LEVELS
from benchmarks.blind.summary import joined, read_scores, scored
from benchmarks.blind.tool import DIAGNOSE
from symdyn.numeric.executor import Executor

HEADER = """# Blind benchmark: results

Written by `python -m benchmarks.blind --report-only --write {}`; edits are lost. What is counted,
and how, stands in [blind.md](blind.md).

"""


def main(arguments: Sequence[str] | None = None) -> None:
    options = _options().parse_args(arguments)
    cases = chosen(options.machines, options.level, options.groups, options.cases, options.draw)
    cases = cases[options.skip :][: options.first]
    if options.list:
        print("\n".join(case.id for case in cases))
        return
    command = tuple(shlex.split(options.tool)) if options.tool else DIAGNOSE
    setting, store = Setting(command, not options.no_oracle, options.limit), options.out / "cases"
    if not options.report_only:
        executor = Executor(options.jobs, options.scheduler, store)
        run_all(cases, setting, executor, lambda text: print(text, file=sys.stderr, flush=True))
    earlier = read_scores(options.add.read_text(encoding="utf-8")) if options.add else []
    text = write_report(joined(earlier, scored(kept(cases, setting, store))), options.out, command)
    if options.write is not None:
        page = HEADER.format(options.write) + text.replace(f"({PLOT})", f"({options.write.stem}.svg)")
        options.write.write_text(page, encoding="utf-8")
        for suffix, name in ((".svg", PLOT), (".json", SCORES)):
            options.write.with_suffix(suffix).write_bytes((options.out / name).read_bytes())
    print(text)


def chosen(
    machines: Sequence[str], levels: Sequence[str], groups: Sequence[str], patterns: Sequence[str], draw: int = 0
) -> list[Case]:
    """The cases of a draw, of the machines, levels and groups, whose id fits one of the patterns; none given: all."""
    return [
        case
        for case in all_cases(draw)
        if (not machines or case.machine in machines)
        and (not levels or case.level in levels)
        and (not groups or case.group in groups)
        and (not patterns or any(fnmatchcase(case.id, pattern) for pattern in patterns))
    ]


def _options() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.blind", description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("out/blind"), metavar="FOLDER", help="default: out/blind")
    parser.add_argument("--machines", type=_one_of(MACHINES), default=[], metavar="A,B", help=", ".join(MACHINES))
    parser.add_argument("--level", type=_one_of(LEVELS), default=[], metavar="A,B", help="noise: " + ", ".join(LEVELS))
    parser.add_argument("--groups", type=_one_of(GROUPS), default=[], metavar="A,B", help=", ".join(GROUPS))
    parser.add_argument("--cases", action="append", default=[], metavar="PATTERN", help="ids, with * for anything")
    parser.add_argument(
        "--draw", type=_count, default=0, metavar="N", help="other cases, as many of every sort: 1, 2, ... (0)"
    )
    parser.add_argument("--skip", type=int, default=0, metavar="N", help="leave out the first N of them")
    parser.add_argument("--first", type=int, metavar="N", help="no more than N of the rest: a fair sample")
    parser.add_argument(
        "--jobs", type=int, default=0, metavar="N", help="cases at a time; 0, the default: one per core"
    )
    parser.add_argument("--scheduler", metavar="tcp://HOST:PORT", help="a dask cluster that does the work instead")
    parser.add_argument("--limit", type=float, default=900.0, metavar="S", help="time for one answer in s (900)")
    parser.add_argument(
        "--tool", metavar="COMMAND", help="another tool, with {model} {training} {heldout} in its command"
    )
    parser.add_argument("--no-oracle", action="store_true", help="do not fit the true structure for comparison")
    parser.add_argument("--list", action="store_true", help="only list the ids")
    parser.add_argument("--report-only", action="store_true", help="only write the tables of the records there are")
    parser.add_argument(
        "--write", type=Path, metavar="FILE.md", help="also write the tables there, scores and plot beside it"
    )
    parser.add_argument("--add", type=Path, metavar="FILE.json", help="scores of other runs, to be counted along")
    return parser


def _count(text: str) -> int:
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"'{text}' is no whole number from 0 on")
    return int(text)


def _one_of(allowed: Sequence[str]) -> object:
    def read(text: str) -> list[str]:
        words = text.split(",")
        if unknown := [word for word in words if word not in allowed]:
            raise argparse.ArgumentTypeError(f"no such: {', '.join(unknown)}; there are {', '.join(allowed)}")
        return words

    return read


if __name__ == "__main__":
    main()
