"""What may be taken away and what it costs: exact limits, error bounds, and the paper's d_5'."""

from __future__ import annotations

import numpy as np
import pytest

from symdyn.base.errors import UsageError
from symdyn.compiler import linearise, load_robot, robot_from_text
from symdyn.derive.linearize import without_nonsmooth
from symdyn.numeric.linear.cost import Band, Signal, cost
from symdyn.numeric.linear.drops import rigid, shafts, with_sensor, without
from symdyn.numeric.linear.lumps import lumped, lumps
from symdyn.numeric.linear.mode_removal import balanced_orders, mode_removals
from symdyn.numeric.linear.modes import modes
from symdyn.numeric.linear.propose import propose, reduced
from symdyn.numeric.linear.response import frequency_response

from .machines import chain, drive

HERTZ = np.geomspace(0.1, 3000, 300)
DAMPERS = ("d_4", "d_5", "d_6", "d_7")


# --- errors ---------------------------------------------------------------------------------------------------------


def test_cost_of_a_known_error() -> None:
    band = Band(1.0, 10.0, Signal.WHITE)
    hertz = band.hertz()
    exact = np.ones(len(hertz), complex)
    simpler = exact.copy()
    simpler[7] = 1.1
    found = cost(band, hertz, exact, simpler)
    assert found.worst == pytest.approx(0.1)
    assert found.hertz == hertz[7]
    assert found.decibel == pytest.approx(20 * np.log10(1.1))
    assert found.rms == pytest.approx(0.1 * np.sqrt(hertz[7] / hertz.sum()))
    assert cost(band, hertz, exact, exact * np.nan).worst == np.inf
    with pytest.raises(UsageError, match="SD302"):
        Band(10.0, 1.0).hertz()


def test_a_step_weighs_low_frequencies_more_than_noise_does() -> None:
    low = np.geomspace(1, 100, 600) < 10
    exact = np.ones(600, complex)
    for wrong, larger in ((low, Signal.STEP), (~low, Signal.WHITE)):
        rms = {s: cost(Band(1, 100, s), Band(1, 100).hertz(), exact, exact + 0.1 * wrong).rms for s in Signal}
        assert max(rms, key=lambda s: rms[s]) is larger


# --- exact limits ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("shaft", "parameter"), [("tachometer_shaft", "c_1"), ("motor_shaft", "c_2"), ("flexspline", "c_3")]
)
def test_rigid_is_the_limit_of_stiffness_and_converges_with_its_inverse(shaft: str, parameter: str) -> None:
    family = drive()
    limit = rigid(family.nominal, f"axis1.{shaft}")
    assert len(limit.states) == 7
    exact = frequency_response(limit, HERTZ).values
    errors = []
    for stiffness in (1e7, 1e8):
        p = family.values.copy()
        p[family.index(parameter)] = stiffness
        errors.append(np.abs(frequency_response(family.at(p), HERTZ).values / exact - 1).max())
    assert errors[0] / errors[1] == pytest.approx(10.0, rel=0.05)
    assert errors[1] < 0.01


def test_all_rigid_is_one_inertia() -> None:
    system = drive().nominal
    for address in shafts(system):
        system = rigid(system, address)
    assert system.coordinates == ("axis1",)
    assert system.e[0, 0] == system.f[0, 1] == 1.0
    assert system.e[1, 1] == pytest.approx(643e-6)
    assert system.f[1, 1] == pytest.approx(-788e-6)
    assert [m.name for m in modes(system)][1] == "axis1 slowing down"
    with pytest.raises(KeyError):
        rigid(system, "axis1.belt")


def test_a_state_that_goes_can_still_be_seen() -> None:
    system = with_sensor(drive().nominal, "axis1.tachometer.qd")
    before = frequency_response(system, HERTZ[:100], None, "axis1.tachometer.qd").values
    after = frequency_response(rigid(system, "axis1.tachometer_shaft"), HERTZ[:100], None, "axis1.tachometer.qd").values
    assert np.abs(after / before - 1).max() < 1e-3
    assert with_sensor(system, "axis1.tachometer.qd") is system


