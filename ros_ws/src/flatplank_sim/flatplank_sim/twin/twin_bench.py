# SPDX-License-Identifier: Apache-2.0
"""Performs plans on the twin, with the same steps at the same cycles as the ROS graph."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import replace
from datetime import date
from pathlib import Path
from typing import Any

from flatplank_control.calibration.book import CalibrationBook
from flatplank_control.runner import steps as S
from flatplank_control.runner.conditions import QUANTITIES, condition_of, prompt_of
from flatplank_control.runner.moves import by_drive
from flatplank_control.runner.plans import release_axes, safe_end
from flatplank_control.runner.provenance import complete_record, utc_now
from flatplank_control.runner.steps import CHUNK, StopDetector, WaitMonitor
from flatplank_data.run_record import record_from_dict
from flatplank_hw.drive import AxisDrive
from flatplank_sim.twin.log import RunLog
from flatplank_sim.twin.twin import Twin, TwinAxis


class TwinBench:
    """Performs plans in one process; `log` stores the recording."""

    def __init__(self, twin: Twin, log: RunLog) -> None:
        self.twin = twin
        self.kept: list[Path] = []
        self._log = log
        self._recording = False
        self._stops = StopDetector()
        operator = twin.plant.operator
        self._by_hand: dict[str, Callable[[float], Any]] = {
            "unload": lambda _value: operator.unload(),
            "load": operator.load_to,
            "pressure_bar": operator.pressure,
            "steer_deg": lambda deg: operator.steer(math.radians(deg)),
            "road_camber_deg": lambda deg: operator.road_camber(math.radians(deg)),
            "cleat_mm": lambda mm: operator.cleat(1e-3 * mm),
            "flexplates": lambda on: operator.flexplates(bool(on)),
            "wheel_camber_deg": lambda deg: operator.wheel_camber(math.radians(deg)),
        }
        self._do: dict[type, Callable[[Any], None]] = {
            S.Manual: self._manual,
            S.Plank: self._plank,
            S.Enable: self._enable,
            S.Mode: self._mode,
            S.MoveTo: lambda s: _need(twin.drive.move_to(math.radians(s.angle_deg))),
            S.SlipWaveform: self._waveform,
            S.Arm: lambda _s: _need(twin.encoders.arm()),
            S.Record: self._record,
            S.StopRecord: self._stop_record,
            S.FastCycles: self._quick,
            S.Wait: self._wait,
            S.ShowProgress: lambda _s: None,
            S.Trigger: lambda s: _need(twin.drive.set_trigger(s.distance)),
            S.HoldLoad: self._hold_load,
            S.AxisProfile: self._profile,
            S.Constants: self._constants,
        }

    def perform(self, plan: Iterable[S.Step]) -> None:
        """Perform a whole plan; on an error stop all motion and close the recording."""
        try:
            for step in plan:
                self._do[type(step)](step)
        except BaseException as error:
            for step in (*safe_end(), *release_axes(self.twin.axes)):
                self._do[type(step)](step)
            if self._recording:
                self._stop_record(S.StopRecord("stopped", str(error)))
            raise

    def snapshot(self) -> S.Snapshot | None:
        latest = self.twin.latest
        return S.Snapshot(latest.encoders, latest.hub, latest.drive) if latest else None

    def advance(self, batches: int) -> None:
        twin = self.twin
        if self._recording:
            add = self._log.add
            for _ in range(batches):
                add(twin.cycle())
        else:
            for _ in range(batches):
                twin.cycle()

    def _manual(self, step: S.Manual) -> None:
        self._by_hand[step.quantity](step.value)
        timeout = QUANTITIES[step.quantity].timeout
        self._wait(S.Wait(f"done: {prompt_of(step)}", condition_of(step), timeout, 0.2))

    def _plank(self, step: S.Plank) -> None:
        self._stops.register_command(step)
        if "plank" not in self.twin.axes:
            self.twin.plant.operator.plank(step.direction, step.fast, step.stop_at)
            return
        for part in by_drive(step):
            self._do[type(part)](part)

    def _enable(self, step: S.Enable) -> None:
        drive = self._drive(step.axis)
        _need(drive.enable() if step.on else drive.disable())

    def _mode(self, step: S.Mode) -> None:
        if step.axis == "wheel":
            _need(self.twin.drive.set_operation_mode(step.mode, step.value))
        else:
            _need(self._drive(step.axis).set_operation_mode(step.mode, step.value))

    def _drive(self, axis: str) -> AxisDrive:
        return self.twin.drive if axis == "wheel" else self._axis(axis).drive

    def _waveform(self, step: S.SlipWaveform) -> None:
        values = {k: float(v) for k, v in step.parameters.items()}
        _need(
            self.twin.sequencer.set_waveform(
                step.name, values, step.start_position, step.effective_rolling_radius
            )
        )

    def _record(self, step: S.Record) -> None:
        s = self.snapshot()
        book = CalibrationBook(Path(self.twin.setup.calibration))
        record = record_from_dict(step.record).with_changes(started=utc_now())
        record = complete_record(record, self.twin.in_force(), book, date.today())
        self._log.start(record, s.encoders.stamp_ns if s else 0, step.at_once)
        self._recording = True

    def _stop_record(self, step: S.StopRecord) -> None:
        self._recording = False
        self.kept.append(self._log.stop(step.status, step.notes))

    def _constants(self, step: S.Constants) -> None:
        core = self.twin.cores[step.node]
        core.set_constants(replace(core.parameters, **step.values))

    def _hold_load(self, step: S.HoldLoad) -> None:
        axis = self._axis("vertical")
        axis.follow(not math.isnan(step.fz))
        self._wait(S.Wait("the vertical drive has answered", lambda _s: True, 2.0, 0.1))
        if not math.isnan(step.fz):
            axis.controller.set_load(step.fz)
            self._wait(S.Wait("the vertical drive is enabled", lambda _s: axis.enabled, 2.0))

    def _profile(self, step: S.AxisProfile) -> None:
        axis = self._axis(step.axis)
        if step.name:
            _need(axis.controller.set_profile(step.name, step.parameters or {}))
            return
        axis.follow(step.parameters is not None)
        if step.parameters is not None:
            what = f"the {step.axis} drive is enabled"
            self._wait(S.Wait(what, lambda _s: axis.enabled, 2.0))

    def _axis(self, name: str) -> TwinAxis:
        axis = self.twin.axes.get(name)
        if axis is None:
            raise S.PlanFailed(f"the {name} axis has no drive: start the bench with --axes {name}")
        return axis

    def _quick(self, step: S.FastCycles) -> None:
        self.twin.batch = step.fitting(self.twin.rate_hz)

    def _wait(self, step: S.Wait) -> None:
        s = self.snapshot() or self._look_again()
        monitor = WaitMonitor(step, s.encoders.stamp_ns * 1e-9)
        while not monitor.over(s, s.encoders.stamp_ns * 1e-9):
            self._stops.check_sample(s.drive)
            s = self._look_again()

    def _look_again(self) -> S.Snapshot:
        """Advance by `CHUNK` batches and return the last samples."""
        self.advance(CHUNK)
        found = self.snapshot()
        assert found is not None, "a cycle gives samples"
        return found


def _need(answer: Any) -> None:
    if not answer.accepted:
        raise S.PlanFailed(answer.reason)
