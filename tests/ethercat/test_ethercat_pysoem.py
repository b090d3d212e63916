# SPDX-License-Identifier: Apache-2.0
"""pysoem on its own, used as its users do: scan, PDO choice, read-out, states, SDOs, EEPROM,
modes."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

from ethercat_rig import BUS_FILES, Emulator, namespace

from flatplank_hw.ethercat.reader import read_bus_file
from flatplank_hw.ethercat.writer import write_bus
from flatplank_sim.emulated import MASTER

HERE = Path(__file__).parent
DEVICES = HERE / "data" / "pysoem_devices.yaml"


def run_script(script: str, bus: Path) -> dict[str, Any]:
    """A script of its own process that knows nothing of this project; it prints JSON."""
    with namespace() as ns:
        emulator = Emulator(ns, bus, "--plant", "ethercat_stub_plant:make")
        try:
            words = [*ns.enter, sys.executable, str(HERE / script), MASTER]
            result = subprocess.run(words, capture_output=True, text=True, check=False, timeout=30)
        finally:
            emulator.close()
    assert result.returncode == 0, result.stderr
    return json.loads(result.stdout)


def test_scan_choose_pdos_and_read() -> None:
    seen = run_script("pysoem_script_io.py", DEVICES)
    assert seen["names"] == ["EK1100", "EL3002", "EL1259"]
    assert seen["products"] == [0x044C2C52, 0x0BBA3052, 0x04EB3052]
    assert seen["sizes"] == [[0, 0], [4, 0], [0, 16]]
    assert [round(v, 3) for v in seen["volts"]] == [1.0, -2.0]
    assert seen["state"] == 8 and seen["good_cycles"] == seen["cycles"]
    assert seen["object"] == "EL3002" and seen["abort"] == 0x06020000
    assert 0x1018 in seen["dictionary"] and seen["eeprom_vendor"] == 2
    assert seen["watchdog_ms"] == 100.0
    assert seen["states_down"] == [4, 2, 1]


def test_drive_state_and_mode_change(tmp_path: Path) -> None:
    """The drive of our bus by plain process data: to operation enabled, another mode, reset."""
    bus = read_bus_file(BUS_FILES / "minimal.yaml")
    path = tmp_path / "bus.yaml"
    path.write_text(write_bus(replace(bus, watchdog_ms=100)))
    seen = run_script("pysoem_script_drive.py", path)
    assert seen["path"] == ["0x40", "0x21", "0x23", "0x27"]
    assert seen["modes"] == [8, 9, 10]
    assert seen["moved"] > 0 and seen["emergencies"] == []
