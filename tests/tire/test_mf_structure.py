# SPDX-License-Identifier: Apache-2.0
"""Radii, stiffnesses, contact patch and relaxation lengths, spelt out for one point at a time."""

from __future__ import annotations

from math import atan, exp, sin, sqrt

import numpy as np
import pytest

from flatplank_tire.magic_formula import OLD, Coefficients, operating_point, pure
from flatplank_tire.magic_formula import structure as shape

K = {
    "UNLOADED_RADIUS": 0.31, "WIDTH": 0.21, "FNOMIN": 4000.0, "NOMPRES": 2.2e5, "LONGVL": 16.7,
    "VERTICAL_STIFFNESS": 2.1e5, "PFZ1": 0.7, "Q_FZ2": 9.0, "Q_FCX": 0.13, "Q_FCY": 0.09,
    "Q_V1": 7e-4, "Q_V2": 0.04, "Q_RE0": 0.99, "BREFF": 8.0, "DREFF": 0.24, "FREFF": 0.03,
    "Q_REA": 0.3, "Q_REG": -0.2, "Q_RA1": 0.8, "Q_RA2": 0.3, "Q_RB1": 0.9, "Q_RB2": -0.4,
    "LONGITUDINAL_STIFFNESS": 3e5, "LATERAL_STIFFNESS": 1e5, "PCFX1": 0.2, "PCFX2": -0.3,
    "PCFX3": 0.15, "PCFY1": 0.25, "PCFY2": 0.35, "PCFY3": -0.1, "PCX1": 1.5, "PDX1": 1.0,
    "PKX1": 20.0, "PKX3": 0.2, "PCY1": 1.3, "PDY1": 0.9, "PKY1": -15.0, "PKY2": 1.7, "PKY3": 0.3,
    "LFZO": 1.1, "PTX1": 2.3, "PTX2": 1.4, "PTX3": -0.2, "PTY1": 2.1, "PTY2": 1.9, "LSGKP": 0.9,
    "LSGAL": 1.2, "LGAY": 0.8,
}  # fmt: skip
POINTS = [(2600.0, 0.04, -0.06, 0.05, 2.5e5), (6100.0, -0.03, 0.09, -0.08, 1.9e5)]


@pytest.mark.parametrize("at", POINTS)
def test_radii_and_deflection(at):
    c, fz, alpha, gamma = Coefficients(K), at[0], at[2], at[3]
    o, omega = operating_point(c, *at, 20.0), 61.0
    dpi, load = at[4] / 2.2e5 - 1.0, fz / 4000.0
    free = 0.31 * (0.99 + 7e-4 * (omega * 0.31 / 16.7) ** 2)
    assert shape.free_radius(c, omega) == pytest.approx(free)
    stiffness = 2.1e5 * (1.0 + 0.7 * dpi)
    assert shape.vertical_stiffness(c, o.dpi) == pytest.approx(stiffness)
    sunk = 4000.0 / stiffness * (0.24 * atan(8.0 * load) + 0.03 * load)
    tilt = 0.31 * (0.3 * alpha**2 - 0.2 * gamma**2)
    assert shape.effective_radius(c, o, omega) == pytest.approx(free - sunk + tilt)
    rho = float(shape.deflection(c, o, -omega, 900.0, -1300.0))
    slope = sqrt((2.1e5 * 0.31 / 4000.0) ** 2 - 4.0 * 9.0)
    gain = 1.0 + 0.04 * 0.31 / 16.7 * omega
    gain -= (0.13 * 900.0 / 4000.0) ** 2 + (0.09 * 1300.0 / 4000.0) ** 2
    carried = gain * (slope * rho / 0.31 + 9.0 * (rho / 0.31) ** 2) * (1.0 + 0.7 * dpi) * 4000.0
    assert carried == pytest.approx(fz)


@pytest.mark.parametrize("vx", [20.0, -20.0])
def test_radius_and_speed_of_rotation_agree(vx):
    c = Coefficients(K | {"Q_V1": 0.05})
    o = operating_point(c, *POINTS[0], vx)
    radius, omega = shape.rolling(c, o, vx)
    assert omega * radius == pytest.approx(1.04 * vx, rel=1e-12)
    assert radius == pytest.approx(shape.effective_radius(c, o, omega), rel=1e-12)


@pytest.mark.parametrize("at", POINTS)
def test_patch_and_stiffnesses(at):
    c = Coefficients(K)
    o = operating_point(c, *at, 20.0)
    dfz, dpi = at[0] / 4400.0 - 1.0, at[4] / 2.2e5 - 1.0
    rho = at[0] / (2.1e5 * (1.0 + 0.7 * dpi) * 0.31)
    assert shape.contact_half_length(c, o) == pytest.approx(0.31 * (0.3 * rho + 0.8 * sqrt(rho)))
    width = 0.21 * (-0.4 * rho + 0.9 * rho ** (1.0 / 3.0))
    assert shape.contact_half_width(c, o) == pytest.approx(width)
    c_x = 3e5 * (1.0 + 0.2 * dfz - 0.3 * dfz**2) * (1.0 + 0.15 * dpi)
    c_y = 1e5 * (1.0 + 0.25 * dfz + 0.35 * dfz**2) * (1.0 - 0.1 * dpi)
    assert shape.stiffness_x(c, o) == pytest.approx(c_x)
    assert shape.stiffness_y(c, o) == pytest.approx(c_y)
    k_x = at[0] * 20.0 * exp(0.2 * dfz)
    assert shape.relaxation_x(c, o) == pytest.approx(k_x / c_x)
    k_y = float(pure.cornering_stiffness(c, o))
    assert k_y < 0.0 and shape.relaxation_y(c, o) == pytest.approx(-k_y / c_y)


@pytest.mark.parametrize("at", POINTS)
def test_relaxation_lengths_of_5_2_where_they_are_given(at):
    c = Coefficients(K, OLD)
    o = operating_point(c, *at, 20.0)
    dfz, load = at[0] / 4400.0 - 1.0, at[0] / 4400.0
    sigma_x = 0.31 * at[0] / 4000.0 * (2.3 + 1.4 * dfz) * exp(0.2 * dfz) * 0.9
    assert shape.relaxation_x(c, o) == pytest.approx(sigma_x)
    camber = 1.0 - 0.3 * abs(at[3]) * 0.8
    sigma_y = 2.1 * sin(2.0 * atan(load / 1.9)) * camber * 0.31 * 1.1 * 1.2
    assert shape.relaxation_y(c, o) == pytest.approx(sigma_y)
    mirrored = Coefficients(K | {"PTX1": -2.3, "PTX2": -1.4, "PTY1": -2.1}, OLD)
    assert shape.relaxation_x(mirrored, o) == pytest.approx(sigma_x)  # a length has no sign
    assert shape.relaxation_y(mirrored, o) == pytest.approx(sigma_y)
    plain = Coefficients({k: v for k, v in K.items() if not k.startswith("PT")}, OLD)
    ratio = pure.longitudinal_stiffness(plain, o) / 3e5
    np.testing.assert_allclose(shape.relaxation_x(plain, o), ratio)
    np.testing.assert_allclose(shape.relaxation_y(plain, o),
                               -pure.cornering_stiffness(plain, o) / 1e5)  # fmt: skip
