# SPDX-License-Identifier: Apache-2.0
"""What of a force turns with the wheel: preloaded shaft, run-out."""

from __future__ import annotations

import numpy as np


def turning_amplitude(
    angle: np.ndarray, force: np.ndarray, drift: np.ndarray | None = None
) -> np.ndarray:
    """Amplitude [N] of a force over the wheel angle [rad], beside a mean and, when told over what,
    a drift; `force` of shape (n,) or (n, k), the amplitude of shape () or (k,)."""
    columns = [np.ones_like(angle), np.sin(angle), np.cos(angle)]
    if drift is not None:
        columns.insert(1, drift - drift.mean())
    a = np.linalg.lstsq(np.column_stack(columns), force, rcond=None)[0]
    return np.hypot(a[-2], a[-1])
