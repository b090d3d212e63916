# SPDX-License-Identifier: Apache-2.0
"""Estimates: intervals, notes, JSON."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import t as student

from flatplank_analysis.identify import repeats
from flatplank_analysis.identify.results import Confusion, Estimate, Fit, to_plain


def test_intervals_and_json_of_estimates():
    one = Estimate("c", 10.0, "N", 2.0, dof=4.0)
    reach = student.ppf(0.95, 4.0) * 2.0
    assert one.interval() == pytest.approx((10.0 - reach, 10.0 + reach))
    assert one.interval(0.5)[1] == pytest.approx(10.0 + student.ppf(0.75, 4.0) * 2.0)
    assert replace(one, dof=0.1).interval()[1] == pytest.approx(
        10.0 + student.ppf(0.95, 1.0) * 2.0
    )
    assert replace(one, determined=False).interval() == (-math.inf, math.inf)
    assert replace(one, std_error=math.nan).interval() == (-math.inf, math.inf)
    assert (one.times(-2.0).value, one.times(3.0).std_error) == (-20.0, 6.0)
    assert one.with_note("a").with_note("b").note == "a; b" and one.with_note("").note == ""
    assert one.to_json()["interval90"] == pytest.approx([10.0 - reach, 10.0 + reach])
    assert Confusion(("A", "B"), 0.5, "s", "r").to_json() == {
        "names": ["A", "B"], "correlation": 0.5, "statement": "s", "remedy": "r"}  # fmt: skip
    json.dumps(Fit("m", (one,), np.eye(1), (Confusion(("A",), math.nan, "", ""),)).to_json())
    mixed = {1: (np.float64(2.0), np.int64(3)), "b": np.array([np.inf]), "c": np.bool_(True)}
    assert to_plain(mixed) == {"1": [2.0, 3], "b": [None], "c": True}
    assert repeats.plain_condition("3000 N") == "3000 N"
    assert repeats.plain_condition(7) == "7"
