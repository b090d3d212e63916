# SPDX-License-Identifier: Apache-2.0
"""Control charts of a reference tire: their arithmetic, and a machine that has drifted."""

from __future__ import annotations

import math

import numpy as np
import pytest
from steptable import step_table

from flatplank_analysis.cli import report as report_verb
from flatplank_analysis.report.sessions import Session, charts_of, variance_parts
from flatplank_data.errors import FlatplankError
from flatplank_data.exporters import export_campaign


def sessions(values, name="r_e"):
    return [Session(f"s{k}", f"2026-01-{k + 1:02d}", {name: v}) for k, v in enumerate(values)]


def test_limits_are_those_of_an_individuals_chart():
    (chart,) = charts_of(sessions([[10.0], [12.0], [11.0], [11.0]]))
    # moving ranges 2, 1, 0
    assert chart.centre == 11.0
    assert chart.reach == pytest.approx(3.0 * 1.0 / 1.128)
    assert not chart.remarks


def test_a_session_beyond_the_limits_and_a_shift_are_named():
    (chart,) = charts_of(sessions([[v] for v in (1.0, 1.1, 1.0, 1.1, 1.0, 5.0, 1.0, 1.1, 1.0)]))
    assert any("2026-01-06 s5 is beyond" in r for r in chart.remarks)
    level = [0.0, 0.2, 0.1, 0.0, 0.1, 0.2, 0.1, 0.0, 1.0, 1.2, 1.1, 1.0, 1.1, 1.2, 1.0, 1.1]
    (chart,) = charts_of(sessions([[v] for v in level]))
    assert any(r.startswith("shift: 8 sessions in a row below") for r in chart.remarks)


def test_three_sessions_give_no_limits():
    (chart,) = charts_of(sessions([[1.0], [2.0], [3.0]]))
    assert math.isnan(chart.reach)
    assert chart.remarks == ("no limits: 3 of at least 4 sessions",)


def test_the_parts_of_the_variance_are_recovered():
    random = np.random.default_rng(3)
    groups = [random.normal(random.normal(5.0, 2.0), 0.5, 6) for _ in range(400)]
    within, between = variance_parts(groups)
    assert within == pytest.approx(0.5, rel=0.05)
    assert between == pytest.approx(2.0, rel=0.1)
    within, between = variance_parts([np.array([1.0]), np.array([3.0])])
    assert math.isnan(within)
    assert between == pytest.approx(math.sqrt(2.0))


def test_sessions_without_a_quantity_in_common_are_refused():
    with pytest.raises(FlatplankError, match="no quantity was measured in two sessions"):
        charts_of([*sessions([[1.0]]), Session("other", "2026-02-01", {"C_z": [2.0]})])


def test_a_machine_that_drifts_is_seen_in_the_report(tmp_path, capsys):
    random = np.random.default_rng(8)
    folders = []
    for k in range(6):
        tables = []
        for kappa in (0.01, -0.01):
            for repeat in (1, 2):
                name = f"TOY_REL_LNG_{100 * kappa:g}perc_T_p25_Fz3700_1_r{repeat:02d}.parquet"
                table = step_table(kappa, 1, 5.0, file=name)
                gain = 1.0 if k < 5 else 1.3
                force = gain * table["fx"] + random.normal(0.0, 2.0, len(table))
                dated = table.with_columns(fx=force).with_info(
                    repeat=repeat, date=f"2026-0{k + 1}-01", file=name
                )
                tables.append(dated)
        folder = tmp_path / f"session{k}"
        export_campaign(tables, folder, ".parquet")
        folders.append(str(folder))
    code = report_verb.main([folders[-1], "--reference", *folders, "--out", str(tmp_path / "out")])
    assert code == 0, capsys.readouterr().err
    text = (tmp_path / "out" / "tables" / "reference.csv").read_text()
    line = next(row for row in text.splitlines() if row.startswith("slip stiffness"))
    assert "2026-06-01 session5 is beyond the limits" in line
    assert (tmp_path / "out" / "figures" / "reference_C_Fk.png").exists()
    assert "Reference tire" in (tmp_path / "out" / "report.html").read_text()
