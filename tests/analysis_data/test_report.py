# SPDX-License-Identifier: Apache-2.0
"""Report, verbs and executors on a small campaign with a known answer."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ElementTree
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from steptable import RADIUS, SIGMA, STIFFNESS, step_table

from flatplank_analysis.cli import fit as fit_verb
from flatplank_analysis.cli import report as report_verb
from flatplank_analysis.cli import table as table_verb
from flatplank_analysis.cli import tire as tire_verb
from flatplank_analysis.figures import chapter7, pieces
from flatplank_analysis.figures.draw import canvas
from flatplank_analysis.figures.spec import Figure, Panel, Series
from flatplank_analysis.report.analysis import analyse
from flatplank_analysis.report.conditions import condition_result
from flatplank_analysis.report.radii import radius_values
from flatplank_analysis.report.tables import all_tables
from flatplank_analysis.report_files.build import make_figures, write
from flatplank_data.campaign import Campaign
from flatplank_data.exporters import export_campaign
from flatplank_data.run_record import RunRecord
from flatplank_data.table import MeasurementTable
from flatplank_validation.thesis import plateau

SLIPS = (-0.02, -0.01, 0.0, 0.01, 0.02)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Five slips x two loads x two starts, a free-rolling, a stiffness and a footprint run."""
    from steptable import step_table

    from flatplank_data.exporters import export_campaign

    tables = []
    for fz in (3700.0, 5550.0):
        for kappa in SLIPS:
            for start in (1, 2):
                name = f"TOY_REL_LNG_{100 * kappa:g}perc_T_p25_Fz{fz:g}_{start}.parquet"
                table = step_table(kappa, start, 15.0, fz=fz, file=name)
                # no two runs of a machine have the same samples
                own = np.random.default_rng(int(fz)).normal(size=len(table))
                load = np.full(len(table), fz)
                tables.append(table.with_columns(fz=load, fx=table["fx"] + own))
    rolling = step_table(
        0.0, 1, measurement="free_rolling", file="TOY_ERR_REL_LNG_T_p25_Fz3700_1.parquet"
    )
    decay = 50.0 - 900.0 * np.exp(-3.0 * rolling["plank_position"])
    tables.append(rolling.with_columns(fx=decay))
    down = np.linspace(0.32, 0.28, 300)
    radius = np.concatenate([down, down[::-1]])
    columns = {"loaded_radius": radius, "fz": 2.13e5 * (0.32 - radius)}
    info = {"tire": "TOY", "pressure": 2.5, "fz": 6000.0}
    stiffness = RunRecord(file="TOY_STF_T_p25_Fz6000_1.parquet", measurement="stiffness", **info)
    tables.append(MeasurementTable(columns, stiffness))
    prints = {
        "fz": np.array([1850.0, 3700.0, 5550.0]),
        "half_length": np.array([0.0496, 0.0708, 0.0872]),
    }
    tables.append(
        MeasurementTable(
            prints, RunRecord(file="footprint.parquet", measurement="footprint", **info)
        )
    )
    return export_campaign(tables, tmp_path_factory.mktemp("report") / "campaign")


@pytest.fixture(scope="module")
def result(folder):
    return analyse(Campaign.load(folder))


def test_linear_model_of_every_condition(result):
    assert len(result.points) == 2 and len(result.conditions) == 10
    for c in result.conditions:
        if c.condition.kappa:
            fit = c.linear
            assert fit.sigma.value == pytest.approx(SIGMA, rel=0.05)
            assert fit.slip_stiffness.value == pytest.approx(STIFFNESS, rel=0.02)
            assert fit.rmse_transient < 15.0 and fit.settled


def test_other_measurements(result):
    assert result.extras["vertical_stiffness"][0]["mean"] == pytest.approx(2.13e5)
    assert result.extras["free_rolling"][0]["settling_distance"] == pytest.approx(
        np.log(900.0 / 2.5) / 3.0, rel=1e-3
    )
    assert result.extras["contact_length"]["q_ra1"] == pytest.approx(0.924, abs=0.03)
    values = radius_values(result)
    assert {v.source for v in values} == {"slip_control", "controller"}
    slip = next(v for v in values if v.source == "slip_control")
    assert slip.corrected.value == pytest.approx(RADIUS, rel=1e-3)


def test_table_6_3_counts_every_start_once():
    """One start angle made five times, its load 5 % higher: the mean is as of the forces."""
    kappa = 0.02
    loads = {1: 1.05, 2: 1.0, 3: 1.0}
    tables = [
        step_table(kappa, s, repeat=r) for s, n in ((1, 5), (2, 1), (3, 1)) for r in range(n)
    ]
    tables = [
        t.with_columns(
            fz=np.where(t["plank_position"] > 1.5, loads[t.info.start], 1.0) * 3700.0,
            fx=t["fx"] * loads[t.info.start],
        )
        for t in tables
    ]
    found = condition_result(tables[0].info.condition, tables)
    mean = sum(loads.values()) / 3.0
    assert found.facts.load_change == pytest.approx(mean - 1.0, abs=1e-4)
    assert found.linear.steady_force.value == pytest.approx(STIFFNESS * kappa * mean, rel=5e-3)


