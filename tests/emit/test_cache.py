"""The private cache of kernels: keyed by content, the user's alone, and not to be fooled by altered files."""

from __future__ import annotations

import os
import shutil
import stat
import subprocess
import sys
from collections.abc import Callable
from importlib.machinery import SourceFileLoader
from pathlib import Path

import numpy as np
import platformdirs
import pytest

from symdyn.compiler import Compiled
from symdyn.emit.kernel import cache_root, load_source

SOURCE = 'ROBOT = "one"\nVALUE = 1\n'


@pytest.fixture
def root(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "kernels"
    monkeypatch.setenv("SYMDYN_CACHE", str(folder))
    return folder


def mode(path: Path) -> int:
    return stat.S_IMODE(path.stat().st_mode)


def only(root: Path) -> Path:
    (folder,) = root.iterdir()
    return folder


def test_the_same_source_is_kept_once_and_another_apart(root: Path) -> None:
    first, second = load_source(SOURCE), load_source(SOURCE)
    assert first.module.__file__ == second.module.__file__ == str(only(root) / "kernel.py")
    other = load_source(SOURCE.replace("1", "2"))
    assert len(list(root.iterdir())) == 2
    assert (first.module.VALUE, other.module.VALUE) == (1, 2)


def test_a_kernel_is_parsed_once(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Even where Python is told to write no bytecode, as in many containers; what is altered is parsed again."""
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    load_source(SOURCE)
    parsed: list[str] = []
    with monkeypatch.context() as watched:
        watched.setattr(SourceFileLoader, "source_to_code", lambda _, data, path: parsed.append(path))
        assert load_source(SOURCE).module.VALUE == 1
    assert parsed == []
    (only(root) / "kernel.py").write_text(SOURCE.replace("1", "2"), encoding="utf-8")
    assert load_source(SOURCE).module.VALUE == 1


COMPILED = """
from numba import njit

@njit(cache=True)
def twice(x):
    return 2.0 * x
"""
USE = """
import sys
from symdyn.emit.kernel import load_source
module = load_source(sys.stdin.read()).module
assert module.twice(3.0) == 6.0
print(sum(module.twice.stats.cache_hits.values()))
"""


def test_a_copied_cache_serves(root: Path, tmp_path: Path) -> None:
    """Numba stores the name of a module in what it compiled: no path may be in it."""

    def hits(folder: Path) -> int:
        environment = {**os.environ, "SYMDYN_CACHE": str(folder)}
        run = [sys.executable, "-c", USE]
        done = subprocess.run(run, input=COMPILED, env=environment, text=True, capture_output=True, check=True)
        return int(done.stdout)

    assert (hits(root), hits(root)) == (0, 1)
    copy = tmp_path / "moved"
    shutil.copytree(root, copy)
    assert hits(copy) == 1


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="owners and modes are those of POSIX")
class TestPrivacy:
    def test_folders_are_the_users_alone(self, root: Path) -> None:
        previous = os.umask(0o002)
        try:
            load_source(SOURCE)
        finally:
            os.umask(previous)
        assert mode(root) == 0o700
        assert mode(only(root)) == 0o700

    @pytest.mark.parametrize("writable", [0o777, 0o770, 0o702, 0o1777])
    def test_a_root_that_others_can_write_to_is_refused(self, root: Path, writable: int) -> None:
        root.mkdir()
        root.chmod(writable)
        with pytest.raises(PermissionError, match="can be written by others; name a private folder with SYMDYN_CACHE"):
            load_source(SOURCE)
        assert list(root.iterdir()) == []

    def test_a_root_of_somebody_else_is_refused(self, root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        load_source(SOURCE)
        owner = root.stat().st_uid
        monkeypatch.setattr(os, "getuid", lambda: owner + 1)
        with pytest.raises(PermissionError):
            load_source(SOURCE)

    def test_a_root_that_others_can_read_is_fine(self, root: Path) -> None:
        root.mkdir(mode=0o755)
        assert load_source(SOURCE).module.VALUE == 1


@pytest.mark.parametrize(
    "altered", [b"", SOURCE.replace("1", "6").encode(), SOURCE.encode()[:-3], b"\xff\x00", b"raise SystemExit"]
)
def test_an_altered_file_is_never_run(root: Path, altered: bytes) -> None:
    load_source(SOURCE)
    path = only(root) / "kernel.py"
    path.write_bytes(altered)
    planted = path.parent / "__pycache__" / "kernel.something.nbc"
    planted.parent.mkdir(exist_ok=True)
    planted.write_bytes(b"compiled from it")
    assert load_source(SOURCE).module.VALUE == 1
    assert path.read_bytes() == SOURCE.encode()
    assert not planted.exists()


def test_what_numba_compiled_is_used_again(root: Path, compiled: Callable[[str], Compiled]) -> None:
    text = compiled("emps").source
    hits = []
    for _ in range(2):
        kernel = load_source(text)
        assert kernel.gravity(np.zeros(1)).tolist() == [0.0]
        hits.append(sum(kernel.gravity.stats.cache_hits.values()))  # type: ignore[attr-defined]  # Numba's
    assert hits == [0, 1]
    compiled_files = list(root.rglob("*.nbi"))
    assert compiled_files
    assert all(only(root) in path.parents for path in compiled_files)


def test_kernels_live_in_the_users_cache_folder(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("SYMDYN_CACHE")
    assert cache_root() == Path(platformdirs.user_cache_dir("symdyn")) / "kernels"
    assert cache_root().is_absolute()
    assert Path.cwd() not in cache_root().parents
