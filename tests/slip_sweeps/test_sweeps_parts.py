# SPDX-License-Identifier: Apache-2.0
"""Parts of the sweeps against what is known by hand: levels, bins, curves, units, verdict."""

from __future__ import annotations

import math
from dataclasses import fields

import numpy as np
import pytest
from scipy.stats import f as f_distribution

from flatplank_analysis.slip_sweeps.channels import BY_NAME as CHANNEL
from flatplank_analysis.slip_sweeps.channels import (
    CHANNELS,
    channel_named,
    check_values,
    columns_of,
    in_si,
    sizes,
)
from flatplank_analysis.slip_sweeps.conditions import (
    BINS,
    BY_NAME,
    SweepCondition,
    levels,
    not_held,
    split_into_conditions,
)
from flatplank_analysis.slip_sweeps.curves import (
    Failure,
    bin_means,
    curve_of,
)
from flatplank_analysis.slip_sweeps.formula import fit_formula
from flatplank_analysis.slip_sweeps.study import Study, by_level
from flatplank_analysis.slip_sweeps.verdict import (
    LONGEST,
    RISK,
    chance_of,
    degrees_of_freedom,
    fails,
)
from flatplank_data.errors import FlatplankError


def test_samples_between_two_levels_belong_to_none():
    """A load that takes 60 samples from 1000 to 2000 N."""
    ramp = np.linspace(1000.0, 2000.0, 60)
    load = np.concatenate([np.full(3000, 1000.0), ramp, np.full(3000, 2000.0)])
    centers, names = levels(BY_NAME["fz"], load)
    assert centers == pytest.approx([1000.0, 2000.0])
    assert set(names[:3000]) == {0} and set(names[-3000:]) == {1}
    assert set(names[3015:3045]) == {-1}


@pytest.mark.parametrize(
    ("name", "values", "count"),
    [
        ("fz", (1000.0, 1010.0), 1),
        ("fz", (1000.0, 1300.0), 2),
        ("gamma", np.radians((0.0, 0.1)), 1),
        ("gamma", np.radians((0.0, 2.0, 4.0)), 3),
        ("gamma", np.radians((-2.0, 2.0)), 2),
        ("kappa", (0.0, 0.1), 2),
        ("speed", (10.0, 20.0), 2),
    ],
)
def test_levels_are_as_far_apart_as_the_channel_says(name, values, count):
    centers, names = levels(BY_NAME[name], np.repeat(values, 200))
    assert len(centers) == count
    assert bool(BY_NAME[name].several(values)) is (count > 1)
    assert set(names) == set(range(count))


def test_a_level_of_few_samples_is_a_transition():
    load = np.concatenate([np.full(3000, 1000.0), np.full(15, 1500.0), np.full(3000, 2000.0)])
    centers, names = levels(BY_NAME["fz"], load)
    assert list(centers) == [1000.0, 2000.0]
    assert set(names[3000:3015]) <= {-1, 0, 1}


@pytest.mark.parametrize(
    ("name", "value", "word"),
    [("fz", 1200.0, "1200 N"), ("gamma", math.radians(4.0), "4 deg"), ("kappa", -0.05, "-5 %"),
     ("pressure", 83e3, "83 kPa"), ("speed", 40.0 / 3.6, "40 km/h"), ("gamma", -1e-12, "0 deg")],
)  # fmt: skip
def test_a_level_is_said_in_the_units_of_people(name, value, word):
    assert BY_NAME[name].word(value) == word


def test_rows_in_no_order_of_time_are_seen():
    load = np.repeat([1000.0, 2000.0], 300)
    assert not_held({"fz": load}) is None
    drawn = np.random.default_rng(1).permutation(np.repeat([1000.0, 1500.0, 2000.0], 200))
    assert not_held({"fz": drawn}) is BY_NAME["fz"]


def a_sweep(force, passes: int = 2, load: float = 1000.0, lead: int = 0) -> dict[str, np.ndarray]:
    """Slip angle up and down between 6 deg; `force` of slip [rad] and of its direction."""
    up = np.radians(np.linspace(-6.0, 6.0, 400))
    alpha = np.concatenate([np.full(lead, up[0]), *([up, up[::-1]] * passes)])
    rises = np.gradient(alpha) > 0.0
    return {"alpha": alpha, "fz": np.full(len(alpha), load), "fy": force(alpha, rises)}


