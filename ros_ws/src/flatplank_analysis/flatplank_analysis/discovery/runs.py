# SPDX-License-Identifier: Apache-2.0
"""A measurement campaign as the engine uses it: aligned runs with repeats and coordinates."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from flatplank_data.errors import FlatplankError
from flatplank_data.wording import behind, brief


@dataclass(frozen=True)
class Coordinate:
    """A quantity over which an effect may show, one value per run and sample."""

    values: np.ndarray
    """shape (runs, samples)"""
    unit: str = "1"
    bins: int = 24
    """number of bins of a map over it"""
    period: float = 0.0
    """period at which the values wrap (an angle), 0 when they do not"""
    local: bool = False
    """True for a place (plank position): local deviations are searched bin by bin"""


@dataclass(frozen=True)
class RunSet:
    """R runs on N nodes each, C measured channels; node k means the same in every repeat."""

    names: tuple[str, ...]
    condition: np.ndarray
    """(runs,) number of the condition; runs with the same number are repeats"""
    condition_names: tuple[str, ...]
    channels: tuple[str, ...]
    measured: np.ndarray
    """(channels, runs, samples)"""
    time: np.ndarray
    """(runs, samples) [s]: time base of the noise model"""
    order: np.ndarray
    """(runs,) order in which the runs were made"""
    coordinates: Mapping[str, Coordinate] = field(default_factory=dict)
    units: tuple[str, ...] = ()
    """unit of every channel"""
    roughness: np.ndarray | None = None
    """(runs, samples) factor >= 1 on the noise where the model is known to be inaccurate; the
    additional part is independent of the noise; for decisions only"""
    input_noise: tuple[float, ...] = ()
    """per channel: prediction error by the resolution of the inputs; it is the same in all
    repeats, which therefore do not show it"""
    facts: Mapping[str, np.ndarray] = field(default_factory=dict)
    """values per run that effects may use (start angle, nominal load ...), shape (runs,)"""
    inputs: Mapping[str, np.ndarray] = field(default_factory=dict)
    """commands or excitations of the machine, shape (runs, samples): where they recur within one
    record, they give a floor without repeats"""
    rest: tuple[float, ...] = ()
    """per channel: standard deviation while nothing moves"""
    resolution: tuple[float, ...] = ()
    """per channel: resolution of the recording"""
    floor_from: str = ""
    """identifier of the source (`sources.ranked`) that the records were cut for, empty: not cut"""
    contradicted: tuple[str, ...] = ()
    """signs of columns or records that physics contradicts, in words; they prevent any fit"""

    def __post_init__(self) -> None:
        shape = self.measured.shape
        if len(shape) != 3 or shape[0] != len(self.channels) or shape[1] != len(self.names):
            raise FlatplankError(
                f"measured has shape {shape}", "RunSet", "channels, runs, samples"
            )
        bad = np.flatnonzero(~np.isfinite(self.measured).all(axis=(0, 2)))
        if len(bad):
            raise FlatplankError(
                "measured holds NaN or infinity", f"run {self.names[bad[0]]}", "leave the run out"
            )

    @property
    def runs(self) -> int:
        return len(self.names)

    @property
    def samples(self) -> int:
        return self.measured.shape[2]

    @cached_property
    def groups(self) -> list[np.ndarray]:
        """Indices of the runs of every condition."""
        return [np.flatnonzero(self.condition == c) for c in range(len(self.condition_names))]

    @cached_property
    def repeated(self) -> bool:
        """True when at least one condition was measured twice."""
        return any(len(g) > 1 for g in self.groups)

    @cached_property
    def comparable(self) -> list[np.ndarray]:
        """Groups of runs within which the scores of an effect scatter: the repeats; all runs where
        nothing is repeated."""
        return self.groups if self.repeated else [np.arange(self.runs)]

    @cached_property
    def largest(self) -> np.ndarray:
        """Largest absolute mean of the repeats (channels,); channels of the same unit share it."""
        own = np.abs(self.mean(self.measured)).max(axis=(1, 2))
        units = self.units or self.channels
        return np.array([max(own[i] for i, v in enumerate(units) if v == u) for u in units])

    def unit_of(self, channel: int = 0) -> str:
        """Unit of a channel; empty where the runs have none."""
        return self.units[channel] if self.units else ""

    def amount(self, value: float, digits: int = 1, channel: int = 0) -> str:
        """A value of a channel with its unit."""
        return behind(brief(value, digits), self.unit_of(channel))

    def mean(self, values: np.ndarray) -> np.ndarray:
        """Mean over the repeats: (..., runs, samples) -> (..., conditions, samples)."""
        return np.stack([values[..., g, :].mean(axis=-2) for g in self.groups], axis=-2)

    def contrast(self, values: np.ndarray) -> np.ndarray:
        """Difference of each run from the mean of its condition."""
        return values - self.mean(values)[..., self.condition, :]

    def rmse(self, residual: np.ndarray) -> float:
        """Root mean square of a (runs, samples) residual."""
        return float(np.sqrt(np.mean(residual**2)))

    def subset(self, keep: np.ndarray) -> RunSet:
        """The same campaign with fewer runs; `keep` holds indices."""
        keep = np.asarray(keep)
        old = self.condition[keep]
        kinds, condition = np.unique(old, return_inverse=True)
        return replace(
            self,
            names=tuple(self.names[i] for i in keep),
            condition=condition,
            condition_names=tuple(self.condition_names[c] for c in kinds),
            measured=self.measured[:, keep],
            time=self.time[keep],
            order=self.order[keep],
            roughness=None if self.roughness is None else self.roughness[keep],
            coordinates={
                k: replace(c, values=c.values[keep]) for k, c in self.coordinates.items()
            },
            inputs={k: v[keep] for k, v in self.inputs.items()},
            floor_from="",
            facts={k: v[keep] for k, v in self.facts.items()},
        )
