# SPDX-License-Identifier: Apache-2.0
"""The real bus: the shell of the EtherCAT master, or of the master on the emulated bus."""

from __future__ import annotations

import threading
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

from flatplank_hw.bus.image import BusInputs as Image
from flatplank_hw.ethercat.emulator.control import ControlError
from flatplank_hw.ethercat.emulated import EmulatedBus
from flatplank_hw.ethercat.master import BusClient
from flatplank_hw.nodes import convert
from flatplank_hw.nodes.operator_services import OperatorServices
from flatplank_hw.nodes.qos import STREAM
from flatplank_hw.nodes.support import BenchNode, answer, run
from flatplank_hw.params import Params, param
from flatplank_hw.share import config_file
from flatplank_msgs.msg import BusInputs, BusOutputs
from flatplank_msgs.srv import SdoRead, SdoWrite


@dataclass(frozen=True)
class BusParameters(Params):
    """Which bus, and how fast."""

    bus_file: str = param("bench", "bus file: a name of config/bus or a path")
    interface: str = param("", "network interface of the bus; not for the emulated one")
    rate_hz: int = param(250, "bus rate", unit="Hz", bounds=(50, 1000))
    batch: int = param(1, "cycles per message", bounds=(1, 20))
    fifo: bool = param(True, "SCHED_FIFO for the bus process where it is allowed")
    emulated: bool = param(False, "the emulated bus with the simulated plant behind it")
    tire: str = param("toyo", "of the simulated plant behind the emulated bus")
    preset: str = param("", "its defects")
    config: str = param("", "YAML file laid over it")
    seed: int = param(1, "its seed", bounds=(0, 2**31 - 1))


class EthercatBus(BenchNode):
    """Publishes /bus/inputs, takes /bus/outputs; the cycle itself runs in a process of its own."""

    PARAMETERS = BusParameters

    def configure(self, p: BusParameters) -> None:
        self.period_ns = 1_000_000_000 // p.rate_hz
        self.emulated: EmulatedBus | None = None
        path = config_file("flatplank_hw", f"bus/{p.bus_file}.yaml") or Path(p.bus_file)
        if p.emulated:
            options = {"tire": p.tire, "preset": p.preset, "config": p.config}
            options = {key: value for key, value in options.items() if value}
            self.emulated = EmulatedBus(path, p.rate_hz, seed=p.seed, options=options)
            self.client = self.emulated.client(fifo=p.fifo, on_event=self.on_event)
        else:
            self.client = BusClient(
                path, p.interface, p.rate_hz, fifo=p.fifo, on_event=self.on_event
            )
        self.cycle = 0
        self.client.start()

    def connect(self) -> None:
        self.message = BusInputs()
        self.message.header.frame_id = "bus"
        self.publish = self.speak(BusInputs, "/bus/inputs", STREAM, needed=True)
        self.publish_diagnostics = self.speak(DiagnosticArray, "/diagnostics", 10)
        self.listen(BusOutputs, "/bus/outputs", self.on_command, STREAM)
        self.every(1.0, self.on_second)
        self.serve(SdoRead, "~/sdo_read", self.on_sdo_read)
        self.serve(SdoWrite, "~/sdo_write", self.on_sdo_write)
        if self.emulated is not None:
            OperatorServices(self, self.operate, lambda: self.cycle)
        self.listening = True
        self.reader = threading.Thread(target=self.read, name="bus reader", daemon=True)
        self.reader.start()

    def operate(self, name: str, *values: Any) -> None:
        # JSON has no NaN: what is not set is left out
        known = [v for v in values if v == v]
        try:
            self.emulated.operate(name, *known)
        except ControlError as error:
            raise ValueError(str(error)) from None

    def read(self) -> None:
        """Hand on what the bus process says, batch by batch."""
        batch: list[Image] = []
        while self.listening:
            for image in self.client.poll():
                batch.append(image)
                if len(batch) >= self.parameters.batch:
                    self.cycle = image.cycle
                    convert.inputs_to_msg(batch, self.period_ns, self.message, 0)
                    self.publish(self.message)
                    batch = []

    def on_command(self, msg: BusOutputs) -> None:
        self.client.send(convert.command_from_msg(msg))

    def on_event(self, *event: Any) -> None:
        self.get_logger().warning(" ".join(str(part) for part in event))

    def on_second(self) -> None:
        found = self.client.diagnostics()
        healthy = str(found.get("health")) in ("ok", "0")
        level = DiagnosticStatus.OK if healthy else DiagnosticStatus.ERROR
        values = [KeyValue(key=str(k), value=str(v)) for k, v in found.items()]
        status = DiagnosticStatus(
            level=level,
            name="ethercat_bus",
            message=str(found.get("reason", "")),
            hardware_id=self.parameters.bus_file,
            values=values,
        )
        message = DiagnosticArray(status=[status])
        message.header.stamp = self.get_clock().now().to_msg()
        self.publish_diagnostics(message)

    def on_sdo_read(self, request, response):
        try:
            data = self.client.sdo_read(request.slave, request.index, request.subindex)
        except LookupError as error:
            return answer(response, False, str(error))
        return answer(response, True, "", data=list(data))

    def on_sdo_write(self, request, response):
        try:
            self.client.sdo_write(
                request.slave, request.index, request.subindex, bytes(request.data)
            )
        except LookupError as error:
            return answer(response, False, str(error))
        return answer(response, True, "")

    def on_deactivate(self, state):
        self.listening = False
        self.reader.join(timeout=2.0)
        return super().on_deactivate(state)

    def finish(self) -> None:
        """The bus stops in order whatever ends the node."""
        self.listening = False
        if hasattr(self, "client"):
            self.client.stop()
        if getattr(self, "emulated", None) is not None:
            self.emulated.close()


def main(args: list[str] | None = None) -> int:
    return run(lambda: EthercatBus("ethercat_bus"), args)


if __name__ == "__main__":
    raise SystemExit(main())
