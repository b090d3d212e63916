# SPDX-License-Identifier: Apache-2.0
"""Node around `flatplank_hw.hub`: bridge volts to forces and moments."""

from __future__ import annotations

from geometry_msgs.msg import WrenchStamped
from std_srvs.srv import SetBool, Trigger

from flatplank_hw.hub import HubParameters, MeasurementHub
from flatplank_hw.nodes import convert
from flatplank_hw.nodes.qos import STREAM
from flatplank_hw.nodes.support import BenchNode, run_node
from flatplank_hw.samples import flagged
from flatplank_msgs.msg import BusInputs, HubState
from flatplank_msgs.srv import LoadParasiticFit


class MeasurementHubNode(BenchNode):
    """Converts /bus/inputs to ~/wrench_wheel, ~/wrench_contact and ~/state."""

    PARAMETERS = HubParameters

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
        self.wheel, self.contact, self.state = WrenchStamped(), WrenchStamped(), HubState()
        self.wheel.header.frame_id = "wheel_center"
        self.contact.header.frame_id = self.state.header.frame_id = "contact_point"
        self.publish_wheel = self.add_publisher(WrenchStamped, "~/wrench_wheel", STREAM)
        self.publish_contact = self.add_publisher(
            WrenchStamped, "~/wrench_contact", STREAM, needed=True
        )
        self.publish_state = self.add_publisher(HubState, "~/state", STREAM, needed=True)
        self.add_subscription(BusInputs, "/bus/inputs", self.on_inputs, STREAM)
        hub = self.hub
        self.add_request(Trigger, "~/tare", lambda _: hub.tare())
        self.add_request(SetBool, "~/set_parasitic_filter", lambda r: hub.set_filter(r.data))
        self.add_request(LoadParasiticFit, "~/load_parasitic_fit", lambda r: hub.load_fit(r.file))

    def on_inputs(self, msg: BusInputs) -> None:
        saturated = 0
        for inputs in convert.inputs_from_msg(msg):
            sample = self.hub.step(inputs)
            saturated |= sample.saturated
        convert.hub_to_msg(sample, self.state)
        convert.wrench_to_msg(sample.contact, sample.stamp_ns, self.contact)
        convert.wrench_to_msg(sample.wheel, sample.stamp_ns, self.wheel)
        self.publish_contact(self.contact)
        self.publish_state(self.state)
        self.publish_wheel(self.wheel)
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


def main(args: list[str] | None = None) -> int:
    return run_node(lambda: MeasurementHubNode("measurement_hub"), args)


if __name__ == "__main__":
    raise SystemExit(main())
