# SPDX-License-Identifier: Apache-2.0
"""Services for the switches and manual settings of the simulated operator, for each node that has
a plant."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any

from std_srvs.srv import SetBool, Trigger

from flatplank_data.limits import LIMITS, refusal
from flatplank_hw.nodes.responses import fill_response
from flatplank_hw.nodes.support import BenchNode
from flatplank_msgs.srv import PlankSwitch, SetValue

PREFIX = "simulated_plant"
SWITCHES = {"emergency_stop": "emergency_stop", "connect_flexplates": "flexplates"}
"""service -> method of the plant's operator"""
VALUES: dict[str, tuple[str, str, Callable[[float], float]]] = {
    "set_axle_height": ("", "axle_height", float),
    "load_to": ("fz", "load_to", float),
    "set_pressure_bar": ("pressure", "pressure", float),
    "set_cleat_mm": ("cleat_mm", "cleat", lambda mm: 1e-3 * mm),
    "set_steer_deg": ("steer_deg", "steer", math.radians),
    "set_wheel_camber_deg": ("wheel_camber_deg", "wheel_camber", math.radians),
    "set_road_camber_deg": ("road_camber_deg", "road_camber", math.radians),
}
"""service -> (setting that gives the limit, method, conversion of the value to SI)"""
ON_THE_WAY = {
    "load_to": "the axle is on its way to {value:g} N, which takes seconds: begin a run when fz "
    "of /measurement_hub/state has settled",
}
"""service -> answer while its axis still moves"""

Operate = Callable[..., Any]
"""calls a method of the plant's operator by name, with arguments; ValueError on refusal"""


class OperatorServices:
    """Adds the services to a node; `cycle` returns the present bus cycle."""

    def __init__(self, node: BenchNode, operate: Operate, cycle: Callable[[], int]) -> None:
        self._operate, self._cycle = operate, cycle
        node.add_service(PlankSwitch, f"{PREFIX}/plank", self._on_plank)
        node.add_service(Trigger, f"{PREFIX}/unload", self._on_unload)
        for name, method in SWITCHES.items():
            node.add_service(SetBool, f"{PREFIX}/{name}", partial(self._on_switch, method))
        for name in VALUES:
            node.add_service(SetValue, f"{PREFIX}/{name}", partial(self._on_value, name))

    def _act(self, response: Any, name: str, *values: Any, answer: str = "") -> Any:
        try:
            self._operate(name, *values)
        except ValueError as error:
            return fill_response(response, False, str(error), self._cycle())
        cycle = self._cycle() + 1
        return fill_response(response, True, f"{answer}, from cycle {cycle}", cycle)

    def _on_plank(self, request: Any, response: Any) -> Any:
        way = {1: "goes forward", 0: "stops", -1: "goes back"}.get(request.direction, "")
        speed = "" if request.direction == 0 else ", fast" if request.fast else ", slowly"
        stop = "" if math.isnan(request.stop_at) else f", to {request.stop_at:g} m"
        values = request.direction, request.fast, request.stop_at
        return self._act(response, "plank", *values, answer=f"the plank {way}{speed}{stop}")

    def _on_unload(self, _request: Any, response: Any) -> Any:
        return self._act(response, "unload", answer="the axle lifts the wheel off the road")

    def _on_switch(self, method: str, request: Any, response: Any) -> Any:
        answer = f"{method.replace('_', ' ')} is {'on' if request.data else 'off'}"
        return self._act(response, method, request.data, answer=answer)

    def _on_value(self, name: str, request: Any, response: Any) -> Any:
        setting, method, to_si = VALUES[name]
        if setting and (reason := refusal(setting, request.value)):
            return fill_response(response, False, reason, self._cycle())
        unit = LIMITS[setting].unit if setting else "m"
        done = f"{method.replace('_', ' ')} goes to {request.value:g} {unit}"
        answer = ON_THE_WAY.get(name, done).format(value=request.value)
        return self._act(response, method, to_si(request.value), answer=answer)
