"""Templates: strict, free of logic, and checked against their data in both directions."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from functools import cache, lru_cache
from pathlib import Path

import jinja2
from jinja2 import meta, nodes

PACKAGED = Path(__file__).parent.parent / "templates"  # in a wheel
CHECKOUT = Path(__file__).parent.parent.parent / "templates"  # in a checkout or an editable install

# Substitution only: anything else in a template would be logic that no test of the program layer sees.
ALLOWED = (nodes.Template, nodes.Output, nodes.TemplateData, nodes.Name)


def template_folder() -> Path:
    return PACKAGED if PACKAGED.is_dir() else CHECKOUT


@cache
def _environment(autoescape: bool) -> jinja2.Environment:
    return jinja2.Environment(
        loader=jinja2.FileSystemLoader(template_folder()),
        undefined=jinja2.StrictUndefined,
        autoescape=autoescape,
        keep_trailing_newline=True,
        # LaTeX and Python braces and percent signs stay themselves.
        variable_start_string="<<",
        variable_end_string=">>",
        block_start_string="<%",
        block_end_string="%>",
        comment_start_string="<#",
        comment_end_string="#>",
    )


def source(name: str) -> str:
    """The text of a template."""
    return (template_folder() / name).read_text(encoding="utf-8")


def digest(*names: str) -> str:
    """SHA-256 over the texts of templates, for manifests and cache keys."""
    total = hashlib.sha256()
    for name in names:
        total.update(source(name).encode())
    return total.hexdigest()


def render(name: str, data: Mapping[str, object]) -> str:
    """Fill a template.

    HTML templates escape their data (markup is passed as ``markupsafe.Markup``).

    Raises ValueError if the template holds anything but substitutions, or if its names and those of
    the data differ: a value that nobody shows is as much a mistake as a name that nobody fills.
    """
    wanted, given = _names(name, source(name)), set(data)
    if wanted != given:
        raise ValueError(
            f"template {name}: names without data {sorted(wanted - given)}, data without names {sorted(given - wanted)}"
        )
    return _environment(".html" in name).get_template(name).render(**data)


@lru_cache(maxsize=32)  # a kernel fills one template for every function
def _names(name: str, text: str) -> frozenset[str]:
    """The names that a template of nothing but substitutions wants."""
    tree = _environment(".html" in name).parse(text)
    logic = sorted({type(node).__name__ for node in tree.find_all(nodes.Node)} - {kind.__name__ for kind in ALLOWED})
    if logic:
        raise ValueError(f"template {name} holds logic: {', '.join(logic)}")
    return frozenset(meta.find_undeclared_variables(tree))
