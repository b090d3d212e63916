# SPDX-License-Identifier: Apache-2.0
"""Node around `flatplank_control.free_rolling`: contact force to motor torque."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from flatplank_control.free_rolling import FreeRollingController, FreeRollingParameters
from flatplank_control.nodes.source import WheelSourceNode
from flatplank_hw.nodes import convert
from flatplank_hw.nodes.running import run_node
from flatplank_hw.samples import Reference
from flatplank_msgs.msg import ControllerState


class FreeRollingControllerNode(WheelSourceNode):
    """Publishes /wheel_drive/reference and ~/state from contact wrench and encoders."""

    PARAMETERS = FreeRollingParameters
    MODE = "free_rolling"
    STATE = ControllerState
    KINDS = ("encoders", "inputs", "contact")

    def configure(self, parameters: FreeRollingParameters) -> None:
        self.core = FreeRollingController(parameters)

    def step(self, latest: Mapping[str, Any]) -> Reference:
        encoders = latest["encoders"]
        return self.core.step(convert.hub_of_contact(latest["contact"], encoders), encoders)


NODE = FreeRollingControllerNode


def main(args: list[str] | None = None) -> int:
    return run_node(lambda: NODE("free_rolling_controller"), args)


if __name__ == "__main__":
    raise SystemExit(main())
