# SPDX-License-Identifier: Apache-2.0
"""The fit of sweeps without the fit: points, start values, loads left out, progress."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from flatplank_analysis.slip_sweeps import fit as under_test
from flatplank_analysis.slip_sweeps.conditions import BINS, SweepCondition
from flatplank_analysis.slip_sweeps.curves import Curve
from flatplank_analysis.slip_sweeps.fit import HeldOut, fit_sweeps, points_of
from flatplank_data.errors import FlatplankError

SLIP = np.linspace(-0.1, 0.1, BINS)
WAY = np.array([1.0] * 6 + [-1.0] * 3)
"""samples of each bin: six while the slip rises, three while it falls"""
ONE_WAY, EMPTY = 5, 7
"""a bin that was passed while the slip rose only, and one without a force"""
EMPTY_SAMPLES = np.arange(9 * EMPTY, 9 * EMPTY + 9)
KEPT = np.arange(BINS) != EMPTY


def a_study(loads=(1000.0,), swept="alpha", held=None, path="a.csv", **more):
    """A condition per load. Forces and load of the two ways differ by 20 N and 100 N; `more`:
    channel -> value, None: not in the file."""
    bins, way = np.repeat(np.arange(BINS), 9), np.tile(WAY, BINS)
    way[9 * ONE_WAY : 9 * ONE_WAY + 9] = 1.0
    n, count = len(bins), len(loads)
    slip = np.tile(SLIP[bins], count)
    load = np.concatenate([f + 50.0 * way for f in loads])
    both = np.tile(way, count)
    force = -1e4 * slip + 10.0 * both + (load - 50.0 * both)
    force.reshape(count, n)[:, EMPTY_SAMPLES] = np.nan
    columns = {swept: slip, "fz": load, "fx": force, "fy": force + 1.0, "mz": 0.1 * force}
    columns |= {k: np.full(n * count, v) for k, v in more.items() if v is not None}
    columns = {k: v for k, v in columns.items() if more.get(k, 0.0) is not None}
    nothing = np.full(BINS, np.nan)
    curve = Curve(bins, slip[:n], way > 0.0, SLIP, nothing, nothing, nothing, 1.0, "", 9.0)
    conditions = [
        SweepCondition(swept, {"fz": f} | (held or {}), np.arange(k * n, (k + 1) * n), 1)
        for k, f in enumerate(loads)
    ]
    return SimpleNamespace(
        columns=columns, conditions=conditions, curves=[curve] * count, path=path
    )


def test_a_point_is_the_mean_of_the_ways_however_many_samples_each_has():
    points = points_of([a_study(gamma=0.05, pressure=2e5)])
    assert len(points) == BINS - 1
    wanted = np.where(np.arange(BINS) == ONE_WAY, 1050.0, 1000.0)[KEPT]
    assert points.fz == pytest.approx(wanted)
    assert points.alpha == pytest.approx(SLIP[KEPT])
    assert points.gamma == pytest.approx(0.05) and (points.kappa == 0.0).all()
    assert points.pressure == pytest.approx(2e5)
    ways = np.where(np.arange(BINS) == ONE_WAY, 10.0, 0.0)
    assert points.measured["fy"] == pytest.approx((1001.0 - 1e4 * SLIP + ways)[KEPT])
    assert points.measured["mz"] == pytest.approx((0.1 * (1000.0 - 1e4 * SLIP + ways))[KEPT])


def test_files_follow_one_another_and_a_pressure_that_one_has_not_is_not_known():
    points = points_of([a_study(pressure=2e5), a_study((1000.0, 3000.0))])
    assert len(points) == 3 * (BINS - 1)
    known = np.isfinite(points.pressure)
    assert known[: BINS - 1].all() and not known[BINS - 1 :].any()
    assert points.fz[-1] == pytest.approx(3000.0) and points.fz[0] == pytest.approx(1000.0)


@pytest.mark.parametrize(
    ("swept", "angle_deg", "forces"),
    [
        ("alpha", None, {"fy", "mz"}), ("kappa", None, {"fx"}), ("kappa", 0.0, {"fx"}),
        ("kappa", 0.4, {"fx"}), ("kappa", -0.4, {"fx"}), ("kappa", 2.0, {"fx", "fy"}),
        ("kappa", -2.0, {"fx", "fy"}),
    ],
)  # fmt: skip
def test_a_sweep_measures_the_forces_of_its_slip_and_both_of_combined_slip(
    swept, angle_deg, forces
):
    held = {} if angle_deg is None else {"alpha": np.radians(angle_deg)}
    more = {} if angle_deg is None else {"alpha": np.radians(angle_deg)}
    points = points_of([a_study(swept=swept, held=held, **more)])
    assert {k for k, v in points.measured.items() if np.isfinite(v).any()} == forces


class Fake:
    """In the place of the fit: keeps what it was given; its model is off by 5 N."""

    def __init__(self, monkeypatch, fits=("fx", "fy"), refuses=()):
        self.calls, self.asked, self._fits, self._refuses = [], [], fits, refuses
        monkeypatch.setattr(under_test, "fit_magic_formula", self.fit)
        monkeypatch.setattr(under_test, "steady_forces", self.forces)
        monkeypatch.setattr(under_test, "_start", self.start(under_test._start))

    def start(self, made):
        def kept(*given):
            self.begun = made(*given)
            return self.begun

        return kept

    def fit(self, points, start, settings):
        loads = {round(f, -2) for f in points.fz}
        if loads in self._refuses:
            raise FlatplankError("too few")
        self.calls.append((loads, points, start, settings))
        return SimpleNamespace(
            fits=dict.fromkeys(self._fits), tir=SimpleNamespace(coefficients=None),
            to_json=lambda: {"model": "mf"},
            file=SimpleNamespace(remarked=lambda remarks: ("complete", remarks)),
        )  # fmt: skip

    def forces(self, _coefficients, fz, **given):
        self.asked.append(given)
        level = np.round(fz, -2)
        true = level + 10.0 * (fz > level + 1.0) - 1e4 * given["alpha"]
        return true + 7.0, true + 1.0 + 5.0, None


def test_each_load_is_left_out_once_and_predicted(monkeypatch):
    fake, told = Fake(monkeypatch), []
    study = a_study((800.0, 400.0, 1200.0))
    found = fit_sweeps([study], progress=lambda *words: told.append(words))
    assert told == [(0, 4, "all loads"), (1, 4, "without 400 N"), (2, 4, "without 800 N"),
                    (3, 4, "without 1200 N"), (4, 4, "done")]  # fmt: skip
    assert [call[0] for call in fake.calls] == [
        {400.0, 800.0, 1200.0}, {800.0, 1200.0}, {400.0, 1200.0}, {400.0, 800.0}
    ]  # fmt: skip
    assert found.points == 3 * (BINS - 1)
    assert {"fx", "fy", "mz"} == set(fake.calls[0][1].measured)
    assert all({"fx", "fy"} == set(call[1].measured) for call in fake.calls[1:])
    assert [(h.force, round(h.load)) for h in found.held_out] == [
        ("fy", 400), ("fy", 800), ("fy", 1200)
    ]  # fmt: skip
    side = np.delete(-1e4 * SLIP + np.where(np.arange(BINS) == ONE_WAY, 10.0, 0.0), EMPTY)
    for held in found.held_out:
        assert held.error == pytest.approx(5.0)
        assert held.r_squared == pytest.approx(1.0 - 25.0 / np.var(side))
    plain = found.to_json()
    assert plain["model"] == "mf" and plain["points"] == found.points
    assert plain["held_out"][0] == pytest.approx(
        {"force": "fy", "load": 400.0, "error": 5.0, "r_squared": found.held_out[0].r_squared}
    )
    assert plain["remarks"] == found.remarks
    assert found.file == ("complete", found.remarks)


def test_two_loads_are_too_few_to_leave_one_out(monkeypatch):
    fake = Fake(monkeypatch)
    assert fit_sweeps([a_study((400.0, 800.0))]).held_out == () and len(fake.calls) == 1


def test_no_prediction_where_the_others_cannot_be_fitted_or_lack_the_force(monkeypatch):
    loads = (400.0, 800.0, 1200.0)
    Fake(monkeypatch, refuses=[{400.0, 1200.0}])
    assert [round(h.load) for h in fit_sweeps([a_study(loads)]).held_out] == [400, 1200]
    Fake(monkeypatch, fits=("fx",))
    assert fit_sweeps([a_study(loads)]).held_out == ()


@pytest.mark.parametrize(("step", "explained"), [(0.0, None), (1.0, 1.0 - 25.0 / 0.25)])
def test_a_force_that_does_not_vary_has_no_share(step, explained, monkeypatch):
    """Forces of 0 and `step` by turns have the variance of a quarter of its square."""
    Fake(monkeypatch)
    study = a_study((400.0, 800.0, 1200.0))
    force = np.tile(np.repeat(step * (np.arange(BINS) % 2), 9), 3)
    study.columns["fy"] = force
    monkeypatch.setattr(
        under_test, "steady_forces",
        lambda _c, fz, **_g: (None, step * (np.arange(len(fz)) % 2) + 5.0, None),
    )  # fmt: skip
    for held in fit_sweeps([study]).held_out:
        assert isinstance(held, HeldOut) and held.error == pytest.approx(5.0)
        assert held.r_squared == pytest.approx(explained, nan_ok=True) or explained is None
        assert np.isnan(held.r_squared) == (explained is None)


@pytest.mark.parametrize(
    ("loads", "more", "wanted"),
    [
        ((1200.0, 400.4, 800.4), {}, {"FNOMIN": 800.0, "NOMPRES": 2e5, "LONGVL": 0.1}),
        ((900.0, 100.0, 300.0, 700.0, 500.0), {"speed": -16.0}, {"FNOMIN": 500, "LONGVL": 16.0}),
        ((500.0,), {"speed": 0.02}, {"FNOMIN": 500.0, "LONGVL": 0.1}),
        ((500.0,), {"speed": 0.15}, {"LONGVL": 0.15}),
    ],
)
def test_start_values_are_in_the_middle_of_what_was_measured(loads, more, wanted, monkeypatch):
    fake = Fake(monkeypatch)
    found = fit_sweeps([a_study(loads, **more)])
    values = fake.calls[0][2].values
    assert {k: values[k] for k in wanted} == pytest.approx(wanted)
    assert values["UNLOADED_RADIUS"] == pytest.approx(0.3)
    assert found.remarks == {
        "UNLOADED_RADIUS": "not measured by sweeps: give --radius",
        "NOMPRES": "not in the sweeps: a placeholder",
    }
    assert (fake.calls[0][1].pressure == values["NOMPRES"]).all()


def test_the_middle_pressure_is_the_nominal_one_and_a_given_radius_is_taken(monkeypatch):
    fake = Fake(monkeypatch)
    studies = [a_study(held={"pressure": p}, pressure=p) for p in (3e5, 1e5, 2e5, 5e5, 4e5)]
    found = fit_sweeps(studies, radius=0.26)
    _, points, start, settings = fake.calls[0]
    assert start.values["NOMPRES"] == pytest.approx(3e5) and not found.remarks
    assert start.values["UNLOADED_RADIUS"] == 0.26
    assert set(points.pressure) == {1e5, 2e5, 3e5, 4e5, 5e5}
    assert settings.reach["pressure"] == pytest.approx((1.2e5, 2.5e5, 3.8e5, 5e5, 6.2e5, 7.5e5))
    assert set(settings.stages) == {
        "pure_x", "pure_y", "aligning", "combined", "pressure", "camber"
    }  # fmt: skip


def test_a_level_that_is_not_stated_is_the_median_of_the_points(monkeypatch):
    fake = Fake(monkeypatch)
    study = a_study((700.0,))
    study.conditions[0] = SweepCondition("alpha", {}, study.conditions[0].samples, 1)
    fit_sweeps([study])
    assert fake.begun.values["FNOMIN"] == 700.0


@pytest.mark.parametrize(("radius", "kept"), [(None, 0.3), (0.26, 0.26)])
def test_a_start_keeps_its_values_but_for_a_given_radius(radius, kept, monkeypatch):
    fake = Fake(monkeypatch)
    fit_sweeps([a_study()])
    start = fake.begun.replaced({"NOMPRES": 1.7e5, "FNOMIN": 4000.0})
    found = fit_sweeps([a_study()], start, radius)
    _, points, given, _ = fake.calls[-1]
    assert given.values["FNOMIN"] == 4000.0 and given.values["UNLOADED_RADIUS"] == kept
    assert (points.pressure == 1.7e5).all() and found.remarks == {}
