# SPDX-License-Identifier: Apache-2.0
"""Aligned runs as inputs of the tire model: increments of position and angle, load, settings."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from flatplank_analysis.contact_patch.signs import WrongSign
from flatplank_analysis.discovery.runs import Coordinate, RunSet
from flatplank_data.errors import FlatplankError

SIGNALS = {"fy": "N", "mx": "N m", "mz": "N m"}
"""channels that are coordinates as well: there may be crosstalk between them"""
FACTS = {"pressure": "bar", "alpha": "rad", "gamma": "rad", "speed": "m/s"}
"""facts of a run that are coordinates where they differ between runs"""
SETTINGS = ("nominal", "radius", "alpha", "gamma", "kappa", "pressure")
"""facts of the runs that are fields of `TireRuns`"""


@dataclass(frozen=True)
class References:
    """What the sizes of effects are told against: the settings in the middle of a campaign, and
    the numbers of its runs. Other runs that a fit is asked about keep those of its campaign."""

    load: float
    """[N]"""
    pressure: float
    """[bar]"""
    first: float
    last: float
    middle: float
    """first, last and mean run order"""

    @classmethod
    def of(cls, data: TireRuns) -> References:
        """Those of the runs themselves."""
        order = data.runs.order
        medians = float(np.median(data.nominal)), float(np.median(data.pressure))
        return cls(*medians, *(float(f(order)) for f in (np.min, np.max, np.mean)))

    def share(self, order: np.ndarray, begin: float) -> np.ndarray:
        """Run order from `begin` on, in units of the whole campaign."""
        return (order - begin) / max(self.last - self.first, 1.0)


@dataclass(frozen=True)
class TireRuns:
    """Inputs of the tire model on the nodes; arrays (runs, samples) unless said otherwise."""

    runs: RunSet
    position: np.ndarray
    """plank travel [m]"""
    angle: np.ndarray
    """wheel angle since the start [rad]"""
    travel: np.ndarray
    """increments of plank travel [m]; first column 0"""
    turned: np.ndarray
    """increments of the wheel angle [rad]; first column 0"""
    step_time: np.ndarray
    """increments of time [s]; first column 0"""
    load: np.ndarray
    """denoised vertical load [N]"""
    nominal: np.ndarray
    """(runs,) nominal load [N]"""
    radius: np.ndarray
    """(runs,) effective rolling radius [m]"""
    alpha: np.ndarray
    """(runs,) side slip angle [rad]"""
    gamma: np.ndarray
    """(runs,) camber [rad]"""
    kappa: np.ndarray
    """(runs,) commanded slip"""
    pressure: np.ndarray
    """(runs,) [bar]"""
    since_step: np.ndarray
    """travel since the step [m], negative before"""
    wheel_turn: np.ndarray
    """wheel angle in space, start angle included [rad]"""
    signals: dict[str, np.ndarray]
    """measured channels as inputs, without their noise"""
    side_force: np.ndarray
    """(runs,) Fy of a turned wheel before the plank moves [N]; 0 where the wheel is straight"""
    grids: list[np.ndarray]
    """runs that share their nodes"""
    signs: tuple[WrongSign, ...] = ()
    """columns and keys whose sign is the other way round"""
    further: Mapping[str, Coordinate] = field(default_factory=dict)
    """columns of other names that all runs have: what was recorded beside the channels"""
    against: References | None = None
    """of another campaign, whose fit these runs are asked about"""

    @cached_property
    def reference(self) -> References:
        """What the sizes of effects are told against."""
        return self.against or References.of(self)

    @cached_property
    def side_before(self) -> np.ndarray:
        """(runs,) sign of the last slip before each run; 0 where none is known."""
        return side_before(self.runs.order, self.kappa)

    def coordinate(self, name: str) -> np.ndarray:
        """A coordinate of the runs, a channel, or a further column by name (runs, samples)."""
        return coordinate_of(self, name).values

    def only_common(self, values: np.ndarray) -> np.ndarray:
        """Remove the run mean and the profile shared by all runs on the same nodes (..., R, N)."""
        out = values - values.mean(axis=-1, keepdims=True)
        for rows in self.grids:
            if len(rows) > 2:
                out[..., rows, :] -= out[..., rows, :].mean(axis=-2, keepdims=True)
        return out


def side_before(order: np.ndarray, kappa: np.ndarray) -> np.ndarray:
    """Sign of the last slip before each run, 1 driving, -1 braking; 0 where none is known.

    order, kappa (runs,): run order and commanded slip.
    """
    sides = np.zeros(len(order))
    last = 0.0
    for row in np.argsort(order, kind="stable"):
        sides[row] = last
        last = float(np.sign(kappa[row])) or last
    return sides


def coordinates_of(data: TireRuns) -> Mapping[str, Coordinate]:
    """Everything by name in which something may show itself; further columns go first."""
    shape = data.position.shape
    out = dict(data.runs.coordinates)
    for name, unit in SIGNALS.items():
        if name in data.signals:
            out[name] = Coordinate(data.signals[name], unit, 24)
    for name, unit in FACTS.items():
        values = np.broadcast_to(data.runs.facts[name][:, None], shape)
        out[name] = Coordinate(values, unit, 9)
    return out | dict(data.further)


def coordinate_of(data: TireRuns, name: str) -> Coordinate:
    """One of them; FlatplankError when the runs do not have it."""
    known = coordinates_of(data)
    if name not in known:
        raise FlatplankError(
            f"the runs have no '{name}'", "coordinate",
            f"record it as a column '{name} [unit]' of every run",
        )  # fmt: skip
    return known[name]
