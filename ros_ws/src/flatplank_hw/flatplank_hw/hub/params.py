# SPDX-License-Identifier: Apache-2.0
"""Parameters of the measurement hub, each with its source; the core derives the gains of (A.1)."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

from flatplank_data.limits import LIMITS, Limit
from flatplank_data.machine import FRICTION_SPEED, FRICTION_TORQUE, GEAR_RATIO
from flatplank_data.params import Params, param
from flatplank_hw.encoders.params import counts_param

VOLTS = Limit(-100.0, 100.0, "V")
"""voltages that an amplifier can give; others count as no number"""
_GAIN = (1.0, 1e5)
_BRIDGE = (0.01, 100.0)
COUNTS = (
    "camber_counts_per_turn", "wheel_counts_per_turn", "plank_counts_per_turn",
    "motor_counts_per_turn",
)  # fmt: skip
DRIVE_MOMENTS = ("force_balance", "motor_torque")
"""estimates of M_yc, see `appendix_a`"""
SETUP_CONSTANTS = ("et_value", "adapter_thickness", "wheel_camber_deg", "road_camber_offset_deg")
"""parameters that may change while the bench runs, after a change of the wheel"""


@dataclass(frozen=True)
class HubParameters(Params):
    """Table A.1 and the constants of the set-up."""

    k_fx1: float = param(3.5841, "bridge constant of Fx1, Table A.1", bounds=_BRIDGE)
    k_fx2: float = param(3.8158, "bridge constant of Fx2, Table A.1", bounds=_BRIDGE)
    k_fy: float = param(3.8246, "bridge constant of Fy, Table A.1", bounds=_BRIDGE)
    k_fz1: float = param(1.9775, "bridge constant of Fz1, Table A.1", bounds=_BRIDGE)
    k_fz2: float = param(1.9396, "bridge constant of Fz2, Table A.1", bounds=_BRIDGE)
    a_fx: float = param(1000.0, "amplification for Fx, Table A.1", bounds=_GAIN)
    a_fy: float = param(1000.0, "amplification for Fy, Table A.1", bounds=_GAIN)
    a_fz: float = param(1000.0, "amplification for Fz, Table A.1", bounds=_GAIN)
    gravity: float = param(9.81, "g of (A.1)", unit="m/s^2", bounds=(9.7, 9.9))
    calibration_date: str = param(
        "2008, Table A.1", "when the bridge constants were calibrated last"
    )

    et_value: float = param(
        0.04, "ET value of the rim", unit="m", bounds=(-0.1, 0.2), placeholder=True
    )
    adapter_thickness: float = param(
        0.02, "thickness of the adapter", unit="m", bounds=(0.0, 0.2), placeholder=True
    )
    wheel_camber_deg: float = param(
        0.0,
        "camber of the hub, by inclinometer",
        unit="deg",
        bounds=LIMITS["wheel_camber_deg"].bounds,
    )
    road_camber_offset_deg: float = param(
        0.0,
        "added to the measured road camber",
        unit="deg",
        bounds=LIMITS["road_camber_deg"].bounds,
    )
    camber_counts_per_turn: int = counts_param("road camber encoder", placeholder=True)
    wheel_counts_per_turn: int = counts_param("wheel encoder, chapter 3")
    plank_counts_per_turn: int = counts_param("pinion encoder, chapter 3")

    lvdt_gain: float = param(
        0.02, "axle height over LVDT volts", unit="m/V", bounds=(-1.0, 1.0), placeholder=True
    )
    lvdt_offset: float = param(
        0.3, "axle height over the road at 0 V", unit="m", bounds=(-1.0, 2.0), placeholder=True
    )
    lvdt_calibration_date: str = param("none", "when the LVDT was calibrated last")

    saturation_volts: float = param(
        10.0, "limit of the amplifier", unit="V", bounds=(0.1, VOLTS.high)
    )
    fz_filter_hz: float = param(
        10.0, "low-pass of Fz for the safety rules", unit="Hz", bounds=(0.1, 500.0)
    )

    filter_on: bool = param(False, "parasitic filter of Appendix C on at the start")
    parasitic_fit: str = param("", "file of the parasitic fit loaded at the start; empty: none")

    tare_samples: int = param(250, "samples averaged by a tare", bounds=(1, 100000))
    tare_limit_fz: float = param(
        1000.0, "a tare is refused above this filtered |Fz|", unit="N", bounds=(0.0, 1e5)
    )
    still_time: float = param(
        0.2,
        "the plank rests when its counts have not changed for so long",
        unit="s",
        bounds=(0.01, 10.0),
    )

    include_drive_moment: bool = param(
        False, "M_yw gains cos(gamma) M_yc and M_zw gains sin(gamma) M_yc"
    )
    drive_moment_source: str = param("force_balance", "estimate of M_yc", choices=DRIVE_MOMENTS)
    gear_ratio: float = param(GEAR_RATIO, "motor to wheel, 30.32 * 47", bounds=(1.0, 1e6))
    efficiency: float = param(0.392, "wheel drive's efficiency, Table 5.1", bounds=(0.01, 1.0))
    motor_counts_per_turn: int = counts_param("wheel drive motor, 23 bit", 2**23)
    friction_speed: tuple[float, ...] = param(
        FRICTION_SPEED, "motor speeds of friction_torque", unit="rad/s", bounds=(0.0, 1e4)
    )
    friction_torque: tuple[float, ...] = param(
        FRICTION_TORQUE,
        "wheel drive's friction torque at the motor, by the settling distances of thesis 5.6",
        unit="N m",
        bounds=(0.0, 100.0),
    )

    def check(self) -> str | None:
        for name in COUNTS:
            if getattr(self, name) == 0:
                return f"{name} is 0: give the counts of one turn, negative to turn the sign"
        if len(self.friction_speed) != len(self.friction_torque):
            return "friction_speed and friction_torque differ in length"
        if any(b <= a for a, b in pairwise(self.friction_speed)):
            return "friction_speed does not increase"
        return "lvdt_gain is 0 m/V: calibrate the LVDT" if self.lvdt_gain == 0.0 else None
