# SPDX-License-Identifier: Apache-2.0
"""Set-up of a bench: one description for the ROS graph, the launch file and the twin."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from flatplank_control.bench.simulator import simulator
from flatplank_control.calibration.book import CALIBRATED, CalibrationBook, book_for
from flatplank_data.arguments import namespace_of
from flatplank_data.names import nearest_hint
from flatplank_data.yaml_text import dump_yaml
from flatplank_hw.share import packaged_parameters


class NodeSpec(NamedTuple):
    """One node of the bench."""

    package: str
    executable: str
    name: str
    in_loop: bool = False
    """true when its answer is needed within the bus cycle"""

    @property
    def module(self) -> str:
        """Module of the node; its `NODE` makes the node, its `main` runs the node alone."""
        return f"{self.package}.nodes.{self.executable}"


LOOP = "loop"
"""process of the nodes whose answers are needed within the bus cycle"""

EVERY_NODE = "every node"

MEASURING = ("measurement_hub", "encoders")
"""nodes that turn signals into measured values by calibrated constants"""

BUSES = {
    "sim": NodeSpec("flatplank_sim", "simulated_plant", "simulated_plant", True),
    "emulated": NodeSpec("flatplank_sim", "emulated_bus", "ethercat_bus", True),
    "lab": NodeSpec("flatplank_hw", "ethercat_bus", "ethercat_bus", True),
}
"""kind of bench -> node that owns its bus"""

NODES = (
    NodeSpec("flatplank_hw", "measurement_hub", "measurement_hub", True),
    NodeSpec("flatplank_hw", "encoders", "encoders", True),
    NodeSpec("flatplank_hw", "wheel_drive", "wheel_drive", True),
    NodeSpec("flatplank_control", "free_rolling_controller", "free_rolling_controller", True),
    NodeSpec("flatplank_control", "slip_sequencer", "slip_sequencer", True),
    NodeSpec("flatplank_control", "recorder", "recorder"),
    NodeSpec("flatplank_control", "measurement_runner", "measurement_runner"),
)
"""nodes that run beside the bus, with any kind of bus"""


class AxisNodes(NamedTuple):
    """Nodes of a driven axis with a controller."""

    drive: NodeSpec
    controller: NodeSpec


AXIS_NODES: dict[str, AxisNodes] = {
    "vertical": AxisNodes(
        NodeSpec("flatplank_hw", "wheel_drive", "vertical_drive", True),
        NodeSpec("flatplank_control", "load_controller", "load_controller", True),
    ),
    "steer": AxisNodes(
        NodeSpec("flatplank_hw", "wheel_drive", "steer_drive", True),
        NodeSpec("flatplank_control", "axis_hold", "steering_hold", True),
    ),
    "camber": AxisNodes(
        NodeSpec("flatplank_hw", "wheel_drive", "camber_drive", True),
        NodeSpec("flatplank_control", "axis_hold", "camber_hold", True),
    ),
}
"""axis with a controller -> its nodes"""

DRIVEN: dict[str, tuple[NodeSpec, ...]] = {
    "plank": (NodeSpec("flatplank_hw", "wheel_drive", "plank_drive", True),),
    **AXIS_NODES,
}
"""axis that may be driven beside the wheel -> its nodes, the drive first; for the plank only a
drive"""


def parse_axes(text: str, argument: str) -> tuple[str, ...]:
    """Parse a list such as `vertical,steer`; ValueError names the argument and an unknown axis."""
    axes = tuple(word.strip() for word in text.split(",") if word.strip())
    for axis in axes:
        if axis not in DRIVEN:
            raise ValueError(f"{argument}: unknown axis '{axis}'{nearest_hint(axis, DRIVEN)}")
    return axes


LOOP_PRIORITY = 20
"""SCHED_FIFO priority of the nodes in the loop, below the bus process and the emulator"""


@dataclass(frozen=True)
class BenchSetup:
    """Set-up of a bench; its parameters override those in the files of the packages."""

    kind: str = "sim"
    """a key of BUSES"""
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
    """bus file of the EtherCAT bus; empty: a packaged one with the driven axes"""
    data: str = "data"
    axes: tuple[str, ...] = ()
    """axes driven beside the wheel: keys of DRIVEN"""
    parameters: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    """node -> further parameters"""
    separate: tuple[str, ...] = ()
    """nodes with a process of their own, or `EVERY_NODE`; the others share one"""
    namespace: str = ""
    """ROS namespace of all nodes, as in `/bench2`; empty: `/`"""
    calibration: str = ""
    """calibration book with constants for the nodes; empty or missing: packaged constants"""

    @classmethod
    def from_arguments(cls, values: Mapping[str, Any], written: str) -> BenchSetup:
        """Bench set-up from arguments of a command line: field -> value, the axes as one text.

        An empty `calibration` is that of the folder `data`. `written`: form of an argument, for
        ValueError.
        """
        axes, book = values["axes"], values["calibration"]
        if book and not Path(book).is_file():
            argument = written.format("calibration", book)
            raise ValueError(f"{argument}: no such file; `flatplank calibrate` makes a book")
        path = Path(book).resolve() if book else book_for(Path(values["data"])).path
        known = {"axes": parse_axes(axes, written.format("axes", axes)), "calibration": str(path)}
        try:
            known["namespace"] = namespace_of(values["namespace"])
        except ValueError as error:
            raise ValueError(f"{written.format('namespace', '')}: {error}") from None
        return cls(**{**values, **known})

    def nodes(self) -> tuple[NodeSpec, ...]:
        """The nodes of this bench, the owner of the bus last."""
        more = [node for axis in self.axes for node in DRIVEN[axis]]
        return (*NODES, *more, BUSES[self.kind])

    def processes(self) -> dict[str, tuple[NodeSpec, ...]]:
        """The processes of this bench and their nodes.

        On the simulated plant the nodes share a process. A bus of frames has a process of its own:
        its guard stops the axes when the loop is gone. So have the recorder, which waits for the
        disk, and the runner, which waits for services.
        """
        nodes = self.nodes()
        of_frames = (
            () if self.kind == "sim" else ("ethercat_bus", "recorder", "measurement_runner")
        )
        apart = {*self.separate, *of_frames}
        shared = tuple(n for n in nodes if not apart.intersection((n.name, EVERY_NODE)))
        found = {node.name: (node,) for node in nodes if node not in shared}
        return found | ({LOOP: shared} if shared else {})

    def of(self, node: NodeSpec) -> dict[str, Any]:
        """Parameters of one node."""
        own = packaged_parameters(node.package, node.name)
        shared = {**self._shared(node.name), **self._scheduling(node)}
        book = CalibrationBook(Path(self.calibration)).parameters() if self.calibration else {}
        known = book.get(node.name, {})
        origin = self._origin_of_constants(bool(known)) if node.name in MEASURING else {}
        return {**own, **known, **origin, **shared, **self.parameters.get(node.name, {})}

    def _origin_of_constants(self, calibrated: bool) -> dict[str, str]:
        """Origin of the constants of a measuring node; of a machine without a book: none."""
        if self.kind != "lab":
            return {"constants_from": "the simulated machine"}
        return {"constants_from": self.calibration} if calibrated else {}

    def constants(self) -> dict[str, dict[str, Any]]:
        """Calibrated parameters that the nodes are given: node -> parameter -> value."""
        given = {node.name: self.of(node) for node in NODES if node.name in CALIBRATED}
        return {name: {key: given[name][key] for key in keys} for name, keys in CALIBRATED.items()}

    def _scheduling(self, node: NodeSpec) -> dict[str, int]:
        """Real-time priority in the loop of a bus of frames. The simulated plant takes its turn:
        with a priority it would stop everything else on a computer that is too slow for it."""
        return {"fifo_priority": LOOP_PRIORITY} if node.in_loop and self.kind != "sim" else {}

    def _shared(self, name: str) -> dict[str, Any]:
        rate = float(self.rate_hz)
        radius = {}
        if name == "wheel_drive" and self.kind != "lab":
            # r_0 of the simulated tire [m], by which the drive recognises an unloaded tire
            radius = {"free_radius": simulator().free_radius(self.tire)}
        of_bus = {"rate_hz": self.rate_hz, "batch": self.batch}
        machine = {
            "tire": self.tire, "preset": self.preset, "config": self.plant_file, "seed": self.seed,
        }  # fmt: skip
        of_graph = {"rate_hz": rate / self.batch}
        shared: dict[str, dict[str, Any]] = {
            "simulated_plant": {
                **machine,
                **of_bus,
                "pace": self.pace,
                **({"driven_axes": ["wheel", *self.axes]} if self.axes else {}),
            },
            "ethercat_bus": {
                **of_bus,
                "bus_file": self.bus_file or ("bench_five_axes" if self.axes else "bench"),
                **(machine if self.kind == "emulated" else {"interface": self.interface}),
            },
            "encoders": {"rate_hz": rate},
            "free_rolling_controller": of_graph,
            "slip_sequencer": of_graph,
            "wheel_drive": radius,
            "load_controller": of_graph,
            "steering_hold": of_graph,
            "camber_hold": of_graph,
            "recorder": {
                "folder": self.data,
                "calibration": self.calibration,
                "axes": ",".join(self.axes),
            },
            "measurement_runner": {
                "held": self.pace == "hold",
                "driven_plank": "plank" in self.axes,
            },
        }
        return shared.get(name, {})

    def write(self, folder: Path) -> dict[str, Path]:
        """Write one parameter file per node to `folder`; returns node name -> file."""
        folder.mkdir(parents=True, exist_ok=True)
        files = {}
        for node in self.nodes():
            path = files[node.name] = folder / f"{node.name}.yaml"
            content = {f"/**/{node.name}": {"ros__parameters": self.of(node)}}
            path.write_text(dump_yaml(content), encoding="utf-8")
        return files
