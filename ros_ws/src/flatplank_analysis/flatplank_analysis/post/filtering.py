# SPDX-License-Identifier: Apache-2.0
"""Zero-phase low-pass over distance, the same for data and model (thesis 6.2)."""

from __future__ import annotations

import numpy as np
from scipy.signal import butter, sosfiltfilt

from flatplank_data.machine import FAST

CUTOFF_HZ = 10.0
ORDER = 2
"""of the filter that runs forward and backward; the thesis does not say"""


def cutoff_per_metre(cutoff_hz: float = CUTOFF_HZ, speed: float = FAST) -> float:
    """Path frequency of a cut-off in time [1/m]: 10 Hz at 0.03092 m/s is 323 1/m."""
    return cutoff_hz / speed


CUTOFF_PER_METRE = cutoff_per_metre()
"""[1/m]"""


def low_pass(
    values: np.ndarray,
    spacing: float = 1e-4,
    cutoff: float = CUTOFF_PER_METRE,
    order: int = ORDER,
) -> np.ndarray:
    """`values` on an even grid of `spacing` [m] without what is above `cutoff` [1/m].

    The cut-off is stated over distance: over time it would change with the plank speed. Leading
    and trailing NaN stay.
    """
    out = np.array(values, dtype=np.float64)
    finite = np.flatnonzero(np.isfinite(out))
    nyquist = 0.5 / spacing
    if finite.size < 30 * order or cutoff >= nyquist:
        return out
    span = slice(finite[0], finite[-1] + 1)
    sections = butter(order, cutoff / nyquist, output="sos")
    out[span] = sosfiltfilt(sections, out[span])
    return out
