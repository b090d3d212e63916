# SPDX-License-Identifier: Apache-2.0
"""Requests to the emulator: a wrong one is answered at once with one clear line."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import pytest
from ethercat_rig import BUS_FILES

from flatplank_hw.ethercat.reader import read_bus_file
from flatplank_sim.emulator.bench import EmulatedBench
from flatplank_sim.emulator.control import ControlError
from flatplank_sim.emulator.faults import FAULTS, FaultTargets
from flatplank_sim.emulator.requests import RequestHandler
from flatplank_sim.emulator.wire import Wire
from flatplank_sim.nodes.emulated_bus import EmulatedBusNode
from flatplank_sim.plant import Plant, PlantConfig


@pytest.fixture(scope="module")
def handler() -> RequestHandler:
    bus = read_bus_file(BUS_FILES / "bench.yaml")
    bench = EmulatedBench(bus, Plant(PlantConfig.load("toyo")))
    targets = FaultTargets(bench, Wire(), lambda _up: None)
    return RequestHandler(targets, lambda: None, dict)


WRONG: list[tuple[str, dict[str, Any], str]] = [
    ("al_drop", {"slave": "wheel_drive", "state": "SAVEOP"}, "no state 'SAVEOP'.*SAFEOP"),
    ("al_drop", {"slave": "wheel_driv"}, "no slave 'wheel_driv'.*wheel_drive"),
    ("al_drop", {"slave": "wheel_drive", "code": 0x10000}, "code: 65536 is outside 0..65535"),
    ("al_refuse", {"slave": "wheel_drive", "state": 8}, "no state '8'"),
    ("power_off", {"slave": "nothing"}, "no slave 'nothing'"),
    ("cable_cut", {"behind": 3}, "no slave '3'"),
    ("identity", {"slave": "wheel_drive", "vendor": 2**32}, "vendor: .* is outside"),
    ("mailbox_hang", {"slave": "coupler"}, "has no mailbox"),
    ("emergency", {"slave": "wheel_drive", "code": 1, "register": 256}, "register: 256 is out"),
    ("drive_fault", {"axis": "whel"}, "no drive on axis 'whel'.*wheel"),
    ("drive_fault", {"code": 70000}, "code: 70000 is outside 0..65535"),
    ("stuck_axis", {"axis": "camber"}, "no drive on axis 'camber'"),
    ("channel", {"name": "C7", "value": 0}, "no input channel 'C7'"),
    ("channel", {"name": "C1", "value": 2**31}, "value: 2147483648 is outside"),
    ("channel", {"name": "C1", "value": "high"}, "value: 'high' is not a whole number"),
    ("lose_frames", {"frames": "some"}, "frames: 'some' is not a whole number"),
    ("hold", {"cycles": math.inf}, "cycles: inf is not a whole number"),
    ("delay", {"ms": math.inf}, "ms: inf is not a number"),
    ("lose_share", {"share": 2}, "share is 2, must be within 0..1"),
]


@pytest.mark.parametrize("when", [{}, {"after": 1}], ids=["now", "later"])
@pytest.mark.parametrize(("fault", "arguments", "reason"), WRONG, ids=lambda v: str(v)[:40])
def test_a_wrong_fault_is_refused_at_once(
    handler: RequestHandler, when: dict, fault: str, arguments: dict, reason: str
) -> None:
    with pytest.raises(ValueError, match=reason) as refusal:
        handler({"do": fault, **arguments, **when})
    assert "\n" not in str(refusal.value)
    handler.rig.bench.step()


RIGHT: dict[str, dict[str, Any]] = {
    "lose_share": {"share": 0.5}, "delay": {"ms": 1}, "counter_offset": {"offset": -1},
    "cable_cut": {"behind": "master"}, "channel": {"name": "emergency_stop_ok", "value": 0},
    "mailbox_late": {"ms": 2.5}, "emergency": {"code": 0x4210},
}  # fmt: skip
OF_SLAVE = {
    "al_drop", "al_refuse", "power_off", "power_cycle", "identity", "mailbox_hang",
    "mailbox_abort", "mailbox_late", "emergency",
}  # fmt: skip


@pytest.mark.parametrize("fault", FAULTS)
def test_a_scheduled_fault_begins_and_ends(handler: RequestHandler, fault: str) -> None:
    bench = handler.rig.bench
    arguments = RIGHT.get(fault, {}) | ({"slave": "wheel_drive"} if fault in OF_SLAVE else {})
    at = handler({"do": fault, "after": 2, **arguments})["at"]
    bench.step()
    assert bench.monitor.last_fault < bench.now
    bench.step()
    assert bench.monitor.last_fault == bench.now and bench.cycle == at
    handler({"do": "mend"})
    bench.step()


def test_an_axle_height_that_is_no_number_is_refused_in_one_line(handler: RequestHandler) -> None:
    """From the node of the emulated bus over the line of the control socket."""

    def operate(name: str, *arguments: Any) -> None:
        try:
            handler({"do": "operator", "name": name, "arguments": list(arguments)})
        except (ValueError, TypeError) as error:
            raise ControlError(str(error)) from None

    node: Any = SimpleNamespace(emulated=SimpleNamespace(operate=operate))
    with pytest.raises(ValueError, match="axle_height is nan, must be finite"):
        EmulatedBusNode.operate(node, "axle_height", math.nan)
    EmulatedBusNode.operate(node, "plank", 1, True, math.nan)
    EmulatedBusNode.operate(node, "plank", 0, True, math.nan)
