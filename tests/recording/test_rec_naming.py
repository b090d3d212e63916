# SPDX-License-Identifier: Apache-2.0
"""Names of Appendix F, and names that must not leave the data folder."""

from __future__ import annotations

import math

import pytest
import rec_samples as samples

from flatplank_data.errors import RecordingError
from flatplank_data.naming import SETTINGS, check_name, facts_of_name, free_name, name_of, numbered
from flatplank_data.run_record import RunRecord

MEASUREMENTS = {"REL": "slip", "ERR": "free_rolling", "STF": "stiffness", "REP": "repeat"}


@pytest.mark.parametrize("kind", SETTINGS)
@pytest.mark.parametrize("number", [1, 2, 13])
def test_every_kind_comes_back(kind, number):
    said = dict.fromkeys(("gamma_deg", "alpha_deg"), 0.0) | {"kappa": -0.1}
    said |= {key: -2.5 for key in SETTINGS[kind] if key != "kappa"}
    said |= {"tire": "TOY", "fz": 850.0, "pressure": 2.5, "start": 3}
    record = RunRecord(measurement=MEASUREMENTS[kind[:3]], **said)
    name = numbered(name_of(vars(record)), number)
    assert name.startswith(f"TOY_{kind}_")
    facts = facts_of_name(name)
    told = {key: said[key] for key in ("tire", "fz", "pressure", "start", *SETTINGS[kind])}
    assert {key: facts[key] for key in told} == told
    assert facts["repeat"] == number


@pytest.mark.parametrize(
    "measurement",
    [
        "slip", "free_rolling", "stiffness", "stiffness_longitudinal", "stiffness_lateral",
        "cleat", "parking", "turning", "camber_sweep", "locked_wheel", "unloaded_turn",
    ],
)  # fmt: skip
def test_every_measurement_comes_back(measurement):
    record = samples.toyo(measurement=measurement)
    assert facts_of_name(record.name)["measurement"] == measurement


@pytest.mark.parametrize("words", ["", "_5perc", "_rel_lng_5perc", "_REP_REL_5perc"])
def test_other_names_are_of_slip_steps(words):
    assert facts_of_name(f"TOY{words}_T_p25_Fz3700_1")["measurement"] == "slip"


UNUSUAL = {
    "TOY_REL_LNG_5perc_T_p5_Fz3700_1": {"pressure": 0.5},
    "TOY_REL_LNG_5perc_T_p0.5_Fz3700_1": {"pressure": 0.05},
    "TOY_REL_LNG_5perc_T_p0_Fz0_1": {"pressure": math.nan, "fz": math.nan},
    "A-B_REL_LNG_5perc_T_p25_Fz3700_1": {"tire": "A-B"},
    "XXX_REL_LNG_5perc_T_p25_Fz3700_1": {"tire": ""},
}
"""name -> what is unusual about its run; there were two makers of names, which differed here"""


@pytest.mark.parametrize("name", UNUSUAL)
def test_unusual_runs_have_one_name(name):
    usual = {"tire": "TOY", "kappa": 0.05, "fz": 3700.0, "pressure": 2.5}
    assert name_of(vars(RunRecord(**(usual | UNUSUAL[name])))) == name


def test_a_pressure_of_two_digits_is_read():
    assert facts_of_name("TOY_REL_LNG_5perc_T_p05_Fz3700_1")["pressure"] == 0.5


@pytest.mark.parametrize("waveform", ["sine", "triangle", "double_step"])
def test_a_waveform_has_a_name_of_its_own(waveform):
    record = samples.toyo(waveform={"name": waveform}, gamma_deg=5.0)
    assert record.name == f"TOY_REL_LNG_CAM_{waveform.upper()}_5deg_5perc_T_p25_Fz5550_2"
    facts = facts_of_name(record.name)
    assert facts["waveform"] == {"name": waveform} and facts["kappa"] == 0.05
    assert samples.toyo(waveform={"name": "step"}).name == samples.toyo().name


def test_a_repeat_in_pure_slip_has_no_angle():
    record = samples.toyo(measurement="repeat", kappa=-0.01)
    assert record.name == "TOY_REP_REL_-1perc_T_p25_Fz5550_2"
    assert facts_of_name(record.name)["kappa"] == -0.01


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


def test_further_runs_are_numbered(tmp_path):
    names = []
    for _ in range(3):
        names.append(free_name(tmp_path, "TOY_STF_T_p25_Fz3700_1"))
        (tmp_path / names[-1]).mkdir()
    assert [name[-4:] for name in names] == ["00_1", "_r02", "_r03"]
    assert facts_of_name(names[2])["repeat"] == 3
