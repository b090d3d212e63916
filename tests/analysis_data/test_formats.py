# SPDX-License-Identifier: Apache-2.0
"""Every format gives the same table; files of the formats' own making are read."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest
import scipy.io

from flatplank_data.campaign import Campaign
from flatplank_data.errors import FlatplankError
from flatplank_data.exporters import EXPORTERS
from flatplank_data.readers import reader, suffixes
from flatplank_data.readers.base import Request
from flatplank_data.readers.mat import read_mat
from flatplank_data.readers.tydex import read_tydex
from flatplank_data.run_record import RunRecord
from flatplank_data.store import LocalStore
from flatplank_data.table import STANDARD_COLUMNS
from flatplank_tire.tydex import parse_tydex

TOLERANCE = {".parquet": 0.0, ".csv": 1e-12, ".tdx": 2e-6, ".mf4": 0.0}


@pytest.mark.parametrize("suffix", sorted(EXPORTERS))
def test_every_exporter_is_read_back(suffix, write_campaign, make_step):
    table = make_step(0.05, noise=10.0)
    campaign = Campaign.load(write_campaign([table], suffix))
    (found,) = campaign.tables()
    assert set(found.columns) == set(STANDARD_COLUMNS)
    for name, values in table.columns.items():
        scale = np.abs(values).max() + 1e-12
        np.testing.assert_allclose(found[name], values, atol=TOLERANCE[suffix] * scale, rtol=0.0)
    assert found.info.condition == table.info.condition
    assert found.info.step_position == table.info.step_position
    assert not campaign.problems


def test_readers_are_registered():
    assert {".parquet", ".csv", ".mat", ".tdx", ".mf4", ".mcap", ".db3"} <= set(suffixes())


def _only_run(folder, name, **entry):
    lines = "".join(f"  {key}: {value}\n" for key, value in entry.items())
    text = f"format: flatplank-measurement-table/1\ntire: TOY\nruns:\n- file: {name}\n{lines}"
    (folder / "campaign.yaml").write_text(text)
    return Campaign.load(folder)


@pytest.mark.parametrize("shape", [(1, -1), (-1, 1), (-1,)])
def test_matlab_vectors_of_any_direction(tmp_path, make_step, shape):
    table = make_step(0.01)
    columns = {name: values.reshape(shape) for name, values in table.columns.items()}
    scipy.io.savemat(tmp_path / "run.mat", columns)
    (found,) = _only_run(tmp_path, "run.mat", kappa=0.01, step_position=1.5).tables()
    np.testing.assert_array_equal(found["fx"], table["fx"])


@pytest.mark.parametrize("imaginary", [0.0, 3.0])
def test_a_complex_matlab_vector_is_read_only_where_it_is_real(tmp_path, make_step, imaginary):
    table = make_step(0.02)
    turned = table["fx"].astype(complex)
    turned[20] += 1j * imaginary
    scipy.io.savemat(tmp_path / "run.mat", dict(table.columns) | {"fx": turned})
    loaded = partial(read_mat, Request(LocalStore(str(tmp_path)), "run.mat"))
    if imaginary:
        with pytest.raises(FlatplankError, match=r"run.mat, row 21: 'fx' is complex"):
            loaded()
    else:
        np.testing.assert_array_equal(loaded().columns["fx"], table["fx"])


def test_matlab_struct_with_units(tmp_path, make_step):
    table = make_step(0.01)
    columns = dict(table.columns) | {"fx": table["fx"] / 1000.0}
    units = {name: "-" if unit == "1" else unit for name, unit in table.units.items()}
    scipy.io.savemat(tmp_path / "run.mat", {"data": columns | {"units": units | {"fx": "kN"}}})
    (found,) = _only_run(tmp_path, "run.mat", kappa=0.01, step_position=1.5).tables()
    np.testing.assert_allclose(found["fx"], table["fx"], atol=1e-9)


@pytest.mark.parametrize("style", ["brackets", "second line", "semicolon"])
def test_csv_units(tmp_path, style):
    rows = [(0.0, 0.0, 0.001), (100.0, 50.0, 0.002), (200.0, 99.0, 0.003)]
    head = {
        "brackets": "time [ms],plank_position [mm],fx [kN]",
        "second line": "time,plank_position,fx\nms,mm,kN",
        "semicolon": "# a comment\ntime [ms];plank_position [mm];fx [kN]",
    }[style]
    mark = ";" if style == "semicolon" else ","
    lines = [mark.join(str(v) for v in row) for row in rows]
    if style == "semicolon":
        lines = [line.replace(".", ",") for line in lines]
    (tmp_path / "run.csv").write_text("\n".join([head, *lines, ""]))
    (found,) = _only_run(tmp_path, "run.csv").tables()
    np.testing.assert_allclose(found["time"], [0.0, 0.1, 0.2])
    np.testing.assert_allclose(found["plank_position"], [0.0, 0.05, 0.099])
    np.testing.assert_allclose(found["fx"], [1.0, 2.0, 3.0])


TYDEX = """**HEADER
RELEASE   Release of TYDEX-format       1.3
MEASID    measurement id.               FP-0042
SUPPLIER  Data supplier                 test lab
DATE      Date                          03-May-2024
**COMMENTS
flat plank, slip step
**CONSTANTS
LONGSLIP  longitudinal slip             %         5.0
FZW       vertical force                kN        3.7
INFLPRES  inflation pressure            kPa       250
SLIPANGL  slip angle                    rad       0.0174532925
INCLANGL  inclination angle             deg       -2
**MEASURCHANNELS
! name    explanation                   unit      factor
RUNTIME   running time                  s         0.001
TRAVDIST  travelled distance            mm        1
WHROTSPD  wheel rotation speed          1/min     0.1       0         0
FX        longitudinal force            kN        0.01      -10       0
FYW       lateral force                 N         1
FZW       vertical force                daN       1
MZW       aligning moment               Nm        1
DSTGRWHC  distance ground wheel centre  mm        1
FZH       vertical force in H           N         1
**MEASURDATA
         0         0         9        10      -1.5     370.0       2.5       300      3700
       100      3.10         9       110      -1.5     370.1       2.5       300      3701
       200      6.20        10       210      -1.5     370.2  NOTAVAIL       300      3702
       300      9.30        10       310      -1.5     370.3
       2.5       300      3703
