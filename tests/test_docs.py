"""What the documents show works: their examples run, their links lead somewhere, their numbers come out."""

from __future__ import annotations

import importlib
import re
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from symdyn.base.errors import InputError
from symdyn.compiler import compile_robot, generate, load_robot, robot_from_text
from symdyn.derive.linearize import without_nonsmooth
from symdyn.emit import targets
from symdyn.numeric.candidates import candidates
from symdyn.physics import effects, registry
from symdyn.program.evaluate import evaluate
from symdyn.spec.machines import machine_names

CHECKOUT = Path(__file__).parent.parent
HEAD = """
[robot]
name = "example"
gravity = [0, 0, -9.81]
"""
PARAMETERS = """
[parameters]
m_1 = "1 kg"
l_1 = "0.5 m"
J_1 = "34e-6 kg m^2"
J_2 = "41e-6 kg m^2"
J_4 = "372e-6 kg m^2"
c_1 = "789 N m/rad"
c_2 = "1225 N m/rad"
d_1 = "1e-3 N m s/rad"
d_2 = "2e-3 N m s/rad"
R = "1.6 Ohm"
L = "87 uH"
K_T = "0.088 N m/A"
K_E = "0.088 V s/rad"
"""
DH = """
[dh]
rows = [ ["q", 0, 0.5, 0] ]
"""
JOINT = """
[[joint]]
name = "{}"
link = {{ mass = 1 }}
[joint.drive]
rotors = [ {{ name = "motor", inertia = 1e-4, fixed_to_joint = true }} ]
"""
ARM = """
[[joint]]
name = "arm"
link = { mass = 1 }
"""
CIRCUIT = """
[joint.drive.motor]
name = "circuit"
at = "motor"
resistance = 1
torque_constant = 0.1
back_emf_constant = 0.1
"""
LOOP = '\n[[effect]]\ntype = "position_servo"\nat = "shoulder.motor"\nproportional = 50\nlimit = 24\n'
LOAD = '\n[parameters]\nm_load = "0 kg"\n'
TIME = '\n[recording]\ntime = { column = "t", unit = "s" }\n'
AROUND_THE_BLOCKS = (  # of docs/format.md: what each leaves out, before and after it
    ("", ""),
    (HEAD, DH + JOINT.format("shoulder")),
    (HEAD + PARAMETERS, JOINT.format("first") + JOINT.format("second") + JOINT.format("third")),
    (HEAD + PARAMETERS, ""),
    (HEAD + PARAMETERS + DH, ""),
    (HEAD + PARAMETERS + DH, ""),
    (HEAD + DH + ARM, ""),
    (HEAD + DH + JOINT.format("axis1"), ""),
    (HEAD + DH + JOINT.format("axis1") + CIRCUIT, ""),
    (HEAD + DH + JOINT.format("shoulder"), ""),
    (HEAD + DH + JOINT.format("shoulder") + CIRCUIT + LOOP + TIME, ""),
    (HEAD + LOAD + DH + JOINT.format("shoulder") + TIME, ""),
)
PAGES = [*sorted(CHECKOUT.glob("*.md")), *sorted((CHECKOUT / "docs").glob("*.md"))]


def _text(page: str) -> str:
    return (CHECKOUT / page).read_text(encoding="utf-8")


