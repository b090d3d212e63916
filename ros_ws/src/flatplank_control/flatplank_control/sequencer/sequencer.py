# SPDX-License-Identifier: Apache-2.0
"""Slip over plank position to wheel speed: omega = V cos(alpha) (1 + kappa) / r_e.

The wheel's angle can follow the road's travel: the wheel recovers a late start, and slip does not
depend on the speed. The wanted angle is the integral of cos(alpha) (1 + kappa) / r_e over the
travel. It is compared with the wheel encoder, so that the backlash of the drive is compensated,
too; the quantization of the encoder averages out."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import Any, NamedTuple

from flatplank_control.sequencer.params import FASTEST, JUMP, SETUP_CONSTANTS, SequencerParameters
from flatplank_data.limits import Limit
from flatplank_data.names import nearest_hint
from flatplank_data.params import ParameterError, from_mapping, require_changes_only
from flatplank_data.waveforms import WAVEFORMS, Waveform, in_words
from flatplank_hw.answers import ActionQueue, Answer, refused
from flatplank_hw.samples import EncoderSample, Reference


class Follower:
    """Lets the wheel follow the road's travel in one run; `step` returns a correction [rad/s]."""

    def __init__(self, p: SequencerParameters) -> None:
        self.parameters = p
        parts = (p.mesh_turn_cos, p.mesh_turn_sin, p.mesh_tooth_cos, p.mesh_tooth_sin)
        self._meshed = any(parts)
        self.reset()

    def reset(self) -> None:
        """Reset for a new run."""
        self._position: float | None = None
        self._error = 0.0
        self._angle = self._wanted = 0.0
        self.travel = 0.0
        """travel of the road since it rested [m]"""
        self.lost = 0.0
        """wanted angle minus wheel angle [rad]"""

    def step(self, encoders: EncoderSample, per_metre: float) -> float:
        """Correction of the wheel speed in this cycle [rad/s], for a wanted turn of `per_metre`
        [rad/m]; 0 while motor and wheel encoder disagree."""
        p = self.parameters
        on_road = p.use_road_encoder and encoders.road_position == encoders.road_position
        position = encoders.road_position if on_road else encoders.plank_position
        before = self._position
        rests = before is None or not encoders.plank_moving
        if before is None or (rests and self.travel == 0.0):
            # the travel starts here
            self._angle, self._wanted = encoders.wheel_angle, 0.0
            self._position = position
            self._error = 0.0 if on_road else self._mesh(position)
            return 0.0
        step = position - before
        self._position = position
        if not -JUMP < step < JUMP:
            step = encoders.plank_velocity / p.rate_hz
            self._error = self._mesh(position)
        if not on_road:
            step = step * p.road_scale + self._mesh_step(position)
        self.travel += step
        self._wanted += step * per_metre
        self.lost = self._wanted - (encoders.wheel_angle - self._angle)
        if not abs(encoders.mismatch) <= p.mismatch_limit:
            return 0.0
        correction = p.follow_rate * self.lost
        most = (FASTEST - 1.0) * p.commanded_speed * per_metre
        return min(max(correction, -0.5 * most), most)

    def _mesh_step(self, position: float) -> float:
        """Change of the mesh error since the last cycle [m]."""
        if not self._meshed:
            return 0.0
        before, self._error = self._error, self._mesh(position)
        return self._error - before

    def _mesh(self, position: float) -> float:
        """Mesh error of rack and pinion at a plank position [m]."""
        if not self._meshed:
            return 0.0
        p = self.parameters
        turn, tooth = position / p.pinion_pitch_radius, math.tau * position / p.tooth_pitch
        return (
            p.mesh_turn_cos * math.cos(turn) + p.mesh_turn_sin * math.sin(turn)
            + p.mesh_tooth_cos * math.cos(tooth) + p.mesh_tooth_sin * math.sin(tooth)
        )  # fmt: skip


SOURCE = "slip"
_NAN = math.nan


class SequencerState(NamedTuple):
    """State of the sequencer after a step."""

    active: bool
    """the waveform has begun"""
    reference_slip: float
    actual_slip: float
    """from measured velocities; NaN while the plank stands"""
    reference_velocity: float
    """of the wheel [rad/s]"""
    distance: float
    """since the start position [m], negative before it; NaN without a waveform"""
    start_position: float
    """plank position [m]"""
    effective_rolling_radius: float
    """[m]"""


