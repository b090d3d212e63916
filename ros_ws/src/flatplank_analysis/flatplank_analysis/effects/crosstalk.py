# SPDX-License-Identifier: Apache-2.0
"""Crosstalk of the hub: a bridge responds to other forces than its own."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from flatplank_analysis.contact_patch.size import usual_load_of
from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.discovery.runs import RunSet
from flatplank_analysis.effects.base import Signal, Tire, TireEffect

if TYPE_CHECKING:
    from flatplank_analysis.contact_patch.tire_runs import TireRuns

LEAST = 0.027
"""root mean square of the lateral force, as a share of the load, below which its crosstalk is not
tested"""


def other(data: TireRuns, channel: str, tared: np.ndarray) -> np.ndarray:
    """Another measured channel (sets, runs, samples); tared = 1 subtracts its initial value."""
    values = data.signals.get(channel)
    if values is None:
        return np.zeros((1, *data.position.shape)) * tared
    return values - tared * values[:, :5].mean(axis=1, keepdims=True)


@dataclass(frozen=True)
class CrosstalkIntoFx(TireEffect):
    """A share of another channel appears in the longitudinal force, whatever the slip."""

    channel: ClassVar[str]
    """the other channel"""
    kind = "sensor"
    coordinate = "time"
    source = "thesis 3.1 and Appendix A: the calibration matrix of the hub"
    check = "Load the standing wheel in that direction only and read Fx."
    removes = "A full calibration matrix of the hub."

    share: float = param(
        0.0, unit="1/m", bounds=(-20.0, 20.0), screen=1.0, matters=0.5,
        title="crosstalk of a moment", symbol="c_xm",
        note="Reading of Fx over the moment that causes it.",
    )  # fmt: skip
    tared: float = param(
        0.0, unit="-", bounds=(0.0, 1.0),
        title="channel set to zero", symbol="b_t",
        note="1: the other channel was set to zero at the start of each run; 0: it was not.",
    )  # fmt: skip

    @classmethod
    def variants(cls, runs: RunSet, residual: np.ndarray) -> list[dict[str, float]]:
        return [{"tared": 1.0}]

    @classmethod
    def held(cls) -> tuple[str, ...]:
        return ("tared",)

    def signal(self, signal: Signal) -> None:
        signal.fx = signal.fx + self.share * other(signal.data, self.channel, self.tared)


@dataclass(frozen=True)
class CrosstalkFy(CrosstalkIntoFx):
    """Lateral force in the longitudinal force."""

    identifier = "crosstalk_fy"
    title = "Crosstalk from the lateral force into Fx"
    channel = "fy"
    what = "The bridge of Fx also answers to the lateral force."

    share: float = param(
        0.0, unit="1", bounds=(-0.5, 0.5), screen=0.05, matters=0.02,
        title="crosstalk of the side force", symbol="c_xy",
        note="Reading of Fx over the side force that causes it.",
    )  # fmt: skip

    @classmethod
    def variants(cls, runs: RunSet, residual: np.ndarray) -> list[dict[str, float]]:
        """No variant where there is hardly a lateral force: its crosstalk would be below noise."""
        force = runs.measured[runs.channels.index("fy")] if "fy" in runs.channels else 0.0
        least = LEAST * usual_load_of(runs)
        return [{"tared": 1.0}] if float(np.sqrt(np.mean(force**2))) > least else []


@dataclass(frozen=True)
class CrosstalkFz(CrosstalkIntoFx):
    """Load in the longitudinal force."""

    identifier = "crosstalk_fz"
    title = "Crosstalk from the load into Fx"
    channel = "fz"
    coordinate = "load"
    what = "The bridge of Fx also answers to the load."

    share: float = param(
        0.0, unit="1", bounds=(-0.3, 0.3), screen=0.02, matters=0.01,
        title="crosstalk of the load", symbol="c_xz",
        note="Reading of Fx over the load that causes it.",
    )  # fmt: skip

    @classmethod
    def variants(cls, runs: RunSet, residual: np.ndarray) -> list[dict[str, float]]:
        return [{"tared": 1.0}, {"tared": 0.0}]


@dataclass(frozen=True)
class CrosstalkMx(CrosstalkIntoFx):
    """Overturning moment in the longitudinal force."""

    identifier = "crosstalk_mx"
    title = "Crosstalk from the overturning moment into Fx"
    channel = "mx"
    what = "The bridge of Fx also answers to the overturning moment."


@dataclass(frozen=True)
class CrosstalkMz(CrosstalkIntoFx):
    """Aligning moment in the longitudinal force."""

    identifier = "crosstalk_mz"
    title = "Crosstalk from the aligning moment into Fx"
    channel = "mz"
    what = "The bridge of Fx also answers to the aligning moment."


@dataclass(frozen=True)
class CrosstalkOfFx(TireEffect):
    """A share of the longitudinal force appears in another channel."""

    kind = "sensor"
    coordinate = "slip level"
    source = "thesis Appendix A: the calibration matrix of the hub"
    removes = "A full calibration matrix of the hub."


@dataclass(frozen=True)
class CrosstalkFxFy(CrosstalkOfFx):
    """A share of the longitudinal force appears in the lateral force."""

    identifier = "crosstalk_fx_fy"
    title = "Crosstalk from Fx into Fy"
    what = "The bridge of Fy also answers to Fx, or the hub is turned about the vertical axis."
    check = "Pull the standing wheel in x only and read Fy."

    share: float = param(
        0.0, unit="1", bounds=(-0.3, 0.3), screen=0.02, matters=0.005,
        title="crosstalk of Fx", symbol="c_yx",
        note="Reading of Fy over the longitudinal force that causes it.",
    )  # fmt: skip

    def signal(self, signal: Signal) -> None:
        signal.fy = signal.fy + self.share * signal.true_fx


@dataclass(frozen=True)
class CrosstalkFxFz(CrosstalkOfFx):
    """A share of the longitudinal force appears in the load channel."""

    identifier = "crosstalk_fx_fz"
    title = "Crosstalk from Fx into Fz"
    what = "The bridges of Fz also answer to Fx."
    check = "Pull the standing wheel in x only and read Fz."

    share: float = param(
        0.0, unit="1", bounds=(-0.3, 0.3), screen=0.02, matters=0.01,
        title="crosstalk of Fx", symbol="c_zx",
        note="Reading of Fz over the longitudinal force that causes it.",
    )  # fmt: skip

    def tire(self, tire: Tire) -> None:
        tire.x.loss_brake -= self.per_run.share
        tire.x.loss_drive -= self.per_run.share

    def signal(self, signal: Signal) -> None:
        signal.fz = signal.fz + self.share * signal.true_fx
