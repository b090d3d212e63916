# SPDX-License-Identifier: Apache-2.0
"""Fits of a campaign by its model, and the fit file."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flatplank_analysis.identify import campaign as fit_file
from flatplank_analysis.identify.campaign import (
    FitFile,
    _fit_condition,
    carcass_fits,
    fit_campaign,
)
from flatplank_data.errors import FlatplankError
from flatplank_data.yaml_text import dump_yaml
from flatplank_validation.fits.campaigns import Truth, simulate_runs


def test_fits_of_a_campaign_by_its_model():
    quiet = simulate_runs(Truth(noise=1e-6, gain_scatter=0.0, slip_scatter=0.0,
                                carcass_scatter=0.0), np.random.default_rng(0))  # fmt: skip
    settings = FitFile("nonlinear", bounds={"c_cx": (3e5, 4e5)})
    found = fit_campaign(quiet, settings)
    assert found.fits[0].c_cx.at_bound == "lower" and found.to_json()["problems"] == []
    assert carcass_fits(quiet, settings)[0].c_cx.value == pytest.approx(3e5)
    # options of the carcass are none of the linear model
    assert fit_campaign(quiet[:6], replace(settings, model="linear")).model == "linear"
    assert "three or more" in _fit_condition("nonlinear", {}, quiet[:2])
    for runs, model, words in (
        (quiet, "mf", "no tire to start from"),
        ([], "linear", "no usable"),
    ):
        with pytest.raises(FlatplankError, match=words):
            fit_campaign(runs, FitFile(model))


def test_a_fit_file_says_what_it_does_not_understand():
    head = {"format": "flatplank-fit/1"}
    for raw, words in (
        ({"stages": 3}, "stages must be a list, not 3"),
        ({"bounds": {"PKX1": [1.0]}}, "bounds: PKX1 must have 2 values, not [1.0]"),
        ({"fixed": {"PKX1": "x"}}, "fixed: PKX1 must be a number, not 'x'"),
        ({"prior": {"PKX1": [1.0, -1.0]}}, "prior of PKX1 has spread -1"),
        ({"bounds": {"PKX1": [1.0, 1.0]}}, "bounds of PKX1 are 1, 1"),
        ({"geometry": {"q": 1.0}}, "geometry: unknown name 'q'"),
    ):
        with pytest.raises(FlatplankError) as error:
            fit_file.parse_fit(dump_yaml(head | raw), "f.yaml")
        assert words in str(error.value)
    good = fit_file.parse_fit(
        dump_yaml(head | {"joint": False, "fixed": {"friction": 0.9, "PKX1": 20}})
    )
    assert good.joint is False and good.carcass_options() == {"friction": 0.9}
    assert good.fixed == {"friction": 0.9, "PKX1": 20.0}
    with pytest.raises(FlatplankError, match="format is not"):
        fit_file.parse_fit("[]")


def test_a_fit_file_that_cannot_be_read_is_one_line(tmp_path):
    path = tmp_path / "fit.yaml"
    for content, words in (
        (b"format: flatplank-fit/1\njoint: [\n", "fit.yaml line 3: not YAML; correct"),
        (b"a: \x00\n", "fit.yaml: not YAML; correct"),
        (b"a: \xff\n", "fit.yaml: is no text; give a fit file"),
        (b"format: flatplank-fit/1\nstages: [1]\n", "stages: unknown name '1'; "),
        (b"format: flatplank-fit/1\n5: 1\n", "unknown parameter '5'; known are "),
        (b"format: flatplank-fit/1\nbounds: {1: [0, 1]}\n", "bounds: unknown name '1'; "),
        (b"format: flatplank-fit/1\nprior: {2: [0, 1]}\n", "prior: unknown name '2'; "),
        (b"format: flatplank-fit/1\nfixed: {3: 0}\n", "fixed: unknown name '3'; "),
        (b"- 1\n", "format is not flatplank-fit/1; begin with format: flatplank-fit/1"),
    ):
        path.write_bytes(content)
        with pytest.raises(FlatplankError) as error:
            fit_file.read_fit_file(str(path))
        assert words in str(error.value) and "fit.yaml" in str(error.value)
    with pytest.raises(FlatplankError, match="No such file"):
        fit_file.read_fit_file(str(tmp_path / "none.yaml"))


def test_what_stands_in_a_fit_file_is_of_its_type():
    raw = {"format": "flatplank-fit/1", "model": 7, "campaigns": [1, "two"], "tire": 3,
           "bounds": {"c_cx": ["1e5", 2e5]}, "prior": {"PKX1": [1, "2"]},
           "weights": {"fx": "2"}, "free": ["PKX2"]}  # fmt: skip
    fit = fit_file.parse_fit(dump_yaml(raw))
    assert (fit.model, fit.campaigns, fit.tire) == ("7", ("1", "two"), "3")
    assert fit.bounds == {"c_cx": (1e5, 2e5)} and fit.prior == {"PKX1": (1.0, 2.0)}
    assert fit.weights == {"fx": 2.0} and fit.free == ("PKX2",) and fit.joint is True
    assert fit.carcass_options() == {"bounds": (1e5, 2e5)}
    assert FitFile().carcass_options() == {}
