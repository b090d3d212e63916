# SPDX-License-Identifier: Apache-2.0
"""Gain, zero and timing of the force channels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.base import Signal, TireEffect


def shifted(values: np.ndarray, time: np.ndarray, delay: np.ndarray) -> np.ndarray:
    """values(time - delay), the ends held.

    Shapes: values (sets, runs, samples), time (runs, samples); delay as values, or 1 where it is
    the same for all.
    """
    late = time - delay
    out = np.empty(np.broadcast_shapes(values.shape, late.shape))
    values, late = np.broadcast_to(values, out.shape), np.broadcast_to(late, out.shape)
    for index in np.ndindex(out.shape[:-1]):
        out[index] = np.interp(late[index], time[index[-1]], values[index])
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
class HubGain(TireEffect):
    """The longitudinal force is read too large by a factor."""

    identifier = "hub_gain"
    title = "Gain of the Fx channel"
    kind = "sensor"
    coordinate = "slip level"
    source = "thesis Appendix A"
    what = (
        "A wrong calibration factor of Fx. A fitted tire hides it: only a weight on a rope "
        "shows it."
    )
    check = "Pull the standing wheel with a known force."
    removes = "Recalibrate Fx."

    gain: float = param(
        0.0, unit="1", bounds=(-0.3, 0.3), screen=0.02, matters=0.01,
        title="error of the gain", symbol="ε_F", note="Relative error of the reading of Fx.",
    )  # fmt: skip

    def signal(self, signal: Signal) -> None:
        signal.fx = signal.fx * (1.0 + self.gain)


@dataclass(frozen=True)
class ZeroDrift(TireEffect):
    """The zero of Fx drifts with time during every run."""

    identifier = "zero_drift"
    title = "Drift of the zero during a run"
    kind = "sensor"
    coordinate = "time"
    source = "thesis 3.1: warming-up of the bridge amplifiers"
    what = "The bridge amplifier warms up: the zero creeps during the run."
    check = "Record the standing wheel for five minutes."
    removes = "Let the amplifier warm up; tare before each run."

    drift: float = param(
        0.0, unit="N/s", bounds=(-3.0, 3.0), screen=0.1, matters=0.04,
        title="drift of the zero", symbol="dF_0",
        note="Change of the zero of Fx in a second of a run.",
    )  # fmt: skip

    def signal(self, signal: Signal) -> None:
        signal.fx = signal.fx + self.drift * signal.data.runs.time


@dataclass(frozen=True)
class ZeroDriftRuns(TireEffect):
    """The zero of Fx drifts from run to run."""

    identifier = "zero_drift_runs"
    title = "Drift of the zero over the runs"
    kind = "sensor"
    coordinate = "run order"
    source = "thesis 3.1"
    what = "The zero of the bridge creeps during the campaign."
    check = "Compare the readings at standstill before each run."
    removes = "Tare before each run."

    drift: float = param(
        0.0, unit="N", bounds=(-300.0, 300.0), screen=20.0, matters=5.0,
        title="drift of the zero", symbol="ΔF_0",
        note="Change of the zero of Fx from the first to the last run.",
    )  # fmt: skip

    def signal(self, signal: Signal) -> None:
        data = signal.data
        share = data.reference.share(data.runs.order, data.reference.middle)
        signal.fx = signal.fx + self.drift * share[:, None]


@dataclass(frozen=True)
class ForceLag(TireEffect):
    """A first-order low-pass acts on the longitudinal force channel."""

    identifier = "force_lag"
    title = "Lag of the force signal"
    kind = "sensor"
    coordinate = "time"
    source = "thesis 3.2: analogue filters of the measurement hub"
    what = "A filter in the bridge amplifier makes the force channel lag behind."
    check = "Tap the hub and look at the decay; look up the filter setting of the amplifier."
    removes = "A higher cut-off, or the same filter on the motion channels."
    order = 80

    lag: float = param(
        0.0, unit="s", bounds=(0.0, 2.0), screen=0.05, matters=0.02,
        title="lag of the force", symbol="τ_F",
        note="Time constant of the low-pass in the channel of Fx.",
    )  # fmt: skip

    @classmethod
    def starts(cls) -> tuple[float, ...]:
        return (1.0, 4.0)

    def signal(self, signal: Signal) -> None:
        signal.fx = lagged(signal.fx, signal.data.step_time, self.lag)


@dataclass(frozen=True)
class TimeSkew(TireEffect):
    """Force and motion are stamped by clocks that differ by a constant."""

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
        0.0, unit="s", bounds=(-1.0, 1.0), screen=0.05, matters=0.02,
        title="skew of the clocks", symbol="Δt",
        note="Time by which the force is recorded later than the motion.",
    )  # fmt: skip

    def signal(self, signal: Signal) -> None:
        time = signal.data.runs.time
        for name in ("fx", "fy"):
            setattr(signal, name, shifted(getattr(signal, name), time, self.skew))
