# SPDX-License-Identifier: Apache-2.0
"""What a bench is made of: one description for the ROS graph, the launch file and the twin."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml

from flatplank_control.bench.node_specs import BUSES, DRIVEN, NODES, NodeSpec
from flatplank_control.bench.simulator import simulator
from flatplank_control.calibration.book import CALIBRATED, Book
from flatplank_data.params import load_parameters
from flatplank_hw.share import config_file

LOOP_PRIORITY = 20
"""SCHED_FIFO of the nodes in the loop, below the bus process and the emulator"""

FOLLOW_UNTIL = 0.25
"""the wheel makes up a late start before the earliest slip at 0.3 m [m]"""


@dataclass(frozen=True)
class BenchSetup:
    """A bench to be started; parameters come from the packages' files, then from here."""

    kind: str = "sim"
    tire: str = "toyo"
    preset: str = ""
    plant_file: str = ""
    seed: int = 1
    rate_hz: int = 250
    batch: int = 1
    pace: str = "realtime"
    interface: str = ""
    """network interface of the bus, in the lab"""
    bus_file: str = ""
    """of the EtherCAT bus; empty: one of ours with the axes that are driven"""
    data: str = "data"
    axes: tuple[str, ...] = ()
    """driven beside the wheel: keys of DRIVEN"""
    parameters: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    """more parameters, by node name"""
    calibration: str = ""
    """book whose constants the nodes take; empty, or no such file: those of the packages"""

    def nodes(self) -> tuple[NodeSpec, ...]:
        """The processes of this bench, the owner of the bus last."""
        more = [node for axis in self.axes for node in DRIVEN[axis]]
        return (*NODES, *more, BUSES[self.kind])

    def of(self, node: NodeSpec) -> dict[str, Any]:
        """Parameters of one node."""
        path = config_file(node.package, f"{node.name}.yaml")
        own = load_parameters(path, node.name) if path else {}
        shared = {**self._shared(node.name), **self._scheduling(node)}
        known = self._calibrated().get(node.name, {})
        return {**own, **known, **shared, **self.parameters.get(node.name, {})}

    def _calibrated(self) -> dict[str, dict[str, Any]]:
        return Book(Path(self.calibration)).parameters() if self.calibration else {}

    def constants(self) -> dict[str, dict[str, Any]]:
        """What the nodes are given of all that is calibrated: node -> parameter -> value."""
        given = {node.name: self.of(node) for node in NODES if node.name in CALIBRATED}
        return {name: {key: given[name][key] for key in keys} for name, keys in CALIBRATED.items()}

    def _scheduling(self, node: NodeSpec) -> dict[str, int]:
        """A bench that runs by the clock must not wait for other work of the computer."""
        by_the_clock = self.kind != "sim" or self.pace == "realtime"
        return {"fifo_priority": LOOP_PRIORITY} if node.in_loop and by_the_clock else {}

    def _shared(self, name: str) -> dict[str, Any]:
        rate = float(self.rate_hz)
        graph_rate = rate / self.batch
        machine = {
            "tire": self.tire,
            "preset": self.preset,
            "config": self.plant_file,
            "seed": self.seed,
        }
        shared: dict[str, dict[str, Any]] = {
            "simulated_plant": {
                **machine,
                "rate_hz": self.rate_hz,
                "batch": self.batch,
                "pace": self.pace,
                **({"driven_axes": ["wheel", *self.axes]} if self.axes else {}),
            },
            "ethercat_bus": {
                "rate_hz": self.rate_hz,
                "batch": self.batch,
                "bus_file": self.bus_file or ("bench_five_axes" if self.axes else "bench"),
                **(machine if self.kind == "emulated" else {"interface": self.interface}),
            },
            "encoders": {"rate_hz": rate},
            "free_rolling_controller": {"rate_hz": graph_rate, "automatic": True},
            "slip_sequencer": {"rate_hz": graph_rate, "follow_until": FOLLOW_UNTIL},
            "wheel_drive": self._free_radius(),
            "load_controller": {"rate_hz": graph_rate, "enabled": True},
            "steering_hold": {"rate_hz": graph_rate, "enabled": True},
            "camber_hold": {"rate_hz": graph_rate, "enabled": True, "axis": "camber"},
            "recorder": {"folder": self.data, "calibration": self.calibration},
            "measurement_runner": {
                "held": self.pace == "hold",
                "driven_plank": "plank" in self.axes,
            },
        }
        return shared.get(name, {})

    def _free_radius(self) -> dict[str, float]:
        """r_0 of the simulated tire, by which the drive knows an unloaded one [m]."""
        if self.kind == "lab":
            return {}
        return {"free_radius": simulator().free_radius(self.tire)}

    def write(self, folder: Path) -> dict[str, Path]:
        """One parameter file per node in `folder`; node name -> file."""
        folder.mkdir(parents=True, exist_ok=True)
        files = {}
        for node in self.nodes():
            path = files[node.name] = folder / f"{node.name}.yaml"
            content = {node.name: {"ros__parameters": self.of(node)}}
            path.write_text(yaml.safe_dump(content, sort_keys=False), encoding="utf-8")
        return files
