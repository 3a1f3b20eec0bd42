"""docs/costs.md is what its script writes from the manifests in generated/, and those numbers are the programs' own."""

from __future__ import annotations

import importlib.util
import re
from pathlib import Path
from types import ModuleType

import pytest

from symdyn.compiler import compile_robot, load_robot
from symdyn.spec.machines import machine_names

CHECKOUT = Path(__file__).parent.parent
PAGE = CHECKOUT / "docs" / "costs.md"


@pytest.fixture(scope="module")
def script() -> ModuleType:
    spec = importlib.util.spec_from_file_location("cost_tables", CHECKOUT / "scripts" / "cost_tables.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_page_is_current(script: ModuleType) -> None:
    assert PAGE.read_text(encoding="utf-8") == script.page(CHECKOUT / "generated"), "write it anew with: make docs"


def test_every_bundled_machine_has_its_tables() -> None:
    headings = re.findall(r"^##+ (.+)$", PAGE.read_text(encoding="utf-8"), re.MULTILINE)
    names = list(machine_names())
    assert sorted(headings[: len(names)]) == names
    assert sorted(headings[len(names) + 1 :]) == [f"{name}, inverse dynamics" for name in names]


def test_the_numbers_are_those_of_the_programs(script: ModuleType, tmp_path: Path) -> None:
    forms = {form.name: form.costs[-1].cost for form in compile_robot(load_robot("two-link")).forms}
    section = PAGE.read_text(encoding="utf-8").partition("## two-link\n")[2].partition("\n## ")[0]
    rows = re.findall(r"^\| `(\w+)` \| (.+) \|$", section, re.MULTILINE)
    assert {name for name, _ in rows} == {name for name in forms if not name.endswith("_p")}
    for name, cells in rows:
        both = [forms[name], forms[f"{name}_p"]]
        counts = [
            tuple(getattr(cost, kind) for cost in both)
            for kind in ("multiplications", "additions", "divisions", "trigonometric", "lines")
        ]
        assert cells.split(" | ") == [f"{folded} ({general})" for folded, general in counts]


def test_without_manifests_nothing_is_written(
    script: ModuleType, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert script.main(tmp_path, tmp_path / "costs.md") == 1
    assert "make generate" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())
