# SPDX-License-Identifier: Apache-2.0
"""The bench that this panel has started itself, if any."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml

from flatplank_control.bench.node_specs import BUSES
from flatplank_control.bench.processes import BenchProcesses
from flatplank_control.bench.setup import BenchSetup
from flatplank_control.calibration.book import book_for
from flatplank_control.panel import validation
from flatplank_hw.params import load_parameters

TIRES = ("toyo", "continental", "michelin", "racing")
PRESETS = ("", "thesis2023")
KINDS = {"sim": "Simulated", "emulated": "Emulated bus", "lab": "Lab"}


def read_parameters(path: Path) -> dict[str, dict[str, Any]]:
    """A ROS parameter file: node name -> parameters; ValueError names the fault."""
    try:
        content = yaml.safe_load(path.read_text(encoding="utf-8")) or {}
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise ValueError(f"{path}: cannot be read ({' '.join(str(error).split())})") from None
    if not isinstance(content, dict):
        raise ValueError(f"{path}: expected node names with 'ros__parameters:' below them")
    return {str(node): load_parameters(path, str(node)) for node in content}


class Host:
    """Starts and ends the nodes of a bench."""

    def __init__(
        self, data: Path, log: Path, parameters: Mapping[str, Mapping[str, Any]] | None = None
    ) -> None:
        """`parameters`: by node name, laid over those of the packages."""
        self.data, self.log, self.parameters = data, log, parameters or {}
        self.setup: BenchSetup | None = None
        self._processes: BenchProcesses | None = None

    @property
    def running(self) -> bool:
        return self._processes is not None

    def start(
        self, kind: str, tire: str, preset: str, seed: object = 1, rate: object = 250
    ) -> BenchSetup:
        """Start the nodes; ValueError when something is not known."""
        if self._processes is not None:
            raise ValueError("a bench is running already; stop it first")
        self.setup = BenchSetup(
            kind=validation.choice(kind, BUSES, "bench"),
            tire=validation.choice(tire, TIRES, "tire"),
            preset=validation.choice(preset, PRESETS, "preset"),
            seed=int(validation.number(seed, "seed", 0, 2**31 - 1)),
            rate_hz=int(validation.number(rate, "bus rate", 50, 1000, "Hz")),
            data=str(self.data),
            parameters=self.parameters,
            calibration=str(book_for(self.data).path),
        )
        self._processes = BenchProcesses(self.setup, log=self.log)
        self._processes.start()
        return self.setup

    def stop(self) -> None:
        """End the nodes; nothing happens when there are none."""
        processes, self._processes = self._processes, None
        if processes is not None:
            processes.stop()

    def ended(self) -> dict[str, int]:
        """Nodes that have ended by themselves."""
        return self._processes.ended() if self._processes else {}