def test_a_wheel_without_flexplates_is_not_judged_against_the_controller(tmp_path):
    rolls = {"measurement": "free_rolling", "step_position": float("nan")}
    free = step_table(0.0, 1, file="free.parquet", r_e_source="flexplates_off", **rolls)
    held = step_table(0.0, 2, file="held.parquet", r_e_source="controller", **rolls)
    rise = 1.0 - np.exp(-4.0 * free["plank_position"])
    tables = [free.with_columns(fx=-35.0 * rise), held.with_columns(fx=50.5 * rise)]
    result = analyse(Campaign.load(export_campaign(tables, tmp_path / "rolling")))
    (table,) = [t for t in all_tables(result) if t.name == "settling"]
    rows = {row[0]: dict(zip(table.header, row, strict=True)) for row in table.rows}
    free_row, held_row = rows["free"], rows["held"]
    assert held_row["reference [N]"] == 50.0 and held_row["steady error [%]"] == pytest.approx(
        1.0, rel=0.01
    )
    assert np.isnan(free_row["steady error [%]"]) and np.isnan(free_row["settling distance [m]"])
    assert free_row["steady Fx [N]"] == pytest.approx(-35.0, rel=0.01)
    assert "no controller" in free_row["remark"]


@pytest.fixture(scope="module")
def page(result, tmp_path_factory):
    return write(result, tmp_path_factory.mktemp("out"))


def test_every_figure_has_its_csv_and_is_well_formed(page, result):
    figures = [f for group in make_figures(result).values() for f in group]
    assert len(figures) >= 12
    for figure in figures:
        for suffix in ("svg", "png", "csv"):
            assert (page.parent / "figures" / f"{figure.name}.{suffix}").stat().st_size > 60
        ElementTree.parse(page.parent / "figures" / f"{figure.name}.svg")
        points = sum(len(s.x) for p in figure.with_strips for s in p.series)
        text = (page.parent / "figures" / f"{figure.name}.csv").read_text()
        rows = [line for line in text.splitlines()[1:] if not line.startswith("#")]
        assert len(rows) == points
    for table in all_tables(result):
        assert (page.parent / "tables" / f"{table.name}.csv").exists()
        assert all(len(row) == len(table.header) for row in table.rows)


def test_the_page_opens_offline(page):
    text = page.read_text(encoding="utf-8")
    for word in ('src="http', 'href="http', "@import", "<script"):
        assert word not in text
    identifiers = [part.split('"')[0] for part in text.split(' id="')[1:]]
    assert len(identifiers) == len(set(identifiers))
    json.loads((page.parent / "report.json").read_text())


def test_processes_give_the_same(folder, result):
    again = analyse(Campaign.load(folder), jobs=2)
    for one, two in zip(result.conditions, again.conditions, strict=True):
        assert one.condition == two.condition
        assert one.linear.to_json() == two.linear.to_json()


def _json(capsys):
    return json.loads(capsys.readouterr().out)


def test_verb_table(folder, tmp_path, capsys):
    assert table_verb.main([str(folder), "--json"]) == 0
    found = _json(capsys)
    assert found["runs"] == 23 and len(found["conditions"]) == 13
    missing = {p["parameters"]: p["missing"] for p in found["parameters"]}
    assert missing["c_cx"] == "" and "pressure" in missing["PPX1 and PPX2, PPX3 and PPX4"]
    assert table_verb.main([str(folder), "--export", str(tmp_path / "e"), "--as", ".csv"]) == 0
    assert "sigma_x" in capsys.readouterr().out
    assert len(Campaign.load(tmp_path / "e")) == 23


@pytest.mark.parametrize("model", ["linear", "nonlinear", "mf"])
def test_verb_fit(folder, model, capsys):
    assert fit_verb.main([str(folder), "--model", model, "--json", "--jobs", "1"]) == 0
    found = _json(capsys)
    assert found["format"] == "flatplank-fit/1" and found["model"] == model
    assert found["runs"] == 20 and found["problems"] == []
    assert fit_verb.main([str(folder), "--model", model, "--jobs", "1"]) == 0
    assert "nan" not in capsys.readouterr().err


