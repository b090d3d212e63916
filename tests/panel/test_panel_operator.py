# SPDX-License-Identifier: Apache-2.0
"""The operator's actions without a browser: refusals, stops, claims, heartbeats, constants."""

from __future__ import annotations

import math
import re
from types import SimpleNamespace
from unittest.mock import MagicMock

import pytest
from own_loop import finished as run
from panel_samples import samples

from flatplank_panel.bench_state import BenchState, Progress
from flatplank_panel.host import Host
from flatplank_panel.link import Reply
from flatplank_panel.operator import Operator
from flatplank_panel.validation import CONSTANTS
from flatplank_panel.views import page


class Answers:
    """A bench that notes what it is asked and says yes, or says no."""

    def __init__(self, reason: str = "") -> None:
        self.state, self.asked, self.reason = BenchState(), [], reason
        self.beats: list[str] = []
        self.claimed_by = ""
        self.offered = {"emergency_stop"}

    def done(self):
        """What was asked but for the claims."""
        return [a for a in self.asked if a[0] != "claim"]

    async def ask(self, request, **fields):
        self.asked.append((request, fields))
        if request == "claim":
            return Reply(not self.claimed_by, f"'{self.claimed_by}' is in charge", {"token": "me"})
        return Reply(not self.reason, self.reason, {"token": "me"})

    async def set_parameters(self, node, values):
        return await self.ask(f"parameters of {node}", **values)

    async def get_parameters(self, node, names):
        return dict.fromkeys(names, 0.0)

    async def measure(self, plan, folder, simulated):
        return await self.ask("measure", plan=plan, folder=folder, simulated=simulated)

    async def cancel(self):
        return await self.ask("cancel")

    def send_heartbeat(self, token):
        self.beats.append(token)

    def offers(self, request):
        return request in self.offered

    def nodes(self):
        return ["simulated_plant"]


class Clock:
    """Instead of `time`."""

    now = 0.0

    def monotonic(self):
        return self.now

    @staticmethod
    def strftime(_format):
        return ""


@pytest.fixture
def bench(tmp_path):
    link = Answers()
    operator = Operator(link, Host(tmp_path, tmp_path / "log"), tmp_path)
    operator.take_charge("me", "me")
    return operator


def test_a_node_that_ends_by_itself_is_told_once(bench, monkeypatch):
    ended = {}
    monkeypatch.setattr(bench.host, "_processes", SimpleNamespace(ended=lambda: dict(ended)))
    bench.log_ended_nodes()
    assert not bench.link.state.log
    ended["encoders"] = -9
    bench.log_ended_nodes()
    bench.log_ended_nodes()
    ((at, line),) = bench.link.state.log
    assert line.startswith("encoders has ended by itself (exit code -9)")
    assert re.fullmatch(r"[0-2]\d:[0-5]\d:[0-5]\d", at)


@pytest.mark.parametrize(
    "fault, shown",
    [(ValueError("the tire stands"), "the tire stands"), (KeyError("x"), "KeyError: 'x'")],
)
def test_whatever_goes_wrong_behind_a_button_is_said(bench, monkeypatch, caplog, fault, shown):
    said = []
    monkeypatch.setattr(page.ui, "notify", lambda text, **_: said.append(text))
    client = MagicMock(id="me")

    def work():
        raise fault

    assert run(page.Page(bench, MagicMock(), client).run_action(work)) is None
    assert len(said) == 1 and shown in said[0]
    assert bool(caplog.records) == isinstance(fault, KeyError)


def test_only_the_page_in_charge_acts(bench):
    run(bench.enable("me", True))
    with pytest.raises(ValueError, match="only watches"):
        run(bench.enable("other", True))
    assert bench.link.done() == [("enable", {"data": True})]
    run(bench.emergency_stop("other"))
    assert {r for r, _ in bench.link.done()[1:]} == {"quick_stop", "emergency_stop"}


def test_stop_says_what_it_has_done(bench):
    assert run(bench.emergency_stop("other")) == "STOP: wheel stops; plank stops"
    bench.link.offered.clear()
    assert "the plank is stopped by its own switch" in run(bench.emergency_stop("other"))
    bench.link.reason = "no answer"
    with pytest.raises(ValueError, match="wheel NOT stopped: no answer"):
        run(bench.emergency_stop("other"))


@pytest.mark.parametrize(
    "act",
    [
        lambda o: o.enable("me", True),
        lambda o: o.move_plank("me", 1),
        lambda o: o.measure("me", {}, ""),
        lambda o: o.set_mode("me", "velocity", 0.1),
    ],
)
def test_nothing_moves_while_another_panel_has_the_drive(bench, act):
    bench.link.claimed_by = "panel-other"
    with pytest.raises(ValueError, match="'panel-other' is in charge"):
        run(act(bench))
    assert bench.link.done() == []
    for stop in (bench.enable("me", False), bench.quick_stop("me"), bench.move_plank("me", 0)):
        run(stop)
    assert len(bench.link.done()) == 3


