# SPDX-License-Identifier: Apache-2.0
"""The frames of the bench, by its URDF: joints as the nodes publish them, signs of ISO W."""

from __future__ import annotations

import math
from xml.etree import ElementTree

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from flatplank_data.limits import LIMITS
from flatplank_hw.samples import JOINTS, RADIUS_JOINT
from flatplank_hw.share import config_file

ROBOT = ElementTree.parse(config_file("flatplank_control", "bench.urdf")).getroot()
JOINT_OF = {joint.find("child").get("link"): joint for joint in ROBOT.iter("joint")}


def pose(link: str, **values: float) -> tuple[Rotation, np.ndarray]:
    """Rotation and position [m] of a link in the frame of the bench, for values of the joints."""
    rotation, position = Rotation.identity(), np.zeros(3)
    while link in JOINT_OF:
        joint = JOINT_OF[link]
        mimic = joint.find("mimic")
        name = joint.get("name") if mimic is None else mimic.get("joint")
        axis = np.array(joint.find("axis").get("xyz").split(), float) * values.get(name, 0.0)
        if joint.get("type") == "prismatic":
            turn, shift = Rotation.identity(), axis
        else:
            turn, shift = Rotation.from_rotvec(axis), np.zeros(3)
        rotation, position = turn * rotation, turn.apply(position) + shift
        link = joint.find("parent").get("link")
    return rotation, position


def test_the_joints_are_those_that_the_nodes_publish():
    own = {j.get("name") for j in ROBOT.iter("joint") if j.find("mimic") is None}
    assert own == {*JOINTS, RADIUS_JOINT}
    links = {link.get("name") for link in ROBOT.iter("link")}
    assert {"wheel_center", "contact_point"} <= links, "frames of the wrenches"
    assert links - JOINT_OF.keys() == {"bench"}


def test_the_contact_point_is_below_the_wheel_by_the_loaded_radius():
    at = {"steer": 0.3, "wheel": 1.0, "loaded_radius": 0.305}
    assert pose("wheel_center", **at)[1] - pose("contact_point", **at)[1] == pytest.approx(
        [0.0, 0.0, 0.305]
    )


def test_positive_angles_are_those_of_iso_w():
    heading = pose("contact_point", steer=0.1)[0].apply([1.0, 0.0, 0.0])
    assert heading == pytest.approx([math.cos(0.1), -math.sin(0.1), 0.0]), "turned to the right"
    wheel_on_road = pose("road", road_camber=0.1)[0].inv() * pose("wheel_center")[0]
    top = wheel_on_road.apply([0.0, 0.0, 1.0])
    assert top[1] < 0.0 < top[2], "a positive camber leans the top to the right"
    rolled = pose("wheel", wheel=0.1)[0].apply([0.0, 0.0, 1.0])
    assert rolled[0] > 0.0, "a wheel that rolls forward moves its top forward"
    assert pose("plank", plank=1.0)[1] == pytest.approx([-1.0, 0.0, 0.0])


def test_the_limit_of_the_road_camber_is_that_of_the_machine():
    limit = JOINT_OF["road"].find("limit")
    low, high = (math.radians(v) for v in LIMITS["road_camber_deg"].bounds)
    assert float(limit.get("lower")) == pytest.approx(low, abs=1e-4)
    assert float(limit.get("upper")) == pytest.approx(high, abs=1e-4)
