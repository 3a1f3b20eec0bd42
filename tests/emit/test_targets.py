"""Targets are found, chosen by name, and listed in the manifest with the hash of what they wrote."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from types import MappingProxyType

import pytest
from typer.testing import CliRunner

from symdyn import compiler
from symdyn.base.errors import UsageError
from symdyn.compiler import generate, load_robot
from symdyn.emit import targets
from symdyn.emit.target import Target
from symdyn.emit.templates import digest
from symdyn.faces.cli import app

ALWAYS = {"equations.tex", "manifest.json"}


def manifest(folder: Path) -> dict[str, dict[str, str]]:
    facts: dict[str, dict[str, str]] = json.loads((folder / "manifest.json").read_text(encoding="utf-8"))
    return facts


def test_the_bundled_targets_are_found_by_their_names() -> None:
    assert list(targets.targets()) == ["c", "numba"]
    assert targets.DEFAULT_TARGET in targets.targets()
    for name, target in targets.targets().items():
        assert target.name == name
        assert target.title
        assert digest(*target.templates)


def test_an_unknown_target_is_refused_before_anything_is_written(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"SD012: no target `numbas`\n *did you mean `numba`\?"):
        generate(load_robot("two-link"), tmp_path, ["c", "numbas"])
    with pytest.raises(UsageError, match=r"no target `fortran`\n *targets: c, numba"):
        generate(load_robot("two-link"), tmp_path, ["fortran"])
    assert not list(tmp_path.iterdir())


def test_targets_are_chosen_on_the_command_line(tmp_path: Path) -> None:
    command = ["generate", "two-link", "--target", "numba", "--target", "c", "--target", "c", "--json", "-o"]
    done = CliRunner().invoke(app, [*command, str(tmp_path)])
    assert done.exit_code == 0
    folder = tmp_path / "two_link"
    names = {path.name for path in folder.iterdir()}
    assert names == {"kernel.py", "two_link.h", "two_link.c"} | ALWAYS
    assert {Path(path).name for path in json.loads(done.stdout)["two-link"]} == names
    hashes = manifest(folder)["files_sha256"]
    assert hashes == {name: hashlib.sha256((folder / name).read_bytes()).hexdigest() for name in hashes}
    assert set(hashes) == names - {"manifest.json"}


def test_numba_is_what_one_gets_without_asking(tmp_path: Path) -> None:
    for name, chosen in (("default", ()), ("numba", ("--target", "numba")), ("c", ("--target", "c"))):
        assert CliRunner().invoke(app, ["generate", "emps", *chosen, "-o", str(tmp_path / name)]).exit_code == 0
    written = {
        name: {path.name: path.read_bytes() for path in (tmp_path / name / "emps").iterdir()}
        for name in ("default", "numba", "c")
    }
    assert written["default"] == written["numba"]
    assert set(written["default"]) == {"kernel.py"} | ALWAYS
    assert set(written["c"]) == {"emps.h", "emps.c"} | ALWAYS
    own = [manifest(tmp_path / name / "emps") for name in ("numba", "c")]
    assert own[0]["templates_sha256"] != own[1]["templates_sha256"]
    assert own[0]["costs"] == own[1]["costs"]  # they are of the programs, whatever prints them


def test_two_targets_may_not_write_one_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    toys = {name: Target(name, "a toy", lambda _, __: {"same.txt": ""}) for name in ("one", "two")}
    toys["three"] = Target("three", "a toy", lambda _, __: {compiler.MANIFEST: ""})
    monkeypatch.setattr(compiler, "target", MappingProxyType(toys).__getitem__)
    for chosen, name in ((["one", "two"], "same.txt"), (["three"], "manifest.json")):
        with pytest.raises(ValueError, match=rf"target (two|three) writes {name}, and is not the only one"):
            generate(load_robot("two-link"), tmp_path, chosen)
    assert not list(tmp_path.iterdir())
