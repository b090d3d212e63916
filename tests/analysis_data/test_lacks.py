# SPDX-License-Identifier: Apache-2.0
"""What a campaign lacks is told: by `table` before a fit, and beside the numbers of a fit."""

from __future__ import annotations

import json
import re

import pytest
from steptable import step_table

from flatplank_analysis.cli import fit as cli_fit
from flatplank_analysis.cli import table as cli_table
from flatplank_analysis.report.analysis import analyse
from flatplank_data.campaign import Campaign
from flatplank_data.exporters import export_campaign
from flatplank_data.table import MeasurementTable


def test_a_slip_run_without_wheel_angle_is_told_by_table(tmp_path, capsys):
    whole = step_table(0.02, 1)
    columns = {k: v for k, v in whole.columns.items() if not k.startswith("wheel")}
    folder = export_campaign([MeasurementTable(columns, whole.info)], tmp_path / "blind")
    assert cli_table.main([str(folder)]) == 0
    said = capsys.readouterr().err
    assert "no column 'wheel_angle': no fit; add 'wheel_angle'" in said and "(run kept)" in said
    assert cli_fit.main([str(folder), "--model", "linear", "--jobs", "1"]) == 2
    assert "no column 'wheel_angle'" in capsys.readouterr().err


def test_numbers_that_are_not_determined_have_no_error_beside_them(tmp_path, capsys):
    tables = [step_table(k, s, file=f"{k}_{s}.parquet") for k in (0.0, 0.02) for s in (1, 2)]
    folder = export_campaign(tables, tmp_path / "two")
    assert cli_fit.main([str(folder), "--model", "mf", "--jobs", "1"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert any("radius: one measurement of re" in line for line in lines)
    rows = [line.split() for line in lines]
    fitted = {row[0]: row for row in rows if row and row[0].startswith(("P", "B", "D", "F", "Q"))}
    assert {"PCX1", "PKX1"} <= set(fitted) and "DREFF" not in fitted
    for row in fitted.values():
        # the column of errors is empty; the remark says how far the number is from determined
        remark = " ".join(row[4:])
        assert row[2] == "-", row
        assert re.search(r"not determined by these data(: ± [\d.e+-]+)?$|on its bound$", remark), (
            row
        )


def test_fit_and_report_give_the_same_tire(tmp_path, capsys):
    """Whatever the order in which the verbs read the runs."""
    tables = [
        step_table(k, s, file=f"{k}_{s}.parquet")
        for k in (-0.05, -0.02, 0.0, 0.02, 0.05)
        for s in (1, 2)
    ]
    folder = export_campaign(tables, tmp_path / "five")
    told = analyse(Campaign.load(folder)).magic
    assert cli_fit.main([str(folder), "--model", "mf", "--jobs", "1", "--json"]) == 0
    fitted = json.loads(capsys.readouterr().out)["coefficients"]
    assert told is not None and told.estimates
    for name, estimate in told.estimates.items():
        assert fitted[name] == pytest.approx(estimate.value, rel=1e-9, abs=1e-12), name
