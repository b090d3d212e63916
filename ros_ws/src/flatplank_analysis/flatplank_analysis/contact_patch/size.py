# SPDX-License-Identifier: Apache-2.0
"""Size of a tire beside the one for which lengths and forces of the analysis are written.

Forces scale with the load, lengths with its square root, stiffnesses with their quotient.
"""

from __future__ import annotations

import numpy as np

from flatplank_analysis.discovery.runs import RunSet

USUAL_LOAD, USUAL_HALF = 3700.0, 0.07
"""[N], [m] load and half contact length of the usual tire"""


def contact_ratio(load: float) -> float:
    """Contact length at a load [N], relative to that at `USUAL_LOAD`."""
    return float(np.sqrt(load / USUAL_LOAD))


def usual_load_of(runs: RunSet) -> float:
    """Load of the usual run [N]; that of the usual tire where the runs state none."""
    return float(np.median(runs.facts.get("nominal", np.array([USUAL_LOAD]))))
