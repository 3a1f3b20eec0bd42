"""Fails unless the files of a folder are, byte by byte, what ``symdyn generate --all`` writes today.

python scripts/check_generated.py generated
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path

COMMAND = "from symdyn.faces.cli import main; main()"


def main(folder: Path) -> int:
    if not folder.is_dir():
        print(f"no folder {folder}; write it with: make generate", file=sys.stderr)
        return 1
    with tempfile.TemporaryDirectory() as temporary:
        fresh = Path(temporary) / "generated"
        # Another hash seed than a user's run has: the order of sets must not reach the files.
        environment = {**os.environ, "PYTHONHASHSEED": "20260"}
        command = [sys.executable, "-c", COMMAND, "generate", "--all", "--out", str(fresh)]
        subprocess.run(command, env=environment, check=True)
        old, new = contents(folder), contents(fresh)
    if not new:
        print("symdyn generate --all wrote nothing", file=sys.stderr)
        return 1
    differing = sorted(name for name in old.keys() | new.keys() if old.get(name) != new.get(name))
    for name in differing:
        what = "is missing" if name not in old else "is left over" if name not in new else "differs"
        print(f"{folder / name} {what}", file=sys.stderr)
    if differing:
        print("look at the change, then write them anew with: make generate", file=sys.stderr)
        return 1
    print(f"{len(new)} generated files are up to date")
    return 0


def contents(folder: Path) -> dict[str, bytes]:
    """Every file by its path in the folder; what Python and Numba cache beside them does not count."""
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and "__pycache__" not in path.parts
    }


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
