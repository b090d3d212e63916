# SPDX-License-Identifier: Apache-2.0
"""The pre-flight sheet: plays by dial gauge, steering zero by protractor, run-out. They are
starting values for the diagnosis."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

from flatplank_data.names import nearest_hint
from flatplank_data.values import is_number
from flatplank_data.yaml_text import load_format

FORMAT = "flatplank-preflight/1"


class Line(NamedTuple):
    """One line of the sheet."""

    how: str
    unit: str
    effect: str
    """name in the library of missing effects"""
    parameter: str
    factor: float
    """factor from the unit of the sheet to SI"""
    most: float
    """largest plausible reading, in the unit of the sheet"""


MM, DEG = 1e-3, math.pi / 180.0
LINES: dict[str, Line] = {
    "road_play": Line("push the road to and fro in the plank", "mm", "road_play", "gap", MM, 5.0),
    "rack_play": Line("push the plank, pinion held", "mm", "rack_backlash", "gap", MM, 5.0),
    "drive_play": Line("turn the tread, motor held", "mm", "drive_backlash", "gap", MM, 5.0),
    "support_play_y": Line("push the road sideways", "mm", "support_play_y", "gap", MM, 10.0),
    "support_play_z": Line("lift the road", "mm", "support_play_z", "gap", MM, 10.0),
    "steering_play": Line("turn the hub by hand", "deg", "steering_play", "play", DEG, 3.0),
    "steering_zero": Line("protractor at zero", "deg", "steering_zero", "zero", DEG, 5.0),
    "run_out": Line("half the swing at the tread", "mm", "runout_1", "cos", MM, 5.0),
}
"""name of a line -> line; plays and run-out by dial gauge, angles by protractor"""


def empty_sheet(date: str) -> str:
    """An empty sheet."""
    head = f"format: {FORMAT}\ndate: {date}\nby: ''\nreadings:\n"
    return head + "".join(f"  {n}: null   # {x.unit}; {x.how}\n" for n, x in LINES.items())


def starting_values(text: str, where: str) -> dict[str, dict[str, float]]:
    """effect -> parameter -> value [SI] from a filled sheet, without empty lines."""
    found: dict[str, dict[str, float]] = {}
    readings = load_format(text, where, FORMAT).get("readings") or {}
    if not isinstance(readings, Mapping):
        raise ValueError(f"{where}: 'readings' must be lines of 'name: value'")
    for name, value in readings.items():
        if name not in LINES:
            raise ValueError(f"{where}: unknown line '{name}'{nearest_hint(name, LINES)}")
        if value is None:
            continue
        line = LINES[name]
        if not is_number(value) or abs(value) > line.most:
            raise ValueError(
                f"{where}: {name} is {value!r}, must be a number within {line.most:g} {line.unit}"
            )
        found.setdefault(line.effect, {})[line.parameter] = float(value) * line.factor
    return found
