# SPDX-License-Identifier: Apache-2.0
"""What the machine can be set to: one table, read by hub, plans, panel and simulated plant."""

from __future__ import annotations

from typing import NamedTuple


class Limit(NamedTuple):
    """Range of one setting."""

    low: float
    high: float
    unit: str
    source: str

    @property
    def bounds(self) -> tuple[float, float]:
        """Lowest and highest value."""
        return self.low, self.high


LIMITS: dict[str, Limit] = {
    "camber_deg": Limit(
        -15.0, 15.0, "deg", "of road and hub each; placeholder, not in the thesis"
    ),
    "steer_deg": Limit(-48.0, 48.0, "deg", "the motor hits the pillar, thesis section 3.1"),
}
"""Setting -> range in the unit of its name."""