class SlipSequencer:
    """Free rolling up to the start position, then the waveform."""

    def __init__(self, p: SequencerParameters) -> None:
        self.parameters = p
        self._agenda = ActionQueue()
        self._wave: Waveform | None = None
        self._start = self._radius = _NAN
        self.waveform: dict[str, Any] = {}
        """the waveform that was set last: name, start [m], rolling radius [m], all parameters"""
        self._position: float | None = None
        self._steer, self._cos = 0.0, 1.0
        self._slip, self._omega, self._distance, self._active = 0.0, 0.0, _NAN, False
        self._sample: EncoderSample | None = None
        self._off_since: int | None = None
        self._follower = Follower(p) if p.follow_until > 0.0 else None

    @property
    def state(self) -> SequencerState:
        """State after the last step."""
        return SequencerState(
            self._active, self._slip, self._actual_slip(), self._omega, self._distance,
            self._start, self._radius,
        )  # fmt: skip

    # requests
    def set_constants(self, p: SequencerParameters) -> None:
        """Change the plank speed from the next cycle on; ValueError for any other change."""
        require_changes_only(self.parameters, p, SETUP_CONSTANTS, "slip sequencer")
        self.parameters = p
        if self._follower is not None:
            self._follower.parameters = p

    def set_slip_step(
        self, kappa: float, start_position: float, effective_rolling_radius: float
    ) -> Answer:
        """Set a step to `kappa` at a plank position [m] with an effective rolling radius [m]."""
        return self.set_waveform(
            "step", {"kappa": kappa}, start_position, effective_rolling_radius
        )

    def set_waveform(
        self,
        name: str,
        values: Mapping[str, float],
        start_position: float,
        effective_rolling_radius: float,
    ) -> Answer:
        """Set a waveform by name and parameters, from the next cycle on; refused as a whole when
        anything is wrong."""
        kind = WAVEFORMS.get(name)
        if kind is None:
            return refused(f"unknown waveform '{name}'{nearest_hint(name, WAVEFORMS)}")
        try:
            wave = from_mapping(kind, values, f"waveform {name}")
        except ParameterError as error:
            return refused(str(error))
        reason = self._refuse(start_position, effective_rolling_radius)
        if reason:
            return refused(reason)

        def act() -> None:
            self._wave, self._start = wave, float(start_position)
            self._radius = float(effective_rolling_radius)

        self.waveform = {
            "name": name,
            "start_position": float(start_position),
            "effective_rolling_radius": float(effective_rolling_radius),
            "parameters": dataclasses.asdict(wave),
        }
        place = f"at {start_position:g} m, r_e {1e3 * effective_rolling_radius:.1f} mm"
        return self._agenda.accept(act, f"{name} of {in_words(wave, values)} {place}")

    def reset(self) -> None:
        """Reset the plank position; the waveform stays."""
        self._position = None
        if self._follower is not None:
            self._follower.reset()

    def watch(self, plank_position: float, cycle: int) -> None:
        """Update the plank position [m] in another mode, since requests are checked against it."""
        self._position, self._agenda.last_cycle = plank_position, cycle

    def step(self, encoders: EncoderSample) -> Reference:
        """Speed reference of this cycle [rad/s at the wheel]; takes about 2 us."""
        agenda = self._agenda
        if agenda.due:
            agenda.run()
        agenda.last_cycle = encoders.cycle
        self._sample = encoders
        self._position = encoders.plank_position
        wave = self._wave
        if wave is None:
            return Reference(encoders.cycle, encoders.stamp_ns, SOURCE, 0.0, False)
        if encoders.steer_angle != self._steer:
            self._steer = encoders.steer_angle
            self._cos = math.cos(self._steer)
        distance = encoders.plank_position - self._start
        self._distance = distance
        self._active = distance >= 0.0
        slip = wave.slip(distance) if distance >= 0.0 else 0.0
        self._slip = slip
        p = self.parameters
        speed = encoders.plank_velocity if p.use_measured_speed else p.commanded_speed
        per_metre = self._cos * (1.0 + slip) / self._radius
        self._omega = speed * per_metre
        follower = self._follower
        if follower is not None and follower.travel < p.follow_until:
            self._omega += follower.step(encoders, per_metre)
        valid = p.use_measured_speed or self._speed_is_as_commanded(encoders)
        return Reference(encoders.cycle, encoders.stamp_ns, SOURCE, self._omega, valid)

    def _speed_is_as_commanded(self, encoders: EncoderSample) -> bool:
        """False when the speed switch is wrong; at the slow speed the slip would be 2000 %."""
        p = self.parameters
        off = (
            abs(encoders.plank_velocity - p.commanded_speed)
            > p.speed_tolerance * p.commanded_speed
        )
        if not (off and encoders.plank_moving):
            self._off_since = None
            return True
        if self._off_since is None:
            self._off_since = encoders.stamp_ns
        return encoders.stamp_ns - self._off_since <= p.speed_patience * 1e9

    def _actual_slip(self) -> float:
        sample = self._sample
        if sample is None or not sample.plank_moving or self._wave is None:
            return _NAN
        along = sample.plank_velocity * self._cos
        p = self.parameters
        turning = (
            sample.motor_velocity / p.gear_ratio if p.slip_from_motor else sample.wheel_velocity
        )
        return turning * self._radius / along - 1.0 if along else _NAN

    def _refuse(self, start: float, radius: float) -> str | None:
        p = self.parameters
        known = {
            "effective_rolling_radius": (Limit(p.radius_min, p.radius_max, "m"), radius),
            "step_position": (Limit(0.0, p.road_length, "m"), start),
        }
        for name, (limit, value) in known.items():
            if reason := limit.refusal(name, value):
                return reason
        if start == p.road_length:
            return f"step_position is {start:g} m, the end of the road: no slip would be given"
        if self._position is not None and start < self._position:
            return (
                f"start position {start:g} m is behind the plank at {self._position:.3f} m: "
                "return the plank or start later"
            )
        return None
