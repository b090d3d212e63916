# SPDX-License-Identifier: Apache-2.0
"""The simulated bench, as control and panel see it: no import, an entry point of its package."""

from __future__ import annotations

from importlib.metadata import entry_points
from pathlib import Path
from typing import Any, Protocol

from flatplank_data.errors import FlatplankError

GROUP = "flatplank.simulator"


class Simulator(Protocol):
    """What `flatplank_sim.simulator` has."""

    def free_radius(self, tire: str) -> float:
        """r_0 of a simulated tire [m]."""

    def check(self, tire: str, preset: str) -> None:
        """ValueError or OSError when the plant has no such tire or preset."""

    def run_on_twin(self, *arguments: Any, **options: Any) -> None:
        """A campaign plan on the twin."""

    def turn_on_twin(self, setup: Any) -> Any:
        """Raw samples of an unloaded turn."""

    def filter_on_twin(self, setup: Any, fit: Path, kappa: float) -> dict[str, Any]:
        """What the parasitic filter leaves of a slip run, by channel."""

    def make_challenge(self, folder: Path, seed: int, progress: Any) -> Path:
        """A campaign with something hidden in it."""


def simulator() -> Simulator:
    """The installed one; FlatplankError without `flatplank_sim`."""
    for entry in entry_points(group=GROUP):
        return entry.load()
    raise FlatplankError(
        "the simulated bench is not installed", "flatplank_sim", "install it, or use --lab"
    )
