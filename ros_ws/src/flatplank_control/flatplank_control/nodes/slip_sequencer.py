# SPDX-License-Identifier: Apache-2.0
"""Node around `flatplank_control.sequencer`: slip over plank position to wheel velocity."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from std_msgs.msg import String

from flatplank_control.nodes.source import WheelSourceNode, named_values
from flatplank_control.sequencer import SequencerParameters, SlipSequencer
from flatplank_data.yaml_text import dump_yaml
from flatplank_hw.answers import Answer
from flatplank_hw.nodes.qos import LATCHED
from flatplank_hw.nodes.responses import fill_response
from flatplank_hw.nodes.running import run_node
from flatplank_hw.samples import EncoderSample, Reference
from flatplank_msgs.msg import SequencerState
from flatplank_msgs.srv import SetSlipStep, SetWaveform


class SlipSequencerNode(WheelSourceNode):
    """Publishes /wheel_drive/reference and ~/state from the encoders; waveforms by service."""

    PARAMETERS = SequencerParameters
    MODE = "slip"
    STATE = SequencerState

    def configure(self, parameters: SequencerParameters) -> None:
        self.core = SlipSequencer(parameters)

    def apply_changes(self, parameters: SequencerParameters) -> None:
        if hasattr(self, "core"):
            self.core.set_constants(parameters)
            self.parameters = parameters

    def connect(self) -> None:
        super().connect()
        self.publish_waveform = self.add_publisher(String, "~/waveform", LATCHED)
        self.add_service(SetSlipStep, "~/set_slip_step", self.on_step)
        self.add_service(SetWaveform, "~/set_waveform", self.on_waveform)

    def on_encoders(self, sample: EncoderSample) -> None:
        super().on_encoders(sample)
        if not self.active:
            self.core.watch(sample.plank_position, sample.cycle)

    def step(self, latest: Mapping[str, Any]) -> Reference:
        return self.core.step(latest["encoders"])

    def on_step(
        self, request: SetSlipStep.Request, response: SetSlipStep.Response
    ) -> SetSlipStep.Response:
        done = self.core.set_slip_step(
            request.kappa, request.start_position, request.effective_rolling_radius
        )
        return self.answer(response, done)

    def on_waveform(
        self, request: SetWaveform.Request, response: SetWaveform.Response
    ) -> SetWaveform.Response:
        try:
            values = named_values(request)
        except ValueError as error:
            return fill_response(response, False, str(error))
        at, radius = request.start_position, request.effective_rolling_radius
        return self.answer(response, self.core.set_waveform(request.name, values, at, radius))

    def answer(self, response: Any, done: Answer) -> Any:
        """Answer a request, and publish the waveform that was set."""
        if done.accepted:
            self.publish_waveform(String(data=dump_yaml(self.core.waveform)))
        return fill_response(response, *done)


NODE = SlipSequencerNode


def main(args: list[str] | None = None) -> int:
    return run_node(lambda: NODE("slip_sequencer"), args)


if __name__ == "__main__":
    raise SystemExit(main())