@pytest.mark.parametrize("parameter", ["L", "J_1", "J_4", "d_2"])
def test_zero_is_the_limit_of_small_values(parameter: str) -> None:
    family = drive()
    limit = without(family, parameter)
    assert limit is not None
    p = family.values.copy()
    p[family.index(parameter)] *= 1e-7
    near = frequency_response(family.at(p), HERTZ).values
    assert np.abs(near / frequency_response(limit, HERTZ).values - 1).max() < 1e-4


# --- lumps ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("high", "error"), [(5.0, 1e-4), (100.0, 1e-3), (3000.0, 0.011)])
def test_the_four_dampers_of_the_paper_are_found_to_act_as_one(high: float, error: float) -> None:
    (found,) = (g for g in lumps(drive(), Band(0.1, high), 0.05) if "d_4" in g.members)
    assert found.members == DAMPERS
    assert found.into == "d_5"
    assert found.value == pytest.approx(788e-6)
    assert found.cost.worst < error
    assert found.parallel > 0.99
    assert dict(found.alternatives)["d_5"] == found.cost


def test_the_cost_of_a_lump_is_that_of_the_machine_with_those_values() -> None:
    family, band = drive(), Band(0.1, 3000.0)
    (found,) = (g for g in lumps(family, band, 0.05) if "d_4" in g.members)
    p = lumped(family.values, [family.index(name) for name in DAMPERS], family.index("d_5"))
    hertz = band.hertz()
    before, after = (frequency_response(s, hertz).values for s in (family.nominal, family.at(p)))
    assert found.cost.worst == pytest.approx(float(np.abs(after / before - 1).max()))


def test_a_load_damper_with_a_value_is_not_moved_to_the_motor() -> None:
    """d_7 is in the paper's sum because it is zero: as large as d_6, it acts across the flexspline."""
    family = drive()
    values = family.values.copy()
    values[family.index("d_7")] = 700e-6
    loaded = type(family)(family.name, family.parameters, family.units, family.meanings, values, family.at,
                          family.derivatives)  # fmt: skip
    (found,) = (g for g in lumps(loaded, Band(0.1, 100.0), 0.05) if "d_4" in g.members)
    assert found.members == ("d_4", "d_5", "d_6")


def test_springs_in_a_row_are_not_lumped() -> None:
    assert not [g for g in lumps(drive(), Band(0.1, 3000.0), 0.05) if "c_1" in g.members or "c_2" in g.members]


# --- modes ----------------------------------------------------------------------------------------------------------


def test_balanced_truncation_keeps_its_bound() -> None:
    system = chain([1e-3, 2e-3, 4e-3], [30.0, 9.0], [2e-3, 1e-3], grounded=0.02).nominal
    band = Band(0.01, 200.0)
    exact = frequency_response(system, band.hertz(), None, "load.qd").values
    found = balanced_orders(system, band, None, "load.qd")
    values = {row.order: row.hankel for row in found}
    assert sorted(values.values(), reverse=True) == [values[k] for k in sorted(values)]
    for row in found:
        tail = sum(value for order, value in values.items() if order >= row.order)
        for one in (row.truncated, row.residualised):
            # the bound is on |change|, the cost relative to |G| where it is worst
            assert one.worst * np.abs(exact).min() <= 2 * tail * (1 + 1e-6)
    assert min(row.order for row in found) == 0


def test_what_the_output_does_not_see_costs_nothing() -> None:
    """The angle behind the tachometer: eight states give its voltage exactly, and fewer do not."""
    found = balanced_orders(drive().nominal, Band(0.1, 100.0))
    assert [row.order for row in found] == list(range(7, -1, -1))
    at_rest = {row.order: row.residualised.worst for row in found}
    assert at_rest[3] < 0.05 < at_rest[2]


def test_a_pole_that_does_not_decay_is_kept_as_it_is() -> None:
    """The load's angle is an integral of the voltage, which no truncation may touch."""
    found = balanced_orders(drive().nominal, Band(0.1, 100.0), None, "axis1.q")
    assert [row.order for row in found] == list(range(len(found), 0, -1))
    assert found[0].residualised.worst < 1e-3
    assert found[-1].residualised.worst > 0.5


def test_removing_every_mode_alone_leaves_the_rest() -> None:
    system = drive().nominal
    found = {m.name: m for m in mode_removals(system, Band(0.1, 100.0))}
    assert found["axis1.motor.current settling"].cost.worst < 1e-3
    assert found["axis1 against harmonic_drive, motor and tachometer"].cost.worst > 1.0
    assert sum(m.states for m in found.values()) == 8  # all but the free motion


