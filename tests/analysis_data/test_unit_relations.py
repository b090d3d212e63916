# SPDX-License-Identifier: Apache-2.0
"""What is known of a run several times: quotients of made-up runs, worked out by hand."""

from __future__ import annotations

import math

import pytest

from flatplank_data.machine import FAST, SLOW, USUAL_RADIUS
from flatplank_data.run_record import RunRecord
from flatplank_data.table import MeasurementTable
from flatplank_data.unit_checks import RELATIONS, WrongUnit, wrong_units
from flatplank_data.unit_relations import Relation, relation

HALF = 0.5 * math.log(1000.0)
"""uncertainty of what is known by its order of magnitude"""
THREE = math.log(3.0)
SPEEDS = 0.5 * math.log(0.03092 / 0.0015)
"""uncertainty of the speed of the plank"""
INF = math.inf


def of(kind: str, columns: dict, **info) -> dict[str, Relation]:
    """Relations of a run by their text."""
    table = MeasurementTable(columns, RunRecord(measurement=kind, **info))
    return {one.text: one for part in RELATIONS[kind] for one in part(table)}


def assert_same(found: dict[str, Relation], expected: dict) -> None:
    """`expected`: text -> quotient, powers, slack below and above."""
    assert found.keys() == expected.keys()
    for text, (quotient, powers, below, above) in expected.items():
        one = found[text]
        assert one.off == pytest.approx(math.log(quotient), abs=1e-9), text
        assert one.powers == powers, text
        assert (one.below, one.above) == pytest.approx((below, above)), text


def only(found: dict[str, Relation], begin: str) -> Relation:
    """The relation whose text begins so."""
    (one,) = [one for text, one in found.items() if text.startswith(begin)]
    return one


def test_a_relation_is_what_is_left_beyond_its_slack():
    one = Relation("", 2.0, {"x": 1, "t": -2}, below=0.5, above=0.25)
    assert one.rest() == pytest.approx(1.75)
    assert one.rest("y", math.e) == pytest.approx(1.75)
    assert one.rest("x", math.e) == pytest.approx(2.75)
    assert one.rest("t", math.e) == 0.0  # exp(0) is within the slack
    assert one.rest("x", math.exp(-2.4)) == 0.0
    assert one.rest("x", math.exp(-3.0)) == pytest.approx(0.5)
    assert one.rest("t", math.exp(2.0)) == pytest.approx(1.5)


@pytest.mark.parametrize(
    ("one", "other"), [(0.0, 1.0), (1.0, 0.0), (math.nan, 1.0), (1.0, math.nan), (INF, 1.0)]
)
def test_there_is_no_relation_of_what_is_no_number_or_zero(one, other):
    assert list(relation("{} {}", one, other, "m", {})) == []


def test_a_relation_compares_amounts():
    (one,) = relation("{}, {}", -30.0, 15.0, "N", {"fx": 1}, 0.1, 0.2)
    assert one == Relation("30 N, 15 N", math.log(2.0), {"fx": 1}, 0.1, 0.2)


HELD = {
    "fz": [4900.0, math.nan, 5100.0], "pressure": [3e5, 3e5, math.nan],
    "side_slip_angle": [0.1, 0.1, 0.1], "camber_angle": [0.05, 0.05, 0.05],
    "total_camber": [0.02, 0.03, 0.04], "loaded_radius": [0.27, 0.28, 0.29],
}  # fmt: skip
NOMINAL = {
    "fz": 4000.0, "pressure": 2.5, "alpha_deg": 4.5, "gamma_deg": 1.8,
    "effective_rolling_radius": 0.3,
}  # fmt: skip
OF_RECORD = {
    "'fz' is 5e+03 N in the mean, nominal 4e+03 N": (1.25, {"fz": 1}, 0.0, 0.0),
    "'pressure' is 3e+05 Pa in the mean, nominal 2.5e+05 Pa": (1.2, {"pressure": 1}, 0.0, 0.0),
    "'side_slip_angle' is 0.1 rad in the mean, nominal 0.0785 rad": (
        4.0 / math.pi, {"side_slip_angle": 1}, 0.0, 0.0,
    ),
    "'camber_angle' is 0.05 rad in the mean, nominal 0.0314 rad": (
        5.0 / math.pi, {"camber_angle": 1}, 0.0, 0.0,
    ),
    "'total_camber' is 0.03 rad in the mean, nominal 0.0314 rad": (
        3.0 / math.pi, {"total_camber": 1}, 0.0, 0.0,
    ),
    "'loaded_radius' is 0.28 m in the mean, nominal 0.3 m": (
        2.8 / 3.0, {"loaded_radius": 1}, 0.0, 0.0,
    ),
}  # fmt: skip


