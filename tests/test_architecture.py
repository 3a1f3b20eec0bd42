"""The layers: imports only go down, SymPy and templates stay where they belong, no text is ever run as code."""

from __future__ import annotations

import ast
import pkgutil
from collections.abc import Iterator
from pathlib import Path

import pytest

import symdyn

PACKAGE = Path(symdyn.__file__).parent
LAYERS = ("base", "spec", "physics", "derive", "program", "emit", "compiler", "numeric", "faces", "__main__")
RANK = {layer: rank for rank, layer in enumerate(LAYERS)}

RUNNING_TEXT = {"eval", "exec", "compile", "__import__"}  # as plain names; re.compile and the like are attributes
RUNNING_TEXT_METHODS = {"eval", "parse_expr", "lambdify", "read_pickle", "to_pickle"}
UNSAFE_MODULES = {"pickle", "cPickle", "marshal", "shelve", "dill", "cloudpickle"}
SYMPIFY_SEES_NO_TEXT = {"base", "physics", "derive", "program"}  # they are handed expressions and records


def _module_name(path: Path) -> str:
    parts = path.relative_to(PACKAGE.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


TREES = {_module_name(path): ast.parse(path.read_text(encoding="utf-8")) for path in sorted(PACKAGE.rglob("*.py"))}


def layer_of(module: str) -> str | None:
    """The layer of a module of the package; None for the package itself, whose one content is the version."""
    _, _, rest = module.partition(".")
    first = rest.partition(".")[0]
    return None if first in ("", "__version__") else first


def imported(tree: ast.AST) -> Iterator[str]:
    """Every module that is imported anywhere in a file, as ``module`` or ``module.name``; relative ones as ``.``."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            origin = "." * node.level + (node.module or "")
            yield from (f"{origin}.{alias.name}" for alias in node.names)


def upward_imports(module: str, tree: ast.AST) -> list[str]:
    own = layer_of(module)
    wrong = []
    for name in imported(tree):
        if name.startswith("."):
            wrong.append(f"{module}: relative import {name}")
        elif name.partition(".")[0] == "symdyn":
            other = layer_of(name)
            if other is not None and (own is None or RANK[other] > RANK[own]):
                wrong.append(f"{module} imports {name}")
    return wrong


def imports_of(tree: ast.AST, package: str) -> list[str]:
    return [name for name in imported(tree) if name.partition(".")[0] == package]


def runs_text(module: str, tree: ast.AST) -> list[str]:
    """Calls that turn text into code or objects."""
    found = [f"{module} imports {name}" for name in imported(tree) if name.partition(".")[0] in UNSAFE_MODULES]
    for node in ast.walk(tree):
        if not isinstance(node, ast.Call):
            continue
        name, is_method = "", False
        if isinstance(node.func, ast.Name):
            name = node.func.id
        elif isinstance(node.func, ast.Attribute):
            name, is_method = node.func.attr, True
        forbidden = name in RUNNING_TEXT_METHODS or (name in RUNNING_TEXT and not is_method)
        if name in ("sympify", "S"):
            is_strict = any(k.arg == "strict" and getattr(k.value, "value", None) is True for k in node.keywords)
            gets_text = any(isinstance(a, ast.JoinedStr | ast.Constant) and not _is_number(a) for a in node.args)
            forbidden = gets_text or not (is_strict or layer_of(module) in SYMPIFY_SEES_NO_TEXT)
        allows_pickle = any(k.arg == "allow_pickle" and getattr(k.value, "value", True) for k in node.keywords)
        if forbidden or allows_pickle:
            found.append(f"{module}:{node.lineno}: {name}")
    return found


def _is_number(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and isinstance(node.value, int | float)


def test_every_module_was_seen_and_has_a_layer() -> None:
    walked = {info.name for info in pkgutil.walk_packages(symdyn.__path__, "symdyn.")}
    assert set(TREES) == walked | {"symdyn"}  # a folder without __init__.py would be missing on the right
    assert {layer_of(module) for module in TREES} == {None, *LAYERS}
    landmarks = {"symdyn.compiler", "symdyn.derive.newton_euler", "symdyn.physics.effects.backlash"}
    assert landmarks <= set(TREES)


def test_every_module_says_its_job_in_its_first_line() -> None:
    silent = [module for module, tree in TREES.items() if not (ast.get_docstring(tree) or "").splitlines()]
    assert not silent


@pytest.mark.parametrize("module", TREES)
def test_imports_go_down_only(module: str) -> None:
    assert upward_imports(module, TREES[module]) == []


@pytest.mark.parametrize("layer", ["spec", "numeric", "faces"])
def test_sympy_stays_in_the_symbolic_layers(layer: str) -> None:
    found = {m: imports_of(tree, "sympy") for m, tree in TREES.items() if layer_of(m) == layer}
    assert found
    assert not {module: names for module, names in found.items() if names}


def test_only_the_kernel_crosses_from_symbols_to_numbers() -> None:
    crossing = {
        name
        for module, tree in TREES.items()
        if layer_of(module) == "numeric"
        for name in imports_of(tree, "symdyn")
        if layer_of(name) in ("derive", "program", "emit")
    }
    assert crossing == {"symdyn.emit.kernel.Kernel"}


def test_jinja_has_one_user_and_templates_are_filled_by_emit_and_faces_alone() -> None:
    assert [module for module, tree in TREES.items() if imports_of(tree, "jinja2")] == ["symdyn.emit.templates"]
    filling = {
        layer_of(module)
        for module, tree in TREES.items()
        for name in imported(tree)
        if name.startswith("symdyn.emit.templates") and not name.endswith(".digest")  # a hash, for manifests
    }
    assert filling == {"emit", "faces"}


@pytest.mark.parametrize("module", TREES)
def test_no_text_is_run_as_code(module: str) -> None:
    assert runs_text(module, TREES[module]) == []


@pytest.mark.parametrize(
    ("module", "source"),
    [
        ("symdyn.base.units", "from symdyn.spec.records import Robot"),
        ("symdyn.spec.places", "import symdyn.physics"),
        ("symdyn.numeric.fitting", "def f():\n    from symdyn import faces"),
        ("symdyn.emit.kernel", "from symdyn.compiler import load_robot"),
        ("symdyn.derive.steps", "from . import energy"),
        ("symdyn", "from symdyn.compiler import load_robot"),
    ],
)
def test_an_upward_import_would_be_seen(module: str, source: str) -> None:
    assert upward_imports(module, ast.parse(source))


@pytest.mark.parametrize(
    ("module", "source"),
    [
        ("symdyn.spec.x", "eval(text)"),
        ("symdyn.spec.x", "exec(text)"),
        ("symdyn.numeric.x", "frame.eval(text)"),
        ("symdyn.numeric.x", "import pickle"),
        ("symdyn.numeric.x", "from dill import load"),
        ("symdyn.numeric.x", "np.load(file, allow_pickle=True)"),
        ("symdyn.faces.x", "sympy.sympify(text)"),
        ("symdyn.derive.x", 'sympify("1 + x")'),
        ("symdyn.derive.x", 'sympify(f"{name}")'),
        ("symdyn.emit.x", "lambdify(x, y)"),
        ("symdyn.emit.x", "parse_expr(text)"),
    ],
)
def test_running_text_would_be_seen(module: str, source: str) -> None:
    assert runs_text(module, ast.parse(source))


@pytest.mark.parametrize("source", ["re.compile(text)", "sympify(expression, strict=True)", "np.load(file)"])
def test_what_is_harmless_passes(source: str) -> None:
    assert runs_text("symdyn.spec.x", ast.parse(source)) == []
