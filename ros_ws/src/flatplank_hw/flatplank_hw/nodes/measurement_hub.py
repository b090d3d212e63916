# SPDX-License-Identifier: Apache-2.0
"""Node around `flatplank_hw.hub`: bridge volts to forces and moments."""

from __future__ import annotations

from std_srvs.srv import SetBool, Trigger

from flatplank_hw.hub import HubParameters, MeasurementHub
from flatplank_hw.nodes import convert, exchanges
from flatplank_hw.nodes.qos import STREAM
from flatplank_hw.nodes.running import run_node
from flatplank_hw.nodes.support import BenchNode
from flatplank_hw.samples import flagged
from flatplank_msgs.srv import LoadParasiticFit


class MeasurementHubNode(BenchNode):
    """Converts /bus/inputs to ~/wrench_wheel, ~/wrench_contact, ~/state and ~/joint_states."""

    PARAMETERS = HubParameters
    MEASURES = True

    def configure(self, parameters: HubParameters) -> None:
        self.hub = MeasurementHub(parameters)

    def apply_changes(self, parameters: HubParameters) -> None:
        if hasattr(self, "hub"):
            self.hub.set_constants(parameters)
            self.parameters = parameters

    def connect(self) -> None:
        self.reported = 0
        """channels whose saturation was reported, as bits"""
        self.reported_tare_reason = ""
        self.publish_wheel = self.add_sample_publisher(
            exchanges.WRENCH, "~/wrench_wheel", STREAM, frame="wheel_center"
        )
        self.publish_contact = self.add_sample_publisher(
            exchanges.WRENCH, "~/wrench_contact", STREAM, frame="contact_point", needed=True
        )
        self.publish_state = self.add_sample_publisher(
            exchanges.HUB, "~/state", STREAM, frame="contact_point", needed=True
        )
        self.publish_joints = self.add_sample_publisher(
            exchanges.HUB_JOINTS, "~/joint_states", STREAM
        )
        self.add_sample_subscription(exchanges.INPUTS, "bus/inputs", self.on_inputs, STREAM)
        hub = self.hub
        self.add_request(Trigger, "~/tare", lambda _: hub.tare())
        self.add_request(SetBool, "~/set_parasitic_filter", lambda r: hub.set_filter(r.data))
        self.add_request(LoadParasiticFit, "~/load_parasitic_fit", lambda r: hub.load_fit(r.file))

    def on_inputs(self, batch: convert.Batch) -> None:
        saturated = 0
        for inputs in batch.cycles:
            sample = self.hub.step(inputs)
            saturated |= sample.saturated
        self.publish_contact(convert.StampedWrench(sample.stamp_ns, sample.contact))
        self.publish_state(sample)
        self.publish_joints(sample)
        self.publish_wheel(convert.StampedWrench(sample.stamp_ns, sample.wheel))
        if saturated != self.reported:
            self.reported = saturated
            names = flagged(saturated)
            self.troubles.set_lasting(
                {"saturated": ", ".join(names)} if names else {}, ("saturated",)
            )
        reason = self.hub.tare_status.reason
        if reason != self.reported_tare_reason:
            self.reported_tare_reason = reason
            if reason:
                self.troubles.report_occurrence("tare_given_up", reason)


NODE = MeasurementHubNode


def main(args: list[str] | None = None) -> int:
    return run_node(lambda: NODE("measurement_hub"), args)


if __name__ == "__main__":
    raise SystemExit(main())
