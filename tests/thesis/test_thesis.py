# SPDX-License-Identifier: Apache-2.0
"""`flatplank thesis`: every figure and table is there once, and no row is wrong without saying
so."""

from __future__ import annotations

import csv
import json
import math
from collections import Counter
from types import SimpleNamespace
from typing import NamedTuple

import numpy as np
import pytest

from flatplank_control.free_rolling.params import FreeRollingParameters
from flatplank_data.errors import FlatplankError
from flatplank_data.run_record import RunRecord
from flatplank_data.table import MeasurementTable
from flatplank_validation.free_rolling.nonlinear import Nonlinear, simulate
from flatplank_validation.thesis import rolling
from flatplank_validation.thesis.chapters import CHAPTERS
from flatplank_validation.thesis.lab import CAMPAIGNS, PLANS, Lab
from flatplank_validation.thesis.page import counts
from flatplank_validation.thesis.points import SLIPS, trend
from flatplank_validation.thesis.published import MAGIC_RMSE, NONLINEAR_RMSE, WHERE
from flatplank_validation.thesis.registry import (
    AGREES,
    DIFFERS,
    UNSHOWN,
    AtMost,
    Near,
    Row,
    Same,
    finding,
)
from flatplank_validation.verbs.thesis import main

FIGURES = {"4": 4, "5": 25, "6": 23, "7": 31, "A": 2, "B": 4, "C": 6, "E": 1, "G": 6}
TABLES = (
    "5.1",
    "5.2",
    "6.1",
    "6.2",
    "6.3",
    "7.1",
    "7.2",
    "7.3",
    "7.4",
    "A.1",
    "H.1",
    "H.2",
    "I.1",
)
"""what the thesis has: figures per chapter, and its tables with parameters or results"""
ENTRIES = [entry for chapter in CHAPTERS.values() for entry in chapter.entries]


def test_every_figure_and_table_is_listed_once():
    expected = [f"{c}.{k}" for c, n in FIGURES.items() for k in range(1, n + 1)]
    expected += [f"Table {t}" for t in TABLES]
    assert Counter(e.number for e in ENTRIES) == Counter(expected)


@pytest.mark.parametrize("entry", ENTRIES, ids=lambda e: e.number)
def test_an_entry_shows_something_or_says_why_not(entry):
    shown = entry.draw or entry.rows or entry.table
    assert bool(shown) != bool(entry.absent)
    assert entry.absent or entry.rows or entry.note, "a figure without a word on it"
    assert len({row.quantity for row in entry.rows}) == len(entry.rows)
    for row in entry.rows:
        assert row.place and row.rule.text and not isinstance(row.thesis, int)
        assert row.ours is not None or row.why


def test_the_comparison_has_all_numbers_of_the_tables():
    rows = [row for entry in ENTRIES for row in entry.rows]
    assert len(rows) >= 170
    assert set(NONLINEAR_RMSE) == set(MAGIC_RMSE) == set(WHERE)
    assert all(len(v) == 9 for t in (NONLINEAR_RMSE, MAGIC_RMSE) for v in t.values())


def test_every_plan_of_a_campaign_is_there():
    assert {m.plan for m in CAMPAIGNS.values()} == {
        p.stem for p in PLANS.glob("*.yaml") if not p.stem.endswith("_plant")
    }


def test_runs_with_and_without_the_filter_are_two_runs():
    """Of one seed their difference would be the filter alone, and agree with it exactly."""
    assert CAMPAIGNS["filtered"].plan == CAMPAIGNS["unfiltered"].plan
    assert CAMPAIGNS["filtered"].seed != CAMPAIGNS["unfiltered"].seed


def made(ours, rule=None, thesis: float | str = 10.0, why="") -> Row:
    return Row("q", "N", thesis, "section", ours, rule or Near(1.0, "stated"), why)


@pytest.fixture
def lab(tmp_path):
    return Lab(tmp_path, 1, say=lambda _: None)


@pytest.mark.parametrize(
    ("row", "verdict"),
    [
        (made(lambda _: 10.9), AGREES),
        (made(lambda _: 11.1, why="known"), DIFFERS),
        (made(lambda _: math.nan, why="not determined"), UNSHOWN),
        (made(None, why="a picture"), UNSHOWN),
        (made(lambda _: 9.0, AtMost()), AGREES),
        (made(lambda _: 10.1, AtMost(), why="known"), DIFFERS),
        (made(lambda _: "rises", Same(), "rises"), AGREES),
        (made(lambda _: "falls", Same(), "rises", "known"), DIFFERS),
    ],
)
def test_verdict_of_a_row(row, verdict, lab):
    found = finding("6.1", row, lab)
    assert found.verdict == verdict
    assert not found.unexplained
    assert found.why == ("" if verdict == AGREES else row.why)


def test_a_difference_without_a_reason_is_counted(lab):
    def refused(_):
        raise FlatplankError("no such point", "campaign", "measure it")

    rows = [made(lambda _: 20.0), made(refused), made(lambda _: 10.0)]
    found = counts([finding("6.1", row, lab) for row in rows])
    assert found == {AGREES: 1, DIFFERS: 1, UNSHOWN: 1, "without a reason": 2}


