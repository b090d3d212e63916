# SPDX-License-Identifier: Apache-2.0
"""Faults on a running bus, one after the other on one bench: safe, signed, and never back by
itself."""

from __future__ import annotations

from typing import Any

import pytest
from ethercat_contract import Contract
from ethercat_rig import Bench
from ethercat_scenarios import SCENARIOS, Scenario
from stalls import undisturbed

pytestmark = pytest.mark.usefixtures("minute")


TOLD_WITHIN = 300
"""further cycles; the kernel may tell a lost carrier a second late"""


def told(bench: Bench, reason: str) -> dict[str, Any]:
    """Diagnostics as soon as they have the reason, or the last ones without it."""
    report = bench.client.diagnostics()
    last = bench.node.last.cycle + TOLD_WITHIN
    while reason not in report["reason"] and bench.node.last.cycle < last:
        bench.node.cycles(5)
        report = bench.client.diagnostics()
    return report


def break_it(bench: Bench, scenario: Scenario, contract: Contract) -> dict[str, Any]:
    """Inject the fault, insist on motion, mend it, insist again; what was seen."""
    node, emulator, client = bench.node, bench.emulator, bench.client
    before = client.diagnostics()
    emulator.send(scenario.fault, **scenario.arguments)
    sdo = bench.ask_sdo() if scenario.sdo else ""
    node.cycles(scenario.cycles)
    during, axis = told(bench, scenario.reason), node.last.axes[0]
    contract.recovers()
    contract.rests()
    return {
        "before": before,
        "during": during,
        "after": client.diagnostics(),
        "axis": axis,
        "seen": set(node.seen),
        "sdo": sdo,
        "events": str(bench.events),
    }


def check_signature(scenario: Scenario, seen: dict[str, Any]) -> None:
    """What tells this fault from the others."""
    assert set(scenario.health) <= seen["seen"]
    assert not set(scenario.never) & seen["seen"]
    assert scenario.reason in seen["during"]["reason"]
    for counter in scenario.grows:
        assert seen["after"][counter] > seen["before"][counter], counter
    steps = seen["before"]["recovery"], seen["after"]["recovery"]
    assert steps[0].get("RESCAN", 0) == steps[1].get("RESCAN", 0), "mended by less than a scan"
    for step in scenario.steps:
        taken = seen["after"]["recovery"].get(step, 0)
        assert taken > seen["before"]["recovery"].get(step, 0), step
    if scenario.stops:
        if scenario.held is not None:
            assert seen["during"]["held"].get("wheel", "") == scenario.held
        assert seen["axis"].error_code == scenario.error_code
    assert scenario.sdo in seen["sdo"]
    for text in scenario.events:
        assert text in seen["events"]


@pytest.mark.parametrize("scenario", SCENARIOS, ids=lambda s: s.name)
def test_fault(bench: Bench, scenario: Scenario) -> None:
    undisturbed(bench.stalls, lambda: one_fault(bench, scenario))


def one_fault(bench: Bench, scenario: Scenario) -> None:
    with Contract(bench, scenario.name, scenario.stops) as contract:
        seen = break_it(bench, scenario, contract)
    check_signature(scenario, seen)
