"""symdyn profile: intervals, a figure, and what the recording does not tell."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import pytest

from .command_line import FRICTION, INERTIA, PENDULUM, dry_friction, run, write_pair


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    folder = tmp_path_factory.mktemp("profile")
    friction = "".join(
        f'[[effect]]\ntype = "{name}"\nat = "pivot"\n{parameter} = "{value}"\n\n'
        for name, parameter, value in (
            ("viscous_friction", "coefficient", "0.1 N m s/rad"),
            ("coulomb_friction", "level", "0.1 N m"),
        )
    )
    text = PENDULUM.replace("[recording]\n", f"{friction}[recording]\n", 1)
    (folder / "rod.toml").write_text(text, encoding="utf-8")
    return folder / "rod.toml", write_pair(folder, dry_friction, count=1500)[0]


@pytest.mark.slow
def test_profile_tells_what_is_not_identified(files: tuple[Path, Path], tmp_path: Path) -> None:
    """m c and J + m c^2 are told, with the mass's own place: J is at most all of the inertia."""
    figure = tmp_path / "profile.svg"
    arguments = ("profile", *files, "-p", "J", "--resume", tmp_path / "store")
    done = run(*arguments, "--plot", figure)
    assert done.code == 1
    assert "practically not identified" in " ".join(done.out.split())
    assert ElementTree.parse(figure).getroot().tag.endswith("svg")
    (one,) = run(*arguments, "--json").json()["profiles"]
    assert one["interval"][0] is None
    assert one["interval"][1] == pytest.approx(INERTIA, rel=0.02)


def test_number_of_processes_changes_nothing(files: tuple[Path, Path], tmp_path: Path) -> None:
    names = ("-p", "pivot_coulomb_friction_level", "-p", "pivot_viscous_friction_coefficient")
    one = run("profile", *files, *names, "--json")
    two = run("profile", *files, *names, "--json", "-j", "2", "--resume", tmp_path)
    assert one.json() == two.json()
    level = one.json()["profiles"][0]
    assert level["interval"][0] < FRICTION < level["interval"][1]
    assert len(list(tmp_path.iterdir())) == 2


def test_bad_requests_are_refused(files: tuple[Path, Path]) -> None:
    done = run("profile", *files, "-p", "K")
    assert (done.code, "SD305" in done.err) == (2, True)
    assert run("profile", *files, "--band", "0").code == 2
    assert run("profile", *files, "-j", "-1").code == 2
