# SPDX-License-Identifier: Apache-2.0
"""An occurrence is one line in the log and stays in /diagnostics as long as it lasts."""

from __future__ import annotations

from types import SimpleNamespace

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus

from flatplank_hw.nodes import reporting
from flatplank_hw.nodes.reporting import Collector, Reporter, reporting_refusals
from flatplank_hw.troubles import DRIVE, OF_HEALTH, TROUBLES


class Terminal:
    """Stands for the logger of a node."""

    def __init__(self) -> None:
        self.lines: list[tuple[str, str]] = []

    def __getattr__(self, level: str):
        return lambda text: self.lines.append((level, text))


@pytest.fixture
def clock(monkeypatch):
    now = SimpleNamespace(value=100.0)
    monkeypatch.setattr(reporting.time, "monotonic", lambda: now.value)
    return now


@pytest.fixture
def node(clock):
    terminal, changes = Terminal(), []
    reporter = Reporter("wheel_drive", terminal, lambda: changes.append(clock.value))
    return SimpleNamespace(says=reporter, terminal=terminal, changes=changes)


def test_what_lasts_is_logged_at_its_edges_only(node, clock):
    for age in (43, 47, 51):
        node.says.begin("samples", f"{age} ms")
        clock.value += 100.0
    status = node.says.status({"cycle": 7})
    assert status.level == DiagnosticStatus.ERROR
    assert status.message == TROUBLES["samples"].line("51 ms"), "the detail is kept up to date"
    assert {v.key: v.value for v in status.values} == {"troubles": "samples", "cycle": "7"}
    assert node.terminal.lines == [("error", TROUBLES["samples"].line("43 ms"))]
    node.says.end("samples")
    node.says.end("samples")
    assert node.terminal.lines[1:] == [("info", f"over: {TROUBLES['samples'].text}")]
    assert node.says.status({}).message == "ok"
    assert len(node.changes) == 2, "published at once when something begins or ends"


def test_what_happened_is_shown_for_a_while_and_not_logged_again_meanwhile(node, clock):
    for _ in range(5):
        node.says.report_occurrence("refused", "/a: no")
        clock.value += 1.0
    node.says.report_occurrence("refused", "/b: no")
    assert [level for level, _ in node.terminal.lines] == ["warning", "warning"]
    assert node.says.status({}).message.count(TROUBLES["refused"].text) == 2
    clock.value += 11.0
    assert node.says.status({}).level == DiagnosticStatus.OK
    node.says.report_occurrence("refused", "/a: no")
    assert len(node.terminal.lines) == 3


def test_the_worst_is_first_and_other_kinds_stay(node):
    node.says.report_occurrence("refused", "/a: no")
    node.says.set_lasting({"plank_stands": "", "drag": "Fz 3700 N"}, DRIVE)
    status = node.says.status({})
    assert status.level == DiagnosticStatus.ERROR
    assert status.message.startswith(TROUBLES["drag"].text)
    node.says.set_lasting({}, DRIVE)
    assert node.says.status({}).message == TROUBLES["refused"].line("/a: no")


def test_the_health_of_the_bus_is_one_of_its_troubles_at_a_time(node):
    for name in OF_HEALTH.values():
        node.says.set_lasting({name: "slave 3"}, OF_HEALTH.values())
        assert node.says.status({}).message == TROUBLES[name].line("slave 3")
    node.says.set_lasting({}, OF_HEALTH.values())
    assert node.says.status({}).message == "ok"


def driven(coroutine):
    """Its result, run as rclpy runs the coroutine of a service: without a loop of asyncio."""
    with pytest.raises(StopIteration) as end:
        coroutine.send(None)
    return end.value.value


def test_refusals_of_services_are_told_however_they_answer(node):
    def plain(_request, response):
        return response

    async def slow(_request, response):
        return response

    no = SimpleNamespace(accepted=False, reason="too much")
    assert reporting_refusals(node.says, "/a", plain)(None, no) is no
    std = SimpleNamespace(success=False, message="not now")
    assert driven(reporting_refusals(node.says, "/b", slow)(None, std)) is std
    reporting_refusals(node.says, "/c", plain)(None, SimpleNamespace(success=True, message="done"))
    said = [text for _, text in node.terminal.lines]
    assert said == [
        f"{TROUBLES['refused'].text} (/a: too much)", f"{TROUBLES['refused'].text} (/b: not now)",
    ]  # fmt: skip


def test_a_node_that_is_not_heard_any_more_is_found(clock):
    collector = Collector()
    collector.store_status(DiagnosticArray(status=[DiagnosticStatus(name="hub", message="ok")]))
    clock.value += 5.0
    collector.store_status(DiagnosticArray(status=[DiagnosticStatus(name="drive", message="ok")]))
    assert collector.silence_by_node() == {"hub": False, "drive": False}
    clock.value += 6.0
    assert collector.silence_by_node() == {"hub": True, "drive": False}
    levels = {s.name: s.level for s in collector.statuses()}
    assert levels == {"drive": DiagnosticStatus.OK, "hub": DiagnosticStatus.STALE}
    clock.value += Collector.FORGOTTEN
    collector.silence_by_node()
    assert not collector.statuses()
