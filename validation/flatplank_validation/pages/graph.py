# SPDX-License-Identifier: Apache-2.0
"""Generates docs/reference/graph.md from the code: topics, services, modes, parameters of nodes:
`python -m flatplank_validation.pages.graph FILE`."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator
from importlib import import_module
from pathlib import Path
from typing import NamedTuple

from flatplank_control.bench.setup import BUSES, DRIVEN, NODES, NodeSpec
from flatplank_control.recording.topics import (
    IN_CHARGE,
    LATCHED,
    REFERENCE,
    ROSOUT,
    RUN_TOPIC,
    STREAM,
    TABLE,
    Qos,
    recorded_topics,
)
from flatplank_data.params import ParamInfo, parameter_infos
from flatplank_hw.drive.modes import MODES

HEAD = """\
# The graph: topics, services, modes, parameters

Written by `python -m flatplank_validation.pages.graph docs/reference/graph.md`; a test keeps it
so. How the nodes belong together: [ARCHITECTURE.md](../../ARCHITECTURE.md).

## Topics

All are stamped with the bus cycle they come from; SI units; ISO W axes. *stream*: reliable, keep
last 2000. *latched*: reliable, transient local, depth 1. *reference*: stream with a deadline of
100 ms. *cycle*: at each bus cycle; of a batch of cycles `/bus/inputs` and `/bus/outputs` have
every cycle, the other topics the last one.
"""

SERVICES_HEAD = """
## Services and actions

Every refusal has its reason in the answer, in the log and in `/diagnostics`. A measurement goal
that is empty, or does not say what to measure, is refused before anything moves. A type without a
package is one of `flatplank_msgs`.
"""

MODES_HEAD = """
## Operation modes

`mode` in a drive's status, constants `MODE_...`.
"""

PARAMETERS_HEAD = """
## Parameters of the nodes