def test_verb_fit_writes_a_tire_that_verb_tire_reads(folder, tmp_path, capsys):
    out = tmp_path / "fitted.tir"
    arguments = [str(folder), "--model", "mf", "--out", str(out), "--jobs", "1"]
    assert fit_verb.main(arguments) == 0
    capsys.readouterr()
    assert tire_verb.main([str(out), "--fz", "3700", "--kappa", "0.01", "--json"]) == 0
    state = _json(capsys)
    keys = {"fx", "fy", "mz", "mx", "my", "re", "a", "sigma_x", "sigma_y", "kx", "ky"}
    assert set(state) == keys
    assert state["fx"] == pytest.approx(900.0, rel=0.05)
    assert state["re"] == pytest.approx(RADIUS, rel=2e-3)


def test_verb_report(tmp_path, capsys):
    small = export_campaign([step_table(0.02)], tmp_path / "small")
    assert report_verb.main([str(small), "--json", "--jobs", "1"]) == 0
    assert Path(_json(capsys)["page"]) == small / "report" / "report.html"


def test_a_run_with_another_waveform_is_no_repeat_of_a_step(tmp_path):
    """A sine is driven through the linear model and gives the same tire."""
    step = step_table(0.02)
    x = step["plank_position"]
    since = np.maximum(x - 1.5, 0.0)
    path = 2.0 * np.pi / 0.8
    slip_travel = 0.02 / path * (1.0 - np.cos(path * since))
    turned = 1j * path * SIGMA
    wave = 0.02 / 1j * (np.exp(1j * path * since) - np.exp(-since / SIGMA))
    force = STIFFNESS * (wave / (1.0 + turned)).real
    sine = step.with_columns(wheel_angle=(x + slip_travel) / RADIUS, fx=force).with_info(
        waveform={"name": "sine", "amplitude": 0.02, "wavelength": 0.8}, file="sine.parquet"
    )
    folder = export_campaign([step, sine], tmp_path / "c")
    found = analyse(Campaign.load(folder))
    assert len(found.conditions) == 1
    (run,) = found.extras["waveforms"]
    assert run["sigma"] == pytest.approx(SIGMA, rel=0.03)
    assert run["slip_stiffness"] == pytest.approx(STIFFNESS, rel=0.03)
    assert run["frequency"][0] == pytest.approx(1.25, rel=0.01)
    assert len(make_figures(found)["waveforms"]) == 2


def test_exit_code_two_when_nothing_is_usable(tmp_path, capsys):
    (tmp_path / "TOY_REL_LNG_5perc_T_p25_Fz3700_1.parquet").write_bytes(b"no parquet")
    for verb in (table_verb, fit_verb, report_verb):
        jobs = [] if verb is table_verb else ["--jobs", "1"]
        assert verb.main([str(tmp_path), *jobs]) == 2
        lines = capsys.readouterr().err.strip().splitlines()
        assert "TOY_REL_LNG_5perc" in " ".join(lines)


def test_the_frequency_response_is_not_squeezed_and_stays_where_it_was_measured(tmp_path):
    """A long legend left the axes a tenth of the picture, and the line ran on to frequency 0."""
    tables = []
    for shape in ("sine", "triangle"):
        name = f"TOY_REL_LNG_{shape.upper()}_2perc_T_p25_Fz3700_1.parquet"
        table = step_table(0.02, 1, waveform={"name": shape}, file=name)
        x = np.maximum(table["plank_position"] - 1.5, 0.0)
        wave = 0.02 * np.sin(2.0 * np.pi * x / 0.5)
        slip = np.concatenate([[0.0], np.cumsum(0.5 * (wave[1:] + wave[:-1]) * np.diff(x))])
        force, step = np.zeros(x.size), np.diff(x)
        for i, way in enumerate(step):  # sigma dF + F dx = C dslip
            force[i + 1] = (force[i] * SIGMA + STIFFNESS * (slip[i + 1] - slip[i])) / (SIGMA + way)
        angle = (table["plank_position"] + slip) / RADIUS
        angle[-1] += 0.01  # the plank has stopped, the wheel not yet
        tables.append(table.with_columns(fx=force, wheel_angle=angle))
    result = analyse(Campaign.load(export_campaign(tables, tmp_path / "waves")))
    runs = result.extras["waveforms"]
    assert not any(run["determined"] for run in runs)
    assert all(run["frequency"][0] == pytest.approx(2.0, rel=0.01) for run in runs)
    figures = {f.name: f for group in make_figures(result).values() for f in group}
    figure = figures["frequency_response"]
    for panel in figure.panels:
        curves = [s for s in panel.series if s.style == "curve"]
        assert curves and all(s.x.min() > 1.5 and s.x.max() < 2.3 for s in curves)
    gain = [s for s in figure.panels[0].series if s.style == "curve"]
    assert max(float(s.y.max()) for s in gain) < 1e-3 * STIFFNESS
    drawn = canvas(figure)
    drawn.draw_without_rendering()
    for axis in drawn.axes:
        assert axis.get_position().width > 0.35
    caption = figures[f"waveform_{runs[0]['run']}"].caption
    assert "C/σx" in caption and "kN," not in caption


