# SPDX-License-Identifier: Apache-2.0
"""A servo drive by hand: enable, velocity, other modes; prints what it saw as JSON."""

import json
import struct
import sys

import pysoem

MASK = 0x6F
NEXT = {0x40: 0x06, 0x21: 0x07, 0x23: 0x0F, 0x27: 0x0F}


def main(interface):
    emergencies = []
    master = pysoem.Master()
    master.open(interface)
    assert master.config_init() == 5
    drive = master.slaves[0]
    drive.add_emergency_callback(lambda e: emergencies.append(e.error_code))
    master.config_map()
    master.state_check(pysoem.SAFEOP_STATE, 50_000)

    def exchange(word, mode, velocity=0):
        drive.output = struct.pack("<Hbxiii", word, mode, 0, velocity, 0)
        master.send_processdata()
        assert master.receive_processdata(20_000) == 8
        status, shown, position = struct.unpack_from("<Hbxi", drive.input)
        return status & MASK, shown, position

    exchange(0, 9)
    master.state = pysoem.OP_STATE
    master.write_state()
    path, state = [], 0
    for _ in range(50):
        state, _, start = exchange(NEXT.get(state, 0), 9)
        if not path or path[-1] != hex(state):
            path.append(hex(state))
    position = start
    for _ in range(20):
        state, _, position = exchange(0x0F, 9, velocity=50_000)
    modes = []
    for mode in (8, 9, 10):
        exchange(0x0F, mode)
        modes.append(exchange(0x0F, mode)[1])
    drive.mbx_receive()
    master.state = pysoem.INIT_STATE
    master.write_state()
    master.close()
    print(json.dumps({"path": path, "modes": modes, "moved": position - start,
                      "emergencies": emergencies}))  # fmt: skip


if __name__ == "__main__":
    main(sys.argv[1])