def the_curve(columns):
    (condition,) = split_into_conditions(columns)
    return condition, curve_of(columns, condition)


def test_the_floor_is_half_of_what_up_and_down_differ_by():
    _, curve = the_curve(a_sweep(lambda a, up: -1e4 * a + np.where(up, 15.0, -15.0)))
    assert curve.floor == pytest.approx(15.0, rel=0.05)
    inner = slice(2, -2)
    assert curve.up[inner] - curve.down[inner] == pytest.approx(30.0, abs=2.0)
    assert curve.force == pytest.approx(-1e4 * curve.slip, abs=8.0)


def test_bins_divide_the_range_of_the_slip_evenly():
    _, curve = the_curve(a_sweep(lambda a, _up: -1e4 * a))
    assert curve.bins.min() == 0 and curve.bins.max() == BINS - 1
    middles = math.radians(12.0) * ((np.arange(BINS) + 0.5) / BINS - 0.5)
    assert curve.slip == pytest.approx(middles, abs=math.radians(12.0) / BINS / 20.0)


def test_a_held_slip_belongs_to_the_way_that_led_to_it():
    """Stairs up and down; the force of each step differs by 30 N between the ways."""
    stairs = np.radians(np.repeat(np.arange(-6.0, 6.5, 0.5), 50))
    alpha = np.concatenate([stairs, stairs[::-1]])
    way = np.repeat([15.0, -15.0], len(stairs))
    columns = {"alpha": alpha, "fz": np.full(len(alpha), 1000.0), "fy": -1e4 * alpha + way}
    _, curve = the_curve(columns)
    filled = np.flatnonzero(np.isfinite(curve.up - curve.down))[1:-1]
    assert len(filled) > 15
    assert (curve.up - curve.down)[filled] == pytest.approx(30.0, abs=2.0)


@pytest.mark.parametrize("moved", [30.0, -50.0])
def test_the_floor_is_half_of_what_a_condition_measured_twice_differs_by(moved):
    """However much rising and falling slip differ."""
    twice = [
        a_sweep(lambda a, up, o=o: -1e4 * a + np.where(up, 100.0, -100.0) + o, passes=1)
        for o in (0.0, moved)
    ]
    between = a_sweep(lambda a, _up: -1e4 * a, passes=1, load=2000.0)
    columns = {k: np.concatenate([twice[0][k], between[k], twice[1][k]]) for k in between}
    condition, other = split_into_conditions(columns)
    curve = curve_of(columns, condition)
    assert condition.visits == 2 and other.visits == 1
    assert curve.floor == pytest.approx(0.5 * abs(moved), rel=1e-6)
    assert curve.floor_from == "repeats of a condition"
    assert curve_of(columns, other).floor_from == "up and down through the same values"


def test_a_slip_that_was_passed_once_has_no_floor():
    columns = {k: v[:400] for k, v in a_sweep(lambda a, _up: -1e4 * a).items()}
    _, curve = the_curve(columns)
    assert math.isnan(curve.floor) and math.isnan(curve.freedom)


def test_a_bin_with_fewer_than_three_samples_is_empty():
    bins = np.array([0, 0, 1, 1, 1, 3, 3, 3, 3])
    values = np.array([1.0, 3.0, 1.0, 2.0, 6.0, 1.0, 1.0, 1.0, 5.0])
    means = bin_means(bins, values)
    assert means.shape == (BINS,)
    np.testing.assert_array_equal(means[:4], [np.nan, 3.0, np.nan, 2.0])
    assert np.isnan(means[4:]).all()
    some = bin_means(bins, values, np.arange(9) != 8)
    np.testing.assert_array_equal(some[:4], [np.nan, 3.0, np.nan, 1.0])


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_formula_is_that_which_made_the_curve(sign):
    b, c, d, e, sh, sv = 12.0, 1.5, 900.0, -0.4, math.radians(0.3), 30.0

    def force(a, _up):
        x = b * (a + sh)
        return sign * (d * np.sin(c * np.arctan(x - e * (x - np.arctan(x)))) + sv)

    columns = a_sweep(force)
    columns["alpha"] = 2.5 * columns["alpha"]
    columns["fy"] = force(columns["alpha"], None)
    _, curve = the_curve(columns)
    formula = fit_formula(curve)
    wanted = {"B": b, "C": c, "D": sign * d, "E": e, "Sh": sh, "Sv": sign * sv}
    for name, value in wanted.items():
        assert formula.values[name] == pytest.approx(value, rel=0.02, abs=1e-4), name
    assert formula.stiffness == pytest.approx(sign * b * c * d, rel=0.02)
    assert formula.rms < 0.5 and all(formula.known(name) for name in "BCD")
    assert formula(curve.slip) == pytest.approx(curve.force, abs=3.0)