def _blocks(page: str, language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```", _text(page), re.DOTALL | re.MULTILINE)


@pytest.fixture
def catalogue_with_the_example(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """CONTRIBUTING's effect as one more file of the catalogue, and nothing else."""
    source = next(block for block in _blocks("CONTRIBUTING.md", "python") if "class CubicDrag" in block)
    (tmp_path / "cubic_drag.py").write_text(source)
    monkeypatch.setattr(effects, "__path__", [*effects.__path__, str(tmp_path)])
    registry.catalogue.cache_clear()
    registry.schemas.cache_clear()
    yield
    registry.catalogue.cache_clear()
    registry.schemas.cache_clear()
    sys.modules.pop(f"{effects.__name__}.cubic_drag", None)


@pytest.fixture
def targets_with_the_example(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """CONTRIBUTING's target as one more file of the targets, and nothing else."""
    (source,) = (block for block in _blocks("CONTRIBUTING.md", "python") if "TARGET = " in block)
    (tmp_path / "micropython.py").write_text(source)
    monkeypatch.setattr(targets, "__path__", [*targets.__path__, str(tmp_path)])
    targets.targets.cache_clear()
    yield
    targets.targets.cache_clear()
    sys.modules.pop(f"{targets.__name__}.micropython", None)


def test_all_pages_were_found() -> None:
    assert {"README.md", "CONTRIBUTING.md", "design.md", "format.md", "seed.md"} <= {page.name for page in PAGES}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    for target in re.findall(r"\]\(([^)\s]+)\)", text):
        if target.startswith("http"):
            continue
        name, _, anchor = target.partition("#")
        there = (page.parent / name).resolve() if name else page
        assert there.exists(), target
        if anchor:
            headings = re.findall(r"^#+ (.+)$", there.read_text(encoding="utf-8"), re.MULTILINE)
            assert anchor in {re.sub(r"[^\w -]", "", h).lower().replace(" ", "-") for h in headings}, target


def test_the_example_of_the_readme_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (model,) = _blocks("README.md", "toml")
    (program,) = _blocks("README.md", "python")
    (tmp_path / "pendulum.toml").write_text(model)
    monkeypatch.chdir(tmp_path)
    exec(compile(program, "README.md", "exec"), {})
    printed = capsys.readouterr().out.split("\n")
    promised = re.findall(r"# (\[.*\])", program)
    assert promised
    assert printed[: len(promised)] == promised


def test_the_readme_names_every_bundled_machine() -> None:
    sentence = next(line for line in _text("README.md").split("\n") if "name of a bundled machine" in line)
    assert set(re.findall(r"`([a-z0-9-]+)`", sentence)) == set(machine_names())


def test_the_effect_of_contributing_works_from_one_file(catalogue_with_the_example: None) -> None:
    (model,) = _blocks("README.md", "toml")
    before = robot_from_text(model, "pendulum.toml")
    assert "cubic_drag" in {candidate.effect for candidate in candidates(before)}
    after = robot_from_text(model + _blocks("CONTRIBUTING.md", "toml")[0], "pendulum.toml")
    q, qd, qdd = np.array([0.7]), np.array([1.0]), np.array([-2.0])
    more, less = (compile_robot(robot).kernel().inverse_dynamics(q, qd, qdd) for robot in (after, before))
    np.testing.assert_allclose(more - less, 0.8 * qd**3, rtol=1e-12)


def test_the_target_of_contributing_works_from_one_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, targets_with_the_example: None
) -> None:
    (model,) = _blocks("README.md", "toml")
    robot = robot_from_text(model, "pendulum.toml")
    written = generate(robot, tmp_path / "out", ["numba", "micropython"])
    assert [path.name for path in written] == ["kernel.py", "robot.py", "equations.tex", "manifest.json"]
    monkeypatch.syspath_prepend(tmp_path / "out")
    module = importlib.import_module("robot")
    rng = np.random.default_rng(1)
    compiled = compile_robot(robot)
    for form in compiled.forms:
        given = {a.name: rng.uniform(0.5, 1.5, len(a.symbols)).tolist() for a in form.program.arguments}
        found = getattr(module, form.name)(*given.values())
        np.testing.assert_allclose(found, [float(v) for v in evaluate(form.program, given)], rtol=1e-12, atol=1e-12)
    sys.modules.pop("robot")


def test_the_blocks_of_the_format_are_read() -> None:
    blocks = _blocks("docs/format.md", "toml")
    assert len(blocks) == len(AROUND_THE_BLOCKS)
    for block, (before, after) in zip(blocks, AROUND_THE_BLOCKS, strict=True):
        robot = robot_from_text(f"{before}\n{block}\n{after}", block.split("\n")[0])
        assert robot.joints


def test_the_error_that_the_format_shows_is_the_one_that_is_told() -> None:
    shown = re.search(r"error: arm\.toml:(\d+):(\d+): (SD\d+: .*)", _text("docs/format.md"))
    assert shown is not None
    (model,) = _blocks("README.md", "toml")
    with pytest.raises(InputError) as raised:
        robot_from_text(model.replace('"0.5 m"', '"0.5 Nm"'), "arm.toml")
    (problem,) = raised.value.problems
    assert str(problem).split("\n")[0] == shown[0].removeprefix("error: ")


def test_what_the_lost_damper_of_the_paper_would_cost() -> None:
    robot = without_nonsmooth(load_robot("irb6-axis1"))
    kernel = compile_robot(robot).kernel()
    values = dict(zip(kernel.parameters, kernel.values, strict=True))
    a = np.asarray(kernel.state_derivative_state_jacobian(np.zeros(len(kernel.states)), np.zeros(len(kernel.inputs))))
    complete = _damping_ratios(a)
    motor, drive = (kernel.states.index(f"axis1.{name}.qd") for name in ("motor", "harmonic_drive"))
    lost = values["d_2"] / values["J_2"]
    a[motor, motor] += lost
    a[motor, drive] -= lost
    assert complete == pytest.approx([0.116, 0.064, 0.105], abs=5e-4)
    assert _damping_ratios(a)[1:] == pytest.approx([0.028, 0.018], abs=5e-4)
    text = " ".join(_text("docs/seed.md").split())
    assert "0.028 and not 0.064" in text
    assert "0.018 and not 0.105" in text


def _damping_ratios(a: np.ndarray) -> list[float]:
    """Of the oscillating modes, slowest first."""
    poles = [pole for pole in np.linalg.eigvals(a) if pole.imag > 1e-6]
    return [float(-pole.real / abs(pole)) for pole in sorted(poles, key=abs)]
