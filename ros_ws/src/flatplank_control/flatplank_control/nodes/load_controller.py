# SPDX-License-Identifier: Apache-2.0
"""Node around `flatplank_control.load_control`: vertical force to axle speed."""

from __future__ import annotations

from flatplank_control.load_control import LoadController, LoadParameters
from flatplank_control.nodes.source import FollowerNode
from flatplank_hw.nodes.responses import fill_response
from flatplank_hw.nodes.running import run_node
from flatplank_msgs.srv import SetValue


class LoadControllerNode(FollowerNode):
    """Holds Fz while `vertical_drive` is in mode follow."""

    PARAMETERS = LoadParameters
    drive = "vertical_drive"

    def configure(self, parameters: LoadParameters) -> None:
        self.core = LoadController(parameters)

    def connect(self) -> None:
        super().connect()
        self.add_service(SetValue, "~/set_load", self.on_load)

    def on_load(self, request: SetValue.Request, response: SetValue.Response) -> SetValue.Response:
        try:
            self.core.set_load(request.value)
        except ValueError as error:
            return fill_response(response, False, str(error))
        ramp = self.core.parameters.ramp
        done = f"Fz goes to {request.value:g} N, at {ramp:g} N/s at most"
        return fill_response(response, True, done)


NODE = LoadControllerNode


def main(args: list[str] | None = None) -> int:
    return run_node(lambda: NODE("load_controller"), args)


if __name__ == "__main__":
    raise SystemExit(main())