def test_whatever_moves_is_asked_for_with_a_claim_that_holds(bench):
    """A pause in the beats may have ended the claim of before."""
    for _ in range(2):
        bench.link.asked.clear()
        run(bench.enable("me", True))
        assert [r for r, _ in bench.link.asked] == ["claim", "enable"]


def test_every_public_action_asks_who_it_is(bench):
    """Walks the operator's methods: a new one is checked by being there."""
    open_to_all = {
        "take_charge",
        "release_page",
        "register_heartbeat",
        "supervise",
        "emergency_stop",
        "constants",
        "add_to_log",
    }
    open_to_all.add("log_ended_nodes")
    values = {"mode": "velocity", "what": "steer", "name": "x", "plan": {}}
    for name in [n for n in vars(Operator) if not n.startswith("_") and n not in open_to_all]:
        method = getattr(bench, name)
        names = method.__code__.co_varnames[1 : method.__code__.co_argcount]
        arguments = [values.get(n, 0) for n in names[1:]]
        with pytest.raises(ValueError, match="only watches"):
            run(method("other", *arguments))
    assert bench.link.asked == []


def test_refusals_of_the_bench_come_back(tmp_path):
    operator = Operator(Answers("the tire stands"), Host(tmp_path, tmp_path / "log"), tmp_path)
    operator.take_charge("me", "me")
    with pytest.raises(ValueError, match="the tire stands"):
        run(operator.move_to("me", 120))


def test_beats_go_on_only_with_a_claim(bench):
    bench.register_heartbeat("me")
    assert bench.link.beats == []
    bench.link.state.accept(samples(1), math.inf)  # for ever fresh
    run(bench.supervise())
    bench.register_heartbeat("me")
    bench.register_heartbeat("other")
    assert bench.link.beats == ["me"]


def test_the_claim_is_renewed_and_given_back(bench, monkeypatch):
    clock = Clock()
    monkeypatch.setattr("flatplank_panel.operator.time", clock)
    bench.take_charge("me", "me")
    bench.link.state.accept(samples(1), math.inf)
    for _ in range(30):
        clock.now += 0.1
        bench.register_heartbeat("me")
        run(bench.supervise())
    assert len(bench.link.asked) in (3, 4)
    bench.charge.release_page("me")
    run(bench.supervise())
    assert bench.link.asked[-1] == ("claim", {"client": ""})


@pytest.mark.parametrize(("until", "goes_on"), [(9.0, True), (11.0, False)])
@pytest.mark.parametrize("reason", ["", "no answer in time; STOP stops the wheel"])
def test_a_measurement_ends_with_the_page_that_is_gone(bench, monkeypatch, until, goes_on, reason):
    """Also while the wheel rests, where no heartbeat is missed: it would turn again unwatched."""
    clock = Clock()
    monkeypatch.setattr("flatplank_panel.operator.time", clock)
    bench.take_charge("me", "me")
    bench.link.state.accept(samples(1), math.inf)
    bench.link.state.progress, bench.link.reason = Progress(active=True), reason
    while clock.now < until:
        clock.now += 0.5
        run(bench.supervise())
    cancelled = [a for a in bench.link.asked if a[0] == "cancel"]
    assert len(cancelled) == (0 if goes_on else 1)
    assert (bench.link.asked[-1] == ("claim", {"client": ""})) is not goes_on
    said = " ".join(text for _, text in bench.link.state.log)
    assert ((reason or "measurement is being stopped") in said) is not goes_on


def test_a_page_that_takes_over_keeps_the_measurement(bench, monkeypatch):
    clock = Clock()
    monkeypatch.setattr("flatplank_panel.operator.time", clock)
    bench.take_charge("me", "me")
    bench.link.state.accept(samples(1), math.inf)
    bench.link.state.progress = Progress(active=True)
    clock.now = 10.5
    bench.take_charge("other", "other")
    run(bench.supervise())
    assert ("cancel", {}) not in bench.link.asked


def test_constants_are_those_of_the_nodes(bench):
    run(bench.set_constants("me", {"et_value": 0.05, "slip_angle_offset_deg": 1}))
    assert dict(bench.link.asked) == {
        "parameters of measurement_hub": {"et_value": 0.05},
        "parameters of encoders": {"slip_angle_offset_deg": 1.0},
    }
    with pytest.raises(ValueError, match="not known"):
        run(bench.set_constants("me", {"k_fx1": 1.0}))
    assert len(CONSTANTS) == 5


def test_who_sets_things_by_hand_is_asked_of_the_bench(bench):
    for there in (True, False):
        bench.link.offered = {"load_to"} if there else set()
        run(bench.measure("me", "name: x", ""))
        assert bench.link.asked[-1][1]["simulated"] is there
