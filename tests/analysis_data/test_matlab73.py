# SPDX-License-Identifier: Apache-2.0
"""MATLAB 7.3 files give the same as older ones; damaged ones are refused in one line."""

from __future__ import annotations

import numpy as np
import pytest
from matlab73_files import write_mat73

from flatplank_data.campaign import Campaign
from flatplank_data.errors import FlatplankError
from flatplank_data.readers.mat import variables

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


def test_damaged_files_are_refused_in_one_line(tmp_path, make_step):
    table = make_step(0.02)
    whole = write_mat73(tmp_path / "a.mat", dict(table.columns)).read_bytes()
    random, refused = np.random.default_rng(1), 0
    for k in range(40):
        data = bytearray(whole)
        at = int(random.integers(512, 6000))
        if k % 2:
            del data[at:]
        else:
            data[at : at + 40] = random.bytes(40)
        try:
            found = variables(bytes(data), "a.mat")
        except FlatplankError as error:
            refused += 1
            assert str(error).startswith("a.mat: not a whole MATLAB file (")
            assert "\n" not in str(error)
        else:
            assert isinstance(found, dict)
    assert refused >= 20
