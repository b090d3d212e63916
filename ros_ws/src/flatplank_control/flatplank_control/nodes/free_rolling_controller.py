# SPDX-License-Identifier: Apache-2.0
"""Contact force to motor torque: the shell of `flatplank_control.free_rolling`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from geometry_msgs.msg import WrenchStamped

from flatplank_control.free_rolling import FreeRollingController, FreeRollingParameters
from flatplank_control.nodes.source import SourceNode
from flatplank_hw.nodes import convert
from flatplank_hw.nodes.qos import STREAM
from flatplank_hw.nodes.support import run
from flatplank_hw.samples import Reference
from flatplank_msgs.msg import ControllerState


class FreeRollingControllerNode(SourceNode):
    """Contact wrench and encoders -> /wheel_drive/reference and ~/state."""

    PARAMETERS = FreeRollingParameters
    MODE = "free_rolling"
    KINDS = ("encoders", "contact")

    def configure(self, parameters: FreeRollingParameters) -> None:
        self.core = FreeRollingController(parameters)

    def connect(self) -> None:
        super().connect()
        self.state = ControllerState()
        self.publish_state = self.add_publisher(ControllerState, "~/state", STREAM)
        self.add_subscription(
            WrenchStamped, "/measurement_hub/wrench_contact", self.on_contact, STREAM
        )
        self.listen_to_mode()

    def on_contact(self, msg: WrenchStamped) -> None:
        if self.active:
            self.join.put("contact", convert.stamp_ns(msg.header), convert.wrench_from_msg(msg))

    def compute(self, latest: Mapping[str, Any]) -> Reference:
        encoders = latest["encoders"]
        return self.core.step(convert.hub_of_contact(latest["contact"], encoders), encoders)

    def show(self, reference: Reference) -> None:
        state = self.state
        convert.set_stamp(state.header, reference.stamp_ns)
        state.cycle = reference.cycle
        (state.reference, state.error, state.p, state.i, state.lead, state.output, state.saturated,
         state.settled) = self.core.state  # fmt: skip
        self.publish_state(state)


def main(args: list[str] | None = None) -> int:
    return run(lambda: FreeRollingControllerNode("free_rolling_controller"), args)


if __name__ == "__main__":
    raise SystemExit(main())