def test_the_intervals_and_the_rms_are_those_of_the_scatter():
    """Fits of the same curve with other noise: 90 % of them lie within 1.64 standard deviations;
    the mean of n samples scatters by the noise over the root of n."""
    noise = 40.0
    alpha = np.radians(np.tile(np.linspace(-15.0, 15.0, 300), 4))
    exact = -900.0 * np.sin(1.5 * np.arctan(12.0 * alpha))
    draw, found = np.random.default_rng(4), []
    for _ in range(40):
        fy = exact + draw.normal(0.0, noise, len(alpha))
        _, curve = the_curve({"alpha": alpha, "fz": np.full(len(alpha), 1000.0), "fy": fy})
        found.append(fit_formula(curve))
    rms = np.sqrt(np.mean([f.rms**2 for f in found]))
    assert rms == pytest.approx(noise * np.sqrt(BINS / len(alpha) * (1.0 - 6.0 / BINS)), rel=0.15)
    for name in ("D", "Sh", "Sv"):
        scatter = np.std([f.values[name] for f in found])
        width = np.median([f.spread[name] for f in found])
        assert width == pytest.approx(1.645 * scatter, rel=0.35), name


def test_few_bins_are_no_formula():
    _, curve = the_curve(a_sweep(lambda a, _up: -1e4 * a))
    bare = np.where(np.arange(BINS) < 7, curve.force, np.nan)
    assert fit_formula(curve.__class__(**{**vars(curve), "force": bare})) is None


def test_a_condition_measured_twice_is_two_visits():
    one = a_sweep(lambda a, _up: -1e4 * a, passes=1)
    two = a_sweep(lambda a, _up: -1e4 * a, passes=1, load=2000.0)
    columns = {k: np.concatenate([one[k], two[k], one[k]]) for k in one}
    found = {round(c.held["fz"]): c.visits for c in split_into_conditions(columns)}
    assert found == {1000: 2, 2000: 1}
    assert [c.label for c in split_into_conditions(columns)] == [
        "slip angle swept, 1000 N", "slip angle swept, 2000 N"
    ]  # fmt: skip


def test_an_unloaded_tire_belongs_to_no_condition():
    columns = a_sweep(lambda a, _up: -1e4 * a)
    columns["fz"][:100] = 30.0
    (condition,) = split_into_conditions(columns)
    assert isinstance(condition, SweepCondition) and condition.samples.min() >= 100


def test_sweeps_of_both_slips_in_one_file_are_conditions_of_their_own():
    side = a_sweep(lambda a, _up: -1e4 * a)
    zero = np.zeros(len(side["fy"]))
    one = {**side, "kappa": zero, "fx": zero}
    two = {"alpha": zero, "kappa": side["alpha"], "fx": -side["fy"], "fy": zero, "fz": side["fz"]}
    columns = {k: np.concatenate([one[k], two[k]]) for k in one}
    first, second = split_into_conditions(columns)
    assert (first.swept, second.swept) == ("alpha", "kappa")
    assert first.samples.max() < len(zero) <= second.samples.min()
    assert len(first.samples) > 0.9 * len(zero) and len(second.samples) > 0.9 * len(zero)


def test_what_the_error_depends_on_is_its_mean_at_each_level():
    held = [{"fz": f, "gamma": 0.0} for f in (1000.0, 2000.0, 1000.0)]
    conditions = [SweepCondition("alpha", at, np.arange(9), 1) for at in held]
    found = [Failure(1.0, share, np.zeros(1), 0.0, 0.0, 0.5) for share in (0.02, 0.3, 0.04)]
    assert list(by_level(conditions, found)) == ["by load: 3 % at 1000 N, 30 % at 2000 N"]
    backwards = list(by_level(conditions[1:], found[1:]))
    assert backwards == ["by load: 4 % at 1000 N, 30 % at 2000 N"]


