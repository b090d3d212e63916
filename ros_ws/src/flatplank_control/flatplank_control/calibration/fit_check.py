# SPDX-License-Identifier: Apache-2.0
"""Whether a parasitic fit is still that of the wheel, and what the filter leaves under load."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from flatplank_control.turning import turning_amplitude

MISMATCH = 40.0
"""once-per-turn force left with the filter on, from which the fit is no longer that of the wheel
[N]"""


def still_fits(left: float) -> str:
    """A warning when the once-per-turn force [N] with the filter on says another mounting; else
    empty."""
    if not left > MISMATCH:
        return ""
    return (
        f"{left:.0f} N once per turn are left with the filter on (at most {MISMATCH:g} N): "
        "the fit is not that of this mounting; make the unloaded turn again"
    )


def under_load(
    plain: Mapping[str, np.ndarray], filtered: Mapping[str, np.ndarray], first: float, last: float
) -> dict[str, tuple[float, float]]:
    """Once-per-turn amplitude of Fx and Fz [N] without and with the filter, between two plank
    positions [m] of two equal runs (Figures C.5, C.6)."""
    found = {}
    for name in ("fx", "fz"):
        both = []
        for run in (plain, filtered):
            inside = (run["plank_position"] >= first) & (run["plank_position"] < last)
            angle = run["wheel_angle"][inside]
            both.append(float(turning_amplitude(angle, run[name][inside], drift=angle)))
        found[name] = (both[0], both[1])
    return found


def text(found: Mapping[str, tuple[float, float]]) -> Sequence[str]:
    """For people."""
    return [f"{name}: {a:.1f} N once per turn, {b:.1f} N filtered" for name, (a, b) in
            found.items()]  # fmt: skip
