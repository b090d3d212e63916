# SPDX-License-Identifier: Apache-2.0
"""Pages and their figures: numbers beside every figure, small, offline, with their origin."""

import csv
import io
import re

import matplotlib
import numpy as np
import pytest
from matplotlib.figure import Figure

from flatplank_analysis.pages.book import Book, write_page
from flatplank_analysis.pages.provenance import provenance
from flatplank_data.run_record import RunRecord


def rows_of(path):
    return list(csv.reader(io.StringIO(path.read_text())))


def test_a_curve_is_in_the_numbers_of_its_figure(tmp_path):
    figure = Figure()
    axes = figure.subplots()
    axes.plot([1.0, 2.0, 4.0], [0.5, 0.25, -1.0], label="measured")
    axes.axhline(0.0)
    axes.set(xlabel="place [m]", ylabel="Fx [N]")
    Book(tmp_path).add("curve", figure)
    header, names, *points = rows_of(tmp_path / "curve.csv")
    assert header == ["panel", "series", "x", "y", "error"]
    assert names == ["# 1", "", "place [m]", "Fx [N]", ""]
    assert points == [
        ["1", "measured", x, y, ""] for x, y in (("1", "0.5"), ("2", "0.25"), ("4", "-1"))
    ]


@pytest.mark.parametrize("lying", [False, True])
def test_bars_carry_the_name_of_their_tick(tmp_path, lying):
    figure = Figure()
    axes = figure.subplots()
    (axes.barh if lying else axes.bar)([0.2, 1.2], [3.0, 4.0], 0.4, label="base")
    (axes.set_yticks if lying else axes.set_xticks)([0, 1], ["κ -1 %", "κ +1 %"])
    Book(tmp_path).add("bars", figure)
    told = [row[1:4] for row in rows_of(tmp_path / "bars.csv")[2:]]
    assert told == [["base", "κ -1 %", "3"], ["base", "κ +1 %", "4"]]


def test_a_map_is_told_cell_by_cell_and_a_gap_is_empty(tmp_path):
    figure = Figure()
    axes = figure.subplots()
    values = np.ma.masked_invalid([[1.0, np.nan], [3.0, 4.0]])
    axes.pcolormesh([0.0, 2.0, 6.0], [0, 1, 2], values)
    axes.set_yticks([0.5, 1.5], ["first", "second"])
    Book(tmp_path).add("map", figure)
    told = [row[1:4] for row in rows_of(tmp_path / "map.csv")[2:]]
    assert told == [
        ["first", "1", "1"], ["first", "4", "nan"], ["second", "1", "3"], ["second", "4", "4"],
    ]  # fmt: skip


def test_a_line_of_the_page_stays_where_it_was_drawn(tmp_path):
    """Coordinates are short and relative; their errors do not add up."""
    figure = Figure(figsize=(4.0, 3.0))
    axes = figure.subplots()
    axes.set_position((0.0, 0.0, 1.0, 1.0))
    x = np.linspace(0.0, 1.0, 301)
    y = np.random.default_rng(3).uniform(0.0, 1.0, 301)
    with matplotlib.rc_context({"path.simplify": False}):
        axes.plot(x, y)
        axes.set(xlim=(0.0, 1.0), ylim=(0.0, 1.0))
        svg = str(Book(tmp_path).add("line", figure).svg)
    paths = [re.findall(r"-?\d*\.?\d+", d) for d in re.findall(r' d="(M[^"C]*)"', svg)]
    drawn = np.cumsum(np.array(max(paths, key=len), float).reshape(-1, 2), axis=0)
    assert drawn.shape == (301, 2)
    assert np.abs(drawn - np.stack([288.0 * x, 216.0 * (1.0 - y)], axis=1)).max() < 0.051


def test_pages_share_one_design_and_tell_their_origin(tmp_path):
    (tmp_path / "own.html.j2").write_text(
        '{% extends "base.html.j2" %}{% block title %}A & B{% endblock %}'
        "{% block content %}{{ text }}{% endblock %}"
    )
    about = provenance([RunRecord(tire="TOY"), RunRecord(tire="TOY")])
    page = write_page(tmp_path / "own.html", "own.html.j2", tmp_path, text="<i>", about=about)
    text = page.read_text(encoding="utf-8")
    assert "&lt;i&gt;" in text and "2 runs of TOY. Evaluated with flatplank_analysis" in text
    assert "prefers-color-scheme: dark" in text and "@media print" in text


def test_the_origin_counts_what_is_too_long_to_be_listed():
    records = [
        RunRecord(tire=f"T{i}", date=f"2026-05-0{i + 1}", plant={"seed": 5}) for i in range(5)
    ]
    told = provenance(records)
    assert told.startswith("5 runs of T0, T1, T2 and 2 more on the simulated bench (seed 5)")
    assert "measured 2026-05-01 to 2026-05-05. Evaluated" in told