def test_what_is_held_is_compared_with_its_nominal_value():
    found = of("locked_wheel", HELD, **NOMINAL)
    assert_same({text: one for text, one in found.items() if "nominal" in text}, OF_RECORD)


@pytest.mark.parametrize(
    ("kind", "changes"),
    [("slip", ()), ("cleat", ()), ("free_rolling", ()), ("stiffness", ("fz",)),
     ("stiffness_vertical", ("fz",)), ("stiffness_longitudinal", ()), ("stiffness_lateral", ()),
     ("footprint", ("fz", "pressure"))],
)  # fmt: skip
def test_what_changes_in_a_run_has_no_nominal_value(kind, changes):
    columns = {**HELD, "plank_position": [0.0, 0.1, 0.2]}
    nominal = {text.split("'")[1] for text in of(kind, columns, **NOMINAL) if "nominal" in text}
    assert nominal == {*HELD} - {*changes}


MOVED = {
    "time": [0.0, 10.0, 30.0, 40.0, 60.0],
    "plank_position": [0.5, 1.0, 1.5, 2.0, 9.0],
    "plank_velocity": [0.04, 0.08, 0.02, 0.06, 9.0],
    "wheel_angle": [3.0, 2.0, 1.0, -3.0, 90.0],
    "wheel_velocity": [0.1, 0.1, 0.2, 0.3, 9.0],
    "motor_velocity": [142.504, 142.504, 142.504, 142.504, 9.0],
}
"""up to the step 1.5 m in 40 s, by its speed 2 m, by its rim 1.8 m, by the speed of that 1.95 m"""


def test_the_ways_up_to_the_step_are_compared():
    found = of("slip", MOVED, effective_rolling_radius=0.3, step_position=2.0, kappa=0.2)
    speed = f"usual are {math.sqrt(0.03092 * 0.0015):.3g} m/s"
    assert_same(found, {
        f"the plank runs at 0.0375 m/s, {speed}": (
            1.0, {"plank_position": 1, "time": -1}, SPEEDS, SPEEDS,
        ),
        "the plank travels 2 m by its speed, 1.5 m by its position": (
            2.0 / 1.5, {"plank_velocity": 1, "time": 1, "plank_position": -1}, 0.0, 0.0,
        ),
        "the rim travels 1.8 m at a radius of 0.3 m, the plank 1.5 m": (
            1.2, {"wheel_angle": 1, "plank_position": -1}, 0.0, 0.0,
        ),
        "the rim travels by its speed 1.95 m at a radius of 0.3 m, the plank 1.5 m": (
            1.3, {"wheel_velocity": 1, "time": 1, "plank_position": -1}, 0.0, 0.0,
        ),
        "the wheel turns by 4 rad by its motor, by 6.5 rad by its own speed": (
            4.0 / 6.5, {"motor_velocity": 1, "wheel_velocity": -1}, 0.0, 0.0,
        ),
    })  # fmt: skip


def test_without_rows_before_the_step_the_rim_slips():
    """Two rows up to the step are too few; a row without a stamp is left out."""
    columns = {name: MOVED[name] for name in ("time", "plank_position", "wheel_angle")}
    columns = {name: [*values[:4], math.nan, 1.0] for name, values in columns.items()}
    columns["plank_position"] = [0.5, 1.0, 1.5, 2.0, 7.0, math.nan]
    found = of("slip", columns, effective_rolling_radius=0.3, step_position=1.0, kappa=0.2)
    assert only(found, "the rim").off == pytest.approx(math.log(1.8 / (1.5 * 1.2)), abs=1e-9)
    three = of("slip", columns, effective_rolling_radius=0.3, step_position=1.5, kappa=0.2)
    assert only(three, "the rim").off == pytest.approx(math.log(0.6 / 1.0))


