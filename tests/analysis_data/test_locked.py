# SPDX-License-Identifier: Apache-2.0
"""A slip run whose wheel was stopped is named as that, not as one with a wrong sign."""

from __future__ import annotations

import numpy as np
import pytest
from steptable import step_table

from flatplank_data.checks import run_checks
from flatplank_data.table import MeasurementTable


def with_wheel(kappa: float, change) -> MeasurementTable:
    """A step run whose wheel turned otherwise."""
    table = step_table(kappa=kappa)
    wheel = change(table["wheel_velocity"], table["plank_position"])
    return MeasurementTable({**table.columns, "wheel_velocity": wheel}, table.info)


@pytest.mark.parametrize("kappa", [0.05, -0.05])
def test_a_wheel_that_stood_is_no_wrong_sign(kappa):
    table = with_wheel(kappa, lambda omega, x: np.where(x > 1.6, 1e-5, omega))
    (told,) = [p for p in run_checks(table)[1] if "wheel" in p.what or "kappa" in p.what]
    assert told.what.startswith("the wheel stood while the plank moved")
    assert told.fatal and "sign" not in f"{told.what} {told.remedy}"


def test_a_wrong_sign_is_still_one():
    table = with_wheel(0.05, lambda omega, x: omega * 0.95 / 1.05)
    assert any("turn the sign" in p.remedy for p in run_checks(table)[1])


def test_a_wheel_against_the_plank_is_still_one():
    table = with_wheel(0.05, lambda omega, x: -omega)
    assert any("turn against each other" in p.what for p in run_checks(table)[1])