@pytest.mark.parametrize(
    ("name", "most", "unit", "si"),
    [
        ("pressure", 2.5, "bar", 2.5e5), ("pressure", 32.0, "psi", 32.0 * 6894.757293168),
        ("pressure", 240.0, "kPa", 2.4e5), ("pressure", 2.4e5, "Pa", 2.4e5),
        ("alpha", 0.2, "rad", 0.2), ("alpha", 12.0, "deg", math.radians(12.0)),
        ("gamma", 4.0, "deg", math.radians(4.0)), ("kappa", 0.3, "-", 0.3),
        ("kappa", 30.0, "%", 0.3), ("fz", 4.0, "kN", 4000.0), ("fy", 900.0, "N", 900.0),
        ("speed", 16.0, "m/s", 16.0), ("speed", 60.0, "km/h", 60.0 / 3.6),
    ],
)  # fmt: skip
def test_a_unit_that_is_not_said_follows_from_the_size(name, most, unit, si):
    values, assumed = in_si(CHANNEL[name], np.array([-most, most]), None, most, "a.csv")
    assert assumed == unit
    assert values == pytest.approx([-si, si], rel=1e-12)


def test_a_unit_that_is_said_is_taken_and_a_bare_one_is_none():
    values = np.array([4.0])
    assert in_si(CHANNEL["fz"], values, "N", 4.0, "") == (values, "")
    assert in_si(CHANNEL["fz"], values, "-", 4.0, "")[1] == "kN"
    assert in_si(CHANNEL["kappa"], values, "-", 4.0, "") == (values, "")
    with pytest.raises(FlatplankError, match="does not fit"):
        in_si(CHANNEL["fz"], values, "deg", 4.0, "a.csv")


def test_forces_have_the_unit_of_the_load_and_angles_that_of_the_larger():
    given = {"fz": [-3000.0, np.nan], "fy": [20.0, 1.0], "alpha": [12.0, 0.0], "gamma": [0.5, 0.1]}
    found = sizes({name: np.array(values) for name, values in given.items()})
    assert found == {"fz": 3000.0, "fy": 3000.0, "alpha": 12.0, "gamma": 12.0}


@pytest.mark.parametrize("channel", CHANNELS, ids=lambda c: c.name)
def test_a_channel_has_all_of_its_names_and_the_first_of_a_file_is_used(channel):
    for name in channel.names:
        for written in (name, name.upper(), name.replace(" ", "_"), name.replace(" ", "-")):
            assert channel_named(written) == channel.name, written
    both = [channel.names[-1], channel.names[0], "other"]
    assert columns_of(both, {}, "a.csv") == {channel.name: channel.names[0]}
    assert columns_of(both, {channel.name: "other"}, "a.csv") == {channel.name: "other"}
    with pytest.raises(FlatplankError, match="no column 'gone'"):
        columns_of(both, {channel.name: "gone"}, "a.csv")
    with pytest.raises(FlatplankError, match="no channel 'nonsense'"):
        columns_of(both, {"nonsense": "other"}, "a.csv")


@pytest.mark.parametrize(
    ("changed", "factor", "refused"),
    [("alpha", 1.0, ""), ("alpha", 16.0, "goes up to 96 deg"), ("alpha", 14.0, ""),
     ("fy", 30.0, ""), ("fy", 33.0, "at a load of"), ("fy", 0.04, ""), ("fy", 0.03, "at a load"),
     ("fy", 0.0, "")],
)  # fmt: skip
def test_values_that_no_tire_has_are_refused(changed, factor, refused):
    columns = a_sweep(lambda a, _up: -1000.0 / math.radians(6.0) * a)
    columns[changed] = factor * columns[changed]
    names = {name: name.upper() for name in columns}
    if not refused:
        check_values(columns, names, "a.csv")
        return
    with pytest.raises(FlatplankError, match=refused):
        check_values(columns, names, "a.csv")


def test_an_error_as_large_as_the_floor_is_even_chance():
    assert chance_of(10.0, 10.0, 40.0) == pytest.approx(0.5)
    assert chance_of(20.0, 10.0, 40.0) == pytest.approx(f_distribution.sf(4.0, 40.0, 40.0))
    assert math.isnan(chance_of(10.0, 0.0, 40.0)) and math.isnan(chance_of(10.0, math.nan, 40.0))


