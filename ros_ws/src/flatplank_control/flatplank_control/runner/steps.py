# SPDX-License-Identifier: Apache-2.0
"""The vocabulary of measurement plans: a plan yields steps, a bench performs them.

A bench is the ROS graph, the in-process twin, or a dry run: each knows how to do every step."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from flatplank_hw.drive.safety import REASONS, STOPS, is_latched
from flatplank_hw.samples import DriveSample, EncoderSample, HubSample
from flatplank_hw.troubles import TROUBLES

LONGEST_BATCH_S = 0.04
"""less than the 42 ms after which a drive misses its inputs [s]"""


class Snapshot(NamedTuple):
    """What the bench measures at one cycle."""

    encoders: EncoderSample
    hub: HubSample
    drive: DriveSample


@dataclass(frozen=True)
class Manual:
    """Something that the operator sets by hand or by a switch, and that the sensors verify.

    `quantity` is a key of `quantities.QUANTITIES`, which has the prompt and the check.
    """

    quantity: str
    value: float
    zero: float = float("nan")
    """what the unloaded hub said at this wheel angle, for a load [N]; NaN: not known"""


@dataclass(frozen=True)
class Plank:
    """The plank's switch, or its drive where it has one: direction 1, 0, -1; it goes to stop by
    itself at `stop_at` [m of the machine].
    """

    direction: int
    fast: bool = True
    stop_at: float = float("nan")


@dataclass(frozen=True)
class Enable:
    """Switch a drive on or off."""

    on: bool
    axis: str = "wheel"


@dataclass(frozen=True)
class Mode:
    """Operation mode of a drive; `value` for modes that need one [SI]."""

    mode: str
    value: float = 0.0
    axis: str = "wheel"


@dataclass(frozen=True)
class MoveTo:
    """Turn the wheel to an angle [deg]."""

    angle_deg: float


@dataclass(frozen=True)
class SlipWaveform:
    """Slip over plank position, by name and parameters."""

    name: str
    parameters: Mapping[str, float]
    start_position: float
    effective_rolling_radius: float


@dataclass(frozen=True)
class Arm:
    """The next motion trigger sets the plank position to zero."""


@dataclass(frozen=True)
class Constants:
    """Constants of the set-up at a node: parameter -> value."""

    values: Mapping[str, float]
    node: str = "measurement_hub"


@dataclass(frozen=True)
class Record:
    """Start a recording; `record` has the fields of a RunRecord."""

    record: Mapping[str, Any] = field(default_factory=dict)
    at_once: bool = False
    """do not wait for the motion trigger"""


@dataclass(frozen=True)
class StopRecord:
    """Close the bag with a status."""

    status: str
    notes: str = ""


@dataclass(frozen=True)
class Trigger:
    """Digital output for an optical system: a pulse each `distance` [m] of road; below 0: off."""

    distance: float


@dataclass(frozen=True)
class HoldLoad:
    """The load controller of a driven vertical axis holds this load [N]; NaN: it lets go."""

    fz: float


@dataclass(frozen=True)
class AxisProfile:
    """A driven steer or camber axis follows an angle over time by name and parameters; empty name:
    it holds its angle; None for the parameters: it lets go."""

    axis: str
    name: str = ""
    parameters: Mapping[str, float] | None = field(default_factory=dict)


@dataclass(frozen=True)
class Quick:
    """Let the bus send batches of cycles while nothing is measured (simulated bench only)."""

    batch: int

    def fitting(self, rate_hz: float) -> int:
        """Cycles of a batch at this bus rate: `batch`, and not over 40 ms."""
        return max(1, min(self.batch, int(LONGEST_BATCH_S * rate_hz + 1e-6)))


@dataclass(frozen=True)
class Wait:
    """Until `until(snapshot)` holds; after `timeout` [s of bench time] the plan fails, saying
    `what`.
    """

    what: str
    until: Callable[[Snapshot], bool]
    timeout: float
    at_least: float = 0.0
    """[s of bench time]"""
    may_end_early: bool = False
    """the operator may say that it is enough"""


@dataclass(frozen=True)
class Say:
    """Progress for people."""

    text: str


Step = (
    Manual | Plank | Enable | Mode | MoveTo | SlipWaveform | Arm | Record | StopRecord
    | Quick | Wait | Say | Trigger | HoldLoad | AxisProfile | Constants
)  # fmt: skip


class PlanFailed(Exception):
    """A measurement could not be finished: why, and what to do."""


CHUNK = 25
"""a held bench is looked at every so many batches of cycles"""


class StopWatch:
    """Ends a plan when the wheel's drive is stopped on the way; a stop that was there before the
    plan is the plan's to clear, and a plank that the plan itself stops is no trouble."""

    def __init__(self) -> None:
        self._ran = False
        self._plank_rests = True

    def asked(self, step: Plank) -> None:
        """The plan moves or stops the plank."""
        self._plank_rests = step.direction == 0 or math.isfinite(step.stop_at)

    def look(self, drive: DriveSample) -> None:
        """One sample; PlanFailed with the reason of a new stop."""
        stopped = is_latched(drive.stop_reason)
        fresh, self._ran = stopped and self._ran, not stopped
        if not fresh or (self._plank_rests and STOPS[drive.stop_reason] == "plank_stopped"):
            return
        raise PlanFailed(f"the wheel was stopped: {TROUBLES[STOPS[drive.stop_reason]].line()}")


class Patience:
    """Decides, look by look, whether a Wait is over. Bench time [s] is an argument."""

    def __init__(self, step: Wait, now: float) -> None:
        self._step = step
        self.start = now

    def over(self, snapshot: Snapshot | None, now: float) -> bool:
        """True when the plan can go on; PlanFailed when it took too long."""
        elapsed = now - self.start
        step = self._step
        if snapshot is not None and elapsed >= step.at_least and step.until(snapshot):
            return True
        if elapsed > step.timeout:
            stop = snapshot.drive.stop_reason if snapshot else 0
            drive = f" (drive: {REASONS[stop]})" if stop else ""
            raise PlanFailed(
                f"waited {step.timeout:g} s of bench time and it is not true that {step.what}"
                f"{drive}"
            )
        return False