# --- the proposal ---------------------------------------------------------------------------------------------------


def test_the_proposal_for_the_control_band() -> None:
    found = propose(drive(), Band(0.1, 100.0), 0.05)
    assert (found.full_order, found.order) == (9, 4)
    assert (found.full_parameters, len(found.parameters)) == (19, 9)
    assert set(found.parameters) == {"R", "K_T", "K_E", "K_Et", "J_2", "J_4", "d_3", "d_5", "c_3"}
    assert found.unused == ("T_f", "S")
    assert [(s.kind, s.what) for s in found.steps if not s.in_file] == [
        ("rigid", "axis1.tachometer_shaft"), ("lump", "J_2"), ("zero", "L"), ("rigid", "axis1.motor_shaft"),
    ]  # fmt: skip
    assert all(s.so_far.worst <= 0.05 for s in found.steps)
    assert found.values == {"d_1": 0.0, "d_2": 0.0, "d_4": 0.0, "d_5": pytest.approx(788e-6), "d_6": 0.0}
    p = drive().values.copy()
    for name, value in found.values.items():
        p[drive().index(name)] = value
    hertz = found.band.hertz()
    before, after = (frequency_response(s, hertz).values for s in (drive().nominal, drive().at(p)))
    assert found.file_cost.worst == pytest.approx(float(np.abs(after / before - 1).max()))


def test_more_error_allowed_never_leaves_more() -> None:
    found = [propose(drive(), Band(0.1, 100.0), tolerance) for tolerance in (1e-6, 1e-3, 0.05)]
    assert [r.order for r in found] == sorted((r.order for r in found), reverse=True)
    assert [len(r.parameters) for r in found] == sorted((len(r.parameters) for r in found), reverse=True)
    assert not [s for s in found[0].steps if s.alone.worst > 1e-6]


def test_where_the_machine_accelerates_no_inertia_is_set_to_zero() -> None:
    """One volt at rest: without an inductance the current would jump, without an inertia the speed."""
    robot = without_nonsmooth(load_robot("irb6-axis1"))
    family = linearise(robot, u=np.array([1.0]))
    assert without(family, "L") is None
    found = propose(family, Band(0.1, 100.0), 0.05)
    assert not {"L", "J_1", "J_2"} & set(dict(found.zeroed))
    assert [s.what for s in found.steps if s.kind == "lump"] == ["d_5"]
    assert all(s.so_far.worst <= 0.05 for s in found.steps)


INVERTED = """\
[robot]
name = "inverted"
gravity = [0, "-9.81 m/s^2", 0]
[dh]
rows = [["q", 0, "1 m", 0]]
[[joint]]
name = "pivot"
link = { mass = "1 kg", com = [0, 0, 0] }
[joint.drive]
ratio = 10
rotors = [{ name = "motor", inertia = "1e-6 kg m^2", fixed_to_joint = true }]
[[effect]]
type = "linear_spring"
at = "pivot"
stiffness = "6 N m/rad"
[[effect]]
type = "linear_spring"
at = "pivot.motor"
stiffness = "0.06 N m/rad"
[[effect]]
type = "viscous_friction"
at = "pivot"
coefficient = "1 N m s/rad"
"""


def test_nothing_is_taken_that_keeps_the_machine_upright() -> None:
    """Two springs hold the rod together. Above its resonance each hardly matters; without either, it would fall."""
    upright = np.array([np.pi / 2, 0.0])
    family = linearise(robot_from_text(INVERTED, "inverted.toml"), upright)
    springs = {"pivot_linear_spring_stiffness", "pivot_motor_linear_spring_stiffness"}
    found = propose(family, Band(30.0, 300.0), 0.05)
    assert all(dict(found.zeroed)[spring].worst < 0.01 for spring in springs)
    assert springs <= set(found.parameters)
    assert all(mode.pole.real <= 0.0 for machine in (family.nominal, reduced(family, found)) for mode in modes(machine))


def test_another_output_is_reduced_for_itself() -> None:
    found = propose(drive(), Band(0.1, 5.0), 0.05, None, "axis1.tachometer.qd")
    assert found.output == "axis1.tachometer.qd"
    assert found.order < found.full_order
    assert "K_Et" in found.unused or "K_Et" not in found.parameters
