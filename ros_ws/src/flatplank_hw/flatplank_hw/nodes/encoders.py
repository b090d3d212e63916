# SPDX-License-Identifier: Apache-2.0
"""Node around `flatplank_hw.encoders`: counts to positions and velocities."""

from __future__ import annotations

from array import array

from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger

from flatplank_hw.encoders import EncoderParameters, Encoders
from flatplank_hw.nodes import convert
from flatplank_hw.nodes.qos import STREAM
from flatplank_hw.nodes.support import BenchNode, run_node
from flatplank_hw.samples import JOINTS
from flatplank_msgs.msg import BusInputs, EncoderState


class EncodersNode(BenchNode):
    """Converts /bus/inputs to ~/state and ~/joint_states."""

    PARAMETERS = EncoderParameters

    def configure(self, parameters: EncoderParameters) -> None:
        self.encoders = Encoders(parameters)

    def apply_changes(self, parameters: EncoderParameters) -> None:
        if hasattr(self, "encoders"):
            self.encoders.set_constants(parameters)
            self.parameters = parameters

    def connect(self) -> None:
        self.apart = False
        self.state, self.joints = EncoderState(), JointState()
        self.state.header.frame_id = "bus"
        self.joints.name = list(JOINTS)
        self.publish_state = self.add_publisher(EncoderState, "~/state", STREAM, needed=True)
        self.publish_joints = self.add_publisher(JointState, "~/joint_states", STREAM)
        self.add_subscription(BusInputs, "/bus/inputs", self.on_inputs, STREAM)
        self.add_request(Trigger, "~/arm", lambda _: self.encoders.arm())

    def on_inputs(self, msg: BusInputs) -> None:
        for inputs in convert.inputs_from_msg(msg):
            sample = self.encoders.step(inputs)
        convert.encoders_to_msg(sample, self.state)
        self.publish_state(self.state)
        joints = self.joints
        joints.header.stamp = self.state.header.stamp
        joints.position = array(
            "d",
            (sample.plank_position, sample.wheel_angle, sample.steer_angle, sample.road_camber),
        )
        joints.velocity = array("d", (sample.plank_velocity, sample.wheel_velocity, 0.0, 0.0))
        self.publish_joints(joints)
        apart = abs(sample.mismatch) > self.parameters.mismatch_limit
        if apart != self.apart:
            self.apart = apart
            detail = f"{sample.mismatch:+.4f} rad, limit {self.parameters.mismatch_limit:g} rad"
            self.troubles.set_lasting({"cross_check": detail} if apart else {}, ("cross_check",))


def main(args: list[str] | None = None) -> int:
    return run_node(lambda: EncodersNode("encoders"), args)


if __name__ == "__main__":
    raise SystemExit(main())
