# SPDX-License-Identifier: Apache-2.0
"""Parasitic filter: identification from a three-turn run, file, switching, effect on the
forces."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hub_inputs import bus

from flatplank_hw.hub import HubParameters, MeasurementHub, parasitic
from flatplank_hw.hub.identify import identify_fit
from flatplank_hw.hub.parasitic import INDEX, ParasiticFit, Sine, fit_to_text

TRUE = (
    Sine(0.004, 1.0, 0.4, 0.01, 0.0),
    Sine(0.15, 1.0, 0.3, -0.02, 0.0),
    Sine(0.12, 1.0, -2.0, 0.03, 0.0),
    Sine(0.09, 1.0, 1.3, 0.00, 0.0),
    Sine(0.07, 1.0, 2.9, -0.05, 0.0),
)
FIT = ParasiticFit("Toyo on adapter 3", "2023-05-04", TRUE)


def sine_of(s: Sine, x):
    """The sine of one channel [V] at wheel angles [rad], with its constant part."""
    return s.amplitude_v * np.sin(s.frequency * x + s.phase_rad) + s.offset_v


def three_turns(noise: float, n: int = 6000):
    rng = np.random.default_rng(1)
    angle = 0.7 + np.linspace(0.0, 6.0 * math.pi, n)
    volts = rng.normal(0.0, noise, (n, 6))
    for column, s in zip(INDEX, TRUE, strict=True):
        volts[:, column] += sine_of(s, angle)
    # the speeding up and slowing down in the first and last turn must not enter the fit
    volts[:500] += 0.3
    volts[-500:] -= 0.3
    return angle, volts


def test_identification_recovers_the_sines():
    angle, volts = three_turns(noise=0.002)
    fit = identify_fit(angle, volts, "m", "2023-05-04")
    for found, true in zip(fit.sines, TRUE, strict=True):
        x = np.linspace(angle[0] + 2 * math.pi, angle[0] + 4 * math.pi, 200)
        y = [sine_of(s, x) for s in (found, true)]
        assert np.max(np.abs(y[0] - y[1])) < 5e-4
        assert found.residual_rms_v == pytest.approx(0.002, rel=0.1)


def test_identification_of_a_wheel_that_turns_backwards():
    angle, volts = three_turns(noise=0.0)
    fit = identify_fit(angle[::-1], volts[::-1], "m", "d")
    assert fit.sines[1].amplitude_v == pytest.approx(0.15, rel=1e-6)


def test_a_short_run_is_refused():
    angle, volts = three_turns(noise=0.0)
    with pytest.raises(ValueError, match="the wheel turned 360 deg and 720 deg are needed"):
        identify_fit(angle[:2001], volts[:2001], "m", "d")
    with pytest.raises(ValueError, match="NaN"):
        identify_fit(np.full(10, np.nan), np.zeros((10, 6)), "m", "d")


def test_file_round_trip(tmp_path):
    path = tmp_path / "fit.yaml"
    path.write_text(fit_to_text(FIT), encoding="utf-8")
    assert parasitic.load_fit(path) == FIT
    path.write_text(fit_to_text(replace(FIT, date="2026-11-29", mounting="7")).replace("'", ""))
    found = parasitic.load_fit(path)
    assert (found.date, found.mounting) == ("2026-11-29", "7")  # YAML has types for both


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("amplitude_v: 0.15", "amplitude_v: .nan", "C2: amplitude_v is nan"),
        ("  C6:", "  C7:", "unknown parameter 'C7'"),
        ("mounting:", "mountng:", "unknown parameter 'mountng'; the nearest is 'mounting'"),
        ("flatplank-parasitic-fit/1", "else", "format is not flatplank-parasitic-fit/1"),
    ],
)
def test_bad_files_are_refused(tmp_path, old, new, message):
    path = tmp_path / "fit.yaml"
    path.write_text(fit_to_text(FIT).replace(old, new), encoding="utf-8")
    answer = MeasurementHub(HubParameters()).load_fit(str(path))
    assert not answer.accepted
    assert message in answer.reason
    assert str(path) in answer.reason


def raw_volts(wheel_counts: int, load: float = 0.0):
    """Volts of an unloaded wheel with the parasitic signal, plus a constant on C5."""
    x = wheel_counts * 2 * math.pi / 20000
    volts = [0.0] * 6
    for column, s in zip(INDEX, TRUE, strict=True):
        volts[column] = sine_of(s, x)
    volts[4] += load
    return tuple(volts)


def run(hub, cycles, load=0.0):
    return [
        hub.step(bus(n, wheel_counts=37 * n, bridge_volts=raw_volts(37 * n, load))) for n in cycles
    ]


def test_filter_takes_the_parasitic_force_away_and_can_be_switched():
    hub = MeasurementHub(HubParameters())
    before = run(hub, range(600))
    assert max(abs(s.wheel.fx) for s in before) > 100.0
    assert not hub.set_filter(True).accepted
    assert hub.use_fit(FIT).cycle == 600
    answer = hub.set_filter(True)
    assert answer.cycle == 600
    after = run(hub, range(600, 1200), load=0.1)
    fz = 0.1 * 9.81 * 4e5 / (1000 * 1.9396)
    assert all(s.filter_on for s in after)
    assert max(abs(s.wheel.fx) for s in after) < 1e-9
    assert all(s.wheel.fz == pytest.approx(fz) for s in after)
    assert hub.set_filter(False).cycle == 1200
    assert not any(s.filter_on for s in run(hub, range(1200, 1210)))


def test_wheel_counter_may_wrap():
    hub = MeasurementHub(HubParameters())
    hub.use_fit(FIT)
    hub.set_filter(True)
    start = 2**31 - 100
    for n in range(200):
        counts = start + 3 * n
        raw = (counts + 2**31) % 2**32 - 2**31
        sample = hub.step(bus(n, wheel_counts=raw, bridge_volts=raw_volts(counts)))
        assert abs(sample.wheel.fx) < 1e-6


def test_a_tare_after_the_fit_replaces_its_offset():
    hub = MeasurementHub(HubParameters(tare_samples=50))
    hub.use_fit(FIT)
    hub.set_filter(True)
    run(hub, range(100), load=0.02)
    assert hub.tare().accepted
    run(hub, range(100, 150), load=0.02)
    after = run(hub, range(150, 200), load=0.02)
    assert max(abs(s.wheel.fz) for s in after) < 1e-9


def test_parameters_can_switch_it_on_at_the_start(tmp_path):
    path = tmp_path / "fit.yaml"
    path.write_text(fit_to_text(FIT), encoding="utf-8")
    hub = MeasurementHub(HubParameters(filter_on=True, parasitic_fit=str(path)))
    assert max(abs(s.wheel.fx) for s in run(hub, range(100))) < 1e-9
    with pytest.raises(ValueError, match="filter_on needs parasitic_fit"):
        MeasurementHub(HubParameters(filter_on=True))


def test_the_signal_is_the_sine_of_each_channel():
    sines = tuple(Sine(0.1 * k, 1.0 + 0.1 * k, 0.3 * k, 0.0, 0.0) for k in range(1, 6))
    signal = ParasiticFit("", "", sines).signal()
    for x in (-2.0, 0.0, 1.3, 7.0):
        by_hand = [sine_of(s, x) for s in sines]
        assert signal(x) == pytest.approx(by_hand, abs=1e-12)


def test_a_channel_without_a_sine_has_its_offset():
    angle, volts = three_turns(noise=0.0)
    volts[500:-500, INDEX[0]] = 0.25
    found = identify_fit(angle, volts, "m", "d").sines[0]
    assert found.amplitude_v == pytest.approx(0.0, abs=1e-9)
    assert found.offset_v == pytest.approx(0.25)


@pytest.mark.parametrize("frequency", [0.9, 1.1])
def test_a_wave_that_is_no_whole_turn_is_found(frequency):
    angle, volts = three_turns(noise=0.0)
    volts[:, INDEX[1]] = 0.1 * np.sin(frequency * angle + 0.5) + 0.02
    found = identify_fit(angle, volts, "m", "d").sines[1]
    assert found.frequency == pytest.approx(frequency, rel=1e-6)
    assert (found.amplitude_v, found.phase_rad) == pytest.approx((0.1, 0.5), rel=1e-5)


def test_two_turns_are_needed_and_enough():
    angle, volts = three_turns(noise=0.0, n=6001)
    assert identify_fit(angle[:4002], volts[:4002], "m", "d").sines
    with pytest.raises(ValueError, match="720 deg are needed"):
        identify_fit(angle[:3990], volts[:3990], "m", "d")
    with pytest.raises(ValueError, match=r"shape \(4000, 6\), wanted \(4001, 6\)"):
        identify_fit(angle[:4001], volts[:4000], "m", "d")
    with pytest.raises(ValueError, match="the wheel turned 0 deg"):
        identify_fit([], np.zeros((0, 6)), "m", "d")
    few = slice(None, None, 61)
    with pytest.raises(ValueError, match="are needed"):
        identify_fit(angle[few], volts[few], "m", "d")


def test_turns_are_counted_from_the_first_sample():
    """The recording misses half a radian after it."""
    angle = np.concatenate([[0.0], np.linspace(0.5, 4.0 * math.pi + 1e-6, 3000)])
    assert identify_fit(angle, np.zeros((3001, 6)), "m", "d").sines


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [("phase_rad", "phaze_rad", "unknown parameter 'phaze_rad'; the nearest is 'phase_rad'"),
     ("    phase_rad: 0.4\n", "", "missing phase_rad")],
)  # fmt: skip
def test_every_number_of_a_sine_is_needed_and_no_other(old, new, message):
    text = fit_to_text(FIT)
    assert old in text
    with pytest.raises(ValueError, match=f"^fit.yaml: channels: C1: {message}"):
        parasitic.fit_from_text(text.replace(old, new, 1), "fit.yaml")
