# SPDX-License-Identifier: Apache-2.0
"""A law of the contact patch, for the tests of the transient models."""

from __future__ import annotations

import numpy as np

from flatplank_analysis.models.nonlinear import TableLaw, table_law

X = np.linspace(0.0, 2.6, 400)
SLIPS = np.linspace(-0.15, 0.15, 61)


def law(peak: float = 3700.0) -> TableLaw:
    return table_law(SLIPS, peak * np.sin(1.4 * np.arctan(9e4 / 1.4 / peak * SLIPS)))
