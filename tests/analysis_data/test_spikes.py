# SPDX-License-Identifier: Apache-2.0
"""Bad samples are named with run and row and left out; sharp physics stays."""

import numpy as np
import pytest

from flatplank_data.campaign import Campaign
from flatplank_data.run_record import RunRecord
from flatplank_data.spikes import LONGEST, SIDE, bad_samples, spikes, stuck
from flatplank_data.table import MeasurementTable

RATE = 250.0
"""samples per second"""


def _noise(seed: int, level: float = 5.0, count: int = 6000) -> np.ndarray:
    return level * np.random.default_rng(seed).normal(size=count)


def _road() -> np.ndarray:
    return np.arange(6000) / RATE * 0.031


def _slip_step() -> np.ndarray:
    return 2500.0 * -np.expm1(-np.maximum(_road() - 0.3, 0.0) / 0.1) + _noise(1)


def _stick_slip() -> np.ndarray:
    return 400.0 * np.mod(_road() / 0.02, 1.0) * (_road() > 0.4) + _noise(2)


def _cleat() -> np.ndarray:
    away = (_road() - 0.35) / 0.006
    return 3700.0 - 900.0 * away * np.exp(-0.5 * away**2) + _noise(3)


def _locked_start() -> np.ndarray:
    """Force of a wheel that is dragged from rest and breaks away."""
    moved = np.maximum(_road() - 0.01, 0.0)
    return np.where(moved < 0.015, -1.5e5 * moved, -400.0) * (moved > 0.0) + 0.5 * _noise(4, 1.0)


def _quantised() -> np.ndarray:
    return np.round(_slip_step() / 20.0) * 20.0


def _standstill() -> np.ndarray:
    return np.where(_road() < 0.5, 0.0, 300.0 + _noise(5))


PHYSICS = {
    "slip step": _slip_step, "stick-slip": _stick_slip, "cleat": _cleat, "ramp": _road,
    "locked start": _locked_start, "quantised": _quantised, "standstill": _standstill,
    "wrapped angle": lambda: np.mod(_road() / 0.31 * 6.0, 2.0 * np.pi),
    "encoder": lambda: np.floor(_road() / 1e-5) * 1e-5, "constant": lambda: np.full(6000, 3700.0),
    "few samples at the start": lambda: np.append([0.0, -230.0], -500.0 + _noise(7, 9.0, 220)),
}  # fmt: skip


@pytest.mark.parametrize("every", (1, 8, 40))
@pytest.mark.parametrize("name", PHYSICS)
def test_sharp_physics_is_no_spike(name, every):
    values = PHYSICS[name]()[:: every if PHYSICS[name]().size > 1000 else 1]
    assert not spikes(values).any()
    assert not stuck(values)


@pytest.mark.parametrize("name", ("slip step", "stick-slip", "cleat", "quantised"))
@pytest.mark.parametrize("size", (-2e4, 6e3, 2e4))
@pytest.mark.parametrize("length", (1, 2, LONGEST))
def test_spikes_anywhere_are_found_and_nothing_else(name, size, length):
    values = PHYSICS[name]()
    for first in (0, 1, 1200, 2417, 5000, values.size - length):
        spoilt = values.copy()
        spoilt[first : first + length] += size
        expected = np.arange(first, first + length)
        np.testing.assert_array_equal(np.flatnonzero(spikes(spoilt)), expected)


def test_a_spike_at_the_start_beside_others():
    values = _slip_step()
    values[[2, 131, 401]] += [2e4, 2e4, -2e4]
    np.testing.assert_array_equal(np.flatnonzero(spikes(values)), [2, 131, 401])


def test_a_longer_spike_by_the_road(make_step):
    """Twenty samples in 2.5 mm of road; no tire answers to that."""
    x = _road()
    force = _slip_step()
    force[3000:3020] -= 5e3
    table = make_step(0.02, 1).rows(slice(0, 1)).info
    made = MeasurementTable({"plank_position": x, "fx": force}, table)
    (found,) = bad_samples(made)
    np.testing.assert_array_equal(found.rows, np.arange(3000, 3020))
    for name, shape in PHYSICS.items():
        values = shape()
        if values.size == x.size and name != "standstill":  # here the plank moves
            made = MeasurementTable({"plank_position": x, "fx": values}, table)
            assert not list(bad_samples(made)), name


def test_spikes_of_both_signs_beside_each_other():
    values = _slip_step()
    values[[3000, 3001, 3003]] += [2e4, -2e4, 1.5e4]
    assert set(np.flatnonzero(spikes(values))) >= {3000, 3001, 3003}
    assert np.flatnonzero(spikes(values)).size <= LONGEST


def test_a_stuck_channel_is_found():
    values = _slip_step()
    values[2000:2040] = values[2000]
    (rows,) = stuck(values)
    np.testing.assert_array_equal(rows, np.arange(2000, 2040))


def test_a_channel_that_dies_while_the_plank_moves(make_step):
    table = make_step(0.02, 1, noise=5.0)
    force = table["fx"].copy()
    force[2000:] = force[2000]
    (found,) = bad_samples(table.with_columns(fx=force))
    np.testing.assert_array_equal(found.rows, np.arange(2000, len(table)))
    still = np.minimum(table["plank_position"], table["plank_position"][2000])
    assert not list(bad_samples(table.with_columns(fx=force, plank_position=still)))


@pytest.mark.parametrize("column", ("fy", "fz", "mz", "wheel_angle", "plank_position"))
def test_every_channel_is_tested(column, make_step):
    table = make_step(0.02, 1, noise=5.0)
    values = table[column].copy()
    values[[700, 701]] += 0.3 * 10.0 ** len(str(int(np.ptp(values) + values.max())))
    (found,) = bad_samples(
        table.with_columns(**{column: values + 1e-6 * _noise(9)[: values.size]})
    )
    assert found.column == column and list(found.rows) == [700, 701]


def test_a_campaign_names_run_and_row_and_goes_on(write_campaign, make_step):
    clean = [make_step(0.02, k, noise=5.0) for k in (1, 2, 3)]
    force = clean[1]["fx"].copy()
    force[1500] = 2e4
    folder = write_campaign([clean[0], clean[1].with_columns(fx=force), clean[2]])
    campaign = Campaign.load(folder)
    tables = list(campaign.tables())
    assert [len(t) for t in tables] == [len(clean[0]), len(clean[1]) - 1, len(clean[2])]
    assert tables[1]["fx"].max() < 3e3
    (problem,) = campaign.problems
    assert "row 1501" in problem.what and "2e+04 N" in problem.what and not problem.fatal
    assert problem.file == clean[1].info.file and "'fx'" in problem.place


def test_a_run_with_too_many_is_refused(write_campaign, make_step):
    table = make_step(0.02, 1, noise=5.0)
    force = table["fx"].copy()
    force[1000:1080] = force[1000]
    folder = write_campaign([table.with_columns(fx=force), make_step(0.02, 2, noise=5.0)])
    campaign = Campaign.load(folder)
    assert len(list(campaign.tables())) == 1
    (problem,) = campaign.problems
    assert problem.fatal and "stuck" in problem.what and "1001 to 1080" in problem.what


@pytest.mark.parametrize("count", [0, 1, SIDE, 4 * LONGEST - 1, 4 * LONGEST])
def test_a_record_of_any_length_is_looked_at(count):
    road, force = _road()[:count], _slip_step()[:count]
    columns = {"plank_position": road, "fx": force}
    assert list(bad_samples(MeasurementTable(columns, RunRecord(file="a.csv")))) == []
