# SPDX-License-Identifier: Apache-2.0
"""Curves, formula, levels and conditions by hand-made samples."""

from __future__ import annotations

import numpy as np
import pytest

from flatplank_analysis.slip_sweeps import curves as under_test
from flatplank_analysis.slip_sweeps.conditions import (
    BINS,
    BY_NAME,
    SweepCondition,
    levels,
    not_held,
    split_into_conditions,
)
from flatplank_analysis.slip_sweeps.curves import Curve, curve_of, failures
from flatplank_analysis.slip_sweeps.formula import Formula, fit_formula
from flatplank_analysis.slip_sweeps.tir_signs import CONVENTIONS

NO = np.full(BINS, np.nan)


def book(b, c, d, e, sh, sv, slip):
    """Magic Formula, from the book."""
    x = b * (slip + sh)
    return sv + d * np.sin(c * np.arctan(x - e * (x - np.arctan(x))))


def a_curve(slip, force) -> Curve:
    """Three samples in every bin, all of one slip."""
    bins = np.repeat(np.arange(BINS), 3)
    return Curve(bins, np.repeat(slip, 3), bins >= 0, slip, force, NO, NO, 1.0, "", 9.0)


FORMULAS = {
    "slip angle": (12.0, 1.5, 900.0, -0.4, 0.004, 30.0, 0.25),
    "stiff, small": (120.0, 1.3, 0.9, 0.5, 0.0004, 0.03, 0.025),
    "soft": (8.0, 1.1, 5000.0, -3.0, -0.004, -200.0, 0.5),
    "one side": (15.0, 1.6, 1500.0, 0.2, 0.0, 0.0, 0.3),
}


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("name", FORMULAS)
def test_an_exact_curve_gives_its_formula(name, sign):
    *values, top = FORMULAS[name]
    slip = np.linspace(0.0 if name == "one side" else -top, top, BINS)
    found = fit_formula(a_curve(slip, sign * book(*values, slip)))
    wanted = dict(zip(("B", "C", "D", "E", "Sh", "Sv"), values, strict=True))
    wanted |= {"D": sign * wanted["D"], "Sv": sign * wanted["Sv"]}
    for key, value in wanted.items():
        size = {"Sh": top, "Sv": wanted["D"]}.get(key, value)
        assert found.values[key] == pytest.approx(value, rel=0.01, abs=1e-3 * abs(size)), key
    assert found.rms < 1e-4 * abs(wanted["D"])
    assert found.stiffness == pytest.approx(sign * values[0] * values[1] * values[2], rel=0.01)
    assert found(slip) == pytest.approx(sign * book(*values, slip), abs=1e-3 * abs(wanted["D"]))


def test_eight_bins_are_enough_for_a_formula_and_seven_are_not():
    slip = np.linspace(-0.25, 0.25, BINS)
    force = book(12.0, 1.5, 900.0, -0.4, 0.0, 0.0, slip)
    for count in (7, 8):
        filled = np.isin(np.arange(BINS), np.linspace(0, BINS - 1, count).round())
        found = fit_formula(a_curve(slip, np.where(filled, force, np.nan)))
        assert (found is not None) == (count == 8)


def test_a_straight_line_does_not_tell_the_peak_but_its_stiffness():
    slip = np.linspace(-0.005, 0.005, BINS)
    noise = np.random.default_rng(2).normal(0.0, 5.0, BINS)
    found = fit_formula(a_curve(slip, -2e4 * slip + noise))
    assert found.stiffness == pytest.approx(-2e4, rel=0.1)
    assert not found.known("D") and not found.known("C") and found.rms < 6.0


@pytest.mark.parametrize(("value", "known"), [(10.0, True), (-10.0, True), (7.0, False)])
def test_a_value_is_known_when_the_half_width_is_below_half_of_it(value, known):
    formula = Formula({"D": value, "B": 2.0, "C": 1.5}, {"D": 4.0}, 1.0)
    assert formula.known("D") is known and formula.stiffness == 3.0 * value


class Tir:
    coefficients = "of the file"


@pytest.mark.parametrize("name", CONVENTIONS)
@pytest.mark.parametrize("swept", ["alpha", "kappa"])
def test_a_convention_turns_what_the_law_takes_and_the_side_force(name, swept, monkeypatch):
    signs, n = CONVENTIONS[name], 120
    slip = np.repeat(np.linspace(-0.2, 0.2, 40), 3)
    columns = {"alpha": slip, "gamma": slip**2, "kappa": 3.0 * slip, "fz": np.full(n, 900.0),
               "fx": 5.0 * slip, "fy": 7.0 * slip, "speed": np.full(n, -0.015)}  # fmt: skip
    asked = {}

    def law(coefficients, fz, **given):
        asked.update(given)
        assert coefficients == Tir.coefficients and (fz == 900.0).all()
        return columns["fx"] + 2.0, signs.fy * (columns["fy"] + 3.0), None

    monkeypatch.setattr(under_test, "steady_forces", law)
    condition = SweepCondition(swept, {}, np.arange(n), 1)
    (found,) = failures(columns, [condition], [curve_of(columns, condition)], Tir, signs)
    assert found.error == pytest.approx({"alpha": 3.0, "kappa": 2.0}[swept])
    assert (asked["alpha"] == signs.alpha * slip).all()
    assert (asked["gamma"] == signs.gamma * slip**2).all()
    assert (asked["kappa"] == 3.0 * slip).all() and asked["vx"] == pytest.approx(0.015)


