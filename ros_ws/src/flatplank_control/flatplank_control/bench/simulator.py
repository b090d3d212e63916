# SPDX-License-Identifier: Apache-2.0
"""Interface to the simulated bench: control and panel load it by entry point, not by import."""

from __future__ import annotations

from functools import cache
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any, Protocol

from flatplank_data.errors import FlatplankError

GROUP = "flatplank.simulator"


class Simulator(Protocol):
    """Interface of `flatplank_sim.simulator`."""

    def free_radius(self, tire: str) -> float:
        """r_0 of a simulated tire [m]."""

    def tires(self) -> tuple[str, ...]:
        """Names of the packaged simulated tires."""

    def presets(self) -> tuple[str, ...]:
        """Names of the packaged presets of defects."""

    def check(self, tire: str, preset: str) -> None:
        """Raise ValueError or OSError when the plant has no such tire or preset."""

    def run_on_twin(self, *arguments: Any, **options: Any) -> None:
        """Run a campaign plan on the twin."""

    def turn_on_twin(self, setup: Any) -> Any:
        """Raw samples of three turns of the unloaded wheel."""

    def speeds_on_twin(self, setup: Any) -> Any:
        """Table of the unloaded wheel turning at several constant speeds."""

    def filter_on_twin(self, setup: Any, fit: Path, kappa: float) -> dict[str, Any]:
        """Once-per-turn amplitude of Fx and Fz in a slip run [N], without and with the filter."""

    def make_challenge(self, folder: Path, seed: int, progress: Any) -> Path:
        """Make a campaign with a hidden effect and its sealed answer; returns its folder."""


@cache
def simulator() -> Simulator:
    """The installed simulator; FlatplankError without `flatplank_sim`."""
    for entry in entry_points(group=GROUP):
        return entry.load()
    raise FlatplankError(
        "the simulated bench is not installed", "flatplank_sim", "install it, or use --lab"
    )