@pytest.mark.parametrize(("rows", "relations"), [(2, 0), (3, 1)])
def test_a_way_needs_three_rows(rows, relations):
    columns = {name: MOVED[name][:rows] for name in ("time", "plank_position")}
    assert len(of("slip", columns)) == relations


@pytest.mark.parametrize("speed", [5e-5, 31.0])
def test_a_speed_counts_beyond_half_a_thousand_of_the_usual_ones(speed):
    """`SPEEDS` is what the fast and the slow speed are from the mean."""
    one = only(of("slip", {"time": [0.0, 1.0, 2.0], "plank_position": [0.0, speed, 2.0 * speed]}),
               "the plank runs")  # fmt: skip
    usual = math.sqrt(SLOW * FAST)
    assert one.off == pytest.approx(math.log(speed / usual) if speed == 31.0 else 0.0)
    assert one.rest() == pytest.approx(math.log(31.0 / FAST) if speed == 31.0 else 0.0)


def test_a_clock_that_stands_tells_no_speed():
    columns = {"time": [5.0, 5.0, 5.0], "plank_position": [0.0, 1.0, 2.0]}
    assert of("slip", columns) == {}


@pytest.mark.parametrize("name", ["wheel_angle", "wheel_velocity", "both"])
@pytest.mark.parametrize(("share", "turns"), [(0.049, False), (0.051, True)])
def test_a_wheel_that_stands_tells_nothing_of_the_way(name, share, turns):
    """Its rim travels less than a twentieth of the road."""
    by = {"wheel_angle": [0.0, 1.0, 2.0 * share], "wheel_velocity": [share] * 3}
    by["wheel_angle"][1] = share
    columns = {"time": [0.0, 1.0, 2.0], "plank_position": [0.0, 0.4, 0.8]}
    columns |= by if name == "both" else {name: by[name]}
    found = of("slip", columns, effective_rolling_radius=0.4)
    assert any("rim" in text for text in found) == turns


@pytest.mark.parametrize("quotient", [1.1, 40.0])
def test_an_unknown_radius_is_the_usual_one_and_coarse(quotient):
    turned = quotient * 0.8 / USUAL_RADIUS
    columns = {"time": [0.0, 1.0, 2.0], "plank_position": [0.0, 0.4, 0.8]}
    columns |= {"wheel_angle": [0.0, 0.3, turned], "wheel_velocity": [0.5 * turned] * 3}
    found = of("slip", columns)
    off = math.log(40.0) if quotient == 40.0 else 0.0
    rims = [one for text, one in found.items() if "rim" in text]
    assert [one.off for one in rims] == pytest.approx([off, off])
    assert [(one.below, one.above) for one in rims] == [(0.0, 0.0)] * 2
    assert sum("radius of 0.311 m" in text for text in found) == 2


FORCES = {
    "fx": [300.0, -700.0, 100.0], "fy": [20.0, 10.0, -5.0], "fz": [3000.0, -4000.0, 5000.0],
    "mx": [1.0, -30.0, 2.0], "my": [-4.0, 3.0, 2.0], "mz": [50.0, 40.0, -60.0],
}  # fmt: skip


def moments(radius: float, load: float = 4000.0) -> dict:
    """Relations of the moments of `FORCES`."""
    most = {"mx": 30.0, "my": 4.0, "mz": 60.0}
    return {
        f"'{name}' goes up to {value:.3g} N m, load times radius is {load * radius:.3g} N m": (
            value / (load * radius), {name: 1, "fz": -1}, INF, THREE,
        )
        for name, value in most.items()
    }  # fmt: skip


def usual_force(name: str, largest: float, usual: float) -> dict:
    text = f"'{name}' goes up to {largest:.3g} N, usual is {usual:.3g} N at this load and slip"
    return {text: (largest / usual, {name: 1, "fz": -1}, HALF, INF)}


