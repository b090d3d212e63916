# SPDX-License-Identifier: Apache-2.0
"""What the other packages ask of the simulated bench (flatplank_control/bench/simulator.py)."""

from __future__ import annotations

from flatplank_sim.plant import PlantConfig
from flatplank_sim.sealed.generate import make_challenge
from flatplank_sim.twin.campaign_run import run_on_twin
from flatplank_sim.twin.parasitic import filter_on_twin, turn_on_twin

__all__ = [
    "check", "filter_on_twin", "free_radius", "make_challenge", "run_on_twin", "turn_on_twin",
]  # fmt: skip


def free_radius(tire: str) -> float:
    """r_0 of a simulated tire [m]."""
    return PlantConfig.load(tire).tire.free_radius


def check(tire: str, preset: str) -> None:
    """ValueError or OSError when the plant has no such tire or preset."""
    PlantConfig.load(tire, preset=preset or None)
