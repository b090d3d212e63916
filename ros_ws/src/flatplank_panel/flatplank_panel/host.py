# SPDX-License-Identifier: Apache-2.0
"""Starts and ends a bench for this panel, from the checked values of a page."""

from __future__ import annotations

import socket
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from flatplank_control.bench.processes import BenchProcesses
from flatplank_control.bench.setup import BUSES, BenchSetup
from flatplank_control.bench.simulator import Simulator, simulator
from flatplank_control.calibration.book import book_for
from flatplank_data.errors import FlatplankError
from flatplank_data.params import load_parameters
from flatplank_data.yaml_text import load_yaml
from flatplank_hw.ethercat.reader import read_bus_file
from flatplank_hw.share import config_file
from flatplank_panel import validation

USUAL = BenchSetup()
KINDS = {"sim": "Simulated", "emulated": "Emulated bus", "lab": "Lab"}


def simulated_tires() -> list[str]:
    """Names of the simulated tires, the usual one first; without a simulator that alone."""
    installed = _simulator()
    return list(dict.fromkeys([USUAL.tire, *(installed.tires() if installed else ())]))


def presets() -> dict[str, str]:
    """Preset of defects of the simulated machine -> its label; empty: none."""
    installed = _simulator()
    return {"": "none"} | {name: name for name in (installed.presets() if installed else ())}


def _simulator() -> Simulator | None:
    try:
        return simulator()
    except FlatplankError:  # a computer of the lab needs none
        return None


def interfaces() -> list[str]:
    """Network interfaces of this machine that can carry the bus."""
    return [name for _, name in socket.if_nameindex() if name != "lo"]


def read_parameters(path: Path) -> dict[str, dict[str, Any]]:
    """Read a ROS parameter file: node name -> parameters; ValueError names the fault."""
    try:
        content = load_yaml(path.read_bytes(), path) or {}
    except OSError as error:
        raise ValueError(f"{path}: cannot be read ({error.strerror})") from None
    if not isinstance(content, dict):
        raise ValueError(f"{path}: expected node names with 'ros__parameters:' below them")
    return {str(node): load_parameters(path, str(node)) for node in content}


class Host:
    """Starts and ends the nodes of a bench."""

    def __init__(
        self,
        data: Path,
        log: Path,
        parameters: Mapping[str, Mapping[str, Any]] | None = None,
        namespace: str = "",
    ) -> None:
        """`parameters`: node name -> parameters that override those of the packages."""
        self.namespace = namespace
        self.data, self.log, self.parameters = data, log, parameters or {}
        self.setup: BenchSetup | None = None
        self._processes: BenchProcesses | None = None
        self._reported: set[str] = set()

    @property
    def running(self) -> bool:
        return self._processes is not None

    def start(
        self,
        kind: str,
        tire: str = USUAL.tire,
        preset: str = "",
        seed: object = 1,
        rate: object = 250,
        interface: str = "",
        bus_file: str = "",
    ) -> BenchSetup:
        """Start the nodes; ValueError for an unknown value.

        `interface` and `bus_file` (a packaged name, or a file below the data folder) are used in
        the lab only.
        """
        if self._processes is not None:
            raise ValueError("a bench is running already; stop it first")
        kind = validation.choice(kind, BUSES, "bench")
        tire = validation.choice(tire, simulated_tires(), "tire")
        preset = validation.choice(preset, presets(), "preset")
        seed = int(validation.number(seed, "seed", 0, 2**31 - 1))
        rate_hz = int(validation.number(rate, "bus rate", 50, 1000, "Hz"))
        wiring = self._wiring(interface, bus_file) if kind == "lab" else ("", "")
        self.setup = BenchSetup(
            kind=kind,
            tire=tire,
            preset=preset,
            seed=seed,
            rate_hz=rate_hz,
            data=str(self.data),
            interface=wiring[0],
            bus_file=wiring[1],
            parameters=self.parameters,
            namespace=self.namespace,
            calibration=str(book_for(self.data).path),
        )
        self._processes = BenchProcesses(self.setup, log=self.log)
        self._processes.start()
        return self.setup

    def _wiring(self, interface: str, bus_file: str) -> tuple[str, str]:
        """Interface and bus file of the machine."""
        text = str(bus_file or "").strip()
        ours = config_file("flatplank_hw", f"bus/{text}.yaml") if text.isidentifier() else None
        if text and ours is None:
            path = validation.inside(self.data, text, "bus file")
            read_bus_file(path)
            text = str(path)
        return validation.choice(interface, interfaces(), "network interface"), text

    def stop(self) -> None:
        """End the nodes, if any."""
        self.setup = None
        processes, self._processes = self._processes, None
        if processes is not None:
            processes.stop()

    def newly_ended(self) -> dict[str, int]:
        """Nodes that have ended by themselves since the last call, with their exit codes."""
        ended = self._processes.ended() if self._processes else {}
        new = {name: code for name, code in ended.items() if name not in self._reported}
        self._reported = set(ended)
        return new