@pytest.mark.parametrize(
    ("kind", "kappa", "share"),
    [("slip", 0.01, 0.2), ("slip", -0.01, 0.2), ("slip", -0.3, 1.0), ("slip", 0.0, 0.01),
     ("locked_wheel", 0.0, 1.0)],
)  # fmt: skip
def test_forces_are_known_by_load_and_slip(kind, kappa, share):
    """20 times the slip, friction at most, the rolling resistance at least."""
    columns = {**FORCES, "plank_position": [0.0, math.nan, math.nan]}
    found = of(kind, columns, kappa=kappa, effective_rolling_radius=0.35)
    assert_same(found, {**usual_force("fx", 700.0, share * 4000.0), **moments(0.35)})


def test_a_tire_that_slips_to_one_side_has_a_side_force_and_a_trail():
    found = of("locked_wheel", FORCES, alpha_deg=-2.0)
    side = 20.0 * math.tan(2.0 * math.pi / 180.0) * 4000.0
    trail = 0.1 * 0.3108 * 20.0
    assert_same(found, {
        **usual_force("fx", 700.0, 4000.0), **usual_force("fy", 20.0, side), **moments(0.3108),
        f"'mz' goes up to 60 N m, side force times trail is {trail:.3g} N m": (
            60.0 / trail, {"mz": 1, "fy": -1}, HALF, INF,
        ),
    })  # fmt: skip


def test_without_a_load_nothing_is_known_of_forces():
    assert of("locked_wheel", {"fx": [1.0, 2.0], "mz": [1.0, 2.0]}) == {}


def about(text: str, value: float, usual: float, unit: str, powers: dict) -> dict:
    """A relation of orders of magnitude."""
    return {
        text.format(f"{value:.3g} {unit}", f"{usual:.3g} {unit}"): (
            value / usual, powers, HALF, HALF,
        )
    }  # fmt: skip


BY_PRESSURE = {"pressure": -1}
LOADED = "'fz' is {} in the mean, usual is {} at this pressure"


@pytest.mark.parametrize("column", [True, False], ids=["pressure measured", "of the record"])
def test_a_tire_that_is_pressed_onto_the_road(column):
    columns = {"fz": [0.0, 1000.0, 2000.0], "loaded_radius": [0.33, 0.32, 0.31]}
    columns |= {"pressure": [2e5, 2e5, 2e5]} if column else {}
    found = of("stiffness", columns, pressure=2.0, effective_rolling_radius=0.4)
    by = BY_PRESSURE if column else {}
    found = {text: one for text, one in found.items() if "nominal" not in text}
    stroke = {"fz": 1, "loaded_radius": -1}
    assert_same(found, {
        **about("'loaded_radius' is {} in the mean, usual is {}", 0.32, 0.4, "m",
                {"loaded_radius": 1}),
        **about(LOADED, 1000.0, 0.15 * 2e5 * 0.16, "N", by | {"fz": 1}),
        **about("the load changes by {}, usual is {} at this stroke and pressure",
                2000.0, 2.7 * 2e5 * 0.4 * 0.02, "N", by | stroke),
    })  # fmt: skip


def test_a_held_wheel_under_which_the_road_creeps():
    columns = {
        "fx": [0.0, -300.0, -900.0], "fy": [0.0, 100.0, 400.0], "fz": [3000.0, 4000.0, 5000.0],
        "plank_position": [0.2, 0.202, 0.206], "mz": [1.0, 2.0, -60.0],
    }  # fmt: skip
    found = of("stiffness_lateral", columns, pressure=2.0, alpha_deg=-30.0,
               effective_rolling_radius=0.4)  # fmt: skip
    found = {text: one for text, one in found.items() if "nominal" not in text}
    trail = 0.1 * 0.4 * 400.0
    expected = about(LOADED, 4000.0, 0.15 * 2e5 * 0.16, "N", {"fz": 1})
    for name, most, share in (("fx", 900.0, math.sqrt(0.75)), ("fy", 400.0, 0.5)):
        usual = 2.7 * 2e5 * 0.4 * share * 0.006
        text = f"'{name}' goes up to {{}}, usual is {{}} at this travel and pressure"
        expected |= about(text, most, usual, "N", {name: 1, "plank_position": -1})
        text = f"'{name}' goes up to {most:.3g} N, the load is 4e+03 N"
        expected[text] = (most / 4000.0, {name: 1, "fz": -1}, INF, HALF)
    text = "'mz' goes up to 60 N m, load times radius is 1.6e+03 N m"
    expected[text] = (60.0 / 1600.0, {"mz": 1, "fz": -1}, INF, THREE)
    text = f"'mz' goes up to 60 N m, side force times trail is {trail:.3g} N m"
    expected[text] = (60.0 / trail, {"mz": 1, "fy": -1}, HALF, INF)
    assert_same(found, expected)


