# SPDX-License-Identifier: Apache-2.0
"""Node of the real bus, around the EtherCAT master."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from concurrent.futures import Future as Errand
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rclpy.lifecycle import LifecycleState, TransitionCallbackReturn
from rclpy.task import Future

from flatplank_data.params import Params, param
from flatplank_hw.bus.commanders import CommandGate
from flatplank_hw.bus.image import BusInputs as Image
from flatplank_hw.bus.image import Health
from flatplank_hw.bus.timing import LATE, MADE, labelled
from flatplank_hw.cia402 import error_words
from flatplank_hw.ethercat.master import BusClient
from flatplank_hw.nodes import convert, exchanges
from flatplank_hw.nodes.qos import STREAM
from flatplank_hw.nodes.responses import fill_response
from flatplank_hw.nodes.running import run_node
from flatplank_hw.nodes.second_commander import COMMANDS, report_refused_commands
from flatplank_hw.nodes.support import BenchNode
from flatplank_hw.share import config_file
from flatplank_hw.troubles import OF_HEALTH
from flatplank_msgs.srv import SdoRead, SdoWrite


@dataclass(frozen=True)
class BusParameters(Params):
    """Bus file, interface and timing of the bus."""

    bus_file: str = param("bench", "bus file: a name of config/bus or a path")
    interface: str = param("", "network interface of the bus")
    rate_hz: int = param(250, "bus rate", unit="Hz", bounds=(50, 1000))
    batch: int = param(1, "cycles per message", bounds=(1, 20))
    fifo: bool = param(True, "SCHED_FIFO for the bus process where it is allowed")


EVENTS: dict[str, Callable[[dict[str, Any]], tuple[str, str]]] = {
    "recovery": lambda e: ("bus_recovery", f"{e['step'].lower()}: {e['reason']}"),
    "emergency": lambda e: ("bus_emergency", f"slave {e['slave']}: {error_words(e['code'])}"),
    "crashed": lambda e: ("bus_ended", e["reason"]),
}
"""event of the bus process -> trouble and detail; other events are no trouble"""


class EthercatBus(BenchNode):
    """Publishes /bus/inputs, subscribes to /bus/outputs; a separate process runs the cycle."""

    PARAMETERS = BusParameters
    OWNS_BUS = True

    def configure(self, p: BusParameters) -> None:
        self.period_ns = 1_000_000_000 // p.rate_hz
        path = config_file("flatplank_hw", f"bus/{p.bus_file}.yaml") or Path(p.bus_file)
        self.client = self.client_for(p, path)
        self.cycle = 0
        self.gate = CommandGate()
        self.oldest = 0
        self.health = int(Health.OK)
        self.worst = int(Health.OK)
        """worst health since the last request for diagnostics"""
        self.asked = False
        self.found: dict[str, Any] = {}
        # by the wall clock: the stamps of a restarted bus are later than those of the last one
        self.t0 = time.time_ns() // self.period_ns * self.period_ns
        # one request at a time, in a thread of its own: a command must not wait for an SDO
        self.threads = ThreadPoolExecutor(1, thread_name_prefix="bus request")
        self.client.start()

    def client_for(self, p: BusParameters, path: Path) -> BusClient:
        """Make the client of the master of this bus, not started yet."""
        return BusClient(path, p.interface, p.rate_hz, fifo=p.fifo, on_event=self.on_event)

    def connect(self) -> None:
        self.publish = self.add_sample_publisher(
            exchanges.INPUTS, "bus/inputs", STREAM, frame="bus", needed=True
        )
        self.add_sample_subscription(exchanges.COMMAND, COMMANDS, self.on_command, STREAM)
        self.add_timer(1.0, self.on_second)
        self.add_service(SdoRead, "~/sdo_read", self.on_sdo_read)
        self.add_service(SdoWrite, "~/sdo_write", self.on_sdo_write)
        self.listening = True
        self.reader = threading.Thread(target=self.read, name="bus reader", daemon=True)
        self.reader.start()

    def read(self) -> None:
        """Publish the images of the bus process, batch by batch."""
        batch: list[Image] = []
        while self.listening:
            for image in self.client.poll():
                batch.append(image)
                if image.health != self.health:
                    self.worst, self.health = max(self.worst, image.health), image.health
                    self.ask_for_diagnosis()
                if len(batch) >= self.parameters.batch:
                    self.cycle = image.cycle
                    sent = convert.batch_of(batch, self.period_ns, self.t0)
                    self.gate.send(sent.cycles[-1].stamp_ns)
                    self.publish(sent)
                    batch = []

    def on_command(self, stamped: convert.StampedCommand) -> None:
        axis = stamped.command.axis
        if not self.gate.accept(axis, stamped.stamp_ns):
            return
        if not self.gate.contested(axis):
            self.client.send(stamped.command)
        self.oldest = max(self.oldest, self.cycle - stamped.command.cycle)

    def on_event(self, event: dict[str, Any]) -> None:
        describe = EVENTS.get(event["event"])
        if describe is not None:
            self.troubles.report_occurrence(*describe(event))

    def on_second(self) -> None:
        report_refused_commands(self, self.gate)
        self.ask_for_diagnosis()

    def ask_for_diagnosis(self) -> None:
        if self.listening and not self.asked:
            self.asked = True
            self.threads.submit(self.diagnose).add_done_callback(self.on_diagnosed)

    def diagnose(self) -> None:
        """Get diagnostics from the bus process and update the troubles."""
        self.asked = False
        worst, self.worst = self.worst, self.health
        try:
            found = self.client.diagnostics()
            health = Health[found["health"]]
        except LookupError as error:
            found, health = {"reason": str(error)}, Health.LOST
        found["oldest_command_cycles"], self.oldest = self.oldest, 0
        self.found = found
        lasting = {OF_HEALTH[health]: found["reason"]} if health in OF_HEALTH else {}
        self.troubles.set_lasting(lasting, OF_HEALTH.values())
        if worst > health:
            self.troubles.report_occurrence(OF_HEALTH[Health(worst)], "it is over")
        if not self.client.alive and not self.ended:
            self.end_with_trouble("bus_ended")

    def on_diagnosed(self, done: Errand) -> None:
        """Log an exception of `diagnose`, which runs in another thread."""
        if not done.cancelled() and done.exception() is not None:
            self.get_logger().error(f"no diagnostics of the bus: {done.exception()!r}")

    def bench_ns(self) -> int:
        return self.gate.sent_ns

    def diagnostic_values(self) -> dict[str, Any]:
        found, times = dict(self.found), dict[str, float]()
        if "sent" in found:
            times = {MADE: found["sent"], LATE: found["missed"]}
            times |= labelled("frame to frame", found.pop("cycle_time"))
            times |= labelled("round trip", found.pop("round_trip"))
        return {"bus file": self.parameters.bus_file, **found, **times}

    def in_thread(self, work: Callable[..., Any], *arguments: Any) -> Future:
        """Do work that waits for the bus process in a separate thread."""
        done = Future()

        def work_in_thread() -> None:
            try:
                done.set_result(work(*arguments))
            except LookupError as error:
                done.set_exception(error)

        self.threads.submit(work_in_thread)
        return done

    async def on_sdo_read(
        self, request: SdoRead.Request, response: SdoRead.Response
    ) -> SdoRead.Response:
        place = (request.slave, request.index, request.subindex)
        try:
            data = await self.in_thread(self.client.sdo_read, *place)
        except LookupError as error:
            return fill_response(response, False, str(error))
        return fill_response(response, True, f"{len(data)} bytes read", data=list(data))

    async def on_sdo_write(
        self, request: SdoWrite.Request, response: SdoWrite.Response
    ) -> SdoWrite.Response:
        place = (request.slave, request.index, request.subindex)
        try:
            await self.in_thread(self.client.sdo_write, *place, bytes(request.data))
        except LookupError as error:
            return fill_response(response, False, str(error))
        return fill_response(response, True, f"{len(request.data)} bytes written")

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        self.stop_publishing()
        return super().on_deactivate(state)

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        self.finish()
        return super().on_cleanup(state)

    def stop_publishing(self) -> None:
        """Stop publishing images."""
        if getattr(self, "listening", False):
            self.listening = False
            self.reader.join()

    def finish(self) -> None:
        """Stop the bus in order, whatever the reason for the end of the node."""
        self.stop_publishing()
        if hasattr(self, "threads"):
            self.threads.shutdown(cancel_futures=True)
            self.client.stop()


NODE = EthercatBus


def main(args: list[str] | None = None) -> int:
    return run_node(lambda: NODE("ethercat_bus"), args)


if __name__ == "__main__":
    raise SystemExit(main())
