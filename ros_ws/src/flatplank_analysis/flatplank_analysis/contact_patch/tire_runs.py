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
"""channels that are also coordinates, because of possible crosstalk"""
FACTS = {"pressure": "bar", "alpha": "rad", "gamma": "rad", "speed": "m/s"}
"""facts of a run that are coordinates where they differ between runs"""
SETTINGS = ("nominal", "radius", "alpha", "gamma", "kappa", "pressure")
"""facts of the runs that are fields of `TireRuns`"""


@dataclass(frozen=True)
class References:
    """Reference values of effect sizes: typical settings and run order of a campaign. Runs of
    another campaign keep those of the fitted one."""

    load: float
    """[N]"""
    pressure: float
    """[bar]"""
    first: float
    last: float
    middle: float
    """run order: first, last and mean"""

    @classmethod
    def of(cls, data: TireRuns) -> References:
        """References of the runs themselves."""
        order = data.runs.order
        medians = float(np.median(data.nominal)), float(np.median(data.pressure))
        return cls(*medians, *(float(f(order)) for f in (np.min, np.max, np.mean)))

    def share(self, order: np.ndarray, begin: float) -> np.ndarray:
        """Run order counted from `begin`, in units of the whole campaign."""
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
    """wheel angle in space, including the start angle [rad]"""
    signals: dict[str, np.ndarray]
    """denoised channels as inputs"""
    side_force: np.ndarray
    """(runs,) Fy of a steered wheel before the plank moves [N]; 0 where the wheel is straight"""
    grids: list[np.ndarray]
    """groups of runs that share their nodes"""
    signs: tuple[WrongSign, ...] = ()
    """columns and keys with the wrong sign"""
    further: Mapping[str, Coordinate] = field(default_factory=dict)
    """further recorded columns that all runs have"""
    against: References | None = None
    """references of another campaign, whose fit is applied to these runs"""

    @cached_property
    def reference(self) -> References:
        """Reference values of effect sizes."""
        return self.against or References.of(self)

    @property
    def relative_load(self) -> np.ndarray:
        """(runs,) nominal load over the reference [-]."""
        return self.nominal / self.reference.load

    @property
    def relative_pressure(self) -> np.ndarray:
        """(runs,) pressure over the reference [-]."""
        return self.pressure / self.reference.pressure

    @cached_property
    def side_before(self) -> np.ndarray:
        """(runs,) sign of the last slip before each run; 0 where unknown."""
        return side_before(self.runs.order, self.kappa)

    @property
    def coordinates(self) -> Mapping[str, Coordinate]:
        """All coordinates by name, see `coordinates_of`."""
        return coordinates_of(self)

    def coordinate(self, name: str) -> np.ndarray:
        """A coordinate, channel or further column by name (runs, samples)."""
        return coordinate_of(self, name).values

    def only_common(self, values: np.ndarray) -> np.ndarray:
        """Remove the run mean and the profile shared by all runs on the same nodes (..., R, N)."""
        out = values - values.mean(axis=-1, keepdims=True)
        for rows in self.grids:
            if len(rows) > 2:
                out[..., rows, :] -= out[..., rows, :].mean(axis=-2, keepdims=True)
        return out


def side_before(order: np.ndarray, kappa: np.ndarray) -> np.ndarray:
    """Sign of the last slip before each run: 1 driving, -1 braking, 0 unknown.

    order, kappa (runs,): run order and commanded slip.
    """
    sides = np.zeros(len(order))
    last = 0.0
    for row in np.argsort(order, kind="stable"):
        sides[row] = last
        last = float(np.sign(kappa[row])) or last
    return sides


def coordinates_of(data: TireRuns) -> Mapping[str, Coordinate]:
    """All coordinates by name over which an effect may show; further columns come first."""
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
    """A coordinate by name; FlatplankError when the runs do not have it."""
    known = coordinates_of(data)
    if name not in known:
        raise FlatplankError(
            f"the runs have no '{name}'", "coordinate",
            f"record it as a column '{name} [unit]' of every run",
        )  # fmt: skip
    return known[name]
