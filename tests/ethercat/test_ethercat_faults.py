# SPDX-License-Identifier: Apache-2.0
"""Faults on a running bus, one after the other on one bench: safe, signed, and never back by
itself."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
from ethercat_rig import ATTEMPTS, Bench, Stalls
from ethercat_scenarios import SCENARIOS, WITHIN_MS, Scenario

pytestmark = pytest.mark.usefixtures("minute")


@pytest.fixture(scope="module")
def bench() -> Iterator[Bench]:
    rig = Bench()
    rig.unload()
    yield rig
    rig.close()


def break_it(bench: Bench, scenario: Scenario) -> dict[str, Any]:
    """Inject the fault, insist on motion, mend it, insist again; what was seen."""
    node, emulator, client = bench.node, bench.emulator, bench.client
    before, enables = client.diagnostics(), emulator.wheel()["enables"]
    emulator.send(scenario.fault, **scenario.arguments)
    node.cycles(scenario.cycles)
    during, axis = client.diagnostics(), node.last.axes[0]
    emulator.send("mend")
    if scenario.again:
        node.run(lambda i: i.health == 0, what="bus well again")
    node.cycles(40)
    client.events()
    return {
        "before": before,
        "during": during,
        "after": client.diagnostics(),
        "axis": axis,
        "wheel": emulator.wheel(),
        "enables": enables,
        "seen": set(node.seen),
        "events": str(bench.events),
    }


def check_motion(scenario: Scenario, seen: dict[str, Any]) -> None:
    """At the shaft of the plant."""
    wheel = seen["wheel"]
    assert wheel["enables"] == seen["enables"], "enabled by itself"
    if scenario.stops:
        print(f"{scenario.name}: the wheel rests after {wheel['ran_on_ms']:g} ms")
        assert not wheel["moving"] and not wheel["enabled"]
        assert wheel["ran_on_ms"] <= WITHIN_MS
    else:
        assert wheel["moving"] and wheel["enabled"]


def check_signature(scenario: Scenario, seen: dict[str, Any]) -> None:
    """What tells this fault from the others."""
    assert set(scenario.health) <= seen["seen"]
    assert not set(scenario.never) & seen["seen"]
    assert scenario.reason in seen["during"]["reason"]
    for counter in scenario.grows:
        assert seen["after"][counter] > seen["before"][counter], counter
    steps = seen["before"]["recovery"], seen["after"]["recovery"]
    assert steps[0].get("RESCAN", 0) == steps[1].get("RESCAN", 0), "mended by less than a scan"
    for rung in scenario.rungs:
        taken = seen["after"]["recovery"].get(rung, 0)
        assert taken > seen["before"]["recovery"].get(rung, 0), rung
    if scenario.stops:
        if scenario.held is not None:
            assert seen["during"]["held"].get("wheel", "") == scenario.held
        assert seen["axis"].error_code == scenario.error_code
    for text in scenario.events:
        assert text in seen["events"]


@pytest.mark.parametrize("scenario", SCENARIOS, ids=lambda s: s.name)
def test_fault(bench: Bench, scenario: Scenario) -> None:
    for _ in range(ATTEMPTS):
        bench.revive()
        stalls = Stalls(bench)
        seen = break_it(bench, scenario)
        if not stalls:
            break
    check_motion(scenario, seen)
    check_signature(scenario, seen)


def test_next_measurement_runs_after_a_reset(bench: Bench) -> None:
    bench.revive()
    assert bench.emulator.wheel()["moving"]
    bench.node.rest()
    assert not bench.emulator.wheel()["moving"]
