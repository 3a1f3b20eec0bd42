"""Effects with several shape parameters, concealed in the pendulum by torques written here: name, values, intervals."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from symdyn.numeric.diagnose import diagnose
from symdyn.numeric.findings import Diagnosis, Verdict
from symdyn.numeric.forward import forward
from symdyn.numeric.inquiry import Inquiry
from symdyn.numeric.kinship import ready, waiting
from symdyn.numeric.setting import prepare
from symdyn.spec.edit import add_effect

from .pendulum import ARM, GRAVITY, MASS, TOML, VISCOUS, pendulum, record

Array = NDArray[np.float64]
SUBSTEPS = 8


def course(rate: Callable[[float, float], float], time: Array, speed: Array) -> Array:
    """A hidden state from zero on, midpoint rule in small steps; rate(state, speed)."""
    found = np.zeros(len(time))
    for k in range(len(time) - 1):
        h, z = (time[k + 1] - time[k]) / SUBSTEPS, found[k]
        for i in range(SUBSTEPS):
            v = speed[k] + (i + 0.5) / SUBSTEPS * (speed[k + 1] - speed[k])
            z += h * rate(z + 0.5 * h * rate(z, v), v)
        found[k + 1] = z
    return found


def lugre(t: Array, q: Array, v: Array, a: Array) -> Array:
    def level(v: float) -> float:
        return float(0.4 + 0.2 * np.exp(-((v / 0.2) ** 2)))

    return 15.0 * course(lambda z, v: v - 15.0 * abs(v) * z / level(v), t, v)


def hysteresis(t: Array, q: Array, v: Array, a: Array) -> Array:
    w = course(lambda w, v: (v - 0.75 * abs(v) * abs(w) * w - 0.25 * v * w * w) / 0.06, t, v)
    return 0.5 * w


def warming(t: Array, q: Array, v: Array, a: Array) -> Array:
    heat = 2.0
    rise = course(lambda x, v: (0.6 * np.exp(-x / 25.0) * v * v - x / 12.0) / heat * 10.0, t, v)
    return 0.6 * np.exp(-rise / 25.0) * v


def counterbalance(t: Array, q: Array, v: Array, a: Array) -> Array:
    turn = 1.2 - q
    length = np.sqrt(0.3**2 + 0.15**2 - 2 * 0.3 * 0.15 * np.cos(turn))
    weight = MASS * GRAVITY * ARM * np.cos(q)  # this pendulum turns about the vertical
    return -40.0 * (length - 0.2) * 0.3 * 0.15 * np.sin(turn) / length - weight


def greased(t: Array, q: Array, v: Array, a: Array) -> Array:
    return 0.9 * 0.5 * np.tanh(v / 0.5)


def found_in(law: Callable[[Array, Array, Array, Array], Array]) -> Diagnosis:
    upright = pendulum(TOML.replace('[0, "-g", 0]', '[0, 0, "-g"]')) if law is counterbalance else pendulum()
    return diagnose(upright, record(1, law), record(101, law))


@pytest.mark.parametrize(
    ("law", "effect", "values"),
    [
        pytest.param(
            lugre,
            "lugre_friction",
            {"level": 0.4, "stiffness": 15.0, "excess": 0.2, "stribeck_velocity": 0.2},
            marks=pytest.mark.slow,
        ),
        pytest.param(
            greased,
            "degressive_friction",
            {"coefficient": 0.9, "turnover_velocity": 0.5},
            marks=pytest.mark.slow,
        ),
        pytest.param(
            hysteresis,
            "bouc_wen_hysteresis",
            {"level": 0.5, "yield_displacement": 0.06, "shape": 0.75, "exponent": 2.0},
            marks=pytest.mark.slow,
        ),
        pytest.param(warming, "warm_up_friction", {"coefficient": 0.6}, marks=pytest.mark.slow),
        pytest.param(counterbalance, "counterbalance_spring", {"dead_centre": 1.2}, marks=pytest.mark.slow),
    ],
    ids=lambda x: x if isinstance(x, str) else "",
)
def test_named_with_its_values(
    law: Callable[[Array, Array, Array, Array], Array], effect: str, values: dict[str, float]
) -> None:
    found = found_in(law)
    assert [f.effect for f in found.findings] == [effect]
    for name, value in values.items():
        told = found.findings[0].parameters[name]
        assert told.value == pytest.approx(value, abs=max(4.0 * (told.se or 0.0), 0.03 * value)), name
    assert not found.remaining.structured
    assert found.after.heldout < 0.1 * found.before.heldout
    assert found.diagnosed.effects[-1].type == effect


@pytest.mark.slow  # whole diagnoses of a model that lacks three laws
@pytest.mark.parametrize("bends", [True, False])
def test_degressive_friction_is_told_from_dry_and_viscous_friction_together(bends: bool) -> None:
    """All three are missing: a curve that rises steeply resembles the other two, and must not come first."""
    bare, effects = TOML.split("[[effect]]")[0], TOML.split("[recording]")[1]

    def friction(t: Array, q: Array, v: Array, a: Array) -> Array:
        return 0.4 * np.sign(v) + (greased(t, q, v, a) - VISCOUS * v if bends else 0.3 * v)

    found = diagnose(pendulum(f"{bare}[recording]{effects}"), record(1, friction), record(101, friction))
    told = {f.effect: f.parameters for f in found.findings}
    assert told.keys() == {"coulomb_friction", "degressive_friction" if bends else "viscous_friction"}
    assert told["coulomb_friction"]["level"].value == pytest.approx(0.4, rel=0.02)
    if not bends:
        assert told["viscous_friction"]["coefficient"].value == pytest.approx(VISCOUS + 0.3, rel=0.02)


def test_a_law_that_waits_for_what_it_contains_is_asked_where_nothing_else_earns_its_place() -> None:
    """Another one had come before viscous friction, and viscous friction did not earn its place beside that."""
    bare, effects = TOML.split("[[effect]]")[0], TOML.split("[recording]")[1]

    def friction(t: Array, q: Array, v: Array, a: Array) -> Array:
        return greased(t, q, v, a) - VISCOUS * v

    runs = (record(1, friction), record(101, friction))
    setting = prepare(pendulum(f"{bare}[recording]{effects}"), *runs, lambda _: None)
    proposed = tuple(c for c in setting.proposed if c.effect in ("quadratic_drag", "degressive_friction"))
    setting = replace(setting, proposed=proposed)
    assert [c.effect for c in ready(proposed, setting.robot, frozenset())] == ["quadratic_drag"]
    assert not waiting(proposed, setting.robot, frozenset({("viscous_friction", "arm", 1)}))
    case = setting.case(5.0)
    given = case.explain()
    found = forward(Inquiry(setting, case, given, setting, case, given), (), lambda _: None)
    assert "degressive_friction" in {f.effect for f in found.findings}
    assert found.case.errors(found.current).heldout < 0.1 * found.case.errors(given).heldout


@pytest.mark.slow
def test_a_model_that_holds_a_law_with_memory_is_diagnosed_again() -> None:
    """What a diagnosis wrote, another one reads: it finds nothing more, and fits the law's own numbers."""
    law = add_effect(TOML, "dahl_friction", "arm", {"stiffness": "9 N m/rad", "level": "0.5 N m"})

    def dahl(t: Array, q: Array, v: Array, a: Array) -> Array:
        return 10.0 * course(lambda z, v: v - 10.0 * abs(v) * z / 0.4, t, v)

    found = diagnose(pendulum(law), record(1, dahl), record(101, dahl))
    assert (found.verdict, found.findings) == (Verdict.COMPLETE, ())
    assert found.model["arm_dahl_friction_level"].value == pytest.approx(0.4, rel=0.01)
    assert found.model["arm_dahl_friction_stiffness"].value == pytest.approx(10.0, rel=0.02)


def test_a_joint_that_stands_still_is_told_no_law_of_motion() -> None:
    """Not even by sensors without noise, where any distance and any speed would do."""
    runs = [record(seed, lambda t, q, v, a: 0.5 + 0 * q, amplitude=0.0, noise=False) for seed in (1, 2)]
    found = diagnose(pendulum(), *runs)
    assert found.findings == ()
