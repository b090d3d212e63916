# SPDX-License-Identifier: Apache-2.0
"""The graph of the bench without cores: same processes, topics, messages and fan-out, empty
callbacks.

It measures the cost of rclpy and the middleware alone. `python bare_graph.py ROLE` starts one
process.
"""

import contextlib
import sys
import time
from array import array

import rclpy
from geometry_msgs.msg import WrenchStamped
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile
from sensor_msgs.msg import JointState

from flatplank_msgs.msg import (
    BusInputs,
    BusOutputs,
    DriveStatus,
    EncoderState,
    HubState,
    Reference,
    SequencerState,
)

QOS = QoSProfile(depth=2000)
EXECUTORS = {"default": SingleThreadedExecutor, "events": EventsExecutor}
TOPICS = {
    "/bus/inputs": BusInputs,
    "/bus/outputs": BusOutputs,
    "/measurement_hub/wrench_wheel": WrenchStamped,
    "/measurement_hub/wrench_contact": WrenchStamped,
    "/measurement_hub/state": HubState,
    "/encoders/state": EncoderState,
    "/encoders/joint_states": JointState,
    "/measurement_hub/joint_states": JointState,
    "/wheel_drive/status": DriveStatus,
    "/wheel_drive/joint_states": JointState,
    "/wheel_drive/reference": Reference,
    "/slip_sequencer/state": SequencerState,
}


def filled(topic):
    """A message with the size of the real one."""
    message = TOPICS[topic]()
    if isinstance(message, BusInputs):
        message.header.frame_id = "bus"
        message.count = 1
        message.bridge_volts = array("d", [0.5] * 6)
        message.lvdt_volts = array("d", [0.5])
        for name in ("plank", "wheel", "steer", "camber", "road"):
            setattr(message, f"{name}_counts", array("i", [1]))
        message.digital = array("B", [3])
        for name, code in zip(
            ("status_word", "mode_display", "position", "velocity", "torque", "error_code"),
            "HbiiiH",
            strict=True,
        ):
            setattr(message, name, array(code, [0] * 5))
    elif isinstance(message, JointState):
        message.name = ["plank", "wheel", "steer", "road_camber"] if "enc" in topic else ["wheel"]
        message.position = message.velocity = array("d", [0.0] * len(message.name))
    return message


class Role(Node):
    """Node that publishes `out` once each of `when` has arrived; it also subscribes to `also`."""

    def __init__(self, name, when, out, also=(), raw=False):
        super().__init__(name)
        self.waiting, self.when = set(when), set(when)
        self.out = [(self.create_publisher(TOPICS[t], t, QOS).publish, filled(t)) for t in out]
        for topic in when:
            self.create_subscription(TOPICS[topic], topic, lambda m, t=topic: self.heard(t), QOS)
        for topic in also:
            self.create_subscription(TOPICS[topic], topic, lambda m: None, QOS, raw=raw)

    def heard(self, topic):
        self.waiting.discard(topic)
        if not self.waiting:
            self.waiting = set(self.when)
            for publish, message in self.out:
                publish(message)


class Bus(Role):
    """Bus node that starts the next round at each answer, and counts the rounds."""

    def __init__(self, rounds):
        super().__init__("bus", ["/bus/outputs"], ["/bus/inputs"])
        self.rounds, self.count, self.start = rounds, 0, 0.0

    def heard(self, topic):
        self.count += 1
        if self.count == self.rounds // 10:
            self.start = time.perf_counter()
        if self.count >= self.rounds:
            rate = (self.rounds - self.rounds // 10) / (time.perf_counter() - self.start)
            print(f"rate {rate:.1f}", flush=True)
            rclpy.shutdown()
            return
        super().heard(topic)

    def ready(self):
        return self.count_subscribers("/bus/inputs") >= 4 and all(
            self.count_subscribers(t) >= 1 and self.count_publishers(t) >= 1 for t in TOPICS
        )


ROLES = {
    "hub": lambda: Role(
        "hub",
        ["/bus/inputs"],
        [
            "/measurement_hub/wrench_contact",
            "/measurement_hub/state",
            "/measurement_hub/wrench_wheel",
            "/measurement_hub/joint_states",
        ],
    ),
    "encoders": lambda: Role(
        "encoders", ["/bus/inputs"], ["/encoders/state", "/encoders/joint_states"]
    ),
    "sequencer": lambda: Role(
        "sequencer", ["/encoders/state"], ["/wheel_drive/reference", "/slip_sequencer/state"]
    ),
    "controller": lambda: Role(
        "controller", [], [], ["/encoders/state", "/measurement_hub/wrench_contact"]
    ),
    "drive": lambda: Role(
        "drive",
        ["/bus/inputs", "/measurement_hub/state", "/encoders/state", "/wheel_drive/reference"],
        ["/bus/outputs", "/wheel_drive/status", "/wheel_drive/joint_states"],
    ),
    "recorder": lambda: Role("recorder", [], [], list(TOPICS), raw=True),
    "runner": lambda: Role(
        "runner",
        [],
        [],
        ["/encoders/state", "/measurement_hub/state", "/wheel_drive/status"],
        raw=True,
    ),
}


def main(role, executor, rounds=0):
    rclpy.init()
    node = Bus(rounds) if role == "bus" else ROLES[role]()
    spinner = EXECUTORS[executor]()
    spinner.add_node(node)
    if role == "bus":
        while not node.ready():
            spinner.spin_once(timeout_sec=0.05)
        time.sleep(1.0)  # the middleware connects readers shortly after it discovers them
        node.out[0][0](node.out[0][1])
    with contextlib.suppress(ExternalShutdownException, KeyboardInterrupt):
        spinner.spin()


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], int(sys.argv[3]) if len(sys.argv) > 3 else 0)
