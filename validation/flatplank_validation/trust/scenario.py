# SPDX-License-Identifier: Apache-2.0
"""Scenarios on the twin: a rolling wheel, faults, and for how long the wheel turns uncommanded.

The shaft must rest, or turn as the good source of its mode wants it to while the drive is in
operation. It may do otherwise until the fault is noticed and the wheel is stopped. The slowest is
a drive that obeys no command at all (`most_s`).
"""

from __future__ import annotations

import copy
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache

from flatplank_control.bench.setup import BenchSetup
from flatplank_data.machine import FAST
from flatplank_hw.answers import Answer
from flatplank_hw.cia402 import State
from flatplank_hw.drive import DriveParameters
from flatplank_hw.samples import DriveSample
from flatplank_sim.twin.twin import Twin
from flatplank_validation.trust.faults import CLOCK, FAULTS
from flatplank_validation.trust.faulty import FaultyTwin

WATCHED_S = 2.5
"""time from the last fault on in which the wheel is watched [s]"""
MEAN_S = 0.1
"""the speed is the mean over this time [s]: a wheel that trembles in the play of its gear rests"""
WATCHDOG_S = 0.06
"""the drive's own watchdog, 15 cycles"""
KAPPA, RADIUS, SPEED, LOAD = 0.05, 0.31, 0.1, 3700.0
"""slip [-], effective rolling radius [m], wheel speed when it hangs free [rad/s], load [N]"""
OFF = 0.2
"""largest difference from the wanted speed, as a share of that on the fast plank: covers the
transients of the tire, and is far below a wheel that turns at a limit of its drive"""


def most_s(p: DriveParameters) -> float:
    """Longest time for which the wheel may turn uncommanded [s], at the speed v of the scenarios.

    A drive that obeys nothing while it is braked, v / 2 a until half of v is missing; then the
    following error, (standstill_speed + v) following_time + v^2 / 2 a at v; then the time that the
    drive is given to leave operation, its watchdog, and the time of a mean of the speed.
    """
    v = FAST * (1.0 + KAPPA) / RADIUS
    braked = 0.5 * v / p.acceleration
    following = (1.0 + p.standstill_speed / v) * p.following_time + braked
    return braked + following + p.stop_timeout + WATCHDOG_S + MEAN_S


@dataclass(frozen=True)
class Motion:
    """A way of turning."""

    prepare: Callable[[Twin], None]
    wanted: Callable[[Twin, DriveSample], float]
    """speed of the wheel when all is well [rad/s]; 0 when it has no reason to turn"""
    road_turns: bool = False
    """the road may turn the wheel, however hard it is braked: any speed up to the wanted one"""


def _need(answer: Answer) -> None:
    if not answer.accepted:
        raise RuntimeError(answer.reason)


def _cycles(twin: Twin, seconds: float) -> None:
    for _ in range(round(seconds * twin.rate_hz)):
        twin.cycle()


def _load(twin: Twin) -> None:
    operator = twin.plant.operator
    operator.load_to(LOAD)
    while not operator.view.at_target:
        twin.cycle()


def _start(twin: Twin, mode: str, value: float = 0.0) -> None:
    _need(twin.set_mode(mode, value))
    _need(twin.drive.enable())
    _cycles(twin, 0.2)


def _roll(twin: Twin, mode: str) -> None:
    _load(twin)
    _need(twin.sequencer.set_waveform("constant", {"kappa": KAPPA}, 0.0, RADIUS))
    _start(twin, mode)
    twin.plant.operator.plank(1, fast=True)
    _cycles(twin, 3.0)


def _hang(twin: Twin) -> None:
    _cycles(twin, 0.1)
    _start(twin, "velocity", SPEED)
    _cycles(twin, 0.5)


def _slipping(twin: Twin, _sample: DriveSample) -> float:
    """The sequencer gives no valid reference at the slow speed of the plank."""
    speed = twin.plant.truth.road_velocity
    return speed * (1.0 + KAPPA) / RADIUS if speed > 0.5 * FAST else 0.0


MOTIONS: dict[str, Motion] = {
    "slip": Motion(lambda twin: _roll(twin, "slip"), _slipping),
    "free rolling": Motion(
        lambda twin: _roll(twin, "free_rolling"),
        lambda twin, _sample: twin.plant.truth.road_velocity / RADIUS,
        road_turns=True,
    ),
    "hanging": Motion(_hang, lambda twin, sample: sample.reference_velocity),
}
"""name -> motion"""


@cache
def _prepared(motion: str) -> Twin:
    twin = Twin(BenchSetup())
    MOTIONS[motion].prepare(twin)
    return twin


@dataclass(frozen=True)
class Scenario:
    """Faults in the order in which they begin, each so many cycles after the last."""

    motion: str
    faults: tuple[tuple[str, int], ...]

    @property
    def text(self) -> str:
        """One line."""
        words = ", ".join(f"{name} +{4 * wait} ms" for name, wait in self.faults)
        return f"{self.motion}: {words}"


def failure(scenario: Scenario) -> str:
    """Empty, or how the wheel turned at the end."""
    twin = copy.deepcopy(_prepared(scenario.motion))
    bench = FaultyTwin(twin)
    bench.drive.client = "operator"
    _need(twin.drive.claim("operator"))
    twin.cycle()
    for name, wait in scenario.faults:
        for _ in range(wait):
            twin.cycle()
        bench.begin((FAULTS | CLOCK)[name]())
    p = twin.drive.parameters
    rest, uncommanded, most = p.standstill_speed, 0, most_s(p) * twin.rate_hz
    speeds: deque[float] = deque(maxlen=round(MEAN_S * twin.rate_hz))
    for _ in range(round(WATCHED_S * twin.rate_hz)):
        sample = twin.cycle().drive
        speeds.append(twin.plant.truth.wheel_velocity)
        speed = sum(speeds) / len(speeds)
        turns = abs(speed) > rest and not _as_wanted(twin, sample, scenario.motion, speed)
        uncommanded = uncommanded + 1 if turns else 0
        if uncommanded > most:
            return f"{scenario.text}: {speed:.3f} rad/s, stop reason {sample.stop_reason}"
    return ""


def _as_wanted(twin: Twin, sample: DriveSample, motion: str, speed: float) -> bool:
    kind = MOTIONS[motion]
    wanted, off = kind.wanted(twin, sample), OFF * FAST / RADIUS
    runs = sample.state == State.OPERATION_ENABLED and not sample.stop_reason
    low = 0.0 if kind.road_turns else wanted - off
    return runs and wanted > 0.0 and low <= speed <= wanted + off


def judge(scenarios: Sequence[Scenario]) -> list[str]:
    """Failures of several scenarios, for a process of a pool."""
    return [failure(s) for s in scenarios]
