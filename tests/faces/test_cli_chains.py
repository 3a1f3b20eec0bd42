"""--base, --tip and --lock-others: the same chain of a URDF that is a tree, wherever a model is named."""

from __future__ import annotations

import inspect
import tomllib
from pathlib import Path

import pytest

from symdyn.compiler import load_robot
from symdyn.faces import cli
from symdyn.spec.urdf_chain import Chain
from tests.spec.urdfs import tree

from .command_line import FRICTION, PENDULUM, dry_friction, run, write_pair

OPTIONS = ("--base", "torso", "--tip", "finger_1", "--lock-others")
CHAIN = Chain("torso", "finger_1", True)
JOINTS = ["left_shoulder", "grip_1"]
BODY = '<inertial>{}<mass value="2"/><inertia ixx="0.04" ixy="0" ixz="0" iyy="0.04" iyz="0" izz="0.01"/></inertial>'
ROD = f"""<robot name="rod and flap">
  <link name="wall"/>
  <link name="rod">{BODY.format('<origin xyz="0 0 -0.25"/>')}</link>
  <link name="flap">{BODY.format("")}</link>
  <joint name="pivot" type="continuous"><parent link="wall"/><child link="rod"/><axis xyz="0 1 0"/></joint>
  <joint name="hinge" type="continuous"><parent link="wall"/><child link="flap"/><axis xyz="0 1 0"/></joint>
</robot>
"""
MAP = f"[recording]\n{PENDULUM.partition('[recording]')[2]}"


@pytest.fixture
def urdf(tmp_path: Path) -> Path:
    """A torso with two arms, and a gripper on one of them."""
    path = tmp_path / "tree.urdf"
    path.write_text(tree(), encoding="utf-8")
    return path


@pytest.fixture
def rod(tmp_path: Path) -> Path:
    path = tmp_path / "rod.urdf"
    path.write_text(ROD, encoding="utf-8")
    (tmp_path / "map.toml").write_text(MAP, encoding="utf-8")
    return path


def test_every_command_that_takes_a_model_takes_a_chain() -> None:
    taking = 0
    for info in (i for i in cli.app.registered_commands if not i.hidden):
        assert info.callback is not None
        parameters = inspect.signature(info.callback, eval_str=True).parameters
        if {"model", "models"} & parameters.keys():
            taking += 1
            for name, declared in (("base", cli.Base), ("tip", cli.Tip), ("lock_others", cli.Lock)):
                assert parameters[name].annotation == declared, info.callback.__name__
    assert taking == 17


@pytest.mark.parametrize(
    "command",
    [
        ("check",),
        ("derive",),
        ("base-parameters",),
        ("variants", "--states", "2"),
        ("latex",),
        ("convert",),
        pytest.param(("simulate", "--duration", "0.002"), marks=pytest.mark.slow),
        ("frequency",),
    ],
    ids=" ".join,
)
def test_the_chain_is_chosen_for_a_command(command: tuple[str, ...], urdf: Path) -> None:
    refused = run(*command, urdf)
    assert (refused.code, refused.out) == (3, "")
    assert "SD412" in refused.err
    assert "--tip" in refused.err
    done = run(*command, urdf, *OPTIONS)
    assert done.code == 0
    assert "right_shoulder" not in done.out
    assert "lift" not in done.out
    assert all(joint in done.out.replace("\\", "") for joint in JOINTS)


def test_generate_makes_the_kernel_of_the_chain(urdf: Path, tmp_path: Path) -> None:
    done = run("generate", urdf, *OPTIONS, "--target", "c", "--out", tmp_path / "out")
    assert done.code == 0
    header = (tmp_path / "out" / "tree" / "tree.h").read_text(encoding="utf-8")
    assert f"tree_n_coordinates = {len(JOINTS)}," in header


def test_a_chain_is_of_a_urdf(tmp_path: Path) -> None:
    for command in (("derive", "two-link"), ("generate", "--all", "--out", tmp_path)):
        done = run(*command, "--tip", "hand")
        assert done.code == 3
        assert "SD415: base, tip and lock_others choose from the tree of a URDF" in done.err
    listed = run("check", "--tip", "hand")
    assert (listed.code, listed.out) == (2, "")
    assert "SD010" in listed.err
    assert not list(tmp_path.iterdir())


def test_identify_fits_the_chain(rod: Path, tmp_path: Path) -> None:
    recording, _ = write_pair(tmp_path, dry_friction)
    given = ("identify", rod, recording, "--map", tmp_path / "map.toml", "--json")
    assert run(*given).code == 3
    done = run(*given, "--tip", "rod")
    assert done.code == 0
    assert done.json()["parameters"]["pivot_mass"]["value"] == pytest.approx(2, rel=0.01)


@pytest.mark.slow
def test_diagnose_writes_into_the_urdf_that_branches(rod: Path, tmp_path: Path) -> None:
    training, judge = write_pair(tmp_path, dry_friction)
    found = tmp_path / "found.urdf"
    given = ("--holdout", judge, "--map", tmp_path / "map.toml", "--model-out", found, "--json")
    done = run("diagnose", rod, training, *given, "--tip", "rod")
    assert done.code == 0
    assert [f["effect"] for f in done.json()["findings"]] == ["coulomb_friction"]
    (effect,) = load_robot(found, Chain(tip="rod")).effects
    assert (effect.type, effect.at) == ("coulomb_friction", "pivot")
    text = found.read_text(encoding="utf-8")
    assert '<link name="flap">' + BODY.format("") in text
    level = float(text.partition('friction="')[2].partition('"')[0])
    assert level == pytest.approx(FRICTION, rel=0.05)


def test_the_toml_of_the_chain_is_the_chain(urdf: Path, tmp_path: Path) -> None:
    written = tmp_path / "arm.toml"
    assert run("convert", urdf, *OPTIONS, "--out", written).code == 0
    again, given = load_robot(written), load_robot(urdf, CHAIN)
    assert [j.name for j in again.joints] == [j.name for j in given.joints] == JOINTS
    assert [j["name"] for j in tomllib.loads(given.text)["joint"]] == JOINTS
