# SPDX-License-Identifier: Apache-2.0
"""The steps of measurement plans: a plan yields steps, a bench performs them.

A bench is the ROS graph, the twin in one process, or a dry run; each can perform every step."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from flatplank_data.errors import FlatplankError
from flatplank_hw.drive.safety import REASONS, STOPS, is_latched
from flatplank_hw.samples import DriveSample, EncoderSample, HubSample
from flatplank_hw.troubles import TROUBLES

BUSY = "the runner is busy with another measurement"
"""reason for a refused measurement"""
LONGEST_BATCH_S = 0.04
"""longest batch; a drive trips after 42 ms without inputs [s]"""


class Snapshot(NamedTuple):
    """Samples of one cycle."""

    encoders: EncoderSample
    hub: HubSample
    drive: DriveSample


@dataclass(frozen=True)
class Manual:
    """A setting that the operator makes by hand or by a switch, and that the sensors verify.

    `quantity` is a key of `conditions.QUANTITIES`, which has the prompt and the check.
    """

    quantity: str
    value: float
    zero: float = float("nan")
    """Fz of the unloaded hub at this wheel angle, for a load [N]; NaN: unknown"""


@dataclass(frozen=True)
class Plank:
    """Command to the plank's switch or drive: direction 1, 0, -1; the plank stops by itself at
    machine position `stop_at` [m].
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
    """Set the operation mode of a drive; `value` for modes that need one [SI]."""

    mode: str
    value: float = 0.0
    axis: str = "wheel"


@dataclass(frozen=True)
class MoveTo:
    """Turn the wheel to an angle [deg]."""

    angle_deg: float


@dataclass(frozen=True)
class SlipWaveform:
    """Set the slip waveform over plank position, by name and parameters."""

    name: str
    parameters: Mapping[str, float]
    start_position: float
    effective_rolling_radius: float


@dataclass(frozen=True)
class Arm:
    """Let the next motion trigger set the plank position to zero."""


@dataclass(frozen=True)
class Constants:
    """Set constants of the set-up at a node: parameter -> value."""

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
    """Set the trigger output for an optical system: a pulse every `distance` [m] of road; below 0:
    off."""

    distance: float


@dataclass(frozen=True)
class HoldLoad:
    """Let the load controller of a driven vertical axis hold a load [N]; NaN: release the axis."""

    fz: float


@dataclass(frozen=True)
class AxisProfile:
    """Let a driven steer or camber axis follow a profile, by name and parameters. Empty name: hold
    the angle; parameters None: release the axis."""

    axis: str
    name: str = ""
    parameters: Mapping[str, float] | None = field(default_factory=dict)


@dataclass(frozen=True)
class FastCycles:
    """Let the bus send batches of cycles while nothing is measured; simulated bench only."""

    batch: int

    def fitting(self, rate_hz: float) -> int:
        """Cycles of a batch at this bus rate: `batch`, but at most 40 ms."""
        return max(1, min(self.batch, int(LONGEST_BATCH_S * rate_hz + 1e-6)))


@dataclass(frozen=True)
class Wait:
    """Wait until `until(snapshot)` holds; after `timeout` [s of bench time] the plan fails with
    `what`.
    """

    what: str
    until: Callable[[Snapshot], bool]
    timeout: float
    at_least: float = 0.0
    """shortest wait [s of bench time]"""
    may_end_early: bool = False
    """true: the operator may end the wait early"""


@dataclass(frozen=True)
class ShowProgress:
    """Show progress to the operator."""

    text: str


Step = (
    Manual | Plank | Enable | Mode | MoveTo | SlipWaveform | Arm | Record | StopRecord
    | FastCycles | Wait | ShowProgress | Trigger | HoldLoad | AxisProfile | Constants
)  # fmt: skip


class PlanFailed(FlatplankError):
    """Error that ends a measurement; the text states why, and what to do."""


CHUNK = 25
"""number of batches that a held bench makes between two checks of a wait"""


class StopDetector:
    """Ends a plan when a safety rule stops the drive of the wheel.

    It ignores a stop from before the plan, which the plan clears, and the stop of the wheel that
    follows when the plan itself stops the plank.
    """

    def __init__(self) -> None:
        self._ran = False
        self._plank_rests = True

    def register_command(self, step: Plank) -> None:
        """Register a plank command of the plan."""
        self._plank_rests = step.direction == 0 or math.isfinite(step.stop_at)

    def check_sample(self, drive: DriveSample) -> None:
        """Check a sample; PlanFailed with the reason of a new stop."""
        stopped = is_latched(drive.stop_reason)
        fresh, self._ran = stopped and self._ran, not stopped
        if not fresh or (self._plank_rests and STOPS[drive.stop_reason] == "plank_stopped"):
            return
        raise PlanFailed(f"the wheel was stopped: {TROUBLES[STOPS[drive.stop_reason]].line()}")


class WaitMonitor:
    """Decides, sample by sample, whether a Wait is over. Bench time [s] is an argument."""

    def __init__(self, step: Wait, now: float) -> None:
        self._step = step
        self.start = now

    def over(self, snapshot: Snapshot | None, now: float) -> bool:
        """True when the plan can continue; PlanFailed after the time-out."""
        elapsed = now - self.start
        step = self._step
        if snapshot is not None and elapsed >= step.at_least and step.until(snapshot):
            return True
        if elapsed > step.timeout:
            stop = snapshot.drive.stop_reason if snapshot else 0
            drive = f" (drive: {REASONS[stop]})" if stop else ""
            raise PlanFailed(f"after {step.timeout:g} s still not: {step.what}{drive}")
        return False
