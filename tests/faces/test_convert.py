"""``symdyn convert``: a URDF as TOML, and back into the URDF."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import pytest

from symdyn.compiler import load_robot
from symdyn.faces.cli import main

BODY = '<inertial><mass value="{}"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>'
URDF = f"""<robot name="fork">
  <link name="base"/> <!-- bolted down -->
  <link name="arm">{BODY.format(2)}</link>
  <link name="finger">{BODY.format(0.5)}</link>
  <joint name="turn" type="continuous"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/></joint>
  <joint name="grip" type="prismatic"><origin xyz="1 0 0"/><parent link="arm"/><child link="finger"/></joint>
  <joint name="drop" type="prismatic"><parent link="arm"/><child link="hook"/></joint>
  <link name="hook">{BODY.format(0.25)}</link>
</robot>
"""


def run(monkeypatch: pytest.MonkeyPatch, *arguments: str) -> int:
    monkeypatch.setattr(sys, "argv", ["symdyn", *arguments])
    with pytest.raises(SystemExit) as caught:
        main()
    return int(caught.value.code or 0)


def test_there_and_back(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    urdf, toml = tmp_path / "fork.urdf", tmp_path / "fork.toml"
    urdf.write_text(URDF)
    assert run(monkeypatch, "check", str(urdf)) == 3
    assert re.search(r"fork\.urdf:7:3: SD412: .*--tip", capsys.readouterr().err, re.DOTALL)
    chain = ("--tip", "finger", "--lock-others")
    assert run(monkeypatch, "convert", str(urdf), *chain) == 0
    shown = capsys.readouterr()
    assert "locked at zero, as parts of `arm`: `drop`" in shown.err
    toml.write_text(shown.out.replace("mass = 0.5", "mass = 0.75"))
    assert load_robot(toml).joints[0].description == "moves arm with hook"
    assert run(monkeypatch, "convert", str(toml), "--into", str(urdf), *chain) == 0
    assert capsys.readouterr().out == URDF.replace('"0.5"', '"0.75"')
    assert run(monkeypatch, "convert", "two-link", "--tip", "finger") == 3
    assert "choose from the tree of a URDF" in capsys.readouterr().err
