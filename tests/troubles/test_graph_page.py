# SPDX-License-Identifier: Apache-2.0
"""The page of the graph is what the code says, and has every service that a node serves."""

from __future__ import annotations

import re
from pathlib import Path

from flatplank_control.bench.setup import DRIVEN, NODES
from flatplank_hw.drive.modes import MODES
from flatplank_validation.pages import graph
from flatplank_validation.pages.graph import SERVICES

ROOT = Path(__file__).resolve().parents[2]
LITERAL = re.compile(r'self\.add_(?:service|request)\(\s*(\w+),\s*"([~/]?[\w/]+)"')
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


def documented() -> dict[str, str]:
    """Name of a service or action -> its type."""
    return {name: row.type for row in SERVICES for name in row.names}


def served() -> dict[str, str]:
    """Every literal name that a node serves -> its type; of a table: the types of its node."""
    found = {}
    for path in SHELLS:
        text = path.read_text(encoding="utf-8")
        name = NAMES.get(path.stem, path.stem)
        for kind, own in LITERAL.findall(text):
            found[own.replace("~", f"/{name}").replace("operator/", "/operator/")] = kind
        prefix = "/simulated_plant" if path.stem == "operator_services" else f"/{name}"
        found |= {f"{prefix}/{own}": "" for own in BY_TABLE.get(path.stem, ())}
    return found


def test_every_service_is_in_the_table_with_its_type():
    assert len(served()) > 35
    known = documented()
    for name, kind in served().items():
        assert known[name].removeprefix("std_srvs/") == (kind or known[name].split("/")[-1]), name
    assert "/run_measurement" in known


def test_the_table_has_no_service_that_nobody_serves():
    of_other_axes = {"/camber_hold/hold_deg", "/camber_hold/set_profile"}
    of_all = {"/NODE/connected", "/run_measurement"}
    assert documented().keys() - served().keys() == of_other_axes | of_all


def test_the_page_is_what_the_code_says():
    page = ROOT / "docs/reference/graph.md"
    assert page.read_text(encoding="utf-8") == graph.page(), (
        "run `python -m flatplank_validation.pages.graph docs/reference/graph.md`"
    )
    assert all(f"| `{name}` | {mode.code} |" in graph.page() for name, mode in MODES.items())
