# SPDX-License-Identifier: Apache-2.0
"""Columns in another unit than the file says are refused; wheel angles count their turns."""

from __future__ import annotations

import numpy as np
import pytest
from steptable import step_table

from flatplank_data.campaign import Campaign
from flatplank_data.checks import run_checks
from flatplank_data.errors import FlatplankError
from flatplank_data.run_record import RunRecord
from flatplank_data.table import MeasurementTable
from flatplank_data.turns import whole_turns

WRONG = {
    "time": {"ms": 1e-3, "min": 60.0, "us": 1e-6},
    "plank_position": {"mm": 1e-3, "cm": 1e-2, "in": 0.0254, "ft": 0.3048},
    "plank_velocity": {"mm/s": 1e-3, "kph": 1.0 / 3.6, "mph": 0.44704, "ft/s": 0.3048},
    "wheel_angle": {"deg": np.pi / 180.0, "rev": 2.0 * np.pi},
    "wheel_velocity": {"deg/s": np.pi / 180.0, "rpm": np.pi / 30.0},
    "motor_velocity": {"rpm": np.pi / 30.0},
    "fz": {"kn": 1e3, "dan": 10.0, "lbf": 4.4482216152605},
    "loaded_radius": {"mm": 1e-3, "cm": 1e-2},
    "pressure": {"bar": 1e5, "kpa": 1e3, "psi": 6894.757293168},
    "side_slip_angle": {"deg": np.pi / 180.0},
}
CASES = [(name, unit) for name, units in WRONG.items() for unit in units]


def a_run(kappa: float = 0.02, **info):
    table = step_table(kappa, alpha_deg=3.0, **info)
    n = len(table)
    return table.with_columns(
        pressure=np.full(n, 2.5e5), side_slip_angle=np.full(n, np.radians(3.0))
    )


def told(table) -> str:
    return "\n".join(str(p) for p in run_checks(table)[1] if p.fatal)


@pytest.mark.parametrize(("name", "unit"), CASES)
def test_a_column_in_another_unit_is_refused_with_its_unit(name, unit):
    table = a_run()
    assert not told(table)
    wrong = table.with_columns(**{name: table[name] / WRONG[name][unit]})
    assert f"'{name}' is in {unit}, not in" in told(wrong)
    assert "write the unit" in told(wrong) and "\n" not in told(wrong)


@pytest.mark.parametrize("kappa", [-0.3, -0.05, 0.0, 0.05, 0.3])
@pytest.mark.parametrize("size", [0.3, 1.0, 2.0])
def test_tires_of_any_size_and_loads_off_the_nominal_are_accepted(kappa, size):
    table = a_run(kappa)
    radius = size * table.info.effective_rolling_radius
    columns = {
        "wheel_angle": table["wheel_angle"] / size, "fz": 0.6 * size * table["fz"],
        "wheel_velocity": table["wheel_velocity"] / size,
        "motor_velocity": table["motor_velocity"] / size,
        "loaded_radius": 0.95 * size * table["loaded_radius"],
    }  # fmt: skip
    table = table.with_columns(**columns)
    assert not told(table.with_info(effective_rolling_radius=radius, fz=size * 3700.0))


@pytest.mark.parametrize("name", ["wheel_angle", "wheel_velocity"])
def test_an_unknown_radius_is_that_of_some_tire(name):
    """A wheel that turns 57 times as far as any tire would has its angle in degrees."""
    table = a_run().with_info(effective_rolling_radius=float("nan"))
    alone = table.select(["time", "plank_position", name, "fx"])
    assert not told(table) and not told(alone)
    unit = {"wheel_angle": "deg", "wheel_velocity": "deg/s"}[name]
    wrong = alone.with_columns(**{name: np.degrees(alone[name])})
    assert f"'{name}' is in {unit}, not in" in told(wrong)


@pytest.mark.parametrize("beside", ["wheel_angle", "wheel_velocity"])
def test_a_way_is_judged_by_the_rim_too(beside):
    table = a_run().select(["time", "plank_position", beside, "fx"])
    assert not told(table)
    way = table.with_columns(plank_position=table["plank_position"] / 0.3048)
    assert "'plank_position' is in ft" in told(way.with_info(step_position=float("nan")))


@pytest.mark.parametrize("speed", [0.002, 0.0015, 0.1, 0.3])
def test_a_run_of_any_speed_is_accepted(speed):
    table = a_run()
    factor = speed / 0.031
    columns = {name: table[name] * factor for name in
               ("plank_velocity", "wheel_velocity", "motor_velocity")}  # fmt: skip
    assert not told(table.with_columns(time=table["time"] / factor, **columns))


def test_without_other_columns_only_what_contradicts_itself_is_refused():
    table = a_run().select(["time", "plank_position", "fx"])
    assert not told(table)
    assert "'time' is in ms" in told(table.with_columns(time=1e3 * table["time"]))
    way = table.with_columns(plank_position=1e3 * table["plank_position"])
    assert "'plank_position' is in mm" in told(way.with_info(step_position=float("nan")))


