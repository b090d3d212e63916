# SPDX-License-Identifier: Apache-2.0
"""Node around `flatplank_control.steering_hold`: angle of a driven steering or camber axis.

The same node runs as `steering_hold` and, with another name and file, as `camber_hold`.
"""

from __future__ import annotations

import math

from flatplank_control.nodes.source import FollowerNode, named_values
from flatplank_control.steering_hold import AngleControl, AngleParameters
from flatplank_hw.nodes.responses import fill_response
from flatplank_hw.nodes.running import run_node
from flatplank_msgs.srv import SetValue, SetWaveform


class AxisHoldNode(FollowerNode):
    """Holds the angle of its axis, or moves it along a profile, in mode follow of its drive."""

    PARAMETERS = AngleParameters

    def configure(self, parameters: AngleParameters) -> None:
        self.core = AngleControl(parameters)
        self.drive = f"{parameters.axis}_drive"

    def connect(self) -> None:
        super().connect()
        self.add_service(SetWaveform, "~/set_profile", self.on_profile)
        self.add_service(SetValue, "~/hold_deg", self.on_hold)

    def on_profile(
        self, request: SetWaveform.Request, response: SetWaveform.Response
    ) -> SetWaveform.Response:
        try:
            values = named_values(request)
        except ValueError as error:
            return fill_response(response, False, str(error))
        return fill_response(response, *self.core.set_profile(request.name, values))

    def on_hold(self, request: SetValue.Request, response: SetValue.Response) -> SetValue.Response:
        return fill_response(response, *self.core.hold(math.radians(request.value)))


NODE = AxisHoldNode


def main(args: list[str] | None = None) -> int:
    return run_node(lambda: NODE("steering_hold"), args)


if __name__ == "__main__":
    raise SystemExit(main())
