"""URDFs against Pinocchio's own reader of them: efforts and mass matrices, of written and of random robots."""

from __future__ import annotations

from dataclasses import fields, is_dataclass, replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from symdyn.compiler import robot_from_text
from symdyn.derive.equations import equations_of_motion
from symdyn.derive.lagrange import lagrange_coefficients
from symdyn.physics import schemas
from symdyn.spec.mass_matrix import mass_matrix as numeric_mass_matrix
from symdyn.spec.monomials import value_of
from symdyn.spec.records import Monomial, Parameter, Robot
from symdyn.spec.urdf_chain import Chain
from symdyn.spec.urdf_reader import read_urdf_text

from .evaluation import close, energy, function, inverse_dynamics, mass_matrix

pin = pytest.importorskip("pinocchio")

TOLERANCE = 1e-10
BODY = """<inertial><origin xyz="{com}" rpy="{turn}"/><mass value="{mass}"/>
<inertia ixx="{xx}" ixy="0.001" ixz="-0.002" iyy="{yy}" iyz="0.003" izz="0.05"/></inertial>"""


def link(name: str, com: str = "0.1 -0.05 0.2", turn: str = "0 0 0", mass: float = 2, xx: float = 0.03) -> str:
    return f'<link name="{name}">{BODY.format(com=com, turn=turn, mass=mass, xx=xx, yy=0.04)}</link>\n'


def joint(name: str, kind: str, parent: str, child: str, xyz: str, rpy: str, axis: str) -> str:
    return (
        f'<joint name="{name}" type="{kind}"><origin xyz="{xyz}" rpy="{rpy}"/><parent link="{parent}"/>'
        f'<child link="{child}"/><axis xyz="{axis}"/><limit lower="-3" upper="3" effort="9" velocity="9"/></joint>\n'
    )


RIGHT = "1.5707963267948966"
WRITTEN = {
    "right angles": (
        link("base") + link("a") + link("b") + link("c")
        + joint("j1", "revolute", "base", "a", "0 0 0.3", "0 0 0", "0 0 1")
        + joint("j2", "revolute", "a", "b", "0.1 0 0.2", f"-{RIGHT} 0 0", "0 0 -1")
        + joint("j3", "revolute", "b", "c", "0 0.3 0", f"0 {RIGHT} {RIGHT}", "0 1 0")
    ),
    "skew axes, fixed joints, a slide": (
        '<link name="world"/>' + link("base") + link("a", turn="0.3 -0.2 0.5") + link("camera", mass=0.4)
        + link("b") + link("tool", "0 0 0.1", "1 0 0") + '<link name="tip"/>'
        + joint("fix", "fixed", "world", "base", "0.2 0.1 0", "0.3 0 0.1", "1 0 0")
        + joint("j1", "revolute", "base", "a", "0.1 0.2 0.3", "0.4 0.5 0.6", "1 -2 0.5")
        + joint("mount", "fixed", "a", "camera", "0.3 0 0.1", "0 1 0", "1 0 0")
        + joint("j2", "prismatic", "a", "b", "0 0.1 0.2", "-0.3 0.1 2", "0.2 0.3 -1")
        + joint("grip", "fixed", "b", "tool", "0 0 0.2", "0 0 0.7", "1 0 0")
        + joint("end", "fixed", "tool", "tip", "0 0 0.1", "0 0 0", "1 0 0")
    ),
}  # fmt: skip


def both(body: str) -> tuple[Robot, Any]:
    text = f'<robot name="arm">{body}</robot>'
    robot, _ = read_urdf_text(text, "f", schemas())
    return robot, pin.buildModelFromXML(text)


def folded(item: Any, values: dict[str, float | None]) -> Any:
    """A record with its parameters replaced by their values."""
    if isinstance(item, Monomial):
        return Monomial(value_of(item, values) or 0.0)
    if isinstance(item, tuple):
        return tuple(folded(each, values) for each in item)
    if is_dataclass(item) and not isinstance(item, Parameter):
        return replace(item, **{f.name: folded(getattr(item, f.name), values) for f in fields(item)})
    return item


def check(robot: Robot, model: Any, state: dict[str, list[float]]) -> None:
    data = model.createData()
    q, qd, qdd = (np.array(state[name]) for name in ("q", "qd", "qdd"))
    values = {p.name: p.value for p in robot.parameters}
    equations = equations_of_motion(folded(robot, values))
    assert close(inverse_dynamics(equations)(state), pin.rnea(model, data, q, qd, qdd), TOLERANCE)
    theirs = np.triu(pin.crba(model, data, q))
    theirs = theirs + np.triu(theirs, 1).T
    assert close(mass_matrix(equations, state["q"]), theirs, TOLERANCE)
    assert close(numeric_mass_matrix(robot, q, values), theirs, TOLERANCE)


@pytest.mark.parametrize("name", WRITTEN)
def test_written_urdf(name: str) -> None:
    robot, model = both(WRITTEN[name])
    rng = np.random.default_rng(1)
    for _ in range(3):
        check(robot, model, {key: list(rng.uniform(-2, 2, model.nv)) for key in ("q", "qd", "qdd")})