def test_a_file_of_kilonewtons_without_a_unit_is_not_fitted(tmp_path, write_campaign):
    table = step_table(0.02)
    small = {name: table[name] / 1e3 for name in ("fx", "fy", "fz")}
    folder = write_campaign([table.with_columns(**small)], ".csv")
    campaign = Campaign.load(folder)
    assert not list(campaign.tables())
    (problem,) = campaign.problems
    assert "'fz' is 3.7 N in the mean, nominal 3.7e+03 N: 'fz' is in kn" in str(problem)


LATERAL = {"fx": 0.0, "fy": -0.5, "mx": 0.01, "my": -0.006, "mz": 0.012}
"""shares of the load, and of load times radius, of a car tire at a side slip of 3 deg"""


def a_lateral_run(size: float, **info):
    """Forces and moments of a tire of any size, a quarter of the way to the largest ones."""
    table = a_run(**info)
    load, radius = size**2 * 3700.0, size * 0.3108
    grown = np.linspace(0.0, 1.0, len(table))
    columns = {n: v * load * grown * (radius if n[0] == "m" else 1.0) for n, v in LATERAL.items()}
    columns["fx"] = load * np.minimum(20.0 * table.info.kappa + 0.01, 0.9) * grown
    columns["loaded_radius"] = size * table["loaded_radius"]
    columns |= {n: table[n] / size for n in ("wheel_angle", "wheel_velocity", "motor_velocity")}
    table = table.with_columns(fz=np.full(len(table), load), **columns)
    return table.with_info(fz=load, effective_rolling_radius=radius)


@pytest.mark.parametrize("size", [0.2, 1.0, 3.0])
@pytest.mark.parametrize(
    ("name", "unit", "factor"),
    [("fx", "kn", 1e3), ("fy", "kn", 1e3), ("mz", "knm", 1e3), ("mz", "nmm", 1e-3),
     ("mx", "nmm", 1e-3), ("my", "nmm", 1e-3)],
)  # fmt: skip
def test_one_force_or_moment_a_thousand_times_off_is_found_at_any_size(size, name, unit, factor):
    for kappa in (0.0, 0.005, 0.05):
        table = a_lateral_run(size, kappa=kappa)
        assert not told(table)
        wrong = told(table.with_columns(**{name: table[name] / factor}))
        assert f"'{name}' is in {unit}" in wrong and "\n" not in wrong


def test_a_locked_wheel_in_kilonewtons_is_refused():
    table = step_table(0.0, measurement="locked_wheel")
    table = table.with_columns(fx=np.full(len(table), -2900.0), wheel_angle=0.0 * table["time"])
    assert not told(table)
    assert "'fx' is in kn" in told(table.with_columns(fx=table["fx"] / 1e3))


def test_noise_of_a_channel_that_is_not_loaded_is_no_other_unit():
    table = a_lateral_run(1.0, kappa=0.0).with_info(alpha_deg=0.0)
    random = np.random.default_rng(1)
    noise = {name: 0.3 * random.standard_normal(len(table)) for name in ("fy", "mx", "my", "mz")}
    table = table.with_columns(side_slip_angle=0.0 * table["fx"], **noise)
    assert not told(table)


TURNS = {"-pi .. pi": -np.pi, "0 .. 2 pi": 0.0, "from where it stood": 1.234}


@pytest.mark.parametrize("low", TURNS.values(), ids=TURNS)
@pytest.mark.parametrize("way", [1.0, -1.0], ids=["forward", "backward"])
def test_a_wrapped_angle_is_that_which_numpy_unwraps(low, way):
    angle = way * np.cumsum(np.random.default_rng(1).uniform(0.0, 0.1, 500)) + 2.0
    wrapped = np.mod(angle - low, 2.0 * np.pi) + low
    columns, remarks = whole_turns({"wheel_angle": wrapped}, "a.csv")
    np.testing.assert_allclose(columns["wheel_angle"], np.unwrap(wrapped))
    assert np.ptp(columns["wheel_angle"]) == pytest.approx(np.ptp(angle))
    row = int(np.argmax(np.abs(np.diff(wrapped)) > np.pi)) + 2
    assert f"(row {row})" in remarks[0]


@pytest.mark.parametrize(("unit", "turn"), [("deg", 360.0), ("rev", 1.0)])
def test_turns_in_another_unit_are_refused_with_the_row(unit, turn):
    angle = np.mod(np.linspace(0.1, 2.4, 400), 1.0) * turn
    row = int(np.argmax(np.diff(angle) < 0.0)) + 2
    with pytest.raises(FlatplankError, match=f"row {row}.*one turn in {unit}"):
        whole_turns({"wheel_angle": angle}, "a.csv")


