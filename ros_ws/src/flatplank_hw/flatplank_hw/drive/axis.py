# SPDX-License-Identifier: Apache-2.0
"""One drive of the bench: reference, safety rules and CiA 402 state machine."""

from __future__ import annotations

from flatplank_hw.bus.image import AXES, AxisCommand, AxisInputs, BusInputs, Digital
from flatplank_hw.cia402 import Goal, State, control_word, decode
from flatplank_hw.drive import safety
from flatplank_hw.drive.following import Following
from flatplank_hw.drive.modes import STAND, Mode, SetPoint
from flatplank_hw.drive.params import DriveParameters
from flatplank_hw.drive.requests import DriveRequests
from flatplank_hw.drive.safety import NS, RULES
from flatplank_hw.samples import DriveSample, EncoderSample, HubSample, Reference

PLANK = AXES.index("plank")
_FRONT, _REAR = int(Digital.LIMIT_FRONT), int(Digital.LIMIT_REAR)
_ENABLED = State.OPERATION_ENABLED
_BRAKE_TIME = NS // 2
"""a turning axis is braked for so long before its voltage is taken away [ns]"""


class AxisDrive(DriveRequests):
    """One drive; call `step` once per cycle and requests in between."""

    def __init__(self, p: DriveParameters) -> None:
        super().__init__(p)
        self.index = AXES.index(p.axis)
        self._stamp = self._asked_at = self._stopped_at = 0
        self._was_enabled = self._resetting = self._entered = self._unanswered = False
        self._reference: Reference | None = None
        self._following, self._point = Following(p), STAND
        self._answered = -1

    def step(
        self,
        inputs: BusInputs,
        encoders: EncoderSample | None,
        hub: HubSample | None,
        reference: Reference | None,
    ) -> tuple[AxisCommand, DriveSample]:
        """Return command and sample of one bus cycle; takes about 5 us.

        A `reference` from another source than that of the mode is ignored. The last good one stays
        in force until it is too old.
        """
        now, cycle, axis = inputs.stamp_ns, inputs.cycle, inputs.axes[self.index]
        shaft, watch = self._shaft, self._watch
        dt_ns = now - self._stamp if shaft.known else 0
        self._stamp = now
        shaft.read(axis, self._homer.running and self.parameters.home_in_drive)
        self._state, self._error = decode(axis.status_word), axis.error_code
        agenda = self._agenda
        if agenda.due:
            agenda.run()
        agenda.last_cycle = cycle

        source = self._mode.source
        if reference is not None and reference.source == source:
            self._take(reference)
        watch.update_from_bus(inputs, self._state, shaft, dt_ns)
        watch.update_from_samples(now, dt_ns, encoders, hub)
        watch.update_reference(now, source is not None, self._reference)

        self._check_obedience(inputs.digital, dt_ns)
        held = self._guard(now) if self._wanted else self._idle()
        word, self._point = self._decide(axis, now, held, dt_ns)
        mode, position, velocity, torque = self._point
        if not self.does_not_stop:
            self._answered = cycle
        outputs = 0
        if self.road_trigger.armed and encoders is not None:
            outputs = self.road_trigger.step(encoders.plank_position, encoders.plank_moving)
        command = AxisCommand(
            self.index, self._answered, word, int(mode), shaft.raw_position(position),
            shaft.raw_velocity(velocity), shaft.raw_torque(torque), outputs,
        )  # fmt: skip
        watch.situation.turning = command.target_velocity != 0 or command.target_torque != 0
        return command, DriveSample(
            cycle, now, self._state, self._mode.code, shaft.position, shaft.velocity,
            shaft.torque, position, velocity, torque, self._stop, self._error,
        )  # fmt: skip

    def _take(self, reference: Reference) -> None:
        reason = self._mode.refusal(reference.value)
        if not reference.valid:
            reason = "its source says that it is not valid"
        self._watch.situation.refused = reason
        if not reason:
            self._reference = reference

    def _check_obedience(self, digital: int, dt_ns: int) -> None:
        """Watch whether the drive follows its commands, and whether it stops when told to."""
        enabled = self._state is _ENABLED
        self._unanswered &= enabled
        situation = self._watch.situation
        free = not self._homer.running and not self._at_switch(digital)
        if enabled and self._runs and free:
            self._following.update(situation, self._point, self._shaft, dt_ns)
        else:
            self._following.reset(situation)
        self._unstopped_ns = self._unstopped_ns + dt_ns if enabled and not self._runs else 0

    @property
    def _runs(self) -> bool:
        """True when the axis is to be in operation; after a stop the drive must have left it
        first, however soon it is enabled again."""
        return self._wanted and not self._unanswered

    def _at_switch(self, digital: int) -> bool:
        """True when a limit switch holds the axis against its command."""
        velocity = self._point.velocity
        if self.index != PLANK or velocity == 0.0:
            return False
        rests = abs(self._shaft.velocity) <= self.parameters.standstill_speed
        return rests and digital & (_FRONT if velocity > 0.0 else _REAR) != 0

    def _idle(self) -> bool:
        """Release the claim of a client whose heartbeat has stopped; a disabled axis is always
        held."""
        watch = self._watch
        if safety.heartbeat_gone(watch.situation, self.parameters):
            watch.claim.release()
        return True

    def _guard(self, now: int) -> bool:
        """Evaluate the safety rules; true when the axis is held."""
        rule = safety.first_stop(self._rules, self._watch.situation, self.parameters)
        if rule is not None and rule.latching:
            self._stop_with(rule.code)
            return True
        if self._unanswered:
            return True
        if self._state is _ENABLED:
            self._was_enabled = True
        elif self._was_enabled:
            self._stop_with(safety.LEFT_OPERATION)
            return True
        elif now - self._asked_at > self.parameters.start_timeout * NS:
            self._stop_with(safety.NO_ANSWER)
            return True
        self._stop = 0 if rule is None else rule.code
        return rule is not None

    def _decide(self, axis: AxisInputs, now: int, held: bool, dt_ns: int) -> tuple[int, SetPoint]:
        """Control word and set-point of this cycle."""
        goal = self._goal(now)
        word = control_word(self._state, goal)
        if goal is Goal.ENABLED and self._state is _ENABLED:
            if self._homer.running:
                return self._home(axis, now)
            if not held:
                return word, self._ask(dt_ns)
        # after a hold the mode restarts from the present position
        self._entered = False
        return word, STAND

    def _goal(self, now: int) -> Goal:
        if self._runs:
            return Goal.ENABLED
        p = self.parameters
        if self._resetting:
            late = now - self._asked_at > p.start_timeout * NS
            self._resetting = self._state is State.FAULT and not late
            return Goal.RESET
        turning = abs(self._shaft.velocity) > p.standstill_speed
        if turning and now - self._stopped_at < _BRAKE_TIME:
            return Goal.QUICK_STOP
        return Goal.DISABLED

    def _ask(self, dt_ns: int) -> SetPoint:
        position = self._shaft.position
        if not self._entered:
            self._mode.enter(position)
            self._entered = True
        value = 0.0 if self._reference is None else self._reference.value
        return self._mode.step(value, position, dt_ns * 1e-9)

    def _home(self, axis: AxisInputs, now: int) -> tuple[int, SetPoint]:
        word, done, failed = self._homer.step(axis, now)
        if failed:
            self._stop_with(safety.NO_ANSWER)
            return word, STAND
        if done:
            self._shaft.make_zero()
            self._change(self._position_mode)
            return word, STAND
        return word, self._mode.step(0.0, 0.0, 0.0)

    # effects of requests
    def _enable(self) -> None:
        if self._wanted:
            return
        self._wanted, self._was_enabled, self._resetting, self._entered = True, False, False, False
        self._stop, self._reference, self._asked_at = 0, None, self._stamp
        self._watch.situation.refused = ""
        self._watch.start(self._stamp)

    def _reset(self) -> None:
        self._stop_with(0)
        self._resetting, self._asked_at = self._state is State.FAULT, self._stamp

    def _stop_with(self, code: int) -> None:
        if self._wanted:
            self._stopped_at, self._unanswered = self._stamp, True
        self._wanted, self._stop, self._resetting = False, code, False
        if self._homer.running:
            self._homer.running = False
            self._mode = self._position_mode
        if code == RULES["heartbeat"].code:
            self._watch.claim.release()

    def _start_homing(self) -> None:
        self._change(self._modes["homing"])
        self._homer.start(self._stamp)

    def _change(self, mode: Mode) -> None:
        if mode is not self._mode:
            self._mode, self._reference, self._watch.situation.refused = mode, None, ""
            mode.enter(self._shaft.position)
            self._entered = True
