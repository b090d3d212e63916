# SPDX-License-Identifier: Apache-2.0
"""Every field that the shipped layouts draw is there in the messages of the bags."""

from __future__ import annotations

import json
import re
import xml.etree.ElementTree as ET

from flatplank_control.recording.topics import RECORDED
from flatplank_control.recording.typestore import typestore
from flatplank_hw.share import config_file

KINDS = {spec.name: spec.type for spec in RECORDED} | {"/run": "flatplank_msgs/msg/Run"}


def exists(path: str) -> bool:
    """`/topic.field.field` or `/topic/field/field`."""
    topic = max(
        (t for t in KINDS if re.match(re.escape(t) + r"([./]|$)", path)), key=len, default=""
    )
    fields = [f for f in re.split(r"[./]", path[len(topic) :]) if f]
    kind, store = KINDS.get(topic, ""), typestore()
    for field in fields:
        known = dict(store.fielddefs[kind][1]) if kind else {}
        if field not in known:
            return False
        kind = known[field][1] if isinstance(known[field][1], str) else ""
    return bool(topic)


def foxglove() -> list[str]:
    layout = json.loads(config_file("flatplank_control", "layouts/foxglove.json").read_text())
    panels = layout["configById"].values()
    return [p["value"] for panel in panels for p in panel.get("paths", [])] + ["/run"]


def plotjuggler() -> list[str]:
    tree = ET.parse(config_file("flatplank_control", "layouts/plotjuggler.xml"))
    return [curve.attrib["name"] for curve in tree.iter("curve")]


def test_the_check_sees_a_wrong_field():
    assert exists("/encoders/state.plank_position")
    assert not exists("/encoders/state.plank_place")
    assert not exists("/nobody.x")


def test_layouts_draw_what_is_recorded():
    for paths in (foxglove(), plotjuggler()):
        assert len(paths) > 10
        assert [p for p in paths if not exists(p)] == []
