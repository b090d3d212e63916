# SPDX-License-Identifier: Apache-2.0
"""Errors in time between recorders and in the force channel."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.base import Signal, TireEffect


def shifted(values: np.ndarray, time: np.ndarray, delay: np.ndarray) -> np.ndarray:
    """values(time - delay), the ends held; shapes (lanes, runs, samples), (runs, samples)."""
    out = np.empty_like(values)
    for lane, row in enumerate(np.broadcast_to(delay, (len(values), 1, 1))[:, 0, 0]):
        for r, t in enumerate(time):
            out[lane, r] = np.interp(t - row, t, values[lane, r])
    return out


def lagged(values: np.ndarray, step: np.ndarray, lag: np.ndarray) -> np.ndarray:
    """First-order low-pass, exact for straight pieces between the nodes."""
    lag = np.broadcast_to(lag, (len(values), 1, 1))
    keep = np.exp(-step / np.maximum(lag, 1e-9))
    slope = np.diff(values, axis=-1, prepend=values[..., :1]) / np.maximum(step, 1e-9)
    behind = slope * lag
    out = values.copy()
    for n in range(1, values.shape[-1]):
        rest = out[..., n - 1] - values[..., n - 1] + behind[..., n]
        out[..., n] = values[..., n] - behind[..., n] + rest * keep[..., n]
    return out


@dataclass(frozen=True)
class TimeSkew(TireEffect):
    """Force and motion are stamped by clocks that differ by a constant.

    Source: thesis 3.2: two computers log force and motion
    """

    identifier = "time_skew"
    title = "Skew between force and motion recording"
    kind = "sensor"
    coordinate = "time"
    source = "thesis 3.2: two computers log force and motion"
    what = (
        "Forces and motions are recorded by two computers; one stamps late. All forces move "
        "together against the motion."
    )
    check = (
        "Tap the wheel while both record; compare the start of the force with the start of "
        "the plank."
    )
    removes = "One clock, one trigger for both recorders; or the found skew in the import."
    order = 90

    skew: float = param(
        0.0,
        unit="s",
        bounds=(-1.0, 1.0),
        screen=0.05,
        matters=0.02,
        note="the force comes later by this",
    )

    def signal(self, signal: Signal) -> None:
        time = signal.data.runs.time
        for name in ("fx", "fy"):
            setattr(signal, name, shifted(getattr(signal, name), time, self.skew))


@dataclass(frozen=True)
class ForceLag(TireEffect):
    """A first-order low-pass sits in the longitudinal force channel.

    Source: thesis 3.2: analogue filters of the measurement hub
    """

    identifier = "force_lag"
    title = "Lag of the force signal"
    kind = "sensor"
    coordinate = "time"
    source = "thesis 3.2: analogue filters of the measurement hub"
    what = "A filter in the bridge amplifier makes the force channel lag behind."
    check = "Tap the hub and look at the decay; look up the filter setting of the amplifier."
    removes = "A higher cut-off, or the same filter on the motion channels."
    order = 80

    lag: float = param(0.0, unit="s", bounds=(0.0, 2.0), screen=0.05, matters=0.02)

    @classmethod
    def starts(cls) -> tuple[float, ...]:
        return (1.0, 4.0)

    def signal(self, signal: Signal) -> None:
        signal.fx = lagged(signal.fx, signal.data.step_time, self.lag)
