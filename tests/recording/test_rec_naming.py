# SPDX-License-Identifier: Apache-2.0
"""Names of Appendix F, and names that must not leave the data folder."""

from __future__ import annotations

import pytest
import rec_samples as samples

from flatplank_data.errors import RecordingError
from flatplank_data.names import parse_name as facts_of_name
from flatplank_data.naming import (
    SETTINGS,
    MeasurementName,
    check_name,
    free_name,
    parse_name,
)

THESIS = {
    "BMW_ERR_REL_LNG_T_p23_Fz1625_1": MeasurementName("BMW", "ERR_REL_LNG", 2.3, 1625.0, 1),
    "TOY_REL_LNG_5perc_T_p25_Fz5550_2": MeasurementName(
        "TOY", "REL_LNG", 2.5, 5550.0, 2, kappa_percent=5.0
    ),
    "TOY_REL_COM_CAM_5deg_1deg_2perc_T_p25_Fz3700_3": MeasurementName(
        "TOY", "REL_COM_CAM", 2.5, 3700.0, 3, kappa_percent=2.0, alpha_deg=1.0, gamma_deg=5.0
    ),
}


@pytest.mark.parametrize("name", THESIS)
def test_examples_of_the_thesis(name):
    assert parse_name(name) == THESIS[name]
    assert str(THESIS[name]) == name


@pytest.mark.parametrize("kind", SETTINGS)
@pytest.mark.parametrize("run", [1, 2, 13])
def test_every_kind_comes_back(kind, run):
    said = dict(zip(SETTINGS[kind], (-2.5, 1.0, -10.0), strict=False))
    name = MeasurementName("TOY", kind, 2.5, 850.0, 3, run=run, **said)
    assert parse_name(str(name)) == name


@pytest.mark.parametrize("waveform", ["sine", "triangle", "double_step"])
def test_a_waveform_has_a_name_of_its_own(waveform):
    record = samples.toyo(waveform={"name": waveform}, gamma_deg=5.0)
    assert record.name == f"TOY_REL_LNG_CAM_{waveform.upper()}_5deg_5perc_T_p25_Fz5550_2"
    assert str(parse_name(record.name)) == record.name
    facts = facts_of_name(record.name)
    assert facts["waveform"] == {"name": waveform} and facts["kappa"] == 0.05
    assert samples.toyo(waveform={"name": "step"}).name == samples.toyo().name


def test_a_repeat_in_pure_slip_has_no_angle():
    name = MeasurementName("TOY", "REP_REL", 2.5, 3700.0, 1, kappa_percent=-1.0)
    assert str(name) == "TOY_REP_REL_-1perc_T_p25_Fz3700_1"
    assert parse_name(str(name)) == name


def test_names_follow_from_the_record():
    assert samples.toyo().name == "TOY_REL_LNG_5perc_T_p25_Fz5550_2"
    assert samples.toyo(kappa=-0.1).name == "TOY_REL_LNG_-10perc_T_p25_Fz5550_2"
    combined = samples.toyo(alpha_deg=1.0, gamma_deg=5.0)
    assert combined.name == "TOY_REL_COM_CAM_5deg_1deg_5perc_T_p25_Fz5550_2"
    free = samples.toyo(measurement="free_rolling", alpha_deg=2.0)
    assert free.name == "TOY_ERR_REL_COM_2deg_T_p25_Fz5550_2"
    assert samples.toyo(measurement="stiffness").name == "TOY_STF_T_p25_Fz5550_2"
    assert samples.toyo(measurement="unloaded_turn").name == "TOY_UNLOADED_TURN_T_p25_Fz5550_2"


@pytest.mark.parametrize(
    "name",
    [
        "",
        ".",
        "..",
        "../x",
        "a/b",
        "/etc/x",
        "a\\b",
        "-x",
        ".hidden",
        "a b",
        "a\0b",
        "a\nb",
        "x.",
        "ü",
        "x" * 201,
    ],
)
def test_names_that_are_more_than_a_name_are_refused(name):
    with pytest.raises(RecordingError, match="not a name"):
        check_name(name)


@pytest.mark.parametrize(
    "name",
    [
        "TOY",
        "TOY_REL_LNG_T_p25_Fz5550_2",
        "TOY_REL_LNG_5deg_T_p25_Fz5550_2",
        "TOY_STF_5perc_T_p25_Fz1_1",
    ],
)
def test_other_names_are_not_parsed(name):
    with pytest.raises(RecordingError, match=name):
        parse_name(name)


def test_further_runs_are_numbered(tmp_path):
    names = []
    for _ in range(3):
        names.append(free_name(tmp_path, "TOY_STF_T_p25_Fz3700_1"))
        (tmp_path / names[-1]).mkdir()
    assert [name[-4:] for name in names] == ["00_1", "_r02", "_r03"]
    assert parse_name(names[2]).run == 3
