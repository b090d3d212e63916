# SPDX-License-Identifier: Apache-2.0
"""State of the bench for the page: the latest samples and a ring buffer of the last minutes."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np

from flatplank_hw.bus.image import AXES, BusInputs, Digital, Health
from flatplank_hw.bus.timing import ToldTimes
from flatplank_hw.cia402 import State, decode
from flatplank_hw.drive.modes import MODES
from flatplank_hw.drive.safety import REASONS
from flatplank_hw.samples import DriveSample, EncoderSample, HubSample, Wrench, flagged
from flatplank_panel.signals import DEG, SIGNALS


class Ring:
    """Ring buffer of the latest `length` rows of `width` numbers; rows have increasing serial
    numbers."""

    def __init__(self, length: int, width: int) -> None:
        self._rows = np.full((length, width), np.nan)
        self.serial = 0
        """serial number of the latest row"""
        self.begun = 0
        """serial number at the last clearing"""

    def push(self, row: Sequence[float]) -> None:
        self._rows[self.serial % len(self._rows)] = row
        self.serial += 1

    def clear(self) -> None:
        self.begun = self.serial

    def since(self, serial: int) -> np.ndarray:
        """Stored rows after number `serial`, oldest first; shape (n, width)."""
        first = max(serial, self.serial - len(self._rows), self.begun)
        places = np.arange(first, self.serial) % len(self._rows)
        return self._rows[places]


POLL_HZ = 20
KEPT_SECONDS = 600
STALE = 1.0
"""the bench is gone after this time without a bus cycle [s of wall clock]"""
BEHIND = 250
"""a sample farther from the bus cycle is not shown: its node has ended [cycles]"""
_MODES = {mode.code: name for name, mode in MODES.items()}
_NAN = math.nan


class Slip(NamedTuple):
    """Reference and actual slip [-]."""

    cycle: int
    reference: float
    actual: float


def _nothing(kind: Any) -> Any:
    """A sample with unknown values only."""
    return kind(*[_NAN] * len(kind._fields))


@dataclass
class Samples:
    """Latest sample of every topic, or None."""

    inputs: BusInputs | None = None
    hub: HubSample | None = None
    """with the wrench at the contact point"""
    encoders: EncoderSample | None = None
    drive: DriveSample | None = None
    slip: Slip | None = None

    def fresh(self) -> Samples:
        """Samples without those too far from the present bus cycle."""
        if self.inputs is None:
            return Samples()
        others = {name: getattr(self, name) for name in ("hub", "encoders", "drive", "slip")}
        now = self.inputs.cycle
        old = [n for n, s in others.items() if s is not None and abs(s.cycle - now) > BEHIND]
        return replace(self, **dict.fromkeys(old))


@dataclass
class RunStatus:
    """Name and status in the last message on `/run`."""

    name: str = ""
    status: str = ""


@dataclass
class Progress:
    """Feedback of the measurement runner."""

    active: bool = False
    step: str = ""
    prompt: str = ""
    measurement: int = 0
    measurements: int = 0
    share: float = 0.0
    message: str = ""
    bags: list[str] = field(default_factory=list)
    time_left: float = 0.0
    """time left [s]"""


class BenchState:
    """State of the bench; its memory does not grow."""

    def __init__(self) -> None:
        self.ring = Ring(POLL_HZ * KEPT_SECONDS, len(SIGNALS))
        self.samples = Samples()
        self.run = RunStatus()
        self.progress = Progress()
        self.log: deque[tuple[str, str]] = deque(maxlen=50)
        """(time of day, text), the latest first"""
        self.rate_hz = 0.0
        self.zero_taken = False
        """a page of this panel has taken the zero of the bridges since the bus was started"""
        self.troubles: dict[str, str] = {}
        """node -> what is wrong and what to do, of nodes with a trouble"""
        self.times: ToldTimes | None = None
        """times of the bus in real time"""
        self._t0_ns = 0
        self._cycle = -1
        self._seen_at = -math.inf
        self._rate_from: tuple[float, int] = (0.0, 0)

    def accept(self, samples: Samples, now: float) -> None:
        """Take new samples at wall time `now` [s, monotonic]; adds a row when the bus cycle has
        advanced."""
        self.samples = samples = samples.fresh()
        if samples.inputs is None or samples.inputs.cycle == self._cycle:
            return
        if samples.inputs.cycle < self._cycle or self._cycle < 0:
            self._t0_ns = samples.inputs.stamp_ns  # the bus was restarted
            self.ring.clear()
            self.zero_taken = False
            self._rate_from = (now, samples.inputs.cycle)
        self._cycle, self._seen_at = samples.inputs.cycle, now
        since, cycle = self._rate_from
        if now - since >= 1.0:
            self.rate_hz = (self._cycle - cycle) / (now - since)
            self._rate_from = (now, self._cycle)
        self.ring.push(self._row(samples, samples.inputs.stamp_ns))

    def running(self, now: float) -> bool:
        """True when there was a bus cycle within the last STALE seconds."""
        return now - self._seen_at < STALE

    def _row(self, s: Samples, stamp_ns: int) -> tuple[float, ...]:
        c = s.hub.contact if s.hub else _nothing(Wrench)
        e, d = s.encoders or _nothing(EncoderSample), s.drive or _nothing(DriveSample)
        slip = s.slip or _nothing(Slip)
        return (
            (stamp_ns - self._t0_ns) * 1e-9, e.plank_position, e.plank_velocity,
            c.fx, c.fy, c.fz, c.mx, c.my, c.mz, e.wheel_angle * DEG, e.wheel_velocity,
            e.steer_angle * DEG, e.road_camber * DEG, s.hub.loaded_radius if s.hub else _NAN,
            d.position * DEG, d.reference_position * DEG, d.velocity, d.reference_velocity,
            d.torque, d.reference_torque, slip.actual * 100.0, slip.reference * 100.0,
        )  # fmt: skip

    # texts
    def state_texts(self, now: float) -> dict[str, str]:
        """State as texts for the page."""
        s = self.samples
        if not self.running(now) or s.inputs is None:
            return {"bench": "not running", "run": self.run_words()}
        digital = s.inputs.digital
        words = {
            "bench": f"running, {self.rate_hz:.0f} Hz",
            "cycle": str(s.inputs.cycle),
            "health": Health(s.inputs.health).name.lower().replace("_", " "),
            "trigger": "on" if digital & Digital.TRIGGER else "off",
            "estop": "released" if digital & Digital.EMERGENCY_STOP_OK else "PRESSED",
            "run": self.run_words(),
            "troubles": " | ".join(f"{n}: {text}" for n, text in self.troubles.items()),
            "late": self.times.in_words if self.times else "",
            **(self.times.durations_in_words if self.times else {}),
        }
        if s.drive is not None:
            words |= {
                "state": State(s.drive.state).name.lower().replace("_", " "),
                "mode": _MODES.get(s.drive.mode, "none"),
                "stop": REASONS.get(s.drive.stop_reason, f"code {s.drive.stop_reason}"),
                "error": f"0x{s.drive.error_code:04X}" if s.drive.error_code else "",
            }
        if s.encoders is not None:
            words["plank"] = "moving" if s.encoders.plank_moving else "at rest"
        if s.hub is not None:
            words["filter"] = "on" if s.hub.filter_on else "off"
            words["saturated"] = ", ".join(flagged(s.hub.saturated))
        return words

    def run_words(self) -> str:
        return f"{self.run.name}: {self.run.status}" if self.run.name else "none"

    def axes(self, now: float) -> list[dict[str, str]]:
        """One line per drive on the bus; none when the bus does not run."""
        if not self.running(now) or self.samples.inputs is None:
            return []
        return [
            {
                "axis": name,
                "state": decode(a.status_word).name.lower().replace("_", " "),
                "word": f"0x{a.status_word:04X}",
                "mode": str(a.mode_display),
                "error": f"0x{a.error_code:04X}" if a.error_code else "none",
            }
            for name, a in zip(AXES, self.samples.inputs.axes, strict=False)
        ]
