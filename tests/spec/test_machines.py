"""Where a model is looked for: files first, then the machines that ship with the package."""

from __future__ import annotations

from pathlib import Path

import pytest

from symdyn.base.errors import InputError
from symdyn.spec.machines import FOLDER, machine_file


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_a_folder_does_not_hide_the_machine_of_its_name(here: Path) -> None:
    (here / "puma560").mkdir()
    assert machine_file("puma560") == FOLDER / "puma560.toml"


def test_a_file_does(here: Path) -> None:
    (here / "puma560").write_text("", encoding="utf-8")
    assert machine_file("puma560") == Path("puma560")


def test_what_is_written_as_a_path_is_one(here: Path) -> None:
    (here / "panda").mkdir()
    assert machine_file("./panda/panda") == Path("panda/panda")
    assert machine_file("panda.toml") == Path("panda.toml")


def test_another_folder_is_told_as_one_and_another_name_as_unknown(here: Path) -> None:
    (here / "arms").mkdir()
    assert machine_file("arms") == Path("arms")
    with pytest.raises(InputError, match="SD003: no file and no bundled machine is called 'legs'"):
        machine_file("legs")
