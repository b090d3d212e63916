# SPDX-License-Identifier: Apache-2.0
"""Columns and keys with the wrong sign are named before anything is fitted, and can be turned."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import yaml
from bristles import Truth, campaign, save
from scipy.signal import lfilter
from third_campaigns import tables

from flatplank_analysis.contact_patch.data import from_tables
from flatplank_analysis.contact_patch.signs import wrong_signs
from flatplank_data.campaign import Campaign
from flatplank_data.errors import FlatplankError
from flatplank_data.run_record import RunRecord
from flatplank_data.table import MeasurementTable


@pytest.fixture(scope="module")
def combined():
    return tables("combined", seed=3, scatter=0.01)


def turned(runs, name):
    """The same runs with the other sign of a column or a key."""
    out = []
    for t in runs:
        columns = {k: -v if k == name else v for k, v in t.columns.items()}
        info = (
            replace(t.info, **{name: -getattr(t.info, name)}) if hasattr(t.info, name) else t.info
        )
        out.append(MeasurementTable(columns, t.info if name in t.columns else info))
    return out


def test_iso_signs_are_not_doubted(combined):
    assert wrong_signs(combined) == ()
    assert wrong_signs(campaign(Truth(seed=3, slips=(-0.05, 0.01, 0.05)))) == ()


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("fz", ("fz",)),
        ("wheel_angle", ("wheel_angle", "plank_position")),
        ("plank_position", ("wheel_angle", "plank_position")),
        ("fx", ("fx",)),
        ("kappa", ("kappa",)),
        ("alpha_deg", ("alpha_deg", "fy")),
        ("fy", ("alpha_deg", "fy")),
    ],
)
def test_one_wrong_sign_is_named_and_no_other(combined, name, said):
    (found,) = wrong_signs(turned(combined, name))
    assert found.names == said
    assert "\n" not in str(found) and "turn: [" in str(found)
    if name in said:
        assert f"[{name}]" in found.remedy


def shaped(wave, slip, names=()):
    """Four runs of a wheel that follows slip(distance) from 0.5 m on and of a tire with a
    relaxation length of 0.2 m; the columns `names` have the other sign."""
    place = np.linspace(0.0, 4.0, 1601)
    kappa = np.array([slip(x - 0.5) if x >= 0.5 else 0.0 for x in place])
    step, sigma = place[1], 0.2
    late = lfilter([step / (sigma + step)], [1.0, -sigma / (sigma + step)], kappa)
    noise = np.random.default_rng(4)
    out = []
    for number in range(1, 5):
        columns = {
            "time": place / 0.03,
            "plank_position": place,
            "wheel_angle": np.cumsum(1.0 + kappa) * step / 0.31,
            "fx": 6e4 * late + noise.normal(0.0, 5.0, len(place)),
            "fy": noise.normal(0.0, 5.0, len(place)),
            "fz": np.full(len(place), 3700.0),
        }
        turned = {n: -v if n in names else v for n, v in columns.items()}
        info = RunRecord(
            file=f"run{number}.parquet", kappa=0.02, fz=3700.0, alpha_deg=0.0, repeat=number,
            step_position=0.5, waveform=wave,
        )  # fmt: skip
        out.append(MeasurementTable(turned, info))
    return out


WAVES = [
    ({"name": "sine", "amplitude": 0.02, "wavelength": 1.3},
     lambda x: 0.02 * np.sin(2.0 * np.pi * x / 1.3)),
    ({"name": "triangle", "amplitude": -0.02, "wavelength": 2.0},
     lambda x: -0.02 * (2.0 / np.pi) * np.arcsin(np.sin(np.pi * x))),
    ({"name": "double_step", "kappa_1": 0.02, "kappa_2": -0.03, "length": 1.0},
     lambda x: 0.02 if x < 1.0 else -0.03),
    ({"name": "step", "kappa": 0.02, "length": 0.8}, lambda x: 0.02 if x < 0.8 else 0.0),
]  # fmt: skip


@pytest.mark.parametrize(("wave", "slip"), WAVES, ids=[w["name"] for w, _ in WAVES])
def test_slip_is_compared_with_the_commanded_waveform_sample_by_sample(wave, slip):
    assert wrong_signs(shaped(wave, slip)) == ()
    (found,) = wrong_signs(shaped(wave, slip, names=["fx"]))
    assert found.names == ("fx",)


def test_an_unknown_waveform_determines_no_sign():
    _, slip = WAVES[0]
    assert wrong_signs(shaped({"name": "varying"}, slip)) == ()
    assert wrong_signs(shaped({"name": "sine", "amplitude": "large"}, slip)) == ()


def test_the_runs_carry_what_was_seen(combined):
    assert from_tables(combined).signs == ()
    (found,) = from_tables(turned(combined, "alpha_deg")).signs
    assert "alpha > 0 gives Fy < 0" in str(found)


def test_camber_thrust_with_the_wrong_sign():
    runs = campaign(Truth(seed=4, slips=(0.0,), repeats=3))
    cambered = []
    for gamma in (-3.0, 3.0):
        for t in runs:
            columns = dict(t.columns, fy=t["fy"] - 60.0 * gamma)
            cambered.append(MeasurementTable(columns, replace(t.info, gamma_deg=gamma)))
    assert wrong_signs(cambered) == ()
    (found,) = wrong_signs(turned(cambered, "gamma_deg"))
    assert found.names == ("gamma_deg", "fy")


def test_the_line_that_is_told_mends_it(tmp_path, combined):
    folder = save(turned(combined, "alpha_deg"), tmp_path)
    file = folder / "campaign.yaml"
    raw = yaml.safe_load(file.read_text())
    runs = [run.table() for run in Campaign.load(folder).runs]
    (found,) = wrong_signs(runs)
    raw["mapping"] = {"turn": [found.names[0]]}
    file.write_text(yaml.safe_dump(raw))
    mended = [run.table() for run in Campaign.load(folder).runs]
    assert wrong_signs(mended) == ()
    assert {t.info.alpha_deg for t in mended} == {0.0, 5.0}
    raw["mapping"] = {"turn": "fy"}
    file.write_text(yaml.safe_dump(raw))
    assert wrong_signs([run.table() for run in Campaign.load(folder).runs]) == ()
    raw["mapping"] = {"turn": ["side_force"]}
    file.write_text(yaml.safe_dump(raw))
    with pytest.raises(FlatplankError, match="no column or key 'side_force'"):
        Campaign.load(folder)
