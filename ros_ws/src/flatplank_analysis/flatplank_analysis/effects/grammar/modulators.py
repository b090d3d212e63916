# SPDX-License-Identifier: Apache-2.0
"""Conditions that switch or scale a proposed effect."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Modulator:
    """A factor (runs, samples) on an effect, written with `data` (see `TireRuns`)."""

    name: str
    formula: str
    words: str


_AFTER = "(data.since_step > 0.0)"

MODULATORS: tuple[Modulator, ...] = (
    Modulator("", "", ""),
    Modulator("driving", f"(data.kappa[:, None] > 0.0) * {_AFTER}", "only while driving"),
    Modulator("braking", f"(data.kappa[:, None] < 0.0) * {_AFTER}", "only while braking"),
    Modulator("slipping", f"(data.kappa[:, None] != 0.0) * {_AFTER}", "only while it slips"),
    Modulator(
        "sign of slip", f"np.sign(data.kappa[:, None]) * {_AFTER}", "with the sign of the slip",
    ),
    Modulator(
        "slip", f"data.kappa[:, None] / 0.05 * {_AFTER}",
        "in proportion to the slip; the size is that at 5 %",
    ),
    Modulator(
        "size of slip", f"np.abs(data.kappa[:, None]) / 0.05 * {_AFTER}",
        "in proportion to the size of the slip; the size is that at 5 %",
    ),
    Modulator(
        "little slip", f"np.exp(-np.abs(data.kappa[:, None]) * {_AFTER} / 0.02)",
        "the less the more it slips; the size is that without slip, at 2 % it is a third",
    ),
    Modulator(
        "load", "data.load / 4000.0", "in proportion to the load; the size is that at 4000 N",
    ),
    Modulator(
        "speed", "data.runs.facts['speed'][:, None] / 0.03",
        "in proportion to the speed of the plank; the size is that at 0.03 m/s",
    ),
)  # fmt: skip
BY_NAME = {m.name: m for m in MODULATORS}
