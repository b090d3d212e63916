# SPDX-License-Identifier: Apache-2.0
"""The settings in the middle of a campaign and the numbers of its runs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flatplank_analysis.contact_patch.data import TireRuns


@dataclass(frozen=True)
class References:
    """What the sizes of effects are told against: the settings in the middle of a campaign, and
    the numbers of its runs. Other runs that a fit is asked about keep those of its campaign."""

    load: float
    """[N]"""
    pressure: float
    """[bar]"""
    first: float
    last: float
    middle: float
    """first, last and mean run order"""

    @classmethod
    def of(cls, data: TireRuns) -> References:
        """Those of the runs themselves."""
        order = data.runs.order
        medians = float(np.median(data.nominal)), float(np.median(data.pressure))
        return cls(*medians, *(float(f(order)) for f in (np.min, np.max, np.mean)))

    def share(self, order: np.ndarray, begin: float) -> np.ndarray:
        """Run order from `begin` on, in units of the whole campaign."""
        return (order - begin) / max(self.last - self.first, 1.0)
