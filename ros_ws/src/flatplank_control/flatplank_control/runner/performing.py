# SPDX-License-Identifier: Apache-2.0
"""What benches do alike when they perform a plan."""

from __future__ import annotations

import math

from flatplank_control.runner.steps import PlanFailed, Plank, Snapshot, Wait
from flatplank_hw.drive.safety import REASONS, STOPS, is_latched
from flatplank_hw.samples import DriveSample
from flatplank_hw.troubles import TROUBLES

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
            raise PlanFailed(
                f"waited {step.timeout:g} s of bench time and it is not true that {step.what}"
                + (
                    f" (drive: {stop_text(snapshot)})"
                    if snapshot and snapshot.drive.stop_reason
                    else ""
                )
            )
        return False


def stop_text(snapshot: Snapshot) -> str:
    """Why the drive holds the wheel."""
    return REASONS[snapshot.drive.stop_reason]
