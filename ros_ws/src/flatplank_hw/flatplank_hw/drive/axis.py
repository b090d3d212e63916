# SPDX-License-Identifier: Apache-2.0
"""One drive of the bench: arbiter of its references, guard of its limits, speaker of CiA 402."""

from __future__ import annotations

import math

from flatplank_hw.answers import Agenda, Answer, refused
from flatplank_hw.bus.image import AXES, AxisCommand, BusInputs
from flatplank_hw.drive import safety
from flatplank_hw.drive.cia402 import Goal, State, control_word, decode
from flatplank_hw.drive.homing import Homer
from flatplank_hw.drive.modes import MODES, STAND, Mode, SetPoint
from flatplank_hw.drive.operator import Charge
from flatplank_hw.drive.params import DriveParameters
from flatplank_hw.drive.safety import RULES, Situation
from flatplank_hw.encoders.counter import turns_between, wrapped
from flatplank_hw.params import nearest
from flatplank_hw.samples import DriveSample, EncoderSample, HubSample, Reference

NS = 1_000_000_000
TORQUE_UNIT = 1e-4
"""[N m] per unit of the torque on the bus."""
_NAN = math.nan
_ENABLED = State.OPERATION_ENABLED
_BRAKE_TIME = NS // 2


class AxisDrive:
    """`step` once per cycle; requests in between take effect with the next step, or at a stated
    cycle."""

    def __init__(self, p: DriveParameters) -> None:
        self.parameters = p
        self.index = AXES.index(p.axis)
        self._agenda = Agenda()
        self._rules = tuple(RULES[name] for name in p.rules)
        self._latching = tuple(rule for rule in self._rules if rule.latching)
        self._modes: dict[str, Mode] = {name: mode(p) for name, mode in MODES.items()}
        self._mode = self._modes["position"]
        self._homer = Homer(p)
        self._charge = Charge()
        self._s = Situation()
        self._per_count = p.direction * p.output_per_turn / (p.counts_per_turn * p.gear_ratio)
        self._raw: int | None = None
        self._counts = self._zero = 0
        self._stamp = self._moving_since = self._asked_at = self._stopped_at = 0
        self._wanted = self._was_enabled = self._resetting = False
        self._stop = 0
        self._entered = False
        self._reference: Reference | None = None
        self._state = State.NOT_READY
        self._error = 0
        self._position = self._velocity = 0.0

    # what the node and the runner ask for
    @property
    def mode(self) -> str:
        """Name of the operation mode."""
        return self._mode.name

    @property
    def listens_to(self) -> str | None:
        """Source of the references that count in the present mode."""
        return self._mode.source

    @property
    def stop_text(self) -> str:
        """Why the axis is held or stopped; empty when it is not."""
        return safety.REASONS[self._stop]

    @property
    def position(self) -> float:
        """Measured position of the output [unit], zero at home."""
        return self._position

    @property
    def at_target(self) -> bool:
        """A move or a homing has come to its end and the axis stands."""
        mode = self._modes["position"]
        asked = mode is self._mode and not self._agenda.due and mode.done
        return asked and self._turning() is None

    # requests
    def enable(self, at_cycle: int | None = None) -> Answer:
        """Bring the drive into operation; clears a latched stop whose cause is gone."""
        if self._raw is None:
            return refused("no inputs yet: start the bus")
        if self._state >= State.FAULT_REACTION_ACTIVE:
            return refused(f"drive fault 0x{self._error:04X}: reset it first")
        # enabling starts afresh: nothing turns yet and no reference is due yet
        self._s.turning, self._s.reference_age_ns = False, 0
        rule = safety.first_stop(self._latching, self._s, self.parameters)
        if rule is not None:
            return refused(rule.text)
        return self._agenda.accept(self._enable, at_cycle)

    def disable(self, at_cycle: int | None = None) -> Answer:
        """Take the drive out of operation; a turning axis is braked first."""
        return self._agenda.accept(lambda: self._stop_with(0), at_cycle)

    def quick_stop(self, at_cycle: int | None = None) -> Answer:
        """Brake at once and stay stopped until enabled again."""
        return self._agenda.accept(lambda: self._stop_with(safety.QUICK_STOP), at_cycle)

    def reset_fault(self, at_cycle: int | None = None) -> Answer:
        """Reset a fault of the drive, or a latched stop; never enables."""
        if self._state is not State.FAULT and not self._stop:
            return refused("there is no fault and no stop to reset")
        return self._agenda.accept(self._reset, at_cycle)

    def home(self, at_cycle: int | None = None) -> Answer:
        """Make the present position zero."""
        reason = self._not_ready() or self._turning()
        return refused(reason) if reason else self._agenda.accept(self._start_homing, at_cycle)

    def move_to(self, position: float, speed: float = 0.0, at_cycle: int | None = None) -> Answer:
        """Go to a position [unit]; speed 0 is the axis's own."""
        mode, p = self._modes["position"], self.parameters
        reason = self._not_ready() or mode.refuse(position)
        if reason is None and not (math.isfinite(speed) and 0.0 <= speed <= p.speed_limit):
            reason = f"speed of {speed} {p.unit}/s is outside 0 .. {p.speed_limit:g} {p.unit}/s"
        if reason is None and mode is not self._mode:
            reason = self._turning()
        if reason is None and "plank_stands" in p.rules and not self._free():
            reason = "the tire stands on the road: unload it before turning the wheel"
        if reason:
            return refused(reason)

        def act() -> None:
            mode.move.speed = speed or p.move_speed
            self._change(mode)
            mode.set_value(position)

        return self._agenda.accept(act, at_cycle)

    def set_operation_mode(
        self, name: str, value: float = 0.0, at_cycle: int | None = None
    ) -> Answer:
        """Choose a mode; `value` is its position, velocity or torque, ignored by the others.

        A position is gone to only when the drive is enabled; else the axis holds where it is.
        """
        mode = self._modes.get(name)
        if mode is None:
            return refused(f"unknown mode '{name}'{nearest(name, MODES)}")
        if mode.name == "homing":
            return self.home(at_cycle)
        if mode.name == "position" and self._wanted:
            return self.move_to(value, at_cycle=at_cycle)
        reason = mode.refuse(value) or (self._turning() if mode is not self._mode else None)
        if reason:
            return refused(reason)

        def act() -> None:
            self._change(mode)
            mode.set_value(value)

        return self._agenda.accept(act, at_cycle)

    def claim(self, client: str, at_cycle: int | None = None) -> Answer:
        """Take charge: from now on `heartbeat` must come, or the axis stops."""
        if not client:
            return refused("a claim needs the name of the client")
        if self._charge.client not in ("", client):
            return refused(f"'{self._charge.client}' is in charge")
        return self._agenda.accept(lambda: self._charge.claim(client), at_cycle)

    def release(self, client: str, at_cycle: int | None = None) -> Answer:
        """Give the charge back."""
        if self._charge.client != client:
            return refused(f"'{client}' is not in charge")
        return self._agenda.accept(self._charge.release, at_cycle)

    def heartbeat(self, client: str) -> Answer:
        """The client in charge is alive."""
        if not client or self._charge.client != client:
            return refused(f"'{client}' is not in charge")
        self._charge.beat()
        return Answer(True, "", self._agenda.last_cycle + 1)

    # the cycle
    def step(
        self,
        inputs: BusInputs,
        encoders: EncoderSample | None,
        hub: HubSample | None,
        reference: Reference | None,
    ) -> tuple[AxisCommand, DriveSample]:
        """One cycle; about 6 us. `reference` of another source than the mode's is not listened
        to."""
        now, cycle, axis = inputs.stamp_ns, inputs.cycle, inputs.axes[self.index]
        agenda = self._agenda
        first = self._raw is None
        dt_ns = 0 if first else now - self._stamp
        self._read(axis, first)
        if agenda.due:
            agenda.run(cycle)
        agenda.last_cycle = cycle
        if (
            reference is not None
            and reference.valid
            and reference.source == self._mode.source
            and reference.value == reference.value
        ):
            self._reference = reference
        self._assess(inputs, encoders, hub, dt_ns)
        self._stamp = now

        held = self._guard(now) if self._wanted else True
        goal = self._goal(now)
        word = control_word(self._state, goal)
        point = STAND
        if goal is Goal.ENABLED and self._state is _ENABLED:
            if self._mode.name == "homing":
                word, point = self._home(axis, now)
            elif held:
                self._entered = False
            else:
                point = self._ask(dt_ns)
        else:
            self._entered = False
        command, turning = self._command(cycle, word, point)
        self._s.turning = turning
        torque = axis.torque * TORQUE_UNIT * self.parameters.direction
        return command, DriveSample(
            cycle, now, self._state, self._mode.code, self._position, self._velocity, torque,
            point.position, point.velocity, point.torque, self._stop, self._error,
        )  # fmt: skip

    def _read(self, axis, first: bool) -> None:
        raw = axis.position
        if first:
            self._counts = self._zero = raw
        elif not (self._homer.running and self.parameters.home_in_drive):
            self._counts += turns_between(self._raw, raw)
        self._raw = raw
        self._position = (self._counts - self._zero) * self._per_count
        self._velocity = axis.velocity * self._per_count
        self._state = decode(axis.status_word)
        self._error = axis.error_code

    def _assess(
        self,
        inputs: BusInputs,
        encoders: EncoderSample | None,
        hub: HubSample | None,
        dt_ns: int,
    ) -> None:
        s, p, now = self._s, self.parameters, inputs.stamp_ns
        s.health, s.digital, s.state, s.gap_ns = inputs.health, inputs.digital, self._state, dt_ns
        s.speed = self._velocity
        s.follows_plank = self._mode.source is not None
        torque = inputs.axes[self.index].torque * TORQUE_UNIT
        high = not -p.torque_trip <= torque <= p.torque_trip
        s.torque_high_ns = s.torque_high_ns + dt_ns if high else 0
        age = 0
        if hub is not None:
            s.loaded_radius, s.fz = hub.loaded_radius, hub.fz_filtered
            s.fz_high_ns = s.fz_high_ns + dt_ns if not s.fz <= p.fz_trip else 0
            age = now - hub.stamp_ns
        if encoders is not None:
            age = max(age, now - encoders.stamp_ns)
            if encoders.plank_moving and not s.moving:
                self._moving_since = now
            s.moving, s.plank_velocity = encoders.plank_moving, encoders.plank_velocity
            s.plank_position, s.steer_angle = encoders.plank_position, encoders.steer_angle
        s.sample_age_ns = age
        since = self._moving_since
        if self._reference is not None and self._reference.stamp_ns > since:
            since = self._reference.stamp_ns
        s.reference_age_ns = now - since
        charge = self._charge
        s.claimed = bool(charge.client)
        if s.claimed:
            s.heartbeat_age_ns = charge.age(now)

    def _guard(self, now: int) -> bool:
        """Ask the rules; true when the axis is held."""
        rule = safety.first_stop(self._rules, self._s, self.parameters)
        if rule is not None and rule.latching:
            self._stop_with(rule.code)
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

    def _goal(self, now: int) -> Goal:
        if self._wanted:
            return Goal.ENABLED
        if self._resetting:
            if self._state is not State.FAULT or now - self._asked_at > (
                self.parameters.start_timeout * NS
            ):
                self._resetting = False
            return Goal.RESET
        turning = abs(self._velocity) > self.parameters.standstill_speed
        if turning and now - self._stopped_at < _BRAKE_TIME:
            return Goal.QUICK_STOP
        return Goal.DISABLED

    def _ask(self, dt_ns: int) -> SetPoint:
        if not self._entered:
            self._mode.enter(self._position)
            self._entered = True
        reference = self._reference
        value = 0.0
        if reference is not None and reference.source == self._mode.source:
            value = reference.value
        return self._mode.step(value, self._position, dt_ns * 1e-9)

    def _home(self, axis, now: int) -> tuple[int, SetPoint]:
        word, done, failed = self._homer.step(axis, now)
        if failed:
            self._stop_with(safety.NO_ANSWER)
            return word, STAND
        if done:
            self._zero = self._counts
            self._position = 0.0
            self._change(self._modes["position"])
        return word, self._mode.step(0.0, 0.0, 0.0) if not done else STAND

    def _command(self, cycle: int, word: int, point: SetPoint) -> tuple[AxisCommand, bool]:
        """Raw command; targets that are not in force are the present position and zero."""
        mode, position, velocity, torque = point
        scale = self._per_count
        target, speed, effort = self._raw, 0, 0
        if position == position:
            target = wrapped(self._raw + round((position - self._position) / scale))
        if velocity == velocity:
            speed = round(velocity / scale)
        if torque == torque:
            effort = round(torque * self.parameters.direction / TORQUE_UNIT)
        command = AxisCommand(self.index, cycle, word, int(mode), target, speed, effort, 0)
        return command, speed != 0 or effort != 0

    # effects of requests
    def _enable(self) -> None:
        if self._wanted:
            return
        self._wanted, self._was_enabled, self._resetting, self._entered = True, False, False, False
        self._stop, self._reference, self._asked_at = 0, None, self._stamp
        self._moving_since = self._stamp

    def _reset(self) -> None:
        self._stop_with(0)
        self._resetting, self._asked_at = self._state is State.FAULT, self._stamp

    def _stop_with(self, code: int) -> None:
        if self._wanted:
            self._stopped_at = self._stamp
        self._wanted, self._stop, self._resetting = False, code, False
        self._homer.running = False
        if self._mode.name == "homing":
            self._mode = self._modes["position"]
        if code == RULES["heartbeat"].code:
            self._charge.release()

    def _start_homing(self) -> None:
        self._change(self._modes["homing"])
        self._homer.start(self._stamp)

    def _change(self, mode: Mode) -> None:
        if mode is not self._mode:
            self._mode, self._reference = mode, None
            mode.enter(self._position)
            self._entered = True

    # reasons
    def _not_ready(self) -> str | None:
        if not self._wanted or self._state is not _ENABLED:
            return "the drive is not enabled: enable it first"
        return "homing is going on" if self._homer.running else None

    def _turning(self) -> str | None:
        if abs(self._velocity) > self.parameters.standstill_speed:
            return "the axis turns: stop it before changing the mode"
        return None

    def _free(self) -> bool:
        s, p = self._s, self.parameters
        return s.moving or safety.unloaded(s, p)
