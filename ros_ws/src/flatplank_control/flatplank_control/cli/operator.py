# SPDX-License-Identifier: Apache-2.0
"""Keys and progress lines for the operator of `run`, `slip` and `investigate`."""

from __future__ import annotations

import select
import sys
import termios
import time
import tty
from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple

from flatplank_control.runner.campaign import CampaignPlan, Journal
from flatplank_control.runner.campaign.journal import RunEnd
from flatplank_control.runner.campaign.plan import PlannedRun


class Keys:
    """Key presses, as a context manager; without a terminal there are none."""

    def __enter__(self) -> Keys:
        self._terminal = sys.stdin.isatty()
        if self._terminal:
            self._before = termios.tcgetattr(sys.stdin)
            tty.setcbreak(sys.stdin)
        return self

    def __exit__(self, *_: object) -> None:
        if self._terminal:
            termios.tcsetattr(sys.stdin, termios.TCSADRAIN, self._before)

    def pressed(self) -> str:
        """The pressed key, or an empty text."""
        if not self._terminal or not select.select([sys.stdin], [], [], 0.0)[0]:
            return ""
        return sys.stdin.read(1)

    def line(self, prompt: str) -> str:
        """Read a whole line, with echo."""
        if not self._terminal:
            return ""
        termios.tcsetattr(sys.stdin, termios.TCSADRAIN, self._before)
        try:
            return input(prompt)
        finally:
            tty.setcbreak(sys.stdin)


class OperatorKey(NamedTuple):
    """Meaning of a key."""

    text: str
    service: str
    """service of the runner"""


OF_A_RUN = {
    "c": OperatorKey("confirm what was asked for", "confirm"),
    "e": OperatorKey("enough: this run ends here and is kept", "enough"),
}
OF_A_CAMPAIGN = {
    **OF_A_RUN,
    "r": OperatorKey("repeat this run from its beginning", "repeat"),
    "d": OperatorKey("discard this run and go on", "discard"),
    "s": OperatorKey("skip this run", "skip"),
}


def call_service_of_key(client: Any, keys: Mapping[str, OperatorKey], key: str) -> None:
    """Call the service of a key and print its answer; other keys do nothing."""
    if key not in keys:
        return
    from std_srvs.srv import Trigger

    answer = client.call(Trigger, f"measurement_runner/{keys[key].service}")
    print(keys[key].text if answer.success else answer.message, flush=True)


NOT_ALL_GOOD = 3
"""exit code when runs are flagged or skipped"""


class ProgressPrinter:
    """Prints progress and the time left at the present pace."""

    def __init__(self, left: float = 0.0, now: Callable[[], float] = time.monotonic) -> None:
        """`left`: bench time of all runs [s]; if not given, that of the first line."""
        self._most, self._now = left, now
        self._began, self._last = now(), ""

    def __call__(self, done: int, total: int, text: str, left: float, asks: bool = False) -> None:
        """Print a line; `left`: bench time of the remaining runs [s]. An unchanged line is not
        repeated, unless it `asks` the operator for something."""
        self._most = max(self._most, left)
        if text == self._last and not asks:
            return
        self._last = text
        made = self._most - left
        minutes = (self._now() - self._began) / made * left / 60.0 if made > 0.0 else 0.0
        tail = f"; {minutes:.0f} min left" if made > 0.0 else ""
        print(f"{done}/{total} {text}{tail}", flush=True)


def _ends(plan: CampaignPlan, journal: Journal) -> Iterator[tuple[PlannedRun, RunEnd, str]]:
    """Each run of a plan, how it ended, and in one word what became of it."""
    for run in plan.runs:
        done = journal.done.get(run.key, RunEnd())
        state = "good" if done.final or done.skipped else "not made"
        if journal.needs_repeat(run.key):
            state = "skipped" if done.skipped else "flagged"
        yield run, done, state


def result_of_plan(plan: CampaignPlan, journal: Journal) -> dict[str, Any]:
    """What became of every run of a plan, for programs."""
    runs = [
        {
            "run": run.key,
            "file": done.valid_file,
            "state": state,
            "verdict": done.facts.get("verdict", ""),
        }
        for run, done, state in _ends(plan, journal)
    ]
    return {"folder": str(journal.path.parent), "runs": runs}


def print_result_of_plan(plan: CampaignPlan, journal: Journal) -> int:
    """Print what became of every run; returns 0 when all exist and are good."""
    ends = [*_ends(plan, journal)]
    made = [done for _, done, _ in ends if done.final and done.valid_file]
    flagged = [done for _, done, state in ends if state == "flagged"]
    skipped = [run for run, _, state in ends if state == "skipped"]
    print(f"{len(made)} of {len(plan.runs)} runs in {journal.path.parent}")
    for done in flagged:
        print(f"flagged: {done.files[-1]}: {done.facts.get('verdict', 'see the journal')}")
    for run in skipped:
        print(f"skipped: {run.key} ({plan.where}:{run.line})")
    if not flagged and not skipped:
        return 0
    print(
        f"{len(flagged)} flagged, {len(skipped)} skipped: look at the flagged ones before they "
        "are used; --redo makes them once more"
    )
    return NOT_ALL_GOOD