@pytest.mark.parametrize("title", ["", "driving"])
@pytest.mark.parametrize("waves", [0.2, 3.0])
def test_a_legend_lies_on_no_line(title, waves):
    """Lines that fill the panel, and lines that leave a corner free."""
    x = np.linspace(0.0, 1.0, 900)
    sine, cosine = (f(2.0 * np.pi * waves * x) for f in (np.sin, np.cos))
    lines = [Series("without the filter", x, sine), Series("with the filter", x, cosine)]
    drawn = canvas(
        Figure("f", "f", "", [Panel("x [m]", "Fx [N]", lines, (0.0, 1.0), title=title)])
    )
    drawn.draw_without_rendering()
    (axis,) = drawn.axes
    box = axis.get_legend().get_window_extent()
    for line in axis.get_lines():
        assert not line.get_transform().transform_path(line.get_path()).intersects_bbox(box, False)
    inside = axis.get_window_extent().contains(*box.get_points().mean(axis=0))
    assert inside == (waves < 1.0 or bool(title))


@pytest.mark.parametrize("points", [9, 2000])
def test_a_label_stands_at_the_end_of_its_line(points):
    """Lines of nine slips had their labels at the mean of the line."""
    x = np.linspace(-10.0, 10.0, points)
    lines = [Series(f"{k}", x, k * x, "joined", end_label=True) for k in (1.0, 2.0, 3.0)]
    drawn = canvas(Figure("f", "f", "", [Panel("slip [%]", "Fx [N]", lines)]))
    (axis,) = drawn.axes
    places = {text.get_text(): text.xy[1] for text in axis.texts}
    assert places == pytest.approx({"1.0": 10.0, "2.0": 20.0, "3.0": 30.0}, rel=0.03)


def test_what_is_constant_but_for_rounding_is_drawn_as_constant():
    x = np.linspace(0.0, 1.0, 5)
    speed = Panel("slip [%]", "speed [mm/s]", [Series("before", x, 30.92 + 1e-7 * x, "joined")])
    force = Panel("slip [%]", "force [N]", [Series("fx", x, 100.0 * x, "joined")])
    drawn = canvas(Figure("made_up", "made up", "", (speed, force)))
    (low, high), (least, most) = (axis.get_ylim() for axis in drawn.axes)
    assert high - low > 0.05 and low < 30.92 < high
    assert -10.0 < least <= 0.0 and 100.0 <= most < 110.0


def test_an_axis_is_scaled_by_what_it_shows():
    x = np.linspace(0.0, 4.0, 401)
    y = np.where(x < 1.0, -2000.0, 10.0 * x)
    panel = Panel("x", "y", [Series("", x, y)], (2.0, 3.0))
    (axis,) = canvas(Figure("shown", "", "", (panel,))).axes
    low, high = axis.get_ylim()
    assert 19.0 < low < 20.0 and 30.0 < high < 31.0


def test_an_overlay_has_a_strip_with_what_the_model_leaves(result):
    point = result.nominal()
    overlay = next(f for f in chapter7.overlays(result) if f.name.startswith("overlay_linear"))
    (forces,) = overlay.panels
    strip = forces.strip
    assert strip.x_range == forces.x_range and strip.y_label == "residual [N]"
    upper, lower = (axis.get_position() for axis in canvas(overlay).axes)
    assert upper.height > 2.0 * lower.height and upper.y0 > lower.y1
    condition = pieces.slips(point)[0]
    x, model = point.models["linear"].curves[condition.condition]
    measured = np.interp(x, condition.since_step, condition.measured["fx"])
    assert strip.series[0].y == pytest.approx(measured - model)


@pytest.mark.parametrize("length", [0.03, 0.08])
def test_a_constant_part_after_the_step_is_found(result, length):
    """A force that rests for `length` soon after the step, with ripple as before it."""
    condition = pieces.at_slip(result.nominal(), 0.01)
    x = condition.since_step
    moved = np.where(x < 0.02, x, np.maximum(x - length, 0.02))
    force = 800.0 * (1.0 - np.exp(-np.maximum(moved, 0.0) / 0.4)) + 3.0 * np.sin(x / 0.002)
    made = replace(condition, measured={**condition.measured, "fx": force})
    # the ripple hides the first and last millimetres
    assert plateau.lost_travel(made) == pytest.approx(length, abs=0.008)
    # a second play, which the force takes up later, makes a longer rest
    again = np.where(moved < 0.1, moved, np.maximum(moved - 0.1, 0.1))
    force = 800.0 * (1.0 - np.exp(-np.maximum(again, 0.0) / 0.4)) + 3.0 * np.sin(x / 0.002)
    made = replace(condition, measured={**condition.measured, "fx": force})
    assert plateau.lost_travel(made) == pytest.approx(length, abs=0.008)