def test_a_jump_that_is_no_turn_is_refused_and_noise_is_none():
    table = step_table(0.05)
    angle = table["wheel_angle"].copy()
    angle[200:] += 5.0
    assert "row 201, column 'wheel_angle': jumps by 5" in told(
        table.with_columns(wheel_angle=angle)
    )
    still = 1e-4 * np.random.default_rng(2).standard_normal(300)
    for quiet in (still, np.zeros(300), np.linspace(0.0, 13.0, 300), np.array([0.0, 4.0])):
        columns, remarks = whole_turns({"wheel_angle": quiet}, "a.csv")
        assert columns["wheel_angle"] is quiet and not remarks


def test_a_wrapped_run_is_read_as_the_whole_one(write_campaign):
    table = step_table(0.05)
    wrapped = np.mod(table["wheel_angle"] + np.pi, 2.0 * np.pi) - np.pi
    campaign = Campaign.load(write_campaign([table.with_columns(wheel_angle=wrapped)]))
    (found,) = campaign.tables()
    np.testing.assert_allclose(found["wheel_angle"], table["wheel_angle"], atol=1e-12)
    assert any("turns are counted" in str(p) for p in campaign.problems)


def a_standing_run(kind: str, size: float):
    """A standing tire of any size: stiffness and patch in proportion to its pressure."""
    grown, radius = np.linspace(0.0, 1.0, 200), 0.3108 * size
    load, spring, still = 3700.0 * size**2, 2.0e5 * size, np.zeros(200)
    deep, creep = load / spring, 0.006 * size * grown
    columns = {
        "stiffness": {"loaded_radius": radius - deep * grown, "fz": load * grown},
        "stiffness_longitudinal": {"plank_position": creep, "fx": -0.5 * spring * creep,
                                   "fy": still, "fz": load + still, "wheel_angle": still},
        "stiffness_lateral": {"plank_position": creep, "fx": -0.4 * spring * creep,
                              "fy": -0.2 * spring * creep, "fz": load + still},
        "footprint": {"fz": load * np.array([0.5, 1.0, 1.5]),
                      "half_length": size * np.array([0.05, 0.071, 0.087]),
                      "half_width": size * np.array([0.062, 0.073, 0.079])},
    }[kind]  # fmt: skip
    alpha = 40.0 if kind == "stiffness_lateral" else 0.0
    record = RunRecord(
        file=f"{kind}.csv", measurement=kind, pressure=2.5, alpha_deg=alpha,
        effective_rolling_radius=radius,
    )  # fmt: skip
    return MeasurementTable(columns, record)


STANDING = {
    "stiffness": (("fz", "kn", 1e3), ("loaded_radius", "mm", 1e-3)),
    "stiffness_longitudinal": (
        ("fz", "kn", 1e3), ("fx", "kn", 1e3), ("plank_position", "mm", 1e-3),
    ),
    "stiffness_lateral": (("fy", "kn", 1e3), ("fx", "kn", 1e3), ("plank_position", "mm", 1e-3)),
    "footprint": (("fz", "kn", 1e3), ("half_length", "mm", 1e-3), ("half_width", "mm", 1e-3)),
}  # fmt: skip
STANDING_CASES = [(kind, *case) for kind, cases in STANDING.items() for case in cases]


@pytest.mark.parametrize("size", [0.5, 1.0, 2.0])
@pytest.mark.parametrize(("kind", "name", "unit", "factor"), STANDING_CASES)
def test_a_standing_tire_in_another_unit_is_refused_at_any_size(kind, name, unit, factor, size):
    table = a_standing_run(kind, size)
    assert not told(table)
    wrong = told(table.with_columns(**{name: table[name] / factor}))
    assert f"'{name}' is in {unit}" in wrong and "\n" not in wrong
    unknown = table.with_info(effective_rolling_radius=float("nan"))
    wrong = told(unknown.with_columns(**{name: table[name] / factor}))
    assert f"'{name}' is in {unit}" in wrong


@pytest.mark.parametrize("kind", STANDING)
@pytest.mark.parametrize("share", [0.2, 0.5, 2.0])
def test_a_standing_run_far_from_its_nominal_load_and_pressure_is_accepted(kind, share):
    table = a_standing_run(kind, 1.0)
    forces = {name: share * table[name] for name in ("fx", "fy", "fz") if name in table}
    soft = table.with_columns(**forces).with_info(pressure=2.5 * share)
    assert not told(soft)
    held = kind in ("stiffness_longitudinal", "stiffness_lateral")
    assert held or not told(soft.with_info(fz=3700.0))


def test_a_print_with_its_pressure_in_bar_is_refused():
    table = a_standing_run("footprint", 1.0).with_info(pressure=float("nan"))
    pressure = np.array([2.0, 2.5, 2.8])
    assert not told(table.with_columns(pressure=1e5 * pressure))
    assert "'pressure' is in bar, not in pa" in told(table.with_columns(pressure=pressure)).lower()
