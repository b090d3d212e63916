# SPDX-License-Identifier: Apache-2.0
"""MATLAB 7.3 files give the same as older ones; damaged ones are refused in one line."""

from __future__ import annotations

import numpy as np
import pytest

from flatplank_data.campaign import Campaign
from flatplank_data.readers.mat import variables
from flatplank_validation.trust.files.matlab73 import write_mat73

ENTRY = "{file: run.mat, kappa: 0.02, fz: 3700, step_position: 1.5}"


def a_campaign(folder) -> Campaign:
    (folder / "campaign.yaml").write_text(
        f"format: flatplank-measurement-table/1\ntire: TOY\nruns: [{ENTRY}]\n"
    )
    return Campaign.load(folder)


@pytest.mark.parametrize("struct", [False, True])
def test_a_run_in_matlab_73(struct, tmp_path, make_step):
    table = make_step(0.02)
    units = {name: "-" if unit == "1" else unit for name, unit in table.units.items()}
    columns = dict(table.columns) | {"fx": table["fx"] / 1e3, "units": units | {"fx": "kN"}}
    write_mat73(tmp_path / "run.mat", {"data": columns} if struct else columns)
    campaign = a_campaign(tmp_path)
    (found,) = campaign.tables()
    for name, values in table.columns.items():
        np.testing.assert_allclose(found[name], values, atol=1e-9)


def test_texts_cells_and_empty_values(tmp_path):
    path = write_mat73(
        tmp_path / "a.mat",
        {"tire": "Größe 1", "channel": {"name": ["FX", "FZ"], "units": ["N", "kN"]}, "n": 3.0},
    )
    found = variables(path.read_bytes(), "a.mat")
    assert found["tire"] == "Größe 1" and found["n"] == 3.0
    assert list(found["channel"]["name"]) == ["FX", "FZ"]
    assert set(found) == {"tire", "channel", "n"}
