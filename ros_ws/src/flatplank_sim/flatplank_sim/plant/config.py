# SPDX-License-Identifier: Apache-2.0
"""Configuration of the simulated bench: frozen dataclasses read from YAML, SI units unless the
name states another.

`(p)` in a comment of `machine.yaml` marks values that the thesis does not give.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from flatplank_data.limits import LIMITS
from flatplank_data.machine import FRICTION_SPEED, FRICTION_TORQUE
from flatplank_data.names import nearest_hint
from flatplank_data.params import ParameterError, from_mapping
from flatplank_hw.bus.image import AXES
from flatplank_sim.plant.defects.base import Defect, build_defects
from flatplank_sim.plant.yamlconfig import (
    merge,
    nested,
    read_overlay,
    read_yaml,
)

MACHINE = "machine"
"""name of the packaged machine without defects"""


@dataclass(frozen=True)
class TireConfig:
    """True parameters of one tire at nominal load and pressure.

    For a field X, `X_load`, `X_pressure` and `X_deflection` are the exponents of its power laws
    over load, pressure and deflection relative to nominal. Tread stiffness is per contact length
    [N/m2]. Effective rolling radius at the deflection rho [m]: free_radius - rolling_radius_drop *
    rho / (rho + rolling_radius_half_deflection).
    """

    name: str
    free_radius: float
    nominal_load: float
    nominal_pressure_bar: float
    vertical_stiffness: float
    vertical_stiffness_pressure: float
    contact_half_length: float
    contact_half_length_deflection: float
    tread_stiffness_x: float
    tread_stiffness_y: float
    tread_stiffness_pressure: float
    carcass_stiffness_x: float
    carcass_stiffness_x_load: float
    carcass_stiffness_x_pressure: float
    carcass_stiffness_y: float
    carcass_stiffness_y_load: float
    carcass_stiffness_y_pressure: float
    friction: float
    friction_load: float
    friction_pressure: float
    rolling_radius_drop: float
    rolling_radius_half_deflection: float
    rolling_resistance: float
    camber_factor: float = 1.0


@dataclass(frozen=True)
class PlankConfig:
    """Plank drive, road and motion trigger."""

    slow_speed: float
    fast_speed: float
    return_speed: float
    acceleration: float
    estop_deceleration: float
    road_length: float
    rear_limit: float
    pinion_pitch_radius: float
    trigger_position: float
    trigger_length: float


@dataclass(frozen=True)
class AxesConfig:
    """Axes that the operator moves by hand."""

    vertical_speed: float
    load_gain: float
    lowest_axle: float
    highest_axle: float
    clearance: float
    steer_speed_deg: float
    camber_speed_deg: float
    lateral_limit: float
    steer_limit_deg: float = LIMITS["steer_deg"].high
    wheel_camber_limit_deg: float = LIMITS["wheel_camber_deg"].high
    road_camber_limit_deg: float = LIMITS["road_camber_deg"].high


@dataclass(frozen=True)
class WheelDriveConfig:
    """Wheel rotation actuator, thesis Table 5.1 and 5.5."""

    gear_ratio: float
    motor_inertia: float
    wheel_inertia: float
    free_wheel_inertia: float
    stiffness: float
    damping: float
    backlash_deg: float
    efficiency: float
    lock_ratio: float
    bearing_torque: float
    estop_cuts_drive: bool
    friction_speed: tuple[float, ...] = FRICTION_SPEED
    friction_torque: tuple[float, ...] = FRICTION_TORQUE


@dataclass(frozen=True)
class ServoConfig:
    """One CiA 402 drive with its motor."""

    output_per_turn: float
    """motion of the axis per turn of its motor [rad or m]; 0 for the wheel, which has its own gear
    model"""
    inertia: float
    """inertia of the motor and its load, at the motor [kg m2]"""
    torque_limit: float
    velocity_limit: float
    """motor speed, like all speeds here [rad/s]"""
    profile_velocity: float
    acceleration: float
    quick_stop_deceleration: float
    friction: float = 0.0
    """friction torque at the motor [N m]; the wheel has the table of its drive"""
    counts_per_turn: int = 2**23
    torque_slope: float = 50.0
    """[N m/s]"""
    velocity_bandwidth_hz: float = 40.0
    velocity_integral_hz: float = 6.0
    position_gain: float = 20.0
    """[1/s]"""
    window_counts: float = 20000.0
    """the target is reached within this window"""
    velocity_window: float = 0.5
    blocked_time: float = 0.5
    """time at the torque limit without motion until the drive trips [s]"""
    start_delay: float = 0.0
    """delay of a motor at rest from set-point to motion [s]"""


@dataclass(frozen=True)
class HubConfig:
    """Hub: Table A.1, amplifier, LVDT."""

    k_fx1: float
    k_fx2: float
    k_fy: float
    k_fz1: float
    k_fz2: float
    amplification: float
    gravity: float
    et_value: float
    adapter_thickness: float
    saturation_volts: float
    lvdt_gain: float
    lvdt_offset: float
    spin_axis_moment: bool


@dataclass(frozen=True)
class EncoderConfig:
    """Counts per turn of the encoders; the road encoder is optional."""

    plank_counts_per_turn: int
    wheel_counts_per_turn: int
    steer_counts_per_turn: int
    camber_counts_per_turn: int
    road_encoder_fitted: bool
    road_counts_per_turn: int
    road_encoder_radius: float
    steer_on_hub: bool = False
    """true: the steering encoder sits on the hub, behind the play of the worm"""


@dataclass(frozen=True)
class CleatConfig:
    """A cleat on the road; height 0: none."""

    height: float = 0.0
    length: float = 0.01
    position: float = 2.0
    """machine position of its centre [m]"""


@dataclass(frozen=True)
class SolverConfig:
    """Discretisation: bristle distance [m], largest steps of tire and drive [s]."""

    bristle_spacing: float
    tire_step: float
    drive_step: float


@dataclass(frozen=True)
class PlantConfig:
    """The whole simulated bench; `PlantConfig.load` reads it from the packaged files."""

    tire: TireConfig
    plank: PlankConfig
    axes: AxesConfig
    wheel_drive: WheelDriveConfig
    servos: Mapping[str, ServoConfig]
    hub: HubConfig
    encoders: EncoderConfig
    solver: SolverConfig
    cleat: CleatConfig = CleatConfig()
    driven_axes: tuple[str, ...] = ("wheel",)
    command_delay_cycles: int = 2
    watchdog_cycles: int = 15
    defects: Mapping[str, Defect] = field(default_factory=dict)

    @staticmethod
    def load(
        tire: str = "toyo",
        preset: str | None = None,
        overrides: Mapping[str, Any] | None = None,
        file: str | Path | None = None,
    ) -> PlantConfig:
        """Load the packaged machine and tire (a name or a file), then apply preset, file and
        overrides.

        Overrides are nested or dotted: {"plank.road_length": 3.0, "defects": {"road_play": {"gap":
        1e-3}}}; a defect set to None is switched off.
        """
        data = _packaged(MACHINE)
        own = Path(tire).suffix in (".yaml", ".yml")
        data["tire"] = read_yaml(Path(tire)) if own else _packaged(tire, "tire", "tires")
        where = "plant"
        if preset:
            data = merge(data, _packaged(preset, "preset"))
            where += f" with preset {preset}"
        if file:
            data = merge(data, nested(read_overlay(Path(file))))
            where = str(file)
        if overrides:
            data = merge(data, nested(overrides))
        return PlantConfig.from_plain(data, where)

    @staticmethod
    def from_plain(data: Mapping[str, Any], where: str = "plant") -> PlantConfig:
        """Make a configuration from nested plain data; the inverse of `to_plain`."""
        data = dict(data)
        defects = data.pop("defects", None) or {}
        servos = data.pop("servos", None) or {}
        for name in servos:
            if name not in AXES:
                raise ParameterError(
                    f"{where}: servos: unknown axis '{name}'{nearest_hint(name, AXES)}"
                )
        data["servos"] = servos
        data["defects"] = build_defects(defects, f"{where}: defects")
        return from_mapping(PlantConfig, data, where)

    def check(self) -> str | None:
        """Reason why these values do not fit together, or None."""
        for axis in self.driven_axes:
            if axis not in AXES:
                return f"driven_axes: unknown '{axis}'{nearest_hint(axis, AXES)}"
            if axis not in self.servos:
                return f"driven_axes: '{axis}' has no entry under servos"
        if len(self.wheel_drive.friction_speed) != len(self.wheel_drive.friction_torque):
            return "wheel_drive: friction_speed and friction_torque differ in length"
        if self.solver.bristle_spacing <= 0.0 or self.tire.contact_half_length <= 0.0:
            return "bristle_spacing and contact_half_length must be above 0 m"
        return "command_delay_cycles is negative" if self.command_delay_cycles < 0 else None


def cleat_heights(c: PlantConfig, x: np.ndarray, height: float) -> np.ndarray:
    """Enveloped height of a cleat at machine positions x [m]: a hump with the length of cleat plus
    contact patch [m]."""
    half = 0.5 * c.cleat.length + c.tire.contact_half_length
    u = np.clip((x - c.cleat.position) / half, -1.0, 1.0)
    return 0.5 * height * (1.0 + np.cos(np.pi * u))


@cache
def config_folder() -> Path:
    """Folder config/plant in the sources, or in share/flatplank_sim of an installed workspace."""
    here = Path(__file__).resolve()
    places = [here.parents[2] / "config" / "plant"]
    places += [p / "share" / "flatplank_sim" / "config" / "plant" for p in here.parents]
    for place in places:
        if (place / f"{MACHINE}.yaml").is_file():
            return place
    raise ParameterError(
        f"{here}: no config/plant/{MACHINE}.yaml; build the workspace with colcon"
    )


def _packaged(name: str, kind: str = "file", folder: str = ".") -> dict[str, Any]:
    path = config_folder() / folder / f"{name}.yaml"
    if not path.is_file():
        known = [p.stem for p in (config_folder() / folder).glob("*.yaml")]
        raise ParameterError(f"plant: unknown {kind} '{name}'{nearest_hint(name, known)}")
    return read_yaml(path)


def presets() -> tuple[str, ...]:
    """Names of the packaged presets of defects."""
    packaged = (p.stem for p in config_folder().glob("*.yaml"))
    return tuple(sorted(name for name in packaged if name != MACHINE))


def tires() -> tuple[str, ...]:
    """Names of the packaged tires."""
    return tuple(sorted(p.stem for p in (config_folder() / "tires").glob("*.yaml")))
