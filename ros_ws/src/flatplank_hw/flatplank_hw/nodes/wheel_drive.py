# SPDX-License-Identifier: Apache-2.0
"""Node of one drive, around `flatplank_hw.drive`. Other axes run the same node with another name
and file.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from rclpy.qos import QoSProfile
from std_msgs.msg import String
from std_srvs.srv import SetBool, Trigger

from flatplank_hw.answers import Answer, refused
from flatplank_hw.bus.image import AXES
from flatplank_hw.drive import AxisDrive, DriveParameters
from flatplank_hw.drive.modes import MODES
from flatplank_hw.joining import CycleJoin
from flatplank_hw.nodes import convert, exchanges
from flatplank_hw.nodes.partners import LOOK_S, Partners
from flatplank_hw.nodes.qos import LATCHED, REFERENCE, STREAM
from flatplank_hw.nodes.responses import fill_response
from flatplank_hw.nodes.running import run_node
from flatplank_hw.nodes.support import BenchNode
from flatplank_hw.troubles import DRIVE
from flatplank_msgs.srv import Claim, MoveTo, SetOperationMode, SetValue

REFERENCES = {"reference", "reference_gone"}
"""safety rules of an axis that follows references"""


class DriveNode(BenchNode):
    """Answers /bus/inputs with /bus/outputs and ~/status, from hub, encoders and the reference of
    the active source."""

    PARAMETERS = DriveParameters

    def configure(self, parameters: DriveParameters) -> None:
        self.drive = AxisDrive(parameters)
        self.linear = parameters.unit == "m"

    def connect(self) -> None:
        axis = self.parameters.axis
        self.join = CycleJoin(("inputs", "encoders", "hub", "reference"), self.on_cycle)
        self.partners = Partners()
        self.published_mode = ""
        self.reported: tuple[int, int, bool, bool] | None = None
        self.publish = self.add_sample_publisher(
            exchanges.COMMAND, "bus/outputs", STREAM, frame=axis, needed=True
        )
        self.publish_status = self.add_sample_publisher(
            exchanges.DRIVE, "~/status", STREAM, frame=axis
        )
        self.publish_joints = self.add_sample_publisher(
            exchanges.joint_of_axis(axis), "~/joint_states", STREAM
        )
        self.publish_mode = self.add_sample_publisher(
            exchanges.MODE, "~/mode", LATCHED, frame=axis
        )
        self.publish_mode_change(0, self.drive.mode)
        self.add_timer(LOOK_S, self.await_partners)
        self.add_sample_subscription(exchanges.INPUTS, "bus/inputs", self.on_inputs, STREAM)
        self.join_topic("hub", exchanges.HUB, "measurement_hub/state")
        self.join_topic("encoders", exchanges.ENCODERS, "encoders/state")
        led = not REFERENCES.isdisjoint(self.parameters.rules)
        self.join_topic("reference", exchanges.REFERENCE, "~/reference", REFERENCE, led)
        drive = self.drive
        self.add_service(SetOperationMode, "~/set_operation_mode", self.on_mode)
        self.add_service(MoveTo, "~/move_to", self.on_move)
        self.add_request(
            SetBool, "~/enable", lambda r: self.enable() if r.data else drive.disable()
        )
        self.add_request(SetValue, "~/set_trigger", lambda r: drive.set_trigger(r.value))
        self.add_request(Trigger, "~/reset_fault", lambda _: drive.reset_fault())
        self.add_request(Trigger, "~/home", lambda _: drive.home())
        self.add_request(Trigger, "~/quick_stop", lambda _: drive.quick_stop())
        if axis == AXES[0]:
            # only one service of this name: the wheel's drive answers and informs the others
            self.add_service(Claim, "operator/claim", self.on_claim)
            self.publish_in_charge = self.add_publisher(String, "operator/in_charge", LATCHED)
        else:
            adopt = self.drive.adopt_claim
            self.add_subscription(
                String, "operator/in_charge", lambda m: adopt(m.data), LATCHED, needed=False
            )
        self.add_subscription(String, "operator/heartbeat", self.on_heartbeat, 10, needed=False)

    # samples
    def on_inputs(self, batch: convert.Batch) -> None:
        inputs = batch.cycles[-1]
        self.join.put("inputs", inputs.stamp_ns, inputs)

    def join_topic(
        self,
        kind: str,
        exchange: exchanges.Exchange,
        topic: str,
        qos: QoSProfile = STREAM,
        needed: bool = True,
    ) -> None:
        """Subscribe to a topic and join its samples by cycle."""

        def take(sample: Any) -> None:
            self.join.put(kind, sample.stamp_ns, sample)
            if self.partners.heard(kind):
                self.await_partners()

        count = self.add_sample_subscription(exchange, topic, take, qos, needed=needed)
        self.partners.add(kind, count, each_cycle=kind != "reference")

    def on_cycle(self, at: int, latest: Mapping[str, Any]) -> None:
        command, sample = self.drive.step(
            latest["inputs"], latest["encoders"], latest["hub"], latest["reference"]
        )
        if self.drive.mode != self.published_mode:
            self.publish_mode_change(at, self.drive.mode)
        self.publish(convert.StampedCommand(sample.stamp_ns, command))
        self.publish_status(sample)
        self.publish_joints(sample)
        drive = self.drive
        seen = (
            sample.stop_reason, sample.error_code, drive.plank_drags_wheel, drive.does_not_stop
        )  # fmt: skip
        if seen != self.reported:
            self.reported = seen
            self.troubles.set_lasting(drive.troubles, DRIVE)

    def publish_mode_change(self, stamp_ns: int, mode: str) -> None:
        """Publish the mode, because each source works only in its own mode. Await references only
        in a mode that has a source. `stamp_ns`: of the last cycle before that [ns]."""
        self.published_mode = mode
        self.publish_mode(convert.StampedMode(stamp_ns, mode))
        self.await_partners()

    def await_partners(self) -> None:
        """Await the samples of this mode in each cycle. Until each of their nodes has spoken, and
        when one has gone, await none, as the others may lack its samples: the rules on stale
        samples act."""
        led = bool(MODES[self.published_mode].source)
        kinds = set(self.join.kinds) - (set() if led else {"reference"})
        self.partners.look()
        lacking = self.partners.silent & kinds
        self.join.await_kinds(self.join.kinds[:1] if lacking else kinds)

    # requests
    def enable(self) -> Answer:
        """Enable the drive of a connected bench."""
        missing = ", ".join(self.missing_partners())
        if missing:
            return refused(f"not connected: no partner on {missing}; start the nodes of the bench")
        return self.drive.enable()

    def on_mode(
        self, request: SetOperationMode.Request, response: SetOperationMode.Response
    ) -> SetOperationMode.Response:
        done = self.drive.set_operation_mode(request.mode, request.value)
        return fill_response(response, *done)

    def on_move(self, request: MoveTo.Request, response: MoveTo.Response) -> MoveTo.Response:
        target = request.angle_deg if self.linear else math.radians(request.angle_deg)
        done = self.drive.move_to(target, request.velocity)
        return fill_response(response, *done)

    def on_claim(self, request: Claim.Request, response: Claim.Response) -> Claim.Response:
        client = request.client
        done = self.drive.claim(client) if client else self.drive.release()
        if done.accepted:
            self.publish_in_charge(String(data=client))
        return fill_response(response, *done, token=client)

    def on_heartbeat(self, msg: String) -> None:
        self.drive.heartbeat(msg.data)


NODE = DriveNode


def main(args: list[str] | None = None) -> int:
    return run_node(lambda: NODE("wheel_drive"), args)


if __name__ == "__main__":
    raise SystemExit(main())
