# SPDX-License-Identifier: Apache-2.0
"""Rolling resistance moment My (A48 of the article of 2010; 5.2: Pacejka 2006, section 4.3.2).

The book (4.E70) has it positive and with one more Fz; MF-Tyre follows the article. In ISO W a
wheel that rolls forward turns about +y, and what resists is negative.
"""

from __future__ import annotations

import numpy as np

from .coefficients import LATEST, OLD, Coefficients
from .state import OperatingPoint, Value, sign


def rolling_resistance(c: Coefficients, o: OperatingPoint, fx: Value) -> Value:
    """My [Nm] at a longitudinal force fx [N]."""
    speed = np.abs(o.vx / c.LONGVL)
    share = c.QSY1 + c.QSY2 * fx / c.FNOMIN + c.QSY3 * speed + c.QSY4 * speed**4
    return -c.UNLOADED_RADIUS * c.LMY * sign(o.vx) * RESISTANCE[c.law](c, o, share)


def _of_load(_c: Coefficients, o: OperatingPoint, share: Value) -> Value:
    """Resisting force [N] of 5.2: a share of the load."""
    return o.fz * share


def _of_load_and_pressure(c: Coefficients, o: OperatingPoint, share: Value) -> Value:
    """Resisting force [N]: a share of the nominal load, by powers of load and pressure."""
    load = o.fz / c.FNOMIN
    camber = (c.QSY5 + c.QSY6 * load) * o.gamma * o.gamma
    return c.FNOMIN * (share + camber) * load**c.QSY7 * (1.0 + o.dpi) ** c.QSY8


RESISTANCE = {LATEST: _of_load_and_pressure, OLD: _of_load}
