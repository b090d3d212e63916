# SPDX-License-Identifier: Apache-2.0
"""A lifecycle client takes every node down and up again; the bench then measures as before."""

import pytest
from bench_graph import graph
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState, GetState

pytestmark = pytest.mark.graph
DOWN = ("deactivate", "inactive"), ("cleanup", "unconfigured")
UP = ("configure", "inactive"), ("activate", "active")
HUNDRED_MS = 25


def change(bench, node: str, wanted: str) -> str:
    """Ask a node for a transition; the state after it."""
    transition = Transition(id=getattr(Transition, f"TRANSITION_{wanted.upper()}"))
    answer = bench.client.call(ChangeState, f"/{node}/change_state", transition=transition)
    assert answer.success, (node, wanted)
    return bench.client.call(GetState, f"/{node}/get_state").current_state.label


def test_every_node_is_taken_down_and_up_and_the_bench_measures(tmp_path, monkeypatch):
    with graph(tmp_path, monkeypatch) as bench:
        for node in bench.names():
            for wanted, state in (*DOWN, *UP):
                assert change(bench, node, wanted) == state, (node, wanted)
        bench.roll(record="after")
        assert bench.wheel_turns()
        assert change(bench, "wheel_drive", "deactivate") == "inactive"
        bench.advance(HUNDRED_MS)
        assert not bench.wheel_turns(), "a drive node that is taken down stops its wheel"
        assert bench.stop_recording().cycles_lost == 0