@pytest.mark.parametrize(
    ("name", "blocks", "wanted"),
    [
        ("fz", [(500, 1000.0), (500, 3000.0), (500, 2000.0)], [1000.0, 2000.0, 3000.0]),
        ("fz", [(500, 1000.0), (500, 1170.0), (500, 2000.0)], [1000.0, 1170.0, 2000.0]),
        ("fz", [(400, 1980.0), (600, 2000.0)], [2000.0]),
        ("gamma", [(500, -0.07), (500, 0.0), (500, 0.07)], [-0.07, 0.0, 0.07]),
        ("gamma", [(500, 0.0)], [0.0]), ("kappa", [(500, 0.0), (20, 0.1)], [0.0]),
        ("kappa", [(500, 0.0), (30, 0.1)], [0.0, 0.1]),
        ("kappa", [(5000, 0.0), (40, 0.1)], [0.0]),
        ("kappa", [(5000, 0.0), (60, 0.1)], [0.0, 0.1]),
    ],
)  # fmt: skip
def test_levels_and_the_samples_of_each(name, blocks, wanted):
    values = np.concatenate([np.full(n, v) for n, v in blocks])
    centers, number = levels(BY_NAME[name], values)
    assert centers == pytest.approx(wanted)
    for k, center in enumerate(wanted):
        near = np.abs(values - center) < 0.02 * abs(values).max() + 1e-9
        assert set(number[near]) <= {k}
    assert set(number) - {-1} == set(range(len(wanted)))


ANGLES = tuple(np.radians((0.0, -3.0, 3.0)))


def block(slip, **held):
    return {"alpha": slip, "kappa": 0.0 * slip} | {k: np.full(len(slip), v)
                                                   for k, v in held.items()}  # fmt: skip


def test_every_combination_of_levels_is_a_condition_with_its_own_samples():
    """Two loads at three cambers at two pressures; one of the twelve was measured twice."""
    slip = 0.15 * np.sin(np.linspace(0.0, 2.0 * np.pi, 240))
    plan = [(f, g, p) for p in (2e5, 3e5) for g in ANGLES for f in (2000.0, 1000.0)]
    parts = [block(slip, fz=f, gamma=g, pressure=p, fy=1.0) for f, g, p in [*plan, plan[0]]]
    columns = {k: np.concatenate([part[k] for part in parts]) for k in parts[0]}
    found = split_into_conditions(columns)
    assert [(c.held["fz"], c.held["gamma"], c.held["pressure"]) for c in found] == plan
    assert [c.visits for c in found] == [2] + [1] * 11
    for k, condition in enumerate(found[1:], start=1):
        assert set(condition.samples) <= set(range(240 * k, 240 * k + 240))
        assert len(condition.samples) > 200 and condition.held["kappa"] == 0.0
    assert found[2].label == "slip angle swept, 2000 N, camber -3 deg, 200 kPa"
    assert {h.name for h in found[0].levels()} == {"fz", "gamma", "pressure"}


@pytest.mark.parametrize(
    ("change", "count"),
    [({}, 1), ({"wide": 0.1}, 0), ({"force": None}, 0), ({"n": 50}, 0), ({"fz": np.nan}, 0)],
)
def test_what_makes_no_condition(change, count):
    """A slip that moves by less than 2 deg, no force that belongs to it, or few samples."""
    n = change.get("n", 240)
    slip = 0.15 * change.get("wide", 1.0) * np.sin(np.linspace(0.0, 2.0 * np.pi, n))
    force = {} if "force" in change else {"fy": 1.0}
    columns = block(slip, fz=1000.0, **force)
    if "fz" in change:
        columns["fy"] = np.full(n, np.nan)
    assert len(split_into_conditions(columns)) == count


@pytest.mark.parametrize(
    ("name", "values", "jumps"),
    [
        ("fz", np.resize([1000.0, 3000.0, 2000.0], 300), True),
        ("fz", np.repeat([1000.0, 3000.0, 2000.0], 100), False),
        ("fz", 2000.0 + np.resize([-100.0, 0.0, 100.0], 300), False),
        ("gamma", np.resize([-0.05, 0.0, 0.05], 300), True),
        ("pressure", np.resize([1e5, 2e5, 3e5], 300), True),
        ("speed", np.resize([5.0, 10.0, 15.0], 300), True),
        ("alpha", np.resize([-0.1, 0.0, 0.1], 300), False),
        ("fz", np.where(np.arange(300) % 5 < 2, 3000.0, 1000.0), False),
    ],
)  # fmt: skip
def test_a_level_that_changes_with_most_rows_is_not_held(name, values, jumps):
    found = not_held({name: values, "other": values})
    assert (found is BY_NAME[name]) if jumps else (found is None)
