"""Templates: substitution only, and filled with exactly the names that they hold."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from markupsafe import Markup

from symdyn.emit import templates

FOLDER = templates.template_folder()
NAMES = sorted(path.relative_to(FOLDER).as_posix() for path in FOLDER.rglob("*") if path.is_file())


def _placeholders(name: str) -> set[str]:
    return set(re.findall(r"<<\s*(\w+)\s*>>", templates.source(name)))


@pytest.fixture
def own_template(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder of templates of the test's own."""
    templates._environment.cache_clear()
    monkeypatch.setattr(templates, "template_folder", lambda: tmp_path)
    yield tmp_path
    templates._environment.cache_clear()


def test_the_templates_of_kernel_and_latex_are_there() -> None:
    assert {"numba/kernel.py.j2", "numba/function.py.j2", "latex/equations.tex.j2"} <= set(NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_holds_nothing_but_substitutions(name: str) -> None:
    text = templates.source(name)
    assert _placeholders(name)
    rest = re.sub(r"<<\s*\w+\s*>>", "", text)
    assert not re.search(r"<<|>>|<%|%>|<#|#>", rest)


@pytest.mark.parametrize("name", NAMES)
def test_is_filled_by_its_own_names(name: str) -> None:
    data = {placeholder: f"value-of-{placeholder}" for placeholder in _placeholders(name)}
    text = templates.render(name, data)
    assert all(value in text for value in data.values())
    assert "<<" not in text


@pytest.mark.parametrize("name", NAMES)
def test_missing_data_is_refused(name: str) -> None:
    complete = dict.fromkeys(_placeholders(name), "x")
    for left_out in complete:
        data = {key: value for key, value in complete.items() if key != left_out}
        with pytest.raises(ValueError, match=rf"names without data \['{left_out}'\]"):
            templates.render(name, data)


@pytest.mark.parametrize("name", NAMES)
def test_surplus_data_is_refused(name: str) -> None:
    data = dict.fromkeys(_placeholders(name) | {"shown_by_nobody"}, "x")
    with pytest.raises(ValueError, match=r"data without names \['shown_by_nobody'\]"):
        templates.render(name, data)


@pytest.mark.parametrize(
    "text",
    [
        "<% if a %>x<% endif %>",
        "<% for b in a %>x<% endfor %>",
        "<% set b = a %>",
        '<% include "other" %>',
        "<< a + 1 >>",
        "<< a | upper >>",
        "<< a.b >>",
        "<< a['b'] >>",
        "<< a() >>",
        "<< 1 >>",
    ],
)
def test_logic_is_refused(own_template: Path, text: str) -> None:
    (own_template / "bad.txt.j2").write_text(text)
    with pytest.raises(ValueError, match="holds logic"):
        templates.render("bad.txt.j2", {"a": "x"})


def test_html_is_escaped_and_code_is_not(own_template: Path) -> None:
    for name in ("page.html.j2", "code.py.j2"):
        (own_template / name).write_text("<< a >> << b >>\n")
    data = {"a": "<b>&", "b": Markup("<i>")}
    assert templates.render("page.html.j2", data) == "&lt;b&gt;&amp; <i>\n"
    assert templates.render("code.py.j2", data) == "<b>& <i>\n"


def test_digest_follows_the_text(own_template: Path) -> None:
    path = own_template / "a.txt.j2"
    path.write_text("<< a >>")
    before = templates.digest("a.txt.j2")
    path.write_text("<< b >>")
    assert templates.digest("a.txt.j2") != before
