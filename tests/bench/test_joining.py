# SPDX-License-Identifier: Apache-2.0
"""Samples of one cycle are brought together, whatever the order and whoever is missing."""

import itertools

from flatplank_hw.joining import CycleJoin

KINDS = ("inputs", "encoders", "hub")
STEP = 4_000_000


def joined(arrivals, kinds=KINDS, needed=None):
    calls = []
    join = CycleJoin(kinds, lambda at, latest: calls.append((at, dict(latest))))
    if needed is not None:
        join.await_kinds(needed)
    for kind, at in arrivals:
        join.put(kind, at, f"{kind}{at}")
    return calls


def test_every_order_of_arrival_gives_one_complete_call_per_cycle():
    for order in itertools.permutations(KINDS):
        arrivals = [(kind, n * STEP) for n in (1, 2, 3) for kind in order]
        calls = joined(arrivals)
        assert [at for at, _ in calls] == [STEP, 2 * STEP, 3 * STEP]
        for at, latest in calls:
            assert latest == {kind: f"{kind}{at}" for kind in KINDS}


def test_a_missing_source_is_replaced_by_its_last_sample_when_the_next_cycle_comes():
    arrivals = [(kind, STEP) for kind in KINDS]
    arrivals += [("inputs", 2 * STEP), ("encoders", 2 * STEP), ("inputs", 3 * STEP)]
    calls = joined(arrivals)
    assert [at for at, _ in calls] == [STEP, 2 * STEP]
    assert calls[1][1]["hub"] == f"hub{STEP}"


def test_a_source_that_never_spoke_is_none():
    calls = joined([("inputs", STEP), ("inputs", 2 * STEP)])
    assert calls == [(STEP, {"inputs": f"inputs{STEP}", "encoders": None, "hub": None})]


def test_a_late_sample_of_a_finished_cycle_makes_no_second_call():
    calls = joined([(k, STEP) for k in KINDS] + [("hub", STEP)])
    assert len(calls) == 1


def test_what_is_not_needed_is_not_waited_for_but_used_when_there():
    kinds = (*KINDS, "reference")
    arrivals = [("reference", STEP), *((kind, STEP) for kind in KINDS)]
    arrivals += [(kind, 2 * STEP) for kind in KINDS]
    calls = joined(arrivals, kinds, needed=KINDS)
    assert [latest["reference"] for _, latest in calls] == [f"reference{STEP}"] * 2


def test_batches_leave_out_stamps():
    arrivals = [(kind, at) for at in (4 * STEP, 8 * STEP) for kind in reversed(KINDS)]
    assert [at for at, _ in joined(arrivals)] == [4 * STEP, 8 * STEP]
