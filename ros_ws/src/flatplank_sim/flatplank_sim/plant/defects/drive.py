# SPDX-License-Identifier: Apache-2.0
"""Defects of the drives of plank and wheel."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_sim.plant.defects.base import Defect, Site, defect_param


@dataclass(frozen=True)
class MeshRipple(Defect):
    """Speed ripple of the rack and pinion mesh, which the encoder on the pinion cannot see.

    It is a position error of the plank with the periods of a tooth and of a turn of the pinion.
    """

    tooth: float = defect_param(20e-6, "m", "amplitude once per tooth", (0.0, 0.005), "mesh_tooth")
    turn: float = defect_param(
        30e-6, "m", "amplitude once per turn of the pinion", (0.0, 0.005), "mesh_turn"
    )
    pitch: float = defect_param(0.01571, "m", "travel of one tooth", (0.001, 0.2), "mesh_pitch")
    phase: float = defect_param(0.0, "rad", "at the start position", into="mesh_phase")

    source = "thesis 3.1, hardware issue 5"
    touches = frozenset({"fx"})
    spares = frozenset({"plank_counts", "wheel_counts", "steer_counts", "lvdt_volts", "fy"})


@dataclass(frozen=True)
class TravelScatter(Defect):
    """Wear and debris between the teeth of rack and pinion: the plank travels a little further or
    less at each tooth, and otherwise in each run.

    The encoder on the pinion cannot see it.
    """

    tooth: float = defect_param(
        1.0e-4, "m", "standard deviation of the travel at a tooth", (0.0, 0.005), "scatter_travel"
    )
    pitch: float = defect_param(0.01571, "m", "travel of one tooth", (0.001, 0.2), "scatter_pitch")

    source = "thesis 3.1, hardware issue 5; section 6.3, repetitions"
    touches = frozenset({"fx"})
    spares = frozenset({"plank_counts", "wheel_counts", "steer_counts", "lvdt_volts", "fy"})


@dataclass(frozen=True)
class StepDelay(Defect):
    """On the moving road the wheel follows a step of its speed late, and otherwise in each run.

    The delay is anything between zero and `most`, drawn anew for each run.
    """

    most: float = defect_param(
        0.7, "s", "largest time from the step to the change", (0.0, 5.0), "scatter_delay"
    )

    source = "thesis 6.3: the force rests after the step, not equally long in ten repetitions"
    touches = frozenset({"fx", "motor_position", "wheel_counts"})
    spares = frozenset({"plank_counts", "steer_counts", "lvdt_volts", "fy"})


@dataclass(frozen=True)
class SpeedDroop(Defect):
    """The speed of the plank drive depends on the tire force: driving raises it, braking lowers
    it.

    Speed rises with fx.
    """

    per_kn: float = defect_param(
        0.0008, "1/kN", "relative speed per longitudinal force", (-0.1, 0.1)
    )

    source = "thesis table 6.3, figure 6.5"
    touches = frozenset({"fx", "plank_counts"})
    spares = frozenset({"steer_counts", "lvdt_volts", "fy"})

    def install(self, site: Site) -> None:
        site.machine["droop"] = self.per_kn / 1000.0


@dataclass(frozen=True)
class TornWeld(Defect):
    """The weld between the drive of the plank and the shaft of its pinions is torn.

    A driving tire that pushes beyond what the crack holds turns the pinions ahead of their drive,
    once per run, up to the gap: the speed spikes, on the encoder too, and fx drops. The hold
    differs from run to run.
    """

    gap: float = defect_param(
        0.0018, "m", "travel of the plank across the crack", (0.0, 0.05), "weld_gap"
    )
    hold: float = defect_param(
        1450.0, "N", "driving force that the crack holds", (0.0, 20000.0), "weld_hold"
    )
    spread: float = defect_param(
        0.03, "-", "standard deviation of the hold between runs", (0.0, 1.0), "weld_spread"
    )
    speed: float = defect_param(
        0.01, "m/s", "of the plank ahead of its drive", (1e-4, 1.0), "weld_speed"
    )

    seen: float = defect_param(
        1.0, "-", "share of it that the encoder shows; 0: it sits before the crack", (0.0, 1.0),
        "weld_seen",
    )  # fmt: skip

    source = "thesis 3.1, hardware issue 12; figures 6.22, 6.23"
    touches = frozenset({"fx", "plank_counts"})
    spares = frozenset({"steer_counts", "lvdt_volts", "fy"})


@dataclass(frozen=True)
class WheelBacklash(Defect):
    """Backlash of the wheel drive other than its usual +-15 deg at the motor.

    The dead zone of (5.16): after a torque reversal the motor turns and the wheel does not.
    """

    half_angle: float = defect_param(
        0.5236, "rad", "half of the gap, at the motor", (0.0, 3.2), "backlash"
    )

    source = "thesis 5.5, figure 5.12"
    touches = frozenset({"fx"})
    spares = frozenset({"plank_counts", "steer_counts", "lvdt_volts", "fy"})


@dataclass(frozen=True)
class WheelEncoderPlay(Defect):
    """The shaft of the wheel encoder is not fixed to the shaft of the hub.

    The encoder follows the wheel with play.
    """

    angle: float = defect_param(0.002, "rad", "whole play", (0.0, 0.2), "wheel_encoder_play")

    source = "thesis 3.1, hardware issue 4"
    touches = frozenset({"wheel_counts"})
    spares = frozenset({"plank_counts", "motor_position", "fx", "fy", "fz", "lvdt_volts"})


@dataclass(frozen=True)
class StartDelay(Defect):
    """The wheel starts late, so the road first deflects a standing tire.

    A resting wheel drive responds after a constant delay.
    """

    time: float = defect_param(
        0.15, "s", "from command to motion", (0.0, 5.0), "wheel_servo.start_delay"
    )

    source = "thesis 4.3, 5.6"
    touches = frozenset({"fx", "motor_position"})
    spares = frozenset({"plank_counts", "steer_counts", "lvdt_volts", "fy"})
