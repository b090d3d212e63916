# SPDX-License-Identifier: Apache-2.0
"""Tires of another form than the base with nothing hidden: what their law and their transients do
at several loads and pressures is no fault."""

from __future__ import annotations

import numpy as np
import pytest
from third_campaigns import tables

from flatplank_analysis.contact_patch.data import from_tables
from flatplank_analysis.contact_patch.model import TireModel
from flatplank_analysis.contact_patch.parameters import _parameters
from flatplank_analysis.contact_patch.session import Session
from flatplank_analysis.discovery.model import same_law
from flatplank_analysis.discovery.verdict import AT_FLOOR, FOUND
from flatplank_validation.blind.nulls import nothing_hidden


@pytest.mark.long
def test_a_law_that_the_loads_bend_is_no_difference_between_driving_and_braking():
    """Was `found: drive_brake_asymmetry`, -2 %: the error fell from 2.1 N to 1.7 N, both of the
    form of the base, in a campaign of 0.8 N of noise with nothing hidden."""
    result = Session.of_tables(nothing_hidden("second", 3, 1.0, design="loads")).diagnose()
    assert (result.verdict, result.found) == (AT_FLOOR, ()), result.reason


@pytest.mark.long
@pytest.mark.parametrize(("design", "seed"), [("loads", 1), ("pressures", 31)])
def test_the_transients_of_all_runs_are_no_worn_patch_and_no_creep(design, seed):
    """Were `found: worn_patch`, 56 % at 0.14 m, where the wheel starts to roll, with an error of
    5.94 N before and 5.91 N after; and `found: carcass_creep`, 5 % in 2 s, which are 6 cm."""
    result = Session.of_tables(nothing_hidden("third", seed, 7.5, design=design)).diagnose()
    names = {f.decision.term.effect.identifier for f in result.found}
    assert names <= {"rolling_resistance"}, result.reason  # that of this tire grows with the load


@pytest.mark.long
@pytest.mark.timeout(300)
def test_two_pressures_change_the_rolling_radius_of_our_own_plant():
    """Was `partly`, a carcass that follows the pressure with 0.31 (0.25 in the plant), and 42 N
    left with nothing hidden: the base had no slip that follows the pressure."""
    result = Session.of_tables(nothing_hidden("plant", 401, 7.5, design="pressures")).diagnose()
    (found,) = result.found
    low, high = found.decision.interval
    assert (result.verdict, found.decision.term.effect.identifier) == (FOUND, "carcass_pressure")
    assert low < 0.25 < high and high - low < 0.2
    assert result.rmse_after < 1.1 * result.floor


@pytest.mark.long
@pytest.mark.timeout(900)
@pytest.mark.parametrize(
    ("design", "own"),
    [
        ("loads", {"carcass_load"}), ("wide_loads", {"carcass_load"}),
        ("pressures", {"carcass_pressure"}), ("cambers", {"camber_thrust"}), ("angles", set()),
        ("combined", set()),
    ],
)  # fmt: skip
@pytest.mark.parametrize("level", [1.0, 7.5, 30.0])
def test_no_setting_of_our_own_plant_is_a_fault(design, own, level):
    """Its carcass follows load and pressure, and it has a camber thrust; nothing else is named."""
    result = Session.of_tables(nothing_hidden("plant", 500, level, 0.01, design=design)).diagnose()
    names = {f.decision.term.effect.identifier for f in result.found}
    assert names <= own, result.reason
    assert result.verdict == (FOUND if names else AT_FLOOR), result.reason


@pytest.mark.parametrize("design", ["loads", "pressures", "angles"])
def test_where_the_settings_differ_the_law_may_be_off_by_more(design):
    """Pressures had the half: other tires have 1.0 % there (`bench-discovery --form 3`)."""
    model = TireModel(from_tables(nothing_hidden("second", 1, 7.5, design=design)))
    plain = TireModel(from_tables(nothing_hidden("second", 1, 7.5)))
    assert (model.form.law, plain.form.law) == (0.01, 0.005)


def test_the_pressure_does_not_change_the_form_of_the_law():
    """Were laws of their own: two pressures made the error of a law that they share smaller by the
    root of two, and that of a carcass that follows the pressure large."""
    model = TireModel(from_tables(nothing_hidden("second", 1, 7.5, design="pressures")))
    data, runs = model.data, model.runs
    law = [set(rows) for rows in same_law(model).values()]
    assert sum(map(len, law)) == runs.runs and len(runs.groups) == 2 * len(law)
    assert all(any(set(rows) <= one for one in law) for rows in runs.groups)
    assert all(np.ptp(data.kappa[[*one]]) == 0.0 for one in law)
    single = TireModel(from_tables(tables("wide_loads", 1)))
    assert [*map(len, same_law(single).values())] == [*map(len, single.runs.groups)]


@pytest.mark.parametrize("load", [450.0, 48e3])
def test_ranges_of_the_base_scale_with_the_tire(load):
    """Forces with the load, lengths with its square root, stiffnesses with their quotient."""
    force, length = load / 3700.0, np.sqrt(load / 3700.0)
    factors = {"N": force, "m": length, "N/m": force / length}
    usual, scaled = ([p for _, p in _parameters(at, turned=True)] for at in (3700.0, load))
    for one, other in zip(usual, scaled, strict=True):
        factor = factors.get(one.unit, 1.0)
        for name in ("null", "lower", "upper", "screen", "prior"):
            wanted = factor * getattr(one, name)
            assert getattr(other, name) == pytest.approx(wanted), f"{name} of {one.name}"
