# SPDX-License-Identifier: Apache-2.0
"""Definition of one measurement, checked before anything moves."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator, Mapping
from dataclasses import MISSING, asdict, dataclass, field, fields
from typing import Any

from flatplank_control.steering_hold import PROFILES
from flatplank_data.errors import FlatplankError
from flatplank_data.limits import LIMITS, RECORDED, Limit, refusal
from flatplank_data.machine import FAST as SPEED
from flatplank_data.machine import ROAD_LENGTH, SLOW, USUAL_RADIUS
from flatplank_data.names import nearest_hint
from flatplank_data.params import ParameterError
from flatplank_data.params import from_mapping as from_params
from flatplank_data.waveforms import WAVEFORMS
from flatplank_hw.hub import HubParameters

DIRECTIONS = {"forward": 1, "reverse": -1}
TRIGGER_AT = 0.02
"""machine position of the motion trigger, where the plank position becomes 0 [m]"""
SETTINGS = {
    **RECORDED,
    "end_position": LIMITS["end_position"],
    "cleat_mm": LIMITS["cleat_mm"],
    "start_angle_deg": Limit(-360.0, 360.0, "deg"),
    "distance": Limit(0.0, ROAD_LENGTH - 0.2, "m"),
    "profile_time": Limit(0.1, 3600.0, "s"),
    "optical_trigger": Limit(0.0, 1.0, "m"),
}
"""field -> range"""
ON_THE_ROAD = ("slip", "cleat", "turning", "camber_sweep")
"""kinds with a driven, rolling wheel, which need an effective rolling radius"""
DRAGGED = ("stiffness_longitudinal", "stiffness_lateral", "locked_wheel")
"""kinds with a held wheel, where the road may move in both directions"""
PROFILED = ("parking", "turning", "camber_sweep")
"""kinds in which the steering or the road camber follows a profile"""
OF_THE_PLAN = (
    "end_position", "distance", "cleat_mm", "profile_time", "hold_load", "optical_trigger",
    "flexplates",
)  # fmt: skip
"""fields that are not copied to the run record"""
START_ANGLES = {1: 0.0, 2: 120.0, 3: 240.0}
"""start position -> wheel angle [deg]"""


class MeasurementError(FlatplankError):
    """Error for an impossible measurement. `key`: field at fault; `reason`: what is wrong."""

    def __init__(self, text: str, key: str = "", reason: str = "") -> None:
        super().__init__(text)
        self.key, self.reason = key, reason or text


@dataclass(frozen=True)
class Measurement:
    """One run on the road. Angles in deg, pressure in bar, all else SI."""

    tire: str = "TOY"
    measurement: str = "slip"
    """kind of measurement, a key of plans.PLANS"""
    kappa: float = 0.0
    fz: float = 3700.0
    pressure: float = 2.5
    alpha_deg: float = 0.0
    gamma_deg: float = 0.0
    start: int = 1
    run_index: int = 0
    repeat: int = 0
    effective_rolling_radius: float = USUAL_RADIUS
    r_e_source: str = ""
    step_position: float = 1.5
    end_position: float = 4.1
    waveform: str = "step"
    waveform_parameters: Mapping[str, float] = field(default_factory=dict)
    speed: float = SPEED
    """speed of the plank, one of the two of its switch [m/s]"""
    direction: str = "forward"
    """direction of the road: forward or reverse"""
    start_angle_deg: float | None = None
    """wheel angle that overrides that of `start`"""
    wheel_camber_deg: float | None = None
    """camber of the hub; the road takes the rest of gamma_deg"""
    flexplates: bool = True
    """False: the wheel is disconnected from its drive and rolls freely"""
    distance: float = 0.0
    """road of a stiffness or locked-wheel measurement [m]; 0: default of its kind"""
    cleat_mm: float = 10.0
    """height of the cleat [mm]"""
    profile: str = "parking"
    """profile of the steering or camber axis, a key of steering_hold.PROFILES"""
    profile_parameters: Mapping[str, float] = field(default_factory=dict)
    profile_time: float = 80.0
    """time for which a standing tire is steered [s]"""
    hold_load: bool = False
    """true: the load controller of a driven vertical axis holds fz"""
    optical_trigger: float = 0.0
    """road between two pulses of the trigger output [m]; 0: none"""
    name: str = ""
    operator: str = ""
    serial: str = ""
    notes: str = ""
    et_value: float | None = None
    """ET value of the rim [m]"""
    adapter_thickness: float | None = None
    """[m]"""
    session: Mapping[str, Any] = field(default_factory=dict)
    """room temperature, paper batch and other facts of the session"""

    def __post_init__(self) -> None:
        for key, reason in self._problems():
            text = f"measurement {self.name or self.measurement}: {reason}"
            raise MeasurementError(text, key, reason)

    def _problems(self) -> Iterator[tuple[str, str]]:
        """(key at fault, reason); later checks assume that earlier ones have passed."""
        for f in fields(self):
            value = getattr(self, f.name)
            if isinstance(value, float) and not math.isfinite(value):
                yield f.name, f"{f.name} is {value}, must be finite"
        for name, limit in SETTINGS.items():
            value = getattr(self, name)
            if value is not None and (reason := limit.refusal(name, value)):
                yield name, reason
        # the road takes the rest of the camber
        hub = self.wheel_camber_deg or 0.0
        if reason := refusal("road_camber_deg", self.gamma_deg - hub):
            both = f"gamma_deg is {self.gamma_deg:g} with {hub:g} at the hub"
            yield "gamma_deg", f"{both}: {reason}; the hub takes the rest, wheel_camber_deg"
        yield from self._problems_of_motion()
        if self.start not in START_ANGLES:
            yield "start", f"start is {self.start}, must be 1, 2 or 3 (0, 120, 240 deg)"
        if self.waveform not in WAVEFORMS:
            yield (
                "waveform",
                f"waveform is '{self.waveform}'{nearest_hint(self.waveform, WAVEFORMS)}",
            )
        profiled = self.measurement in PROFILED
        if profiled and self.profile not in PROFILES:
            yield "profile", f"profile is '{self.profile}'{nearest_hint(self.profile, PROFILES)}"
        name = "profile_parameters"
        try:
            if profiled:
                from_params(PROFILES[self.profile], self.profile_parameters, name)
            for name, value in self.rim().items():
                from_params(HubParameters, {name: value}, "rim")
        except ParameterError as error:
            yield name, str(error)
        if self.measurement in ON_THE_ROAD and self.end_position <= self.step_position:
            both = f"{self.end_position:g} m is not behind step_position {self.step_position:g} m"
            yield "end_position", f"end_position {both}: the slip would never be given"

    def _problems_of_motion(self) -> Iterator[tuple[str, str]]:
        """Problems with the plank and the coupling to the drive of the wheel."""
        if min(abs(self.speed - v) for v in (SPEED, SLOW)) > 1e-6:
            known = f"{SPEED:g} and {SLOW:g}"
            yield "speed", f"speed is {self.speed:g} m/s; the plank has {known} m/s"
        if self.direction not in DIRECTIONS:
            yield "direction", f"direction is '{self.direction}', must be forward or reverse"
        if self.direction == "reverse" and self.measurement not in DRAGGED:
            reason = "a rolling run begins at the motion trigger, at the front end of the road"
            held = f"only a held wheel goes back ({', '.join(DRAGGED)})"
            yield "direction", f"direction is reverse: {reason}; {held}"
        if not self.flexplates and self.measurement != "free_rolling":
            reason = f"a wheel without its drive can only roll freely, not {self.measurement}"
            yield "flexplates", f"flexplates is false: {reason}"

    def slip_parameters(self) -> dict[str, float]:
        """Parameters of the waveform; a step uses the slip of the run."""
        own = {"kappa": self.kappa} if self.waveform == "step" else {}
        return {**own, **self.waveform_parameters}

    @property
    def start_angle(self) -> float:
        """Wheel angle at the start [deg]."""
        given = self.start_angle_deg
        return START_ANGLES[self.start] if given is None else given

    @property
    def fast(self) -> bool:
        """True for the fast speed of the plank."""
        return self.speed > 2.0 * SLOW

    def rim(self) -> dict[str, float]:
        """Constants of the hub that the plan names [m, deg]."""
        names = ("et_value", "adapter_thickness", "wheel_camber_deg")
        given = {name: getattr(self, name) for name in names}
        return {name: value for name, value in given.items() if value is not None}

    def record(self) -> dict[str, Any]:
        """Fields of the run record."""
        values = asdict(self)
        values["waveform"] = {"name": values["waveform"], **values.pop("waveform_parameters")}
        for name in OF_THE_PLAN:
            del values[name]
        profile = {"name": values.pop("profile"), **values.pop("profile_parameters")}
        session = values.pop("session")
        if session:
            values["parameters"] = {"session": dict(session)}
        if self.fast:
            values["speed"] = None
        if not self.flexplates:
            values["r_e_source"] = "flexplates_off"
        if self.measurement == "unloaded_turn":
            values["fz"] = 0.0
        if self.measurement not in ON_THE_ROAD:
            values["effective_rolling_radius"] = values["step_position"] = None
        if self.measurement != "slip":
            values["waveform"] = {}
        extra = self._extra(profile)
        if extra:
            values["parameters"] = {**values.get("parameters", {}), "measurement": extra}
        return values

    def _extra(self, profile: dict[str, Any]) -> dict[str, Any]:
        """Fields that only this kind of measurement has."""
        found: dict[str, Any] = {}
        if self.measurement in PROFILED:
            found["profile"] = profile
        if self.measurement == "cleat":
            found["cleat_mm"] = self.cleat_mm
        if self.hold_load:
            found["hold_load"] = True
        if self.optical_trigger:
            found["optical_trigger"] = self.optical_trigger
        return found


def from_mapping(data: Mapping[str, Any], where: str) -> Measurement:
    """A measurement from YAML; MeasurementError names the unknown key and the nearest one."""
    known = {f.name: f for f in fields(Measurement)}
    values = {}
    try:
        for key, value in data.items():
            if key not in known:
                reason = f"unknown key '{key}'{nearest_hint(key, known)}"
                raise MeasurementError(reason, key)
            values[key] = _typed(key, value, known[key].default)
        return Measurement(**values)
    except MeasurementError as error:
        raise MeasurementError(f"{where}: {error}", error.key, error.reason) from None


_TYPES: dict[type, tuple[tuple[type[Any], ...], str]] = {
    bool: ((bool,), "true or false"),
    int: ((int,), "a whole number"),
    float: ((int, float), "a number"),
    str: ((str,), "text"),
    dict: ((Mapping,), "keys and values"),
}
"""type of a field -> allowed YAML types, and their description"""


def _typed(key: str, value: Any, default: Any) -> Any:
    """The value in the type of the field; a field with default None takes a number or nothing."""
    if default is None and value is None:
        return None
    kind = dict if default is MISSING else float if default is None else type(default)
    allowed, words = _TYPES[kind]
    if not isinstance(value, allowed) or (isinstance(value, bool) and kind is not bool):
        raise MeasurementError(f"{key} is {value!r}, must be {words}", key)
    if kind is float and abs(value) > sys.float_info.max:
        raise MeasurementError(f"{key} is {value}, must be finite", key)
    return float(value) if kind is float else value
