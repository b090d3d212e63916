# SPDX-License-Identifier: Apache-2.0
"""Appendix A: against its formulas written out again, and there and back."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hub_inputs import bus, volts_from_wheel, wheel_from_contact

from flatplank_hw.hub import HubParameters, MeasurementHub
from flatplank_hw.hub.appendix_a import contact_from_wheel, gains, wheel_from_volts
from flatplank_hw.samples import Wrench

P = HubParameters(et_value=0.038, adapter_thickness=0.025)
RANDOM = np.random.default_rng(5)


def appendix_a1(c, p):
    """(A.1) of the thesis as printed."""
    x, y, z = (p.gravity * 4e5 / a for a in (p.a_fx, p.a_fy, p.a_fz))
    d = -p.et_value + p.adapter_thickness
    return {
        "fx": -x * (c[1] / p.k_fx1 + c[2] / p.k_fx2),
        "fy": y / p.k_fy * c[0],
        "fz": z * (c[4] / p.k_fz2 + c[5] / p.k_fz1),
        "mx": z * (c[4] / p.k_fz2 * (0.0475 + d) + c[5] / p.k_fz1 * (0.3475 + d)),
        "my": 0.0,
        "mz": x * (c[1] / p.k_fx1 * (0.3475 + d) + c[2] / p.k_fx2 * (0.0475 + d)),
    }


def rotation(gamma):
    return np.array(
        [[1, 0, 0], [0, math.cos(gamma), -math.sin(gamma)], [0, math.sin(gamma), math.cos(gamma)]]
    )


@pytest.mark.parametrize("volts", RANDOM.uniform(-9, 9, (20, 6)).tolist())
def test_wheel_wrench_is_appendix_a1(volts):
    wheel = wheel_from_volts(tuple(volts), gains(P))
    for name, value in appendix_a1(volts, P).items():
        assert getattr(wheel, name) == pytest.approx(value, rel=1e-12, abs=1e-9)


@pytest.mark.parametrize("volts", RANDOM.uniform(-9, 9, (50, 6)).tolist())
def test_volts_forces_volts_is_exact(volts):
    volts[3] = 0.0
    back = volts_from_wheel(wheel_from_volts(tuple(volts), gains(P)), gains(P))
    assert np.max(np.abs(np.subtract(back, volts))) < 1e-12


@pytest.mark.parametrize("gamma_deg", [-15.0, -5.0, 0.0, 0.1, 5.0, 30.0])
def test_contact_wrench_is_the_wheel_wrench_moved_and_turned(gamma_deg):
    """(A.2) is the shift of the wrench by r_l along the wheel plane and a turn by gamma."""
    gamma, radius = math.radians(gamma_deg), 0.2955
    for values in RANDOM.normal(0.0, 1000.0, (20, 6)):
        wheel = Wrench(*values)
        force, moment = np.array(values[:3]), np.array(values[3:])
        shifted = moment + np.cross([0.0, 0.0, radius], force)
        wanted = [*(rotation(gamma) @ force), *(rotation(gamma) @ shifted)]
        contact = contact_from_wheel(wheel, radius, math.cos(gamma), math.sin(gamma))
        assert contact == pytest.approx(wanted, rel=1e-12, abs=1e-9)
        again = wheel_from_contact(contact, radius, math.cos(gamma), math.sin(gamma))
        assert again == pytest.approx(wheel, rel=1e-12, abs=1e-9)


@pytest.mark.parametrize("counts", [-900, 0, 137, 1200])
def test_hub_reproduces_a_contact_wrench_at_any_camber(counts):
    """The total camber is hub + measured road camber + offset."""
    p = replace(P, wheel_camber_deg=-2.5, road_camber_offset_deg=0.7)
    gamma = math.radians(-1.8) + counts * 2 * math.pi / p.camber_counts_per_turn
    lvdt = -0.3
    radius = p.lvdt_offset + p.lvdt_gain * lvdt
    wheel = Wrench(800.0, -350.0, 3700.0, 120.0, 0.0, -45.0)
    volts = volts_from_wheel(wheel, gains(p))
    sample = MeasurementHub(p).step(bus(bridge_volts=volts, lvdt_volts=lvdt, camber_counts=counts))
    wanted = contact_from_wheel(wheel, radius, math.cos(gamma), math.sin(gamma))
    assert sample.total_camber == pytest.approx(gamma, rel=1e-14)
    assert sample.loaded_radius == pytest.approx(radius, rel=1e-14)
    assert sample.wheel == pytest.approx(wheel, rel=1e-12, abs=1e-9)
    assert sample.contact == pytest.approx(wanted, rel=1e-12, abs=1e-9)


@pytest.mark.parametrize("gamma_deg", [0.0, 4.0])
@pytest.mark.parametrize("source", ["force_balance", "motor_torque"])
def test_drive_moment_enters_as_the_thesis_recommends(source, gamma_deg):
    p = replace(P, drive_moment_source=source, wheel_camber_deg=gamma_deg)
    axes = bus().axes
    turning = round(142.0 * 2**23 / (2.0 * math.pi))
    axes = (axes[0]._replace(torque=35000, velocity=turning), *axes[1:])
    volts = volts_from_wheel(Wrench(1000.0, 0.0, 3700.0, 0.0, 0.0, 10.0), gains(p))
    inputs = bus(bridge_volts=volts, axes=axes)
    off = MeasurementHub(p).step(inputs)
    on = MeasurementHub(replace(p, include_drive_moment=True)).step(inputs)
    moment = on.wheel.my
    wanted = {
        "force_balance": -off.loaded_radius * off.wheel.fx,
        "motor_torque": -p.efficiency * p.gear_ratio * (3.5 - 0.7502),
    }[source]
    gamma = math.radians(gamma_deg)
    assert off.wheel.my == 0.0
    assert moment == pytest.approx(wanted)
    assert on.contact.my - off.contact.my == pytest.approx(math.cos(gamma) * moment)
    assert on.contact.mz - off.contact.mz == pytest.approx(math.sin(gamma) * moment, abs=1e-9)
    assert on.contact[:4] == off.contact[:4]
