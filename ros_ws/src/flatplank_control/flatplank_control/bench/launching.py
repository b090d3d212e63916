# SPDX-License-Identifier: Apache-2.0
"""Arguments of `ros2 launch` and messages at its end, for the launch file."""

from __future__ import annotations

import signal
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from flatplank_control.bench.setup import DRIVEN, EVERY_NODE, BenchSetup
from flatplank_control.bench.simulator import simulator
from flatplank_data.names import nearest_hint
from flatplank_hw.bus.pacing import PACES
from flatplank_hw.share import config_file
from flatplank_hw.troubles import TROUBLES


class Argument(NamedTuple):
    """One argument of the launch file."""

    default: str
    text: str
    choices: tuple[str, ...] = ()


ARGUMENTS = {
    "sim": Argument("false", "true: simulated plant instead of the bus", ("true", "false")),
    "tire": Argument("toyo", "simulated tire: toyo, continental, michelin, racing or a file"),
    "preset": Argument("", "defects of the simulated machine, for instance thesis2023"),
    "seed": Argument("1", "of the simulated plant"),
    "pace": Argument("realtime", "of the simulated plant's bench time", PACES),
    "rate_hz": Argument("250", "bus rate [Hz], 50 to 1000"),
    "batch": Argument("1", "bus cycles per message"),
    "interface": Argument("", "network interface of the bus, in the lab"),
    "bus": Argument("", "bus file of the EtherCAT bus; empty: ours, with placeholders"),
    "data": Argument("data", "folder for the bags"),
    "calibration": Argument("", "book of the calibrations; empty: of data, else the one here"),
    "separate": Argument("false", "true: every node in a process of its own", ("true", "false")),
    "namespace": Argument("", "of all nodes, as in bench2; two benches may run side by side"),
    "axes": Argument("", f"driven beside the wheel, of {','.join(DRIVEN)}"),
}


def check_argument_names(command_line: Sequence[str]) -> None:
    """Raise ValueError for an unknown `name:=value`, which launch itself accepts silently."""
    for word in command_line:
        name, is_argument, _ = word.partition(":=")
        if is_argument and name not in ARGUMENTS:
            raise ValueError(f"unknown argument '{name}'{nearest_hint(name, ARGUMENTS)}")


def setup_of(value: Mapping[str, str]) -> BenchSetup:
    """Bench set-up from the arguments; ValueError with one line."""
    for name, argument in ARGUMENTS.items():
        if argument.choices and value[name] not in argument.choices:
            known = ", ".join(argument.choices)
            raise ValueError(f"{name}:={value[name]}: must be one of {known}")
    sim = value["sim"] == "true"
    bus, data = value["bus"], value["data"]
    if not sim and not value["interface"]:
        raise ValueError(
            "sim is false and interface is empty: give interface:=NAME in the lab (`ip link` "
            "lists them), or sim:=true without the machine"
        )
    if bus and not config_file("flatplank_hw", f"bus/{bus}.yaml") and not Path(bus).is_file():
        raise ValueError(f"bus:={bus}: no such bus file; give a path, or leave it empty")
    if Path(data).expanduser().is_file():
        raise ValueError(f"data:={data}: is a file; give a folder")
    others = ("sim", "bus", "separate")
    texts = {name: text for name, text in value.items() if name not in others}
    numbers = {
        "seed": _number("seed", value["seed"], 0, 2**31 - 1),
        "rate_hz": _number("rate_hz", value["rate_hz"], 50, 1000),
        "batch": _number("batch", value["batch"], 1, 50),
    }
    separate = (EVERY_NODE,) if value["separate"] == "true" else ()
    kind = {"kind": "sim" if sim else "lab", "bus_file": bus, "separate": separate}
    setup = BenchSetup.from_arguments({**texts, **numbers, **kind}, "{}:={}")
    if sim:
        try:
            simulator().check(setup.tire, setup.preset)
        except (ValueError, OSError) as error:
            raise ValueError(" ".join(str(error).split())) from None
    return setup


def why_ended(name: str, code: int) -> str:
    """Message for a node whose end has ended the bench."""
    how = f"ended by {signal.Signals(-code).name}" if code < 0 else f"exit code {code}"
    return TROUBLES["node_ended"].line(f"{name}, {how}")


def _number(name: str, value: str, low: int, high: int) -> int:
    try:
        number = int(value)
    except ValueError:
        raise ValueError(f"{name}:={value}: must be a whole number") from None
    if not low <= number <= high:
        raise ValueError(f"{name}:={value}: must be within {low} .. {high}")
    return number
