# SPDX-License-Identifier: Apache-2.0
"""Node around `flatplank_hw.encoders`: counts to positions and velocities."""

from __future__ import annotations

from std_srvs.srv import Trigger

from flatplank_hw.encoders import EncoderParameters, Encoders
from flatplank_hw.nodes import convert, exchanges
from flatplank_hw.nodes.qos import STREAM
from flatplank_hw.nodes.running import run_node
from flatplank_hw.nodes.support import BenchNode


class EncodersNode(BenchNode):
    """Converts /bus/inputs to ~/state and ~/joint_states."""

    PARAMETERS = EncoderParameters
    MEASURES = True

    def configure(self, parameters: EncoderParameters) -> None:
        self.encoders = Encoders(parameters)

    def apply_changes(self, parameters: EncoderParameters) -> None:
        if hasattr(self, "encoders"):
            self.encoders.set_constants(parameters)
            self.parameters = parameters

    def connect(self) -> None:
        self.apart = False
        self.publish_state = self.add_sample_publisher(
            exchanges.ENCODERS, "~/state", STREAM, frame="bus", needed=True
        )
        self.publish_joints = self.add_sample_publisher(
            exchanges.ENCODER_JOINTS, "~/joint_states", STREAM
        )
        self.add_sample_subscription(exchanges.INPUTS, "bus/inputs", self.on_inputs, STREAM)
        self.add_request(Trigger, "~/arm", lambda _: self.encoders.arm())

    def on_inputs(self, batch: convert.Batch) -> None:
        for inputs in batch.cycles:
            sample = self.encoders.step(inputs)
        self.publish_state(sample)
        self.publish_joints(sample)
        apart = abs(sample.mismatch) > self.parameters.mismatch_limit
        if apart != self.apart:
            self.apart = apart
            detail = f"{sample.mismatch:+.4f} rad, limit {self.parameters.mismatch_limit:g} rad"
            self.troubles.set_lasting({"cross_check": detail} if apart else {}, ("cross_check",))


NODE = EncodersNode


def main(args: list[str] | None = None) -> int:
    return run_node(lambda: NODE("encoders"), args)


if __name__ == "__main__":
    raise SystemExit(main())
