# SPDX-License-Identifier: Apache-2.0
"""Scenarios on the twin: a rolling wheel, faults, and for how long the wheel turns uncommanded.

From the first fault on the shaft must rest, or turn as the good source of its mode wants it to
while the drive is in operation. It may do otherwise until the fault is noticed and the wheel is
stopped. The slowest is a drive that obeys no command at all (`most_s`).
"""

from __future__ import annotations

import copy
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from statistics import fmean

from flatplank_control.bench.setup import BenchSetup
from flatplank_control.sequencer.sequencer import Follower
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
"""the speed is the travel in this time [s]: a wheel that trembles in the play of its gear rests"""
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


Wanted = Callable[[Twin, DriveSample], tuple[float, float]]
"""slowest and fastest speed of the wheel when all is well [rad/s]; 0 when it has no reason to
turn"""


@dataclass(frozen=True)
class Motion:
    """A way of turning."""

    prepare: Callable[[Twin], None]
    wanted: Callable[[Twin], Wanted]
    """made for a scenario before its first fault"""


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
    _need(twin.drive.set_operation_mode(mode, value))
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


class _Slipping:
    """What the sequencer wants with the true motion: the slip, and lost travel recovered.

    It gives no valid reference at the slow speed of the plank.
    """

    def __init__(self, twin: Twin) -> None:
        self.parameters = twin.sequencer.parameters
        self.follower = Follower(self.parameters)

    def __call__(self, twin: Twin, _sample: DriveSample) -> tuple[float, float]:
        truth, latest = twin.plant.truth, twin.latest
        assert latest is not None
        speed, per_metre = truth.road_velocity, (1.0 + KAPPA) / RADIUS
        true = latest.encoders._replace(
            plank_position=truth.road_position, plank_velocity=speed, plank_moving=speed != 0.0,
            wheel_angle=truth.wheel_angle, mismatch=0.0,
        )  # fmt: skip
        recovers = self.follower.travel < self.parameters.follow_until
        lost = self.follower.step(true, per_metre) if recovers else 0.0
        if speed <= 0.5 * FAST:
            return 0.0, 0.0
        slip = speed * per_metre
        return slip + min(lost, 0.0), slip + max(lost, 0.0)


def _rolling(twin: Twin, _sample: DriveSample) -> tuple[float, float]:
    """The road may turn the wheel, however hard it is braked."""
    return 0.0, twin.plant.truth.road_velocity / RADIUS


def _turning(_twin: Twin, sample: DriveSample) -> tuple[float, float]:
    return sample.reference_velocity, sample.reference_velocity


MOTIONS: dict[str, Motion] = {
    "slip": Motion(lambda twin: _roll(twin, "slip"), _Slipping),
    "free rolling": Motion(lambda twin: _roll(twin, "free_rolling"), lambda _: _rolling),
    "hanging": Motion(_hang, lambda _: _turning),
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
    watch = _Watch(twin, MOTIONS[scenario.motion])
    for name, wait in scenario.faults:
        watch.cycles(wait)
        bench.begin((FAULTS | CLOCK)[name]())
    watch.cycles(round(WATCHED_S * twin.rate_hz))
    return f"{scenario.text}: {watch.fault}" if watch.fault else ""


class _Watch:
    """Watches the shaft, cycle by cycle."""

    def __init__(self, twin: Twin, kind: Motion) -> None:
        self.twin, self.wanted = twin, kind.wanted(twin)
        self.fault = ""
        self._most = most_s(twin.drive.parameters) * twin.rate_hz
        self._uncommanded = 0
        last = round(MEAN_S * twin.rate_hz)
        self._turned: deque[tuple[float, float]] = deque([self._now()], maxlen=1 + last)
        self._range: deque[tuple[float, float]] = deque(maxlen=last)

    def cycles(self, count: int) -> None:
        """Some cycles, until the wheel has turned uncommanded for too long."""
        for _ in range(count):
            if self.fault:
                return
            sample, turned = self.twin.cycle().drive, self._turned
            turned.append(self._now())
            (before, start), (now, angle) = turned[0], turned[-1]
            speed = (angle - start) / (now - before)
            turns = abs(speed) > self.twin.drive.parameters.standstill_speed
            wanted = self._as_wanted(sample, speed)
            self._uncommanded = self._uncommanded + 1 if turns and not wanted else 0
            if self._uncommanded > self._most:
                self.fault = f"{speed:.3f} rad/s, stop reason {sample.stop_reason}"

    def _now(self) -> tuple[float, float]:
        truth = self.twin.plant.truth
        return truth.t, truth.wheel_angle

    def _as_wanted(self, sample: DriveSample, speed: float) -> bool:
        self._range.append(self.wanted(self.twin, sample))
        low, high = map(fmean, zip(*self._range, strict=True))
        off = OFF * FAST / RADIUS
        runs = sample.state == State.OPERATION_ENABLED and not sample.stop_reason
        return runs and high > 0.0 and low - off <= speed <= high + off


def judge(scenarios: Sequence[Scenario]) -> list[str]:
    """Failures of several scenarios, for a process of a pool."""
    return [failure(s) for s in scenarios]
