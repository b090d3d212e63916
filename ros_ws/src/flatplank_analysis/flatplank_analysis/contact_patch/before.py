# SPDX-License-Identifier: Apache-2.0
"""Where the run before left the machine."""

from __future__ import annotations

import numpy as np


def side_before(order: np.ndarray, kappa: np.ndarray) -> np.ndarray:
    """Sign of the last slip before each run, 1 driving, -1 braking; 0 where none is known.

    order, kappa (runs,): run order and commanded slip.
    """
    sides = np.zeros(len(order))
    last = 0.0
    for row in np.argsort(order, kind="stable"):
        sides[row] = last
        last = float(np.sign(kappa[row])) or last
    return sides
