# SPDX-License-Identifier: Apache-2.0
"""Changes of mode while cycles are on their way: source and drive agree from which cycle on."""

import pytest
from bench_graph import graph
from std_srvs.srv import SetBool

from flatplank_msgs.msg import DriveStatus
from flatplank_msgs.srv import SetOperationMode, SetPace

pytestmark = pytest.mark.graph
CHANGES = 5
TIMEOUT_S = 120.0
"""for an answer of a bench that never rests [s]"""


@pytest.mark.parametrize(
    "separate", [(), pytest.param(("wheel_drive", "slip_sequencer"), marks=pytest.mark.long)]
)
def test_a_free_lockstep_goes_on_after_every_change_of_mode(separate, tmp_path, monkeypatch):
    with graph(tmp_path, monkeypatch, separate=separate) as bench:
        told = bench.listen(DriveStatus, "/wheel_drive/status")
        bench.advance(100)
        bench.call(SetBool, "/wheel_drive/enable", data=True)
        bench.call(SetPace, "/simulated_plant/set_pace", pace="lockstep", batch=1)
        for _ in range(CHANGES):
            for mode in ("free_rolling", "slip"):
                name = "/wheel_drive/set_operation_mode"
                asked = bench.call(SetOperationMode, name, timeout=TIMEOUT_S, mode=mode)
                told.clear()
                while not told or told[-1].cycle <= asked.cycle + 2:
                    bench.client.spin(0.2)
