# SPDX-License-Identifier: Apache-2.0
"""What a client hears while its measurement is made."""

from __future__ import annotations

import time
from typing import Any

from flatplank_control.runner.progress import Progress
from flatplank_msgs.action import RunMeasurement

OFTEN = 1.0
"""progress is told so often during a wait [s of wall clock]"""
SHARE = 0.05
"""and at once when so much more of the measurement is done: a simulated bench is fast"""


class Feedback:
    """The feedback of one goal, kept from word to word."""

    def __init__(self, goal: Any) -> None:
        self.message = RunMeasurement.Feedback(measurements=1, measurement=1)
        self._goal = goal
        self._progress: Progress | None = None
        self._step, self._told, self._share = 0, 0.0, 0.0

    def say(self, text: str, prompt: str = "") -> None:
        """What is going on, and what the operator must do."""
        self.message.step, self.message.prompt = text, prompt
        self._goal.publish_feedback(self.message)

    def follow(self, progress: Progress) -> None:
        """The steps of a single measurement begin."""
        self._progress, self._step, self._share = progress, 0, 0.0
        self.passing(0.0)

    def next_step(self) -> None:
        """One more step is done."""
        self._step += 1
        self.passing(0.0)

    def passing(self, seconds: float) -> None:
        """The present step takes so long [s of bench time]; told now and then."""
        progress, now = self._progress, time.monotonic()
        if progress is None:
            return
        self.message.progress = progress.done(self._step, seconds)
        self.message.time_left = progress.left(self._step, seconds)
        due = now - self._told >= OFTEN or self.message.progress - self._share >= SHARE
        if due and not self.message.prompt:
            self._told, self._share = now, self.message.progress
            self._goal.publish_feedback(self.message)