def test_a_print_carries_its_load_by_its_pressure():
    columns = {"fz": [1000.0, 3000.0], "half_length": [0.05, 0.07], "half_width": [0.07, 0.09],
               "pressure": [2.5e5, 3.5e5]}  # fmt: skip
    found = of("footprint", columns, pressure=9.0, effective_rolling_radius=0.4)
    assert_same(found, {
        **about("'half_length' is {} in the mean, usual is {}", 0.06, 0.23 * 0.4, "m",
                {"half_length": 1}),
        "'half_width' is 0.08 m in the mean, 'half_length' 0.06 m": (
            8.0 / 6.0, {"half_width": 1, "half_length": -1}, HALF, HALF,
        ),
        **about("'fz' is {} in the mean, usual is {} on this length at this pressure",
                2000.0, 3e5 * 4.0 * 0.0036, "N", BY_PRESSURE | {"fz": 1, "half_length": -2}),
    })  # fmt: skip


def units_told(monkeypatch, *relations: Relation) -> list[tuple[str, str]]:
    """Columns and units that are told of a run of which this is known."""
    monkeypatch.setitem(RELATIONS, "toy", (lambda table: iter(relations),))
    found = wrong_units(MeasurementTable({}, RunRecord(measurement="toy")))
    assert all(isinstance(one, WrongUnit) for one in found)
    return [(one.column, one.unit) for one in found]


FEET = -math.log(0.3048)


@pytest.mark.parametrize(
    ("off", "told"),
    [
        (0.0, []),
        (-math.log(1e3), [("fz", "kn")]),
        (math.log(1e3), []),  # no unit of a force is a thousandth of a newton
        (-math.log(10.0), [("fz", "dan"), ("fz", "kgf")]),  # 2 % apart: both explain it
        (-math.log(4.4482216152605), [("fz", "lbf")]),
    ],
)
def test_the_unit_that_explains_a_quotient_is_told(monkeypatch, off, told):
    assert units_told(monkeypatch, Relation("", off, {"fz": 1})) == told


@pytest.mark.parametrize(("more", "told"), [(0.005, []), (0.015, [("loaded_radius", "ft")])])
def test_a_unit_is_wrong_where_another_explains_more_than_2_percent(monkeypatch, more, told):
    """Half of the way from metres to feet, and a little more."""
    one = Relation("", 0.5 * FEET + more, {"loaded_radius": 1})
    assert units_told(monkeypatch, one) == told


def test_every_column_that_explains_the_quotients_is_told_with_the_worst_of_them(monkeypatch):
    mild = Relation("mild", 1e-3 - math.log(1e3), {"fx": 1, "fy": -1}, above=1.0)
    worst = Relation("worst", -math.log(1e3), {"fx": 1})
    assert units_told(monkeypatch, mild, worst) == [("fx", "kn")]
    monkeypatch.setitem(RELATIONS, "toy", (lambda table: [mild], lambda table: [worst]))
    (wrong,) = wrong_units(MeasurementTable({}, RunRecord(measurement="toy")))
    assert wrong == WrongUnit("fx", "kn", "N", "worst")


def test_of_other_measurements_nothing_is_known():
    table = MeasurementTable({"fz": [1.0, 2.0]}, RunRecord(measurement="unloaded_turn", fz=9.0))
    assert wrong_units(table) == []
