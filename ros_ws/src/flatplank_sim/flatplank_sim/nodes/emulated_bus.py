# SPDX-License-Identifier: Apache-2.0
"""Node of the emulated EtherCAT bus, with the same master as the real bus."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from flatplank_data.params import param
from flatplank_hw.ethercat.master import BusClient
from flatplank_hw.nodes.ethercat_bus import BusParameters, EthercatBus
from flatplank_hw.nodes.running import run_node
from flatplank_sim.emulated import EmulatedBus
from flatplank_sim.emulator.control import ControlError
from flatplank_sim.nodes.operator_services import OperatorServices


@dataclass(frozen=True)
class EmulatedBusParameters(BusParameters):
    """Parameters of the bus and of the simulated plant behind it."""

    wait_for_nodes: bool = param(
        True,
        "the bus waits for the nodes; false: as a machine, which stops when commands are older "
        "than 44 ms",
    )
    tire: str = param("toyo", "tire of the simulated plant behind the bus")
    preset: str = param("", "defects of the simulated plant; empty: none")
    config: str = param("", "YAML file laid over the plant's own; empty: none")
    seed: int = param(1, "seed of the simulated plant", bounds=(0, 2**31 - 1))


class EmulatedBusNode(EthercatBus):
    """The bus node on an emulated bus, with services for the operator's switches."""

    PARAMETERS = EmulatedBusParameters

    def client_for(self, p: Any, path: Path) -> BusClient:
        options = {"tire": p.tire, "preset": p.preset, "config": p.config}
        self.emulated: EmulatedBus | None = EmulatedBus(
            path,
            p.rate_hz,
            seed=p.seed,
            options={key: value for key, value in options.items() if value},
            wait_for_nodes=p.wait_for_nodes,
        )
        return self.emulated.client(fifo=p.fifo, on_event=self.on_event, batch=p.batch)

    def connect(self) -> None:
        OperatorServices(self, self.operate, lambda: self.cycle)
        super().connect()

    def operate(self, name: str, *values: Any) -> None:
        if self.emulated is None:
            raise ValueError("the emulated bus has ended")
        try:
            self.emulated.operate(name, *values)
        except ControlError as error:
            raise ValueError(str(error)) from None

    def finish(self) -> None:
        """End the master, then the emulated bus."""
        super().finish()
        emulated = getattr(self, "emulated", None)
        if emulated is not None:
            emulated.close()
            self.emulated = None


NODE = EmulatedBusNode


def main(args: list[str] | None = None) -> int:
    return run_node(lambda: NODE("ethercat_bus"), args)


if __name__ == "__main__":
    raise SystemExit(main())