def test_lagrange_and_energy_of_a_placed_robot_with_base_and_tool() -> None:
    """The same arm, its fixed links written as base placement and tool: both formulations, energies, Pinocchio."""
    text = f'<robot name="arm">{WRITTEN["skew axes, fixed joints, a slide"]}</robot>'
    model = pin.buildModelFromXML(text)
    robot, _ = read_urdf_text(text, "f", schemas(), Chain(base="base"))
    base = "[base]\nplacement = { xyz = [0.2, 0.1, 0], rpy = [0.3, 0, 0.1] }\n"
    placed = robot_from_text(robot.text.replace("[[joint]]", f"{base}\n[[joint]]", 1), "f")
    state = {"q": [0.3, -0.2], "qd": [1.1, 0.7], "qdd": [-0.4, 2.0]}
    check(placed, model, state)
    placed = folded(placed, {p.name: p.value for p in placed.parameters})
    coefficients = lagrange_coefficients(placed)
    efforts = function(coefficients.axes, (), coefficients.efforts())(state)
    data = model.createData()
    q, qd, qdd = (np.array(state[name]) for name in ("q", "qd", "qdd"))
    assert close(np.array(efforts, dtype=float), pin.rnea(model, data, q, qd, qdd), TOLERANCE)
    theirs = pin.computeKineticEnergy(model, data, q, qd), pin.computePotentialEnergy(model, data, q)
    ours = [float(e) for e in energy(equations_of_motion(placed))(state)]
    at_zero = pin.computePotentialEnergy(model, data, np.zeros(2))
    rest = [float(e) for e in energy(equations_of_motion(placed))({**state, "q": [0.0, 0.0]})]
    # the base, which never moves, has a share in their potential
    assert close([ours[0], ours[1] - rest[1]], [theirs[0], theirs[1] - at_zero], TOLERANCE)


def test_a_tool_is_a_body_fixed_to_the_last_link() -> None:
    whole, model = both(WRITTEN["right angles"])
    body = link("hand", "0.02 0 0.1", "0.2 0 0", 0.7, 0.02)
    bigger = f'<robot name="arm">{WRITTEN["right angles"]}{body}' + joint(
        "mount", "fixed", "c", "hand", "0.1 0.2 0.3", "0.3 0.4 0.5", "1 0 0"
    )
    model = pin.buildModelFromXML(bigger + "</robot>")
    # c turns about its y: its frame in symdyn is turned by -90 degrees about x
    turn, hand = pin.rpy.rpyToMatrix(-np.pi / 2, 0, 0), pin.rpy.rpyToMatrix(0.3, 0.4, 0.5)
    rotation = (turn.T @ hand).tolist()
    inner = pin.rpy.rpyToMatrix(0.2, 0, 0)
    tensor = inner @ np.array([[0.02, 0.001, -0.002], [0.001, 0.04, 0.003], [-0.002, 0.003, 0.05]]) @ inner.T
    entries = {"xx": tensor[0, 0], "yy": tensor[1, 1], "zz": tensor[2, 2]}
    entries |= {"xy": tensor[0, 1], "xz": tensor[0, 2], "yz": tensor[1, 2]}
    inertia = ", ".join(f"{key} = {float(value)!r}" for key, value in entries.items())
    xyz = [float(x) for x in turn.T @ [0.1, 0.2, 0.3]]
    tool = f"""
[tool]
placement = {{ xyz = {xyz}, rotation = {rotation} }}
mass = 0.7
com = [0.02, 0, 0.1]
inertia = {{ {inertia} }}
"""
    robot = robot_from_text(whole.text + tool, "f")
    check(robot, model, {"q": [0.3, -0.2, 1.0], "qd": [1.1, 0.7, -0.4], "qdd": [-0.4, 2.0, 0.3]})


_ANGLE = st.one_of(  # plain angles are never so near to a right one that they are taken for it
    st.sampled_from([0.0, np.pi / 2, -np.pi / 2, np.pi]),
    st.integers(-300, 300).map(lambda hundredths: hundredths / 100),
)
_LENGTH = st.floats(-1, 1)


def three(draw: st.DrawFn, values: st.SearchStrategy[float]) -> str:
    return " ".join(repr(draw(values)) for _ in range(3))


@st.composite
def serial_urdfs(draw: st.DrawFn) -> str:
    """Up to four joints, moving or fixed, with any axes and offsets; the last one moves."""
    n = draw(st.integers(1, 4))
    body, names = '<link name="l0"/>', [f"l{i}" for i in range(n + 1)]
    for i, name in enumerate(names[1:], start=1):
        kind = draw(st.sampled_from(["revolute", "prismatic", "fixed"])) if i < n else "revolute"
        axis = draw(st.sampled_from(["1 0 0", "0 1 0", "0 0 1", "0 0 -1", "-1 0 0", "1 2 3", "-0.1 0 -5"]))
        mass = draw(st.floats(0.1, 5))
        body += link(name, three(draw, _LENGTH), three(draw, _ANGLE), mass)
        body += joint(f"j{i}", kind, names[i - 1], name, three(draw, _LENGTH), three(draw, _ANGLE), axis)
    return body


@settings(max_examples=25, deadline=None)
@given(serial_urdfs(), st.randoms(use_true_random=False))
def test_random_urdf(body: str, random: Any) -> None:
    robot, model = both(body)
    check(robot, model, {key: [random.uniform(-2, 2) for _ in range(model.nv)] for key in ("q", "qd", "qdd")})
    again = robot_from_text(robot.text, "f")
    assert again.joints == robot.joints
