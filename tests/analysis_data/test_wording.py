# SPDX-License-Identifier: Apache-2.0
"""Numbers as people read them."""

from __future__ import annotations

import math

import pytest

from flatplank_data.wording import plain, quantity, sized, span


@pytest.mark.parametrize(
    ("value", "digits", "text"),
    [
        (99.6, 2, "100"),
        (0.0009123, 3, "0.000912"),
        (-83_012.0, 3, "-83000"),
        (0.05, 3, "0.05"),
        (2.5e-6, 3, "0.0000025"),
        (3.2e7, 2, "32000000"),
        (-3e-9, 3, "0"),
        (0.0, 3, "0"),
        (math.nan, 3, "nan"),
        (math.inf, 3, "inf"),
    ],
)
def test_a_number_for_people_has_no_power_of_ten(value, digits, text):
    assert plain(value, digits) == text


def test_the_unit_stands_behind_and_a_share_is_in_percent():
    assert (quantity(79.96, "N"), quantity(0.1, "1")) == ("80 N", "10 %")
    assert (quantity(1.05, "-"), span(-0.03, 0.03, "1")) == ("1.05", "-3 to 3 %")
    assert sized(7e-4, (6e-4, 8e-4), "m") == "0.7 mm (90 %: 0.6 to 0.8 mm)"
    assert quantity(0.028, "m", axis=(0.028, 0.14)) == "0.028 m"


def test_a_range_has_the_unit_of_its_axis():
    assert span(-0.044, 0.013, "m") == "-44 to 13 mm"
    assert span(-0.044, 0.013, "m", axis=(-1.5, 2.6)) == "-0.044 to 0.013 m"
    assert span(0.0, math.pi, "rad", axis=(0.0, 2.0 * math.pi)) == "0 to 180 deg"
