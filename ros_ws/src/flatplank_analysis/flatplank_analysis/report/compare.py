# SPDX-License-Identifier: Apache-2.0
"""A model's response made comparable with a measured one: same positions, same low-pass."""

from __future__ import annotations

import numpy as np

from flatplank_analysis.identify.quality import is_transient, rmse
from flatplank_analysis.post.filtering import low_pass
from flatplank_analysis.post.gridding import SPACING
from flatplank_analysis.report.results import ConditionResult

LEAD = 0.1
"""road before the step on which the model rests, for the filter [m]"""


def positions(c: ConditionResult) -> np.ndarray:
    """Where a condition is compared: measured positions from the step on [m since the step]."""
    return c.since_step[(c.since_step >= 0.0) & np.isfinite(c.measured["fx"])]


def filtered_alike(x: np.ndarray, response: np.ndarray, start: float) -> np.ndarray:
    """`response` [N] at `x` [m since the step] through the filter of the data.

    Before the step the model rests at `start` [N].
    """
    fine = np.arange(-LEAD, x[-1] + SPACING, SPACING)
    values = np.where(fine < 0.0, start, np.interp(fine, x, response))
    return np.interp(x, fine, low_pass(values))


def compared(
    c: ConditionResult, x: np.ndarray, response: np.ndarray
) -> tuple[tuple[np.ndarray, np.ndarray], float]:
    """The filtered curve and its RMSE in the transient part [N]."""
    curve = filtered_alike(x, response, c.linear.start_force.value)
    seen = np.interp(x, c.since_step, c.measured["fx"])
    return (x, curve), rmse(seen, curve, is_transient(x, c.linear.transient_end))
