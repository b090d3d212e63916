# SPDX-License-Identifier: Apache-2.0
"""Hub: constants of the set-up, motion of the plank, counter of the wheel, drive moment, files."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hub_inputs import bus, volts_from_wheel

from flatplank_hw.hub import HubParameters, MeasurementHub
from flatplank_hw.hub.appendix_a import force_balance, gains, motor_torque
from flatplank_hw.hub.hub import TareStatus
from flatplank_hw.hub.parasitic import ParasiticFit, Sine, fit_from_text, fit_to_text
from flatplank_hw.samples import Wrench

P = HubParameters(tare_samples=20)
VOLTS = volts_from_wheel(Wrench(100.0, 200.0, 300.0, 10.0, 0.0, 30.0), gains(P))
NONE = (0.0,) * 5
SETUP = {
    "et_value": 0.07, "adapter_thickness": 0.05, "wheel_camber_deg": -3.0,
    "road_camber_offset_deg": 1.5,
}  # fmt: skip


@pytest.mark.parametrize("names", [*([n] for n in SETUP), list(SETUP)], ids=str)
def test_changed_constants_give_what_a_new_hub_gives(names):
    """Also where the camber encoder stands still."""
    before = replace(P, wheel_camber_deg=1.0, road_camber_offset_deg=0.5)
    changed = replace(before, **{name: SETUP[name] for name in names})
    hub, fresh = MeasurementHub(before), MeasurementHub(changed)
    old = hub.step(bus(0, bridge_volts=VOLTS, camber_counts=300))
    hub.set_constants(changed)
    new = hub.step(bus(1, bridge_volts=VOLTS, camber_counts=300))
    wanted = fresh.step(bus(1, bridge_volts=VOLTS, camber_counts=300))
    assert new.wheel == wanted.wheel and new.contact == wanted.contact != old.contact
    assert new.total_camber == wanted.total_camber
    camber = changed.wheel_camber_deg + changed.road_camber_offset_deg
    turned = 300.0 * 360.0 / P.camber_counts_per_turn
    assert math.degrees(new.total_camber) == pytest.approx(camber + turned)


def test_other_parameters_cannot_change_while_the_bench_runs():
    hub = MeasurementHub(P)
    with pytest.raises(ValueError, match="k_fy"):
        hub.set_constants(replace(P, k_fy=4.0))
    assert hub.parameters == P


@pytest.mark.parametrize(
    ("jump", "rests"), [(0, True), (1, True), (-1, True), (2, False), (-2, False), (3, False)]
)
def test_the_plank_moves_from_two_counts_on(jump, rests):
    hub = MeasurementHub(P)
    for n in range(100):
        hub.step(bus(n, plank_counts=5000))
    hub.step(bus(100, plank_counts=5000 + jump))
    assert hub.tare().accepted is rests


def test_the_plank_may_stand_anywhere_at_the_start():
    hub = MeasurementHub(P)
    hub.step(bus(0, plank_counts=5000))
    assert hub.tare_status == TareStatus(False, -1, NONE, "")
    assert hub.tare().accepted


def test_the_first_load_is_the_filtered_one_and_the_second_is_weighted_by_the_period():
    hub = MeasurementHub(P)
    assert hub.step(bus(5, bridge_volts=VOLTS)).fz_filtered == pytest.approx(300.0)
    twice = tuple(2.0 * v for v in VOLTS)
    weight = 1.0 - math.exp(-2.0 * math.pi * P.fz_filter_hz * 3 * 4e-3)
    later = hub.step(bus(8, bridge_volts=twice)).fz_filtered
    assert later == pytest.approx(300.0 * (1.0 + weight))


SINES = tuple(Sine(0.1, 1.1, 0.2 * k, 0.0, 0.0) for k in range(5))


def test_the_wheel_is_counted_while_the_filter_is_off():
    """Three quarters of the range of the counter turn past before the filter is on."""
    hub, step = MeasurementHub(P), 2**30
    hub.use_fit(ParasiticFit("m", "d", SINES))
    for n in range(4):
        raw = (n * step + 2**31) % 2**32 - 2**31
        sample = hub.step(bus(n, wheel_counts=raw, bridge_volts=(0.0,) * 6))
        assert sample.wheel.fy == 0.0 and not sample.filter_on
    hub.set_filter(True)
    x = 3 * step * 2.0 * math.pi / P.wheel_counts_per_turn
    sample = hub.step(bus(4, wheel_counts=raw))
    assert sample.filter_on
    assert sample.wheel.fy == pytest.approx(-gains(P).c1 * 0.1 * math.sin(1.1 * x), rel=1e-6)


@pytest.mark.parametrize("counts", [2**23, -(2**23)])
@pytest.mark.parametrize("sign", [1, -1])
def test_the_drive_moment_is_that_of_the_motor_beyond_its_friction(counts, sign):
    """Friction between the points of the table, at 150 rad/s: 0.9 N m; (5.3)."""
    p = HubParameters(motor_counts_per_turn=counts, friction_speed=(0.0, 100.0, 200.0),
                      friction_torque=(0.1, 0.8, 1.0), efficiency=0.4)  # fmt: skip
    inputs = bus()
    turning = sign * round(150.0 * 2**23 / (2.0 * math.pi))
    for torque, wanted in ((50000, -0.4 * 30.32 * 47 * 4.1), (8000, 0.0), (-50000, 0.0)):
        axes = (inputs.axes[0]._replace(torque=torque, velocity=turning), *inputs.axes[1:])
        moment = motor_torque(inputs._replace(axes=axes), 100.0, 0.3, p)
        assert moment == pytest.approx(wanted, rel=1e-4)
    assert force_balance(inputs, 100.0, 0.3, p) == pytest.approx(-30.0)


FIT = fit_to_text(ParasiticFit("7", "d", SINES))
BAD = {
    "no mapping": (lambda t: "- 1\n", "a.yaml: format is not flatplank-parasitic-fit/1"),
    "no channels": (lambda t: t[: t.index("channels:")] + "channels: 3\n",
                    "a.yaml: channels: expected keys with values"),
    "another channel": (lambda t: t.replace("  C5:", "  C4:"),
                        "a.yaml: channels: unknown parameter 'C4'"),
    "two keys less": (lambda t: t.replace("mounting:", "#").replace("date:", "#"),
                      "a.yaml: missing mounting, date"),
    "a number as channel": (lambda t: t[: t.index("  C6:")] + "  C6: 5\n",
                            "a.yaml: channels: C6: expected keys with values"),
    "a text": (lambda t: t.replace("offset_v: 0.0", "offset_v: much", 1),
               "a.yaml: channels: C1: offset_v must be a number, not 'much'"),
    "a switch": (lambda t: t.replace("offset_v: 0.0", "offset_v: true", 1),
                 "a.yaml: channels: C1: offset_v must be a number, not True"),
    "an amplitude": (lambda t: t.replace("amplitude_v: 0.1", "amplitude_v: -0.1", 1),
                     "a.yaml: channels: C1: amplitude_v is -0.1 V"),
    "a frequency": (lambda t: t.replace("frequency: 1.1", "frequency: 11", 1),
                    "a.yaml: channels: C1: frequency is 11 1/rad"),
}  # fmt: skip


@pytest.mark.parametrize("case", BAD)
def test_a_file_that_is_no_fit_is_told_with_the_place(case):
    change, message = BAD[case]
    text = change(FIT)
    assert text != FIT
    with pytest.raises(ValueError) as caught:
        fit_from_text(text, "a.yaml")
    assert str(caught.value).startswith(message) and "\n" not in str(caught.value)


def test_whole_numbers_are_numbers():
    found = fit_from_text(FIT.replace("frequency: 1.1", "frequency: 1", 1), "a.yaml")
    assert found.sines[0] == Sine(0.1, 1.0, 0.0, 0.0, 0.0) and found.mounting == "7"
    assert found.offsets == NONE
