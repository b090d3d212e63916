# SPDX-License-Identifier: Apache-2.0
"""Requests to a drive: each is checked against the present state of the drive and answered at
once."""

from __future__ import annotations

from collections.abc import Callable

from flatplank_data.limits import Limit
from flatplank_data.names import nearest_hint
from flatplank_hw.answers import ActionQueue, Answer, refused
from flatplank_hw.cia402 import State, error_words
from flatplank_hw.drive import safety
from flatplank_hw.drive.modes import MODES, HomingSequence, Mode, Position
from flatplank_hw.drive.params import DriveParameters
from flatplank_hw.drive.road_trigger import SHORTEST, RoadTrigger
from flatplank_hw.drive.safety import NS, RULES, trouble_detail
from flatplank_hw.drive.shaft import Shaft
from flatplank_hw.drive.watch import Watch
from flatplank_hw.troubles import TROUBLES

LONGEST_NAME = 200
"""most characters of the name of a client"""
RUNNER = "measurement_runner"
"""client in charge while a measurement is made and no person is in charge"""
LASTING = ("inputs", "samples", "emergency_stop")
"""rules whose cause must be gone before a reset; an earlier reset would have no effect"""


class DriveRequests:
    """State of one drive and the requests that change it; `AxisDrive` adds the cyclic step.

    An accepted request takes effect in the next cycle.
    """

    def __init__(self, p: DriveParameters) -> None:
        self.parameters = p
        self._agenda = ActionQueue()
        self._rules = tuple(RULES[name] for name in p.rules)
        self._latching = tuple(rule for rule in self._rules if rule.latching)
        self._lasting = tuple(rule for rule in self._rules if rule.name in LASTING)
        self._position_mode = Position(p)
        self._modes: dict[str, Mode] = {name: mode(p) for name, mode in MODES.items()}
        self._modes["position"] = self._position_mode
        self._mode: Mode = self._position_mode
        self._shaft, self._watch, self._homer = Shaft(p), Watch(p), HomingSequence(p)
        self._state, self._error = State.NOT_READY, 0
        self._wanted = False
        self._stop = self._unstopped_ns = 0
        self.road_trigger = RoadTrigger()

    # status
    @property
    def mode(self) -> str:
        """Name of the operation mode."""
        return self._mode.name

    @property
    def reference_source(self) -> str | None:
        """Source of the references that the present mode follows."""
        return self._mode.source

    @property
    def troubles(self) -> dict[str, str]:
        """Troubles of the last cycle, with the measured values."""
        situation, p = self._watch.situation, self.parameters
        found = {}
        if self._stop:
            found[safety.STOPS[self._stop]] = ""
        if self._state >= State.FAULT_REACTION_ACTIVE:
            found["drive_fault"] = error_words(self._error)
        if self.plank_drags_wheel:
            found["drag"] = ""
        if self.does_not_stop:
            found["does_not_stop"] = ""
        return {name: text or trouble_detail(name, situation, p) for name, text in found.items()}

    @property
    def plank_drags_wheel(self) -> bool:
        """True when the plank moves under the loaded tire of a wheel that is not driven."""
        if self._wanted or "plank_stopped" not in self.parameters.rules:
            return False
        situation = self._watch.situation
        return situation.moving and not safety.unloaded(situation, self.parameters)

    @property
    def does_not_stop(self) -> bool:
        """True when the drive stays in operation although it was told to stop; its commands then
        keep the number of an old cycle, so that guard and watchdog act."""
        return self._unstopped_ns > self.parameters.stop_timeout * NS

    @property
    def position(self) -> float:
        """Measured position of the output [unit], zero at home."""
        return self._shaft.position

    @property
    def at_target(self) -> bool:
        """True when a move or a homing is complete and the axis stands."""
        mode = self._position_mode
        asked = mode is self._mode and not self._agenda.due and mode.done
        return asked and self._turning() is None

    # requests
    def enable(self) -> Answer:
        """Enable the drive; clears a latched stop whose cause is gone."""
        if not self._shaft.known:
            return refused("no inputs yet: start the bus")
        if self._state >= State.FAULT_REACTION_ACTIVE:
            return refused(f"drive fault {error_words(self._error)}: reset it first")
        # nothing turns yet and no reference is due yet
        situation = self._watch.situation
        situation.turning, situation.wheel_left, situation.reference_age_ns = False, False, 0
        rule = safety.first_stop(self._latching, situation, self.parameters)
        if rule is not None:
            return refused(
                TROUBLES[rule.name].line(trouble_detail(rule.name, situation, self.parameters))
            )
        return self._agenda.accept(self._enable, f"the drive is enabled in mode {self.mode}")

    def disable(self) -> Answer:
        """Disable the drive; a turning axis is braked first."""
        return self._agenda.accept(lambda: self._stop_with(0), "the axis is braked and disabled")

    def quick_stop(self) -> Answer:
        """Brake at once and stay stopped until the drive is enabled again."""
        return self._agenda.accept(
            lambda: self._stop_with(safety.QUICK_STOP),
            "the axis is braked and stays stopped until it is enabled",
        )

    def reset_fault(self) -> Answer:
        """Reset a fault of the drive, or a latched stop; never enables."""
        if self._state is not State.FAULT and not self._stop:
            return refused("there is no fault and no stop to reset")
        rule = safety.first_stop(self._lasting, self._watch.situation, self.parameters)
        if rule is not None:
            return refused(f"{rule.text}: reset when that is over")
        return self._agenda.accept(
            self._reset, "fault and stop are reset, the drive stays disabled"
        )

    def home(self) -> Answer:
        """Make the present position zero."""
        reason = self._not_ready() or self._turning()
        if reason:
            return refused(reason)
        unit = self.parameters.unit
        here = f"the present position {self.position:.4g} {unit} becomes 0 {unit}"
        return self._agenda.accept(self._start_homing, here)

    def move_to(self, position: float, speed: float = 0.0) -> Answer:
        """Move to a position [unit]; speed 0 selects `move_speed`."""
        mode, p = self._position_mode, self.parameters
        reason = self._not_ready() or mode.refusal(position)
        reason = reason or Limit(0.0, p.speed_limit, f"{p.unit}/s").refusal("speed", speed)
        if not reason and mode is not self._mode:
            reason = self._turning() or ""
        if not reason and "plank_stands" in p.rules and not self._free():
            reason = "the tire stands on the road: unload it before turning the wheel"
        if reason:
            return refused(reason)

        def act() -> None:
            mode.move.speed = speed or p.move_speed
            self._change(mode)
            mode.set_value(position)

        way = f"from {self.position:.4g} {p.unit} to {position:.4g} {p.unit}"
        return self._agenda.accept(
            act, f"the axis moves {way} at {speed or p.move_speed:g} {p.unit}/s"
        )

    def set_operation_mode(self, name: str, value: float = 0.0) -> Answer:
        """Choose a mode; `value` is its position, velocity or torque, ignored by the others.

        The axis moves to a position only when the drive is enabled; otherwise it stays where it
        is.
        """
        mode = self._modes.get(name)
        if mode is None:
            return refused(f"unknown mode '{name}'{nearest_hint(name, MODES)}")
        if mode.name == "homing":
            return self.home()
        if mode is self._position_mode and self._wanted:
            return self.move_to(value)
        axis = self.parameters.axis
        if mode.source and axis not in mode.axes:
            return refused(f"the {axis} drive has no source for mode '{name}'")
        reason = None if mode.source else mode.refusal(value)
        reason = reason or (self._turning() if mode is not self._mode else None)
        if reason:
            return refused(reason)

        def act() -> None:
            self._change(mode)
            mode.set_value(value)

        unit = mode.limit.unit if mode.limit else ""
        own = "" if mode.source else f" with {value:.4g} {unit}".rstrip()
        return self._agenda.accept(act, f"mode {name}{own}")

    def set_trigger(self, distance: float) -> Answer:
        """Set the trigger output for an optical system: a pulse every `distance` [m] of road; 0:
        constantly on; below 0: off."""
        trigger = self.road_trigger
        if distance < 0.0:
            return self._agenda.accept(trigger.disarm, "the trigger output is off")
        limit = Limit(SHORTEST, self.parameters.road_length, "m")
        if distance != 0.0 and (reason := limit.refusal("trigger distance", distance)):
            return refused(reason)
        pulses = f"gives a pulse every {1e3 * distance:g} mm of road" if distance else "is on"
        return self._agenda.accept(lambda: trigger.arm(distance), f"the trigger output {pulses}")

    def claim(self, client: str) -> Answer:
        """Give control to `client`: from now on the axis stops without its `heartbeat`. The same
        client may claim again, also after its claim has lapsed; a person may take over from the
        runner."""
        claim = self._watch.claim
        if not client:
            return refused("a claim needs the name of the client")
        if len(client) > LONGEST_NAME:
            return refused(f"a name of {len(client)} characters: give at most {LONGEST_NAME}")
        if claim.client not in ("", client, RUNNER):
            return refused(f"'{claim.client}' is in charge")
        limit = self.parameters.heartbeat_timeout
        done = f"'{client}' is in charge and must send a heartbeat within {limit:g} s"
        return self._agenda.accept(lambda: claim.take(client), done)

    def release(self) -> Answer:
        """Release the claim; no client is in charge then."""
        return self._agenda.accept(self._watch.claim.release, "nobody is in charge")

    def adopt_claim(self, client: str) -> Answer:
        """Take over a claim that another drive has answered: `client` is in charge of this axis,
        too; empty: none."""
        if not client:
            return self.release()
        claim = self._watch.claim
        return self._agenda.accept(lambda: claim.take(client), f"'{client}' is in charge")

    def heartbeat(self, client: str) -> Answer:
        """Register a heartbeat of the client in charge."""
        claim = self._watch.claim
        if not client or claim.client != client:
            return refused(f"'{client}' is not in charge")
        claim.register_heartbeat()
        return Answer(True, "", self._agenda.last_cycle + 1)

    # reasons for refusal
    def _not_ready(self) -> str | None:
        if not self._wanted or self._state is not State.OPERATION_ENABLED:
            return "the drive is not enabled: enable it first"
        return "homing is going on" if self._homer.running else None

    def _turning(self) -> str | None:
        if abs(self._shaft.velocity) > self.parameters.standstill_speed:
            return "the axis turns: stop it before changing the mode"
        return None

    def _free(self) -> bool:
        situation = self._watch.situation
        return situation.moving or safety.unloaded(situation, self.parameters)

    # effects of requests, implemented by `AxisDrive`
    _enable: Callable[[], None]
    _reset: Callable[[], None]
    _stop_with: Callable[[int], None]
    _start_homing: Callable[[], None]
    _change: Callable[[Mode], None]