def test_many_conditions_fail_together_no_more_often_than_one():
    assert list(fails([0.009, 0.011])) == [False, False]
    assert list(fails([0.009])) == [True] and list(fails([])) == []
    chances = np.random.default_rng(1).uniform(size=(20_000, 5))
    assert np.mean([fails(c).any() for c in chances]) == pytest.approx(RISK, abs=0.002)


def test_independent_bins_are_degrees_of_freedom():
    draw = np.random.default_rng(2)
    found = [degrees_of_freedom(draw.normal(size=40), np.full(40, 9)) for _ in range(200)]
    assert np.median(found) == pytest.approx(40.0, rel=0.1)
    alone = np.where(np.arange(40) < 2, 1.0, np.nan)
    assert math.isnan(degrees_of_freedom(alone, np.full(40, 9)))
    uneven = np.where(np.arange(40) < 20, 1, 10_000)
    assert degrees_of_freedom(draw.normal(size=40) / np.sqrt(uneven), uneven) < 25.0


def test_degrees_of_freedom_are_satterthwaites():
    """Differences whose memory is known by counting: signs that alternate have none, of those
    that change at every third bin 20 of 29 pairs of neighbours are alike."""
    counts = np.resize([4, 25, 9], 30)
    alternating = np.resize([1.0, -1.0], 30) / np.sqrt(counts)
    independent = (1.0 / counts).sum() ** 2 / (1.0 / counts**2).sum()
    assert degrees_of_freedom(alternating, counts) == pytest.approx(independent)
    assert degrees_of_freedom(5.0 * alternating, counts) == pytest.approx(independent)
    assert degrees_of_freedom(np.zeros(30), counts) == pytest.approx(independent)
    gaps = np.where(np.arange(30) % 5 == 1, np.nan, 1.0)
    kept = 1.0 / counts[np.isfinite(gaps)]
    random = np.random.default_rng(5).permutation(np.resize([1.0, -1.0], 30))
    assert degrees_of_freedom(gaps * random / np.sqrt(counts), counts) <= (
        kept.sum() ** 2 / (kept**2).sum() + 1e-9
    )
    even = np.full(30, 16)
    apart = np.abs(np.subtract.outer(np.arange(30), np.arange(30)))
    for difference, memory in (
        (np.resize([1.0, 1.0, 1.0, -1.0, -1.0, -1.0], 30), (20 - 9) / 30),
        (np.ones(30), LONGEST),
    ):
        wanted = 30**2 / (memory ** (2 * apart)).sum()
        assert degrees_of_freedom(difference, even) == pytest.approx(wanted)


def test_a_polynomial_that_the_ways_differ_by_is_no_scatter():
    """A cubic is left out whole, and costs its share of the freedom."""
    even, bins = np.full(30, 16), np.arange(30.0)
    scatter = np.resize([1.0, -1.0], 30)
    cubic = 1e-3 * bins**3 - 0.4 * bins**2 + 7.0
    for difference in (scatter, scatter + cubic):
        found = degrees_of_freedom(difference, even, 4)
        assert found == pytest.approx(30.0 * (1.0 - 4.0 / 30.0), rel=0.02)
    assert degrees_of_freedom(cubic, even) < 5.0
    few = np.where(bins < 7, scatter, np.nan)
    assert degrees_of_freedom(few, even, 4) >= 1.0
    assert math.isnan(degrees_of_freedom(np.where(bins < 6, scatter, np.nan), even, 4))


def conditions_of(*held: tuple[str, dict[str, float]]) -> Study:
    conditions = tuple(SweepCondition(swept, at, np.arange(9), 1) for swept, at in held)
    return Study(**{f.name: () for f in fields(Study)} | {"conditions": conditions, "columns": {}})


@pytest.mark.parametrize(
    ("held", "lacks"),
    [
        ([("alpha", {})], ["for Fx", "for combined slip"]),
        ([("kappa", {"alpha": 0.0})], ["for Fy and Mz", "for combined slip"]),
        ([("alpha", {}), ("kappa", {"alpha": 0.0})], ["for combined slip"]),
        ([("alpha", {}), ("kappa", {"alpha": 0.0}), ("kappa", {"alpha": 0.05})], []),
    ],
)
def test_what_a_whole_tire_model_still_needs_is_said(held, lacks):
    said = conditions_of(*held).lacking()
    assert len(said) == len(lacks)
    assert all(
        line.startswith(f"{words} you still need") for line, words in zip(said, lacks, strict=True)
    )
