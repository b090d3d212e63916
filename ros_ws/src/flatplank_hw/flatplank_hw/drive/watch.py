# SPDX-License-Identifier: Apache-2.0
"""Updates the situation that the safety rules check, cycle by cycle."""

from __future__ import annotations

from flatplank_hw.bus.image import AXES, BusInputs
from flatplank_hw.cia402 import State, decode
from flatplank_hw.drive.params import DriveParameters
from flatplank_hw.drive.safety import Situation
from flatplank_hw.drive.shaft import Shaft
from flatplank_hw.samples import EncoderSample, HubSample, Reference


class ControlClaim:
    """The claim of one client. Times are bench times [ns]; a heartbeat gets the time of the next
    cycle."""

    __slots__ = ("_beat_at", "_heard", "client")

    def __init__(self) -> None:
        self.client = ""
        self._beat_at = 0
        self._heard = False

    def take(self, client: str) -> None:
        """Register the claim; a new claim counts as a heartbeat, its renewal by the same client
        does not."""
        self._heard |= client != self.client
        self.client = client

    def release(self) -> None:
        """Release the claim."""
        self.client = ""

    def register_heartbeat(self) -> None:
        """Register a heartbeat."""
        self._heard = True

    def age(self, now: int) -> int:
        """Time since the last heartbeat [ns]."""
        if self._heard:
            self._heard, self._beat_at = False, now
        return now - self._beat_at


WHEEL = AXES.index("wheel")


class Watch:
    """Keeps `situation` up to date, including ages and times above trip values."""

    __slots__ = ("_minds_wheel", "_p", "_since", "_wheel_ran", "claim", "situation")

    def __init__(self, p: DriveParameters) -> None:
        self._p = p
        self._since = 0
        self._minds_wheel, self._wheel_ran = "wheel_stopped" in p.rules, False
        self.situation = Situation()
        self.claim = ControlClaim()

    def start(self, now: int) -> None:
        """Start at bench time `now` [ns], when the axis is enabled: references are due from then
        on."""
        self._since = now
        self.situation.wheel_left = False

    def update_from_bus(self, inputs: BusInputs, state: int, shaft: Shaft, dt_ns: int) -> None:
        """Update from the bus inputs and the drive; `dt_ns`: time since the last inputs [ns]."""
        s, p = self.situation, self._p
        s.health, s.digital, s.gap_ns = inputs.health, inputs.digital, dt_ns
        s.state, s.speed = state, shaft.velocity
        high = not -p.torque_trip <= shaft.torque <= p.torque_trip
        s.torque_high_ns = s.torque_high_ns + dt_ns if high else 0
        s.claimed = bool(self.claim.client)
        if s.claimed:
            s.heartbeat_age_ns = self.claim.age(inputs.stamp_ns)
        if self._minds_wheel:
            runs = decode(inputs.axes[WHEEL].status_word) is State.OPERATION_ENABLED
            s.wheel_left = (s.wheel_left or self._wheel_ran) and not runs
            self._wheel_ran = runs

    def update_from_samples(
        self, now: int, dt_ns: int, encoders: EncoderSample | None, hub: HubSample | None
    ) -> None:
        """Update from hub and encoders; without them their values stay, and their age is 0."""
        s, p = self.situation, self._p
        age = 0
        if hub is not None:
            s.loaded_radius, s.fz = hub.loaded_radius, hub.fz_filtered
            high = not -p.fz_trip <= s.fz <= p.fz_trip
            s.fz_high_ns = s.fz_high_ns + dt_ns if high else 0
            age = abs(now - hub.stamp_ns)
        if encoders is not None:
            age = max(age, abs(now - encoders.stamp_ns))
            if encoders.plank_moving and not s.moving:
                self._since = now
            s.moving, s.plank_velocity = encoders.plank_moving, encoders.plank_velocity
            s.plank_position, s.steer_angle = encoders.plank_position, encoders.steer_angle
        s.sample_age_ns = age

    def update_reference(
        self, now: int, follows_reference: bool, reference: Reference | None
    ) -> None:
        """Update the age of the reference; it counts from the start of the plank if that was
        later."""
        s, since = self.situation, self._since
        if reference is not None and reference.stamp_ns > since:
            since = reference.stamp_ns
        # a stamp of the future is as bad as an old one
        s.follows_reference, s.reference_age_ns = follows_reference, abs(now - since)
