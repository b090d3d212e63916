# SPDX-License-Identifier: Apache-2.0
"""The tables of ARCHITECTURE.md have every service, action and mode that the code has."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from flatplank_control.bench.setup import DRIVEN, NODES
from flatplank_control.recording.topics import TABLE
from flatplank_hw.drive.modes import MODES

ROOT = Path(__file__).resolve().parents[2]
TEXT = (ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8")
SHELLS = [
    path
    for package in ("flatplank_hw", "flatplank_sim", "flatplank_control", "flatplank_panel")
    for path in (ROOT / "ros_ws/src" / package / package / "nodes").glob("*.py")
]
NAMES = {node.executable: node.name for node in NODES} | {
    "axis_hold": "steering_hold",
    "load_controller": DRIVEN["vertical"][1].name,
    "simulated_plant": "simulated_plant",
    "ethercat_bus": "ethercat_bus",
}
BY_TABLE = {
    "measurement_runner": ("skip", "repeat", "discard"),
    "operator_services": (
        "emergency_stop", "connect_flexplates", "set_axle_height", "load_to", "set_pressure_bar",
        "set_cleat_mm", "set_steer_deg", "set_wheel_camber_deg", "set_road_camber_deg", "plank",
        "unload",
    ),
}  # fmt: skip
"""services whose names are in a table of their node"""


def documented() -> set[str]:
    """Service names of the table; `/a/b`, `c` in one row is `/a/b` and `/a/c`."""
    found = set()
    for row in re.findall(r"^\| (`/.*?) \|", TEXT, re.MULTILINE):
        names = re.findall(r"`([\w/…]+)`", row.replace(", `", " `")) or []
        names = [n for part in re.findall(r"`([^`]+)`", row) for n in part.split(", ")] or names
        folder = names[0].rsplit("/", 1)[0]
        found |= {name if name.startswith("/") else f"{folder}/{name}" for name in names}
    return found


def served() -> set[str]:
    """Every literal name that a node serves."""
    found = set()
    for path in SHELLS:
        text = path.read_text(encoding="utf-8")
        name = NAMES.get(path.stem, path.stem)
        for own in re.findall(r'self\.add_(?:service|request)\(\s*\w+,\s*"([~/][\w/]+)"', text):
            found.add(own.replace("~", f"/{name}"))
        prefix = "/simulated_plant" if path.stem == "operator_services" else f"/{name}"
        found |= {f"{prefix}/{own}" for own in BY_TABLE.get(path.stem, ())}
    return found


def test_every_service_is_in_the_table():
    assert len(served()) > 35
    assert served() - documented() == set()
    assert "/run_measurement" in documented()


@pytest.mark.parametrize("name", MODES)
def test_every_mode_is_in_the_table(name):
    assert f"| `{name}` | {MODES[name].code} |" in TEXT


def test_every_recorded_topic_is_in_the_table():
    assert {row.spec.name for row in TABLE} <= documented()
    assert {"/troubles", "/diagnostics", "/run"} <= documented()
