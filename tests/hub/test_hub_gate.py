# SPDX-License-Identifier: Apache-2.0
"""Voltages that are no numbers: flagged, without a force, and without a trace in later samples."""

from __future__ import annotations

import math

import pytest
from hub_inputs import bus, volts_from_wheel

from flatplank_control.load_control import LoadController, LoadParameters
from flatplank_hw.hub import HubParameters, MeasurementHub
from flatplank_hw.hub.appendix_a import gains
from flatplank_hw.samples import EncoderSample, HubSample, Wrench, flagged

P = HubParameters(tare_samples=20)
GOOD = volts_from_wheel(Wrench(100.0, 50.0, 300.0, 5.0, 0.0, 2.0), gains(P))
BAD = (math.nan, math.inf, -math.inf, 1e308, -1e308, 100.1)


def with_bad(channel: int, value: float) -> tuple[float, ...]:
    return (*GOOD[:channel], value, *GOOD[channel + 1 :])


def numbers(sample: HubSample) -> tuple[float, ...]:
    return (*sample.wheel, *sample.contact, sample.loaded_radius, sample.fz_filtered)


@pytest.mark.parametrize("value", BAD)
@pytest.mark.parametrize("channel", range(7))
def test_a_bad_voltage_leaves_no_trace(channel, value):
    fine, hit = MeasurementHub(P), MeasurementHub(P)
    for n in range(40):
        wanted = fine.step(bus(n, bridge_volts=GOOD, lvdt_volts=1.0))
        if n == 20:
            fields = {"bridge_volts": GOOD, "lvdt_volts": 1.0}
            bad = {"lvdt_volts": value} if channel == 6 else {
                "bridge_volts": with_bad(channel, value)
            }  # fmt: skip
            sample = hit.step(bus(n, **{**fields, **bad}))
            assert flagged(sample.saturated) == [
                ("C1", "C2", "C3", "C4", "C5", "C6", "LVDT")[channel]
            ]
            assert not any(math.isinf(x) for x in numbers(sample))
            assert math.isnan(sample.contact.fz) == (channel in (0, 4, 5))
            assert math.isnan(sample.loaded_radius) == (channel == 6)
            continue
        sample = hit.step(bus(n, bridge_volts=GOOD, lvdt_volts=1.0))
        assert sample.saturated == 0
        assert numbers(sample) == pytest.approx(numbers(wanted), rel=1e-12)


def test_a_bad_first_voltage_leaves_no_trace():
    hub = MeasurementHub(P)
    assert math.isnan(hub.step(bus(0, bridge_volts=with_bad(5, math.nan))).fz_filtered)
    for n in range(1, 50):
        sample = hub.step(bus(n, bridge_volts=GOOD))
    assert sample.fz_filtered == pytest.approx(300.0)


@pytest.mark.parametrize("value", BAD)
def test_a_tare_with_a_bad_voltage_is_given_up(value):
    hub = MeasurementHub(P)
    for n in range(100):
        hub.step(bus(n, bridge_volts=GOOD))
    assert hub.tare().accepted
    for n in range(100, 150):
        hub.step(bus(n, bridge_volts=with_bad(5, value) if n == 110 else GOOD))
    assert "zero unchanged" in hub.tare_status.reason
    assert not hub.tare_status.running
    assert hub.tare_status.zero == (0.0,) * 5


def test_saturation_is_a_flag_and_the_force_stays():
    hub = MeasurementHub(P)
    sample = hub.step(bus(0, bridge_volts=with_bad(5, 10.5)))
    assert flagged(sample.saturated) == ["C6"]
    assert math.isfinite(sample.fz_filtered)


@pytest.mark.parametrize("value", (math.nan, math.inf, -math.inf, 1e308))
def test_the_load_controller_forgets_a_bad_force(value):
    def of(fz: float) -> HubSample:
        force = Wrench(0.0, 0.0, fz, 0.0, 0.0, 0.0)
        return HubSample(0, 0, force, force, 0.3, 0.0, fz, False, 0)

    encoders = EncoderSample(0, 0, *([0.0] * 9), False, False, 0.0)
    controller = LoadController(LoadParameters(enabled=True))
    controller.set_load(1000.0)
    good = controller.reference(of(900.0), encoders)
    assert good.valid
    assert not controller.reference(of(value), encoders).valid
    again = controller.reference(of(900.0), encoders)
    assert again.valid and math.isfinite(again.value)


def test_a_tare_takes_the_zero_of_every_bridge():
    hub = MeasurementHub(P)
    for n in range(100):
        hub.step(bus(n, bridge_volts=GOOD))
    assert hub.tare().accepted
    for n in range(100, 150):
        sample = hub.step(bus(n, bridge_volts=GOOD))
    assert sample.wheel == pytest.approx((0.0,) * 6, abs=1e-9)
