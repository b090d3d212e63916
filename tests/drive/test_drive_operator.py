# SPDX-License-Identifier: Apache-2.0
"""An operator in charge who falls silent: every axis that moves by power stops, and nobody is
locked out."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from drive_rig import PERIOD, Rig, up

from flatplank_data.params import load_parameters
from flatplank_hw.bus.image import AXES
from flatplank_hw.drive.safety import RULES

CONFIG = Path(__file__).parents[2] / "ros_ws/src/flatplank_hw/config"


def parameters(axis: str) -> dict[str, Any]:
    """Of the drive of an axis, as its node has them."""
    found = load_parameters(CONFIG / f"{axis}_drive.yaml")
    return {**found, "rules": tuple(found["rules"])}


def turning(axis: str) -> Rig:
    """The axis moves at half its speed over an empty road, with an operator in charge."""
    p = parameters(axis)
    rig = up("velocity", 0.5 * p["speed_limit"], **p)
    hear = rig.drive.claim if axis == "wheel" else rig.drive.adopt_claim
    assert hear("panel").accepted
    rig.beat = "panel"
    rig.run(250)
    assert rig.velocity == pytest.approx(0.5 * p["speed_limit"], rel=1e-3)
    return rig


@pytest.mark.parametrize("axis", AXES)
def test_every_axis_stops_when_the_operator_in_charge_is_gone(axis: str) -> None:
    rig = turning(axis)
    rig.beat, start = "", rig.n
    while rig.velocity != 0.0:
        rig.cycle()
        assert (rig.n - start) * PERIOD * 1e-9 <= 0.5 + 0.08
    assert rig.run(1).stop_reason == RULES["heartbeat"].code
    rig.beat = "panel"
    assert rig.run(100).stop_reason == RULES["heartbeat"].code, "a beat alone starts nothing"
    assert rig.velocity == 0.0
    assert rig.drive.enable().accepted


@pytest.mark.parametrize("axis", AXES)
def test_an_operator_who_gives_the_charge_back_may_fall_silent(axis: str) -> None:
    rig = turning(axis)
    assert (rig.drive.release() if axis == "wheel" else rig.drive.adopt_claim("")).accepted
    rig.beat = ""
    rig.run(250)
    assert rig.velocity != 0.0


def test_who_fell_silent_while_nothing_moved_locks_nobody_out() -> None:
    rig = Rig()
    rig.run(2)
    assert rig.drive.claim("panel").accepted
    rig.run(10)
    assert "'panel' is in charge" in rig.drive.claim("other").reason
    rig.run(130)
    assert rig.drive.claim("other").accepted
    assert rig.drive.enable().accepted


def test_a_renewed_claim_is_no_beat() -> None:
    rig = turning("wheel")
    rig.beat, start = "", rig.n
    while rig.velocity != 0.0:
        assert rig.drive.claim("panel").accepted
        rig.cycle()
        assert (rig.n - start) * PERIOD * 1e-9 <= 0.5 + 0.08
    assert rig.run(1).stop_reason == RULES["heartbeat"].code


def test_a_lapsed_claim_holds_again_when_it_is_renewed() -> None:
    rig = Rig()
    rig.run(2)
    assert rig.drive.claim("panel").accepted
    rig.run(250)
    assert rig.drive.claim("panel").accepted
    assert rig.drive.enable().accepted
    assert rig.drive.set_operation_mode("velocity", 0.1).accepted
    assert rig.run(250).stop_reason == RULES["heartbeat"].code
    assert rig.velocity == 0.0