def test_the_slip_is_gone_when_it_stays_gone(monkeypatch):
    """The wheel catches up within 4 mm and overshoots; 4 mm stood beside the thesis's 0.02 m."""
    x = np.linspace(0.0, 0.05, 501)
    kappa = np.where(x < 0.004, -1.0, 1.4 * np.exp(-(x - 0.004) / 0.004))
    monkeypatch.setattr(rolling, "slip", lambda _: (x, kappa))
    assert rolling.slip_gone(None) == pytest.approx(0.004 + 0.004 * math.log(14.0), abs=2e-4)


class Slip(NamedTuple):
    kappa: float


@pytest.mark.parametrize("table", ["Table 7.4", "Table H.2"])
def test_the_magic_formula_is_the_one_whose_lag_shrinks_with_slip(table, lab):
    """Section 7.3: ‘set to nonlinear dynamics with relaxation behavior’."""
    at = [SimpleNamespace(fz=fz, pressure=bar, alpha_deg=a, gamma_deg=g)
          for fz in (1850.0, 3700.0, 5550.0) for bar in (2.0, 2.5)
          for a in (0.0, 1.0, 5.0, 10.0) for g in (0.0, 5.0)]  # fmt: skip
    errors = [(Slip(k), 7.0) for k in SLIPS]
    models = {
        name: SimpleNamespace(rmse=dict(value))
        for name, value in (("mf", ()), ("mf_contact_point", errors))
    }
    points = [SimpleNamespace(point=p, models=models) for p in at]
    names = ("longitudinal", "angles", "standing", "footprints")
    lab._results[names] = SimpleNamespace(points=points, path="runs")
    (entry,) = (e for e in ENTRIES if e.number == table)
    assert [row.ours(lab) for row in entry.rows] == [7.0] * len(entry.rows)


def test_words_for_a_trend():
    assert trend([1.0, 2.0, 3.0]) == "rises"
    assert trend([3.0, 2.0, 1.0]) == "falls"
    assert trend([1.0, 2.0, 1.5]) == "rises, then falls"
    assert trend([1.0, 0.5, 2.0, 1.0]) == "goes up and down"


@pytest.mark.parametrize("chapter", ["8", "x", ""])
def test_a_wrong_chapter_is_refused(chapter, tmp_path):
    with pytest.raises(ValueError, match="--chapter") as refused:
        main(["--chapter", chapter, "--out", str(tmp_path / "t")])
    assert "\n" not in str(refused.value)
    assert not (tmp_path / "t").exists()


def test_a_chapter_is_measured_and_written(tmp_path, capsys):
    """Chapter 4: three unloaded turns on the twin, the fit, forces before and after."""
    out = tmp_path / "thesis"
    assert main(["--chapter", "4", "--out", str(out), "--jobs", "1", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["counts"]["without a reason"] == 0
    text = (out / "comparison.csv").read_text(encoding="utf-8")
    rows = list(csv.DictReader(text.splitlines()))
    assert [r["figure or table"] for r in rows] == ["4.1", "4.1"]
    before, after = (float(r["ours"]) for r in rows)
    # the preset preloads the shaft by 250 N
    assert before == pytest.approx(250.0, rel=0.05)
    assert after < 15.0
    page = (out / "thesis.html").read_text(encoding="utf-8")
    assert "Figure 4.1" in page and "<svg" in page and 'src="http' not in page
    assert np.all([word in page for word in ("250", "agrees", "Figure 4.4")])


@pytest.mark.long
def test_the_whole_thesis(tmp_path, capsys):
    """Every row is measured; what differs has a reason."""
    out = tmp_path / "thesis"
    assert main(["--out", str(out), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert len(told["rows"]) >= 170
    assert told["counts"]["without a reason"] == 0
    drawn = {e.number for e in ENTRIES if e.draw}
    assert not drawn & set(told["missing"])


def test_a_measured_road_that_stands_at_first_does_not_hold_the_simulation(lab):
    """Figures 5.18, 5.19: the low-passed speed at the first sample is a little below zero, and the
    simulation never ended."""
    time = np.arange(0.0, 136.5, 0.02)
    speed = np.minimum(0.206 * time, 0.03092)
    x = np.cumsum(speed) * 0.02
    columns = {
        "time": time, "plank_position": x, "plank_velocity": speed - 2e-5 * (time < 0.1),
        "motor_torque": np.full(time.size, 0.9),
    }  # fmt: skip
    info = RunRecord(file="run", measurement="free_rolling", fz=rolling.NOMINAL)
    lab.kept[rolling.STARTS] = [MeasurementTable(columns, info)]
    run = rolling.improved(lab)
    assert run.position[-1] == pytest.approx(4.2, abs=0.01)
    assert run.time[-1] == pytest.approx(4.2 / 0.03092, rel=0.01)
    with pytest.raises(ValueError, match="the road stands at 0.000 m"):
        simulate(Nonlinear(), FreeRollingParameters(), speed=lambda at: at)
