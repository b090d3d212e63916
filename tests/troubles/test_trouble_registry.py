# SPDX-License-Identifier: Apache-2.0
"""The registry of troubles: complete, in plain words, and the same in messages and docs."""

from __future__ import annotations

import importlib.util
import re
from pathlib import Path

import pytest

from flatplank_hw.bus.image import Health
from flatplank_hw.cia402 import ERROR_CODES, State
from flatplank_hw.drive.modes import MODES
from flatplank_hw.drive.safety import REASONS, RULES, STOPS
from flatplank_hw.ethercat.master.guard import Cause
from flatplank_hw.troubles import OF_HEALTH, TROUBLES, Level
from flatplank_msgs.msg import DriveStatus
from flatplank_validation.pages.troubles import page

ROOT = Path(__file__).resolve().parents[2]
SOURCES = ROOT / "ros_ws" / "src"


@pytest.mark.parametrize("name", TROUBLES)
def test_each_says_what_is_seen_what_it_means_and_what_to_do(name):
    trouble = TROUBLES[name]
    assert len(trouble.text) > 10 and len(trouble.cause) > 20
    assert trouble.remedy or name in ("plank_stands", "refused")
    for text in (trouble.text, trouble.cause, trouble.remedy):
        assert "\n" not in text and not text.endswith(".") and text == text.strip()
    assert trouble.line("C1").startswith(f"{trouble.text} (C1)")


def test_every_stop_reason_and_every_bad_health_has_its_trouble():
    assert set(STOPS.values()) <= set(TROUBLES) and set(RULES) <= set(STOPS.values())
    assert all(TROUBLES[rule.name].level >= Level.WARN for rule in RULES.values() if rule.latching)
    assert set(OF_HEALTH) == set(Health) - {Health.OK}
    assert set(OF_HEALTH.values()) <= set(TROUBLES)


def test_what_the_guard_of_the_bus_holds_an_axis_for_has_words():
    assert {int(cause) for cause in Cause} - {0} <= set(ERROR_CODES)


def test_the_message_has_the_constants_of_the_drive():
    stops = {f"STOP_{name.upper()}": code for code, name in STOPS.items()} | {"STOP_NONE": 0}
    modes = {f"MODE_{name.upper()}": mode.code for name, mode in MODES.items()}
    said = {n: getattr(DriveStatus, n) for n in dir(DriveStatus) if n.startswith("STOP_")}
    assert said == stops
    said = {n: getattr(DriveStatus, n) for n in dir(DriveStatus) if n.startswith("MODE_")}
    assert said == modes
    assert all(getattr(DriveStatus, state.name) == state for state in State)
    assert set(REASONS) == set(STOPS) | {0}


def test_every_trouble_is_told_by_somebody():
    """Stops and health by their tables, the others by name in a node or a launch file."""
    code = "".join(
        path.read_text(encoding="utf-8")
        for package in ("flatplank_hw", "flatplank_sim", "flatplank_control", "flatplank_panel")
        for path in (SOURCES / package).rglob("*.py")
        if "troubles" not in path.parts
    )
    others = set(TROUBLES) - set(STOPS.values()) - set(OF_HEALTH.values())
    assert {name for name in others if f'"{name}"' not in code} == set()


def test_the_page_is_what_the_registry_says():
    text = (ROOT / "docs/reference/troubles.md").read_text(encoding="utf-8")
    assert text == page(), (
        "run `python -m flatplank_validation.pages.troubles docs/reference/troubles.md`"
    )
    assert len(re.findall(r"^\| `\w+` \|", text, re.MULTILINE)) == len(TROUBLES)


def test_the_definitions_name_no_table_that_is_not_there():
    for path in sorted((SOURCES / "flatplank_msgs").rglob("*.msg")):
        for document in re.findall(r"[\w/]+\.md", path.read_text(encoding="utf-8")):
            assert (ROOT / document).is_file(), (path.name, document)
        assert "table in" not in path.read_text(encoding="utf-8"), path.name


def test_the_registry_needs_no_ros():
    spec = importlib.util.find_spec("flatplank_hw.troubles")
    assert spec is not None and spec.origin is not None
    assert "rclpy" not in Path(spec.origin).read_text(encoding="utf-8")