**END
"""


def test_tydex_as_the_manual_has_it(tmp_path):
    (tmp_path / "run.tdx").write_text(TYDEX)
    campaign = Campaign.load(tmp_path)
    table = campaign.runs[0].table(check=False)
    np.testing.assert_allclose(table["time"], [0.0, 0.1, 0.2, 0.3])
    np.testing.assert_allclose(table["plank_position"], [0.0, 0.0031, 0.0062, 0.0093])
    np.testing.assert_allclose(table["wheel_velocity"], np.array([0.9, 0.9, 1, 1]) * np.pi / 30)
    np.testing.assert_allclose(table["fx"], [0.0, 1000.0, 2000.0, 3000.0])
    np.testing.assert_allclose(table["fz"], [3700.0, 3701.0, 3702.0, 3703.0])
    np.testing.assert_allclose(table["loaded_radius"], 0.3)
    assert np.isnan(table["mz"][2]) and table["mz"][3] == 2.5
    info = table.info
    assert (info.kappa, info.fz) == pytest.approx((0.05, 3700.0))
    assert (info.pressure, info.alpha_deg, info.gamma_deg) == pytest.approx((2.5, 1.0, -2.0))
    said = read_tydex(Request(LocalStore(str(tmp_path)), "run.tdx")).remarks
    other = "'FZH' is not known and was left out (C and H axes are not turned to W)"
    assert any(other in remark for remark in said)


@pytest.mark.parametrize("text", ["OVL", "--", "3x0.1"])
def test_text_in_a_tydex_channel_costs_the_file_only_where_it_is_needed(tmp_path, text):
    (tmp_path / "run.tdx").write_text(TYDEX.replace("  NOTAVAIL", f"{text:>10}"))
    loaded = read_tydex(Request(LocalStore(str(tmp_path)), "run.tdx", needed=("fx",)))
    assert np.isnan(loaded.columns["mz"][2]) and loaded.columns["fx"][2] == 2000.0
    assert (
        f"column 'MZW': 1 of 4 cells are not numbers, first '{text}' in line 28" in loaded.remarks
    )
    (tmp_path / "run.tdx").write_text(TYDEX.replace("       210", f"{text:>10}"))
    with pytest.raises(FlatplankError) as caught:
        read_tydex(Request(LocalStore(str(tmp_path)), "run.tdx", needed=("fx",)))
    assert f"run.tdx, line 28: '{text}' in column 'FX' is not a number" in str(caught.value)


def test_tydex_without_blanks_between_the_values():
    text = TYDEX.split("**MEASURDATA")[0]
    channels = text.split("**MEASURCHANNELS")[0] + (
        "**MEASURCHANNELS\n"
        "FX        longitudinal force            N         1\n"
        "FYW       lateral force                 N         1\n"
        "**MEASURDATA\n-1234.5678-2345.6789\n 1234.5678-2345.6789\n**END\n"
    )
    file = parse_tydex(channels, "x.tdx")
    np.testing.assert_allclose(file.data, [[-1234.5678, -2345.6789], [1234.5678, -2345.6789]])


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("**END\n", ""), "cut short"),
        (("       2.5       300      3703\n", ""), "values"),
        (("TRAVDIST  travelled distance            mm        1", "TRAVDIST  travelled"), "unit"),
        (("**COMMENTS", "**COMENTS"), "COMENTS"),
        (("FXX", "FXX"), ""),
    ],
)
def test_tydex_says_what_is_wrong(change, words):
    text = TYDEX.replace(*change)
    if not words:
        parse_tydex(text, "x.tdx")
        return
    with pytest.raises(FlatplankError, match=words) as caught:
        parse_tydex(text, "x.tdx")
    assert "x.tdx" in str(caught.value) and "\n" not in str(caught.value)


@pytest.mark.parametrize("suffix", suffixes())
def test_a_run_is_named_without_the_suffix_of_its_file(suffix):
    assert RunRecord(file=f"somewhere/run 0.5perc{suffix}").name == "run 0.5perc"


def test_a_reader_without_a_known_suffix_is_refused():
    with pytest.raises(ValueError, match="KNOWN_SUFFIXES"):
        reader(".other")(lambda request: None)
