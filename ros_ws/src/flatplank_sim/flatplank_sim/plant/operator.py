# SPDX-License-Identifier: Apache-2.0
"""Switches and handwheels of the simulated operator; they act at the next cycle, axes move at
their speed."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from flatplank_data.limits import Limit
from flatplank_sim.plant import layout
from flatplank_sim.plant.config import PlantConfig, cleat_heights

MAX_CLEAT = 0.03
"""largest height of a cleat [m]"""


class OperatorView(NamedTuple):
    """What the operator sees at the machine, without sensors of the bench."""

    plank_position: float
    """machine position, 0 at rest before the trigger [m]"""
    plank_moving: bool
    axle_height: float
    """[m]"""
    load_reached: bool
    """true when no loading is in progress"""
    at_target: bool
    """true when axle, steering and cambers have reached their targets"""
    pressure: float
    """[bar]"""
    emergency_stop: bool
    flexplates: bool
    runs: int
    """number of times that the plank has passed the trigger forward"""


class Operator:
    """Actions of the operator, effective from the next step on; ValueError on refusal."""

    def __init__(
        self, config: PlantConfig, state: np.ndarray, wishes: np.ndarray, machine: np.ndarray,
        road_map: np.ndarray,
    ) -> None:  # fmt: skip
        self._c, self._s, self._op, self._m = config, state, wishes, machine
        self._map = road_map

    def plank(self, direction: int, fast: bool | None = None, stop_at: float = math.nan) -> None:
        """Set the plank switch: forward (1), stop (0) or reverse (-1).

        fast: speed switch, None: unchanged; stop_at: as in `plank_stop_at` [m], NaN: none.
        """
        if direction not in (-1, 0, 1):
            raise ValueError(f"plank: direction {direction} is not -1, 0 or 1")
        if math.isnan(stop_at):
            self._op["use_stop"], self._op["stop_position"] = 0, 0.0
        else:
            self.plank_stop_at(stop_at, "plank: stop_at")
        if fast is not None:
            self.fast(fast)
        self._op["direction"] = int(direction)

    def plank_stop_at(self, position: float, what: str = "plank_stop_at") -> None:
        """Let the switch go to stop by itself so that the plank rests at this position [m]."""
        plank = self._c.plank
        _within(what, position, -plank.rear_limit, plank.road_length, "m")
        self._op["use_stop"], self._op["stop_position"] = 1, position

    def fast(self, on: bool) -> None:
        """Set the speed switch: fast (0.03092 m/s) or slow (0.0015 m/s)."""
        self._op["fast"] = int(bool(on))

    def axle_height(self, height: float) -> None:
        """Move the axle to a height over the road [m]."""
        _within("axle_height", height, self._c.axes.lowest_axle, self._c.axes.highest_axle, "m")
        self._op["load_mode"], self._op["height"] = 0, height

    def load_to(self, fz: float) -> None:
        """Lower the axle until the load is reached [N]; the height then stays."""
        _within("load_to", fz, 1.0, 20000.0, "N")
        self._op["load"], self._op["load_mode"] = fz, 1

    def unload(self) -> None:
        """Lift the wheel off the road."""
        self.axle_height(self._c.tire.free_radius + self._c.axes.clearance)

    def steer(self, angle: float) -> None:
        """Set the steering angle [rad], with the sign of the side slip angle: fy < 0 for a
        positive angle."""
        limit = math.radians(self._c.axes.steer_limit_deg)
        _within("steer", angle, -limit, limit, "rad")
        self._op["steer"] = angle

    def lateral(self, position: float) -> None:
        """Move the hub by handwheel to a position left of the middle of the road [m]."""
        limit = self._c.axes.lateral_limit
        _within("lateral", position, -limit, limit, "m")
        self._op["lateral"] = position

    def wheel_camber(self, angle: float) -> None:
        """Set the camber of the hub [rad]."""
        self._camber("wheel_camber", angle, self._c.axes.wheel_camber_limit_deg)

    def road_camber(self, angle: float) -> None:
        """Set the camber of the road [rad]."""
        self._camber("road_camber", angle, self._c.axes.road_camber_limit_deg)

    def _camber(self, name: str, angle: float, limit_deg: float) -> None:
        limit = math.radians(limit_deg)
        _within(name, angle, -limit, limit, "rad")
        self._op[name] = angle

    def pressure(self, bar: float) -> None:
        """Set the tire inflation pressure [bar]."""
        _within("pressure", bar, 0.5, 6.0, "bar")
        self._op["pressure"] = bar

    def cleat(self, height: float) -> None:
        """Mount a cleat of this height [m] at its configured position; 0 removes it."""
        _within("cleat", height, 0.0, MAX_CLEAT, "m")
        if height and self._s["fz"][0] > 0.0:
            raise ValueError("cleat: the tire stands on the road; unload it first")
        x = np.arange(len(self._map)) * layout.MAP_STEP - layout.MAP_START
        self._map[:, 2] = cleat_heights(self._c, x, height)
        self._m["mapped"] = 1

    def emergency_stop(self, pressed: bool = True) -> None:
        """Press or release the emergency stop: the plank stops, driven axes other than the wheel
        quick-stop."""
        self._op["estop"] = int(bool(pressed))
        if pressed:
            self._op["direction"] = 0

    def flexplates(self, connected: bool) -> None:
        """Connect the wheel to its drive, or let it roll freely; only at rest."""
        s = self._s
        joined = bool(s["joined"][0] > 0.0)
        if joined == bool(connected):
            return
        if abs(s["speed"][0]) > 0.0 or abs(s["omega"][0]) > 1e-3:
            raise ValueError("flexplates: plank and wheel must rest; stop them first")
        if connected:
            s["offset"] = s["motor"] - self._m["gear"] * s["theta"]
        s["joined"] = 1.0 if connected else 0.0
        self._op["flexplates"] = int(bool(connected))

    @property
    def view(self) -> OperatorView:
        """What the operator sees at the machine."""
        s, op = self._s[0], self._op[0]
        wanted = ("height", "lateral", "steer", "wheel_camber", "road_camber")
        loaded = not op["load_mode"]
        at_target = loaded and all(abs(s[n] - op[n]) < 1e-9 for n in wanted)
        return OperatorView(
            float(s["plank"]), bool(s["pinion_velocity"] != 0.0), float(s["height"]), loaded,
            at_target, float(s["pressure"]), bool(op["estop"]), bool(op["flexplates"]),
            int(s["run"]),
        )  # fmt: skip


def _within(what: str, value: float, low: float, high: float, unit: str) -> None:
    if reason := Limit(low, high, unit).refusal(what, value):
        raise ValueError(reason)
