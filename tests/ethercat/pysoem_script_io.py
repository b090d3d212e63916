# SPDX-License-Identifier: Apache-2.0
"""Scan, choose PDOs, exchange, look around, and go down again; prints what it saw as JSON."""

import json
import struct
import sys

import pysoem


def choose_inputs(slave):
    slave.sdo_write(0x1C12, 0, struct.pack("B", 0))
    slave.sdo_write(0x1C13, 0, struct.pack("<BxHH", 2, 0x1A01, 0x1A03), ca=True)


def choose_outputs(slave):
    slave.sdo_write(0x8001, 2, b"\x01")
    some = [0x1603 + 4 * n for n in range(3)] + [0x160F, 0x1611, 0x1617, 0x161B, 0x161F]
    some += list(range(0x1620, 0x1628))
    slave.sdo_write(0x1C12, 0, struct.pack("<Bx16H", len(some), *some), ca=True)


def go_down(master):
    down = []
    for state in (pysoem.SAFEOP_STATE, pysoem.PREOP_STATE, pysoem.INIT_STATE):
        master.state = state
        master.write_state()
        down.append(master.state_check(state, 50_000))
    return down


def main(interface):
    seen = {}
    master = pysoem.Master()
    master.open(interface)
    assert master.config_init() == 3
    seen["names"] = [s.name for s in master.slaves]
    seen["products"] = [s.id for s in master.slaves]
    master.slaves[1].setup_func = choose_inputs
    master.slaves[2].setup_func = choose_outputs
    master.config_map()
    seen["sizes"] = [[len(s.input), len(s.output)] for s in master.slaves]
    assert master.state_check(pysoem.SAFEOP_STATE, 50_000) == pysoem.SAFEOP_STATE
    seen["dc"] = bool(master.config_dc())
    master.slaves[2].dc_sync(act=True, sync0_cycle_time=10_000_000)
    master.send_processdata()
    master.receive_processdata(20_000)
    master.state = pysoem.OP_STATE
    master.write_state()
    seen["state"] = master.state_check(pysoem.OP_STATE, 50_000)
    good = 0
    for number in range(200):
        master.slaves[2].output = bytes([number % 256] * 16)
        master.send_processdata()
        good += master.receive_processdata(20_000) == 3
    seen["cycles"], seen["good_cycles"] = 200, good
    seen["volts"] = [v * 10 / 0x8000 for v in struct.unpack("<hh", master.slaves[1].input)]
    seen["object"] = master.slaves[1].sdo_read(0x1008, 0).decode()
    try:
        master.slaves[1].sdo_read(0x5555, 0)
    except pysoem.SdoError as error:
        seen["abort"] = error.abort_code
    seen["dictionary"] = [entry.index for entry in master.slaves[1].od]
    seen["eeprom_vendor"] = struct.unpack("<I", master.slaves[2].eeprom_read(8))[0]
    seen["watchdog_ms"] = master.slaves[2].get_watchdog("processdata")
    seen["states_down"] = go_down(master)
    master.close()
    print(json.dumps(seen))


if __name__ == "__main__":
    main(sys.argv[1])
