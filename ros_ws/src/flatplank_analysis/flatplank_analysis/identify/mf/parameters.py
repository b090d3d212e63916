# SPDX-License-Identifier: Apache-2.0
"""Start, bounds and size of every coefficient that can be identified.

`size` is a change that a tire engineer would call large: a coefficient whose error is as big is
not determined by the data. Bounds hold C > 0 and mu > 0; E <= 1 is a penalty, since E is a sum.
Sources: typical passenger tires in Pacejka (2012) appendix 3, and the thesis's Table I.1.
"""

from __future__ import annotations

from typing import NamedTuple


class Coefficient(NamedTuple):
    """Start value, lower and upper bound, size that matters, unit."""

    start: float
    lower: float
    upper: float
    size: float
    unit: str = "-"


def _table(text: str) -> dict[str, Coefficient]:
    rows = (line.split() for line in text.strip().splitlines())
    return {
        name: Coefficient(*(float(v) for v in values[:4]), *values[4:]) for name, *values in rows
    }


GENERAL = ("PCX1", "PDX1", "PKX1", "PCY1", "PDY1", "PKY1", "BREFF", "DREFF", "FREFF")
"""Coefficients without which a tire has no force and no rolling radius."""

COEFFICIENTS: dict[str, Coefficient] = _table("""
PCX1 1.5 0.6 2.4 0.3
PDX1 1.0 0.1 3.0 0.3
PDX2 -0.1 -1 1 0.2
PDX3 0 -50 50 5 1/rad2
PEX1 0 -20 1 1
PEX2 0 -20 20 1
PEX3 0 -20 20 1
PEX4 0 -0.9 0.9 0.5
PKX1 25 2 150 5
PKX2 0 -60 60 5
PKX3 0 -2 2 0.5
PHX1 0 -0.03 0.03 0.003
PHX2 0 -0.03 0.03 0.003
PVX1 0 -0.2 0.2 0.03
PVX2 0 -0.2 0.2 0.03
PPX1 0 -5 5 0.5
PPX2 0 -30 30 2
PPX3 0 -5 5 0.3
PPX4 0 -30 30 1
RBX1 12 0.5 80 5 1/rad
RBX2 8 -40 40 5
RBX3 0 -500 500 50 1/rad3
RCX1 1 0.3 1.8 0.2
REX1 0 -10 1 1
REX2 0 -10 10 1
RHX1 0 -0.1 0.1 0.01 rad
PCY1 1.4 0.6 2.2 0.3
PDY1 0.95 0.1 3.0 0.3
PDY2 -0.1 -1 1 0.2
PDY3 0 -50 50 5 1/rad2
PEY1 0 -20 1 1
PEY2 0 -20 20 1
PEY3 0 -2 2 0.5
PEY4 0 -60 60 5 1/rad
PEY5 0 -300 300 30 1/rad2
PKY1 -20 -150 -1 5 1/rad
PKY2 1.8 0.2 10 0.5
PKY3 0 -5 5 0.5 1/rad
PKY4 2 0.5 2 0.3
PKY5 0 -100 100 10 1/rad2
PKY6 -0.9 -5 5 0.5 1/rad
PKY7 0 -5 5 0.5 1/rad
PHY1 0 -0.05 0.05 0.005 rad
PHY2 0 -0.05 0.05 0.005 rad
PVY1 0 -0.2 0.2 0.03
PVY2 0 -0.2 0.2 0.03
PVY3 0 -3 3 0.3 1/rad
PVY4 0 -3 3 0.3 1/rad
PPY1 0 -5 5 0.3
PPY2 0 -5 5 0.5
PPY3 0 -5 5 0.3
PPY4 0 -30 30 1
PPY5 0 -10 10 1
RBY1 10 0.5 80 5
RBY2 8 -60 60 5 1/rad
RBY3 0 -0.2 0.2 0.02 rad
RBY4 0 -500 500 50 1/rad2
RCY1 1 0.3 1.8 0.2
REY1 0 -10 1 1
REY2 0 -10 10 1
RHY1 0 -0.1 0.1 0.01
RHY2 0 -0.1 0.1 0.01
RVY1 0 -1 1 0.1
RVY2 0 -1 1 0.1
RVY3 0 -10 10 1 1/rad
RVY4 0 -60 60 10 1/rad
RVY5 1.9 -5 5 1
RVY6 0 -80 80 10
QBZ1 10 0.5 60 4 1/rad
QBZ2 0 -30 30 3 1/rad
QBZ3 0 -30 30 3 1/rad
QBZ4 0 -10 10 1 1/rad2
QBZ5 0 -10 10 1 1/rad2
QBZ9 10 0 100 10 1/rad
QBZ10 0 -5 5 0.5
QCZ1 1.15 0.4 1.9 0.2
QDZ1 0.1 0.001 0.5 0.03
QDZ2 0 -0.3 0.3 0.03
QDZ3 0 -10 10 1 1/rad
QDZ4 0 -100 100 10 1/rad2
QDZ6 0 -0.1 0.1 0.005
QDZ7 0 -0.1 0.1 0.005
QDZ8 0 -2 2 0.1 1/rad
QDZ9 0 -2 2 0.1 1/rad
QDZ10 0 -10 10 1 1/rad2
QDZ11 0 -10 10 1 1/rad2
QEZ1 0 -20 1 1
QEZ2 0 -20 20 1
QEZ3 0 -20 20 1
QEZ4 0 -5 5 0.5
QEZ5 0 -50 50 5 1/rad
QHZ1 0 -0.05 0.05 0.005 rad
QHZ2 0 -0.05 0.05 0.005 rad
QHZ3 0 -2 2 0.2
QHZ4 0 -2 2 0.2
PPZ1 0 -5 5 0.5
PPZ2 0 -5 5 0.5
SSZ1 0 -0.3 0.3 0.03
SSZ2 0 -0.3 0.3 0.03
SSZ3 0 -3 3 0.3 1/rad
SSZ4 0 -3 3 0.3 1/rad
BREFF 6 0.3 60 4
DREFF 0.25 0.001 3 0.15
FREFF 0.02 -1 1 0.05
Q_RE0 1 0.9 1.1 0.005
Q_REA 0 -5 5 0.3 1/rad2
Q_REG 0 -5 5 0.3 1/rad2
VERTICAL_STIFFNESS 2e5 3e4 1e6 2e4 N/m
PFZ1 0.7 -0.5 3 0.3
Q_FZ2 10 0 200 10
Q_RA1 0.8 0 3 0.3
Q_RA2 0.3 -2 4 0.3
Q_RB1 0.9 0 3 0.3
Q_RB2 0 -4 4 0.5
LONGITUDINAL_STIFFNESS 2e5 2e4 5e6 5e4 N/m
PCFX1 0 -3 3 0.3
PCFX2 0 -5 5 0.3
PCFX3 0 -3 3 0.3
LATERAL_STIFFNESS 1e5 1e4 5e6 3e4 N/m
PCFY1 0 -3 3 0.3
PCFY2 0 -5 5 0.3
PCFY3 0 -3 3 0.3
""")


def general_start() -> dict[str, float]:
    """Start values of no tire in particular, for a tire record without a start file."""
    return {name: COEFFICIENTS[name].start for name in GENERAL}