`ros2 param describe` shows the same. The values of this bench are in the parameter files of the
packages. *placeholder*: a value that the thesis does not have; set it for the machine. Every node
also has `autostart`, `fifo_priority` and, when it measures, `constants_from`.
"""


class Serves(NamedTuple):
    """A row of the table of services: names that share a type and a purpose."""

    names: tuple[str, ...]
    type: str
    says: str = ""


SERVICES = (
    Serves(("/slip_sequencer/set_slip_step",), "SetSlipStep",
           "kappa [-], start position [m], effective rolling radius [m]"),
    Serves(("/slip_sequencer/set_waveform",), "SetWaveform",
           "waveform over the road with its parameters"),
    Serves(("/wheel_drive/set_operation_mode",), "SetOperationMode",
           "a mode of the table below; `follow` for drives beside the wheel"),
    Serves(("/wheel_drive/enable",), "std_srvs/SetBool", "true: enable, false: disable"),
    Serves(("/wheel_drive/reset_fault", "/wheel_drive/home", "/wheel_drive/quick_stop"),
           "std_srvs/Trigger", "what the name says"),
    Serves(("/wheel_drive/move_to",), "MoveTo", "0, 120, 240, 360, 1080 deg or any"),
    Serves(("/wheel_drive/set_trigger",), "SetValue",
           "road between two pulses of the trigger output for an optical system [m]; 0: constant "
           "level, below 0: off"),
    Serves(("/load_controller/set_load",), "SetValue",
           "vertical force to hold [N], with `bench --axes vertical`"),
    Serves(("/steering_hold/hold_deg", "/camber_hold/hold_deg"), "SetValue",
           "angle to hold [deg]"),
    Serves(("/steering_hold/set_profile", "/camber_hold/set_profile"), "SetWaveform",
           "profile over time with its parameters"),
    Serves(("/operator/claim",), "Claim",
           "take charge; a heartbeat must follow, or every driven axis stops"),
    Serves(("/measurement_hub/tare",), "std_srvs/Trigger", "makes the present forces zero"),
    Serves(("/measurement_hub/set_parasitic_filter",), "std_srvs/SetBool",
           "true: the filter of the parasitic force is on"),
    Serves(("/measurement_hub/load_parasitic_fit",), "LoadParasiticFit",
           "file with the coefficients of the filter"),
    Serves(("/encoders/arm",), "std_srvs/Trigger",
           "the next motion trigger zeroes the plank position"),
    Serves(("/recorder/start",), "StartRecording", "starts a bag, with what is measured"),
    Serves(("/recorder/stop",), "StopRecording", "closes the bag, with its status"),
    Serves(("/recorder/discard",), "std_srvs/Trigger", "closes the bag and removes it"),
    Serves(("/run_measurement",), "action RunMeasurement",
           "one measurement or a campaign; prompts and progress are in the feedback"),
    Serves(("/measurement_runner/confirm",), "std_srvs/Trigger",
           "confirms that the prompted step is done"),
    Serves(("/measurement_runner/enough",), "std_srvs/Trigger",
           "ends the current run here and keeps it"),
    Serves(tuple(f"/measurement_runner/{wish}" for wish in ("repeat", "skip", "discard")),
           "std_srvs/Trigger", "in a campaign: repeats, skips or discards the current run"),
    Serves(("/ethercat_bus/sdo_read",), "SdoRead", "reads an object of a slave"),
    Serves(("/ethercat_bus/sdo_write",), "SdoWrite", "writes an object of a slave"),
    Serves(("/simulated_plant/advance",), "Advance", "cycles to run at pace `hold`"),
    Serves(("/simulated_plant/set_pace",), "SetPace", "`realtime`, `lockstep` or `hold`"),
    Serves(("/simulated_plant/plank",), "PlankSwitch", "the switch of the plank"),
    Serves(("/simulated_plant/load_to",), "SetValue",
           "vertical force [N] that the operator winds; the axis moves for seconds"),
    Serves(("/simulated_plant/set_axle_height",), "SetValue", "axle height [m]; the axis moves"),
    Serves(("/simulated_plant/set_pressure_bar",), "SetValue", "inflation pressure [bar]"),
    Serves(tuple(f"/simulated_plant/set_{angle}_deg"
                 for angle in ("steer", "wheel_camber", "road_camber")),
           "SetValue", "angle that the operator sets by hand [deg]; the axis moves"),
    Serves(("/simulated_plant/set_cleat_mm",), "SetValue",
           "height of the cleat fastened on the road [mm]; 0: none"),
    Serves(("/simulated_plant/unload",), "std_srvs/Trigger", "lifts the wheel off the road"),
    Serves(("/simulated_plant/emergency_stop",), "std_srvs/SetBool",
           "true: the emergency stop is pressed"),
    Serves(("/simulated_plant/connect_flexplates",), "std_srvs/SetBool",
           "true: the flexplates carry the hub"),
    Serves(("/NODE/connected",), "std_srvs/Trigger",
           "whether all nodes that this node needs are present"),
)  # fmt: skip
"""services and actions of the graph; a test compares the names with those that the nodes serve"""

_QOS = {STREAM: "stream", LATCHED: "latched", REFERENCE: "reference"}


def _table(heads: str, rows: Iterable[Iterable[object]]) -> Iterator[str]:
    yield f"| {heads} |"
    yield "|" + "---|" * (heads.count("|") + 1)
    for row in rows:
        yield "| " + " | ".join(str(cell).replace("|", r"\|") for cell in row) + " |"


def _topic_rows() -> Iterator[tuple[str, ...]]:
    for spec, rate, says, _ in TABLE:
        yield f"`{spec.name}`", _short(spec.type), rate, _qos(spec.qos), says
    for axis in DRIVEN:
        own = [s for s in recorded_topics([axis]) if s.name.startswith(f"/{axis}_drive/")]
        names = ", ".join(f"`{s.name}`" for s in own)
        yield (
            names, "as of the wheel", "as of the wheel", "as of the wheel",
            f"only with `bench --axes {axis}`",
        )  # fmt: skip
    for spec, rate, says in (
        (RUN_TOPIC, "start and end of a run", "the run record, YAML"),
        (IN_CHARGE, "when it changes", "the client in charge, empty: nobody; published by the "
         "wheel drive for the drives of the other axes"),
        (ROSOUT, "when a node logs", "log of all nodes; stamped by the wall clock, in the bag at "
         "the bench time of its arrival"),
    ):  # fmt: skip
        yield f"`{spec.name}`", _short(spec.type), rate, _qos(spec.qos), says
    yield (
        "`/troubles`", "diagnostic_msgs/DiagnosticArray", "1 Hz, and at each change", "depth 10",
        "each node's own troubles; the owner of the bus makes `/diagnostics` of them",
    )  # fmt: skip
    yield (
        "`/operator/heartbeat`", "std_msgs/String", "2 Hz or more, when claimed", "stream",
        "the token of the client in charge: of a panel, or, in real time, of the runner while it "
        "measures; a client of `/run_measurement` sends the `heartbeat` of its goal",
    )  # fmt: skip
    yield (
        "`/clock`", "rosgraph_msgs/Clock", "every 10 cycles, not in realtime", "stream",
        "bench time",
    )  # fmt: skip


def _short(kind: str) -> str:
    return kind.replace("/msg/", "/")


def _qos(qos: Qos) -> str:
    return _QOS.get(qos, f"depth {qos.depth}" + ", transient local" * (qos != Qos(qos.depth)))


def _service_rows() -> Iterator[tuple[str, ...]]:
    for names, kind, says in SERVICES:
        yield ", ".join(f"`{name}`" for name in names), kind, says


def _mode_rows() -> Iterator[tuple[str, ...]]:
    for name, mode in sorted(MODES.items(), key=lambda item: item[1].code):
        yield f"`{name}`", str(mode.code), (mode.__doc__ or "").splitlines()[0]


def _nodes() -> dict[str, list[NodeSpec]]:
    """Executable -> its nodes."""
    found: dict[str, list[NodeSpec]] = {}
    of_axes = [spec for nodes in DRIVEN.values() for spec in nodes]
    for spec in (*BUSES.values(), *NODES, *of_axes):
        found.setdefault(spec.module, []).append(spec)
    return found


def _number(value: float) -> str:
    return f"{value:.9g}" if isinstance(value, float) else str(value)


def _parameter_row(info: ParamInfo) -> tuple[str, ...]:
    span = " .. ".join(_number(b) for b in info.bounds) if info.bounds else ""
    default = info.default
    if isinstance(default, (list, tuple)):
        default = ", ".join(str(v) for v in default)
    elif isinstance(default, float):
        default = _number(default)
    notes = [
        info.note,
        f"one of {', '.join(info.choices)}" if info.choices else "",
        "placeholder" if info.placeholder else "",
        "read only" if info.read_only else "",
    ]
    return (
        f"`{info.name}`", str(default), info.unit, span, "; ".join(n for n in notes if n)
    )  # fmt: skip


def page() -> str:
    """The whole file."""
    lines = [HEAD, *_table("topic | type | rate | QoS | content", _topic_rows())]
    lines += [SERVICES_HEAD, *_table("name | type | what it does", _service_rows())]
    lines += [MODES_HEAD, *_table("mode | number | what the axis is told", _mode_rows())]
    lines += [PARAMETERS_HEAD.rstrip("\n")]
    for module, nodes in _nodes().items():
        infos = parameter_infos(import_module(module).NODE.PARAMETERS)
        names = ", ".join(f"`{spec.name}`" for spec in nodes)
        kind = " (emulated)" if module.endswith("emulated_bus") else ""
        lines += ["", f"### {names}{kind}", ""]
        lines += _table(
            "parameter | default | unit | range | meaning", (_parameter_row(i) for i in infos)
        )
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    Path(sys.argv[1]).write_text(page(), encoding="utf-8")
