# SPDX-License-Identifier: Apache-2.0
"""The benchmark of load controller and steering hold keeps what it promises."""

from __future__ import annotations

import pytest

from flatplank_control.bench.hold_bench import load_over_the_road, load_step, steering


def test_the_load_is_within_1_percent_through_undulation_and_braking():
    free = load_over_the_road(False, -0.1, 1.3)["worst_percent"]
    held = load_over_the_road(True, -0.1, 1.3)["worst_percent"]
    assert held < 1.0 < free


@pytest.mark.parametrize("tire", ["toyo", "racing"])
def test_no_overshoot_over_2_percent(tire):
    found = load_step(2000.0, 3700.0, tire)
    assert found["overshoot_percent"] < 2.0
    assert abs(found["end_percent"]) < 0.5


@pytest.mark.parametrize("way", ["by_moment", "by_hub_encoder"])
def test_the_steering_is_held_against_0_2_deg_of_play(way):
    assert abs(steering("free", distance=0.8)["mean_deg"]) > 0.08
    assert steering(way, distance=0.8)["worst_deg"] < 0.03
