# SPDX-License-Identifier: Apache-2.0
"""Sweeps as the grammar of proposals sees them: every channel is a coordinate."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from flatplank_analysis.discovery.runs import Coordinate, RunSet
from flatplank_analysis.slip_sweeps.runs import CHANNEL
from flatplank_data.errors import FlatplankError


@dataclass(frozen=True)
class SweepChannels:
    """The channels of sweeps (runs, nodes), under the names that `TireRuns` has for them."""

    runs: RunSet

    @property
    def position(self) -> np.ndarray:
        """Number of each node (runs, nodes)."""
        return self.runs.time

    @property
    def kappa(self) -> np.ndarray:
        """(runs,) no run drives or brakes: a sweep does both."""
        return np.zeros(self.runs.runs)

    @property
    def coordinates(self) -> Mapping[str, Coordinate]:
        """Channels that vary."""
        return self.runs.coordinates

    @property
    def further(self) -> Mapping[str, Coordinate]:
        """All of them: what follows a channel looks like scatter of repeats, as with the further
        columns of a campaign."""
        return self.coordinates

    def coordinate(self, name: str) -> np.ndarray:
        """A channel by name (runs, nodes); FlatplankError when the sweeps do not have it."""
        known = dict(channels_of(self.runs))
        if name not in known:
            what = f"the sweeps have no '{name}'"
            raise FlatplankError(what, "channel", f"known: {', '.join(known)}")
        return known[name]


def channels_of(runs: RunSet) -> Iterator[tuple[str, np.ndarray]]:
    """Every channel of the sweeps in their bins (runs, nodes)."""
    for name, values in runs.facts.items():
        if name.startswith(CHANNEL):
            yield name.removeprefix(CHANNEL), values
