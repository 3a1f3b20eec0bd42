"""The same robot gives the same bytes: in any process, under any hash seed, today and when it was committed."""

from __future__ import annotations

import hashlib
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

GENERATED = Path(__file__).parents[2] / "generated"
MACHINES = ("irb6-axis1", "two-link")
SEEDS = ("0", "20260")

WRITE = """
import sys
from pathlib import Path
from symdyn.compiler import generate, load_robot
for name in sys.argv[2:]:
    generate(load_robot(name), Path(sys.argv[1]) / name.replace("-", "_"))
"""

Files = dict[str, bytes]


def contents(folder: Path) -> Files:
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """A folder per hash seed, each written by a process of its own."""
    folders = {seed: tmp_path_factory.mktemp("generated") for seed in SEEDS}
    processes = [
        subprocess.Popen(
            [sys.executable, "-c", WRITE, str(folder), *MACHINES],
            env={**os.environ, "PYTHONHASHSEED": seed, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
            stderr=subprocess.PIPE,
            text=True,
        )
        for seed, folder in folders.items()
    ]
    for process in processes:
        _, errors = process.communicate()
        assert process.returncode == 0, errors
    return folders


@pytest.mark.parametrize("machine", MACHINES)
def test_hash_seeds_do_not_reach_the_files(machine: str, written: dict[str, Path]) -> None:
    first, second = (contents(written[seed] / machine.replace("-", "_")) for seed in SEEDS)
    assert set(first) == {"kernel.py", "equations.tex", "manifest.json"}
    assert first == second


@pytest.mark.parametrize("machine", MACHINES)
def test_committed_files_are_those_of_today(machine: str, written: dict[str, Path]) -> None:
    folder = machine.replace("-", "_")
    fresh, committed = contents(written[SEEDS[0]] / folder), contents(GENERATED / folder)
    stale = [name for name in fresh if committed.get(name) != fresh[name]]
    assert not stale, "write them anew with: make generate"
    assert set(committed) == set(fresh)


@pytest.mark.parametrize("machine", MACHINES)
def test_the_manifest_tells_what_went_in_and_out(machine: str, written: dict[str, Path]) -> None:
    folder = written[SEEDS[0]] / machine.replace("-", "_")
    manifest = json.loads((folder / "manifest.json").read_text(encoding="utf-8"))
    for name in ("kernel.py", "equations.tex"):
        assert manifest["files_sha256"][name] == hashlib.sha256((folder / name).read_bytes()).hexdigest()
    source = Path(__file__).parents[2] / "symdyn" / "machines" / f"{machine}.toml"
    assert manifest["model_sha256"] == hashlib.sha256(source.read_bytes()).hexdigest()
    assert manifest["robot"] == machine
    text = (folder / "kernel.py").read_text(encoding="utf-8")
    assert {f"def {name}(" in text for name in manifest["costs"]} == {True}
    assert not any(str(folder) in (folder / name).read_text(encoding="utf-8") for name in contents(folder))
