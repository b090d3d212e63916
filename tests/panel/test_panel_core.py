# SPDX-License-Identifier: Apache-2.0
"""Parts of the panel without a browser: rings, charge, validation, guard, live data, operator."""

from __future__ import annotations

import json
import math
from types import SimpleNamespace
from unittest.mock import MagicMock

import numpy as np
import pytest
from own_loop import finished as run

from flatplank_control.sequencer.waveforms import WAVEFORMS
from flatplank_hw.bus.image import AXES, AxisInputs, BusInputs
from flatplank_hw.samples import DriveSample, EncoderSample, HubSample, Wrench
from flatplank_panel import validation as check
from flatplank_panel.access import COOKIE, Guard, address, host_of, is_loopback
from flatplank_panel.analysis.worker import plain
from flatplank_panel.bench_state import BEHIND, BenchState, Ring, Samples, Slip
from flatplank_panel.charge import HOLDER_TIMEOUT_S, NotInCharge, PageInCharge
from flatplank_panel.host import Host
from flatplank_panel.link import Reply
from flatplank_panel.live import LiveData, script
from flatplank_panel.operator import Operator
from flatplank_panel.signals import SIGNALS
from flatplank_panel.validation import CONSTANTS
from flatplank_panel.views import page
from flatplank_panel.views.drive import preview

COLUMN = {signal.key: i for i, signal in enumerate(SIGNALS)}


def samples(cycle: int, fz: float = 1.0) -> Samples:
    """One complete set."""
    stamp = cycle * 4_000_000
    axes = (AxisInputs(0x27, 9, 0, 0, 0, 0),) * len(AXES)
    wrench = Wrench(1.0, 2.0, fz, 4.0, 5.0, 6.0)
    return Samples(
        BusInputs(cycle, stamp, (0.0,) * 6, 0.0, 0, 0, 0, 0, 0, 2, 0, axes),
        HubSample(cycle, stamp, wrench, wrench, 0.31, 0.0, fz, False, 0),
        EncoderSample(
            cycle, stamp, 0.5, 0.03, 1.0, 0.1, 0.0, 0.0, math.nan, 0.0, 0.0, True, True, 0.0
        ),
        DriveSample(cycle, stamp, 4, 3, 1.0, 0.1, 0.2, math.nan, 0.1, math.nan, 0, 0),
    )


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

    def beat(self, token):
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
    operator.take("me", "me")
    return operator


def test_ring_forgets_the_oldest():
    ring = Ring(4, 2)
    for i in range(11):
        ring.push((i, -i))
    assert ring.serial == 11
    assert ring.since(9).tolist() == [[9, -9], [10, -10]]
    assert ring.since(0)[:, 0].tolist() == [7, 8, 9, 10]
    assert ring.since(11).shape == (0, 2)


def test_state_takes_a_row_per_new_cycle_and_stays_small():
    state = BenchState()
    for cycle in (1, 1, 2, 3):
        state.accept(samples(cycle, 10.0 * cycle), cycle * 0.05)
    assert state.ring.serial == 3
    assert state.ring.since(0)[:, COLUMN["fz"]].tolist() == [10.0, 20.0, 30.0]
    assert state.words(0.2)["state"] == "operation enabled"
    assert state.words(9.0)["bench"] == "not running"
    assert [a["axis"] for a in state.axes(0.2)] == list(AXES)
    assert state.axes(9.0) == []


def test_samples_far_behind_the_bus_are_missing():
    """The hub has died: no number of its last sample is shown or drawn."""
    state = BenchState()
    for cycle in range(0, BEHIND + 100, 50):
        now = samples(cycle)
        now.hub = samples(0).hub
        now.slip = Slip(0, 0.1, 0.1)
        state.accept(now, 0.0)
    gone = np.isnan(state.ring.since(0))
    for key in ("fx", "mz", "rl", "slip", "slip_ref"):
        assert gone[:, COLUMN[key]].tolist() == [False] * 6 + [True], key
    assert not gone[:, [COLUMN[key] for key in ("t", "x", "vel")]].any()
    assert "filter" not in state.words(0.0) and "plank" in state.words(0.0)


def test_another_bus_begins_with_an_empty_table():
    """Neither rows nor samples of the bus before it are mixed in."""
    state = BenchState()
    live = LiveData(state)
    for cycle in (1000, 1010):
        state.accept(samples(cycle), 0.0)
    live.tick()
    state.accept(samples(1020), 0.0)
    begins = samples(3)
    begins.hub = samples(1020).hub
    state.accept(begins, 0.0)
    message = strict(live.tick())
    assert message["begun"] == 3 and message["serial"] == 4
    (row,) = message["rows"]
    assert row[COLUMN["t"]] == 0.0 and row[COLUMN["fz"]] is None
    assert state.ring.since(0).shape[0] == 1


def test_a_node_that_ends_by_itself_is_told_once(bench, monkeypatch):
    ended = {}
    monkeypatch.setattr(bench.host, "_processes", SimpleNamespace(ended=lambda: dict(ended)))
    bench.log_ended_nodes()
    assert not bench.link.state.log
    ended["encoders"] = -9
    bench.log_ended_nodes()
    bench.log_ended_nodes()
    (line,) = [text for _, text in bench.link.state.log]
    assert line.startswith("encoders has ended by itself (exit code -9)")


def strict(message: dict) -> dict:
    """As the browser gets it."""
    return json.loads(json.dumps(message, allow_nan=False))


def test_live_message_is_strict_json_with_what_is_new():
    state = BenchState()
    live = LiveData(state)
    state.accept(samples(1), 0.0)
    first = strict(live.tick())
    again = strict(live.tick())
    assert len(first["rows"]) == 1 and len(first["rows"][0]) == len(SIGNALS)
    assert first["rows"][0][COLUMN["pos_ref"]] is None
    assert again["rows"] == [] and again["serial"] == 1


def test_nothing_in_a_message_ends_its_script():
    text = script({"name": "</script><!-- & '\u2028"})
    assert not set("<>&\u2028") & set(text)
    assert json.loads(text) == {"name": "</script><!-- & '\u2028"}


def test_one_in_charge_until_it_is_silent():
    charge = PageInCharge()
    charge.take("a", "first", 0.0)
    with pytest.raises(NotInCharge, match="first is in charge"):
        charge.take("b", "second", HOLDER_TIMEOUT_S - 0.1)
    assert charge.beat("a", 1.0) and not charge.beat("b", 1.0)
    assert not charge.expire(0.9 + HOLDER_TIMEOUT_S)
    assert charge.expire(1.1 + HOLDER_TIMEOUT_S)
    charge.take("b", "second", 1.2 + HOLDER_TIMEOUT_S)
    with pytest.raises(NotInCharge):
        charge.check("a")
    charge.check("b")


@pytest.mark.parametrize("value", ["nan", math.inf, None, "1e999", "x", "", 11])
def test_numbers_are_checked(value):
    with pytest.raises(ValueError, match="load"):
        check.number(value, "load", 0.0, 10.0, "N")


@pytest.mark.parametrize("path", ["..", "/etc/passwd", "a/../../b", "a\x00b", "x" * 600])
def test_paths_stay_inside(tmp_path, path):
    with pytest.raises(ValueError):
        check.inside(tmp_path, path)


def test_links_do_not_lead_out(tmp_path):
    inside = tmp_path / "data"
    inside.mkdir()
    (inside / "link").symlink_to(tmp_path)
    with pytest.raises(ValueError, match="outside"):
        check.inside(inside, "link/x")


@pytest.mark.parametrize("name", ["", "../x", "a/b", "<script>", ".hidden", "a b"])
def test_names_are_plain(name):
    with pytest.raises(ValueError):
        check.name(name)


def judged(guard: Guard, query: str = "", **headers: str):
    return guard.judge({k.replace("_", "-"): v for k, v in headers.items()}, query)


def test_guard_on_loopback_refuses_other_sites():
    guard = Guard(None, "127.0.0.1")
    assert judged(guard, host="127.0.0.1:8080") is None
    assert judged(guard, host="localhost:8080", origin="http://localhost:8080") is None
    assert judged(guard, host="127.0.0.1:8080", origin="http://evil.example")[0] == 403
    assert judged(guard, host="evil.example:8080")[0] == 400
    assert judged(guard)[0] == 400


def test_guard_elsewhere_wants_the_token():
    with pytest.raises(ValueError, match="token"):
        Guard(None, "0.0.0.0")
    guard = Guard(None, "0.0.0.0", "secret")
    assert judged(guard, host="bench:8080")[0] == 401
    assert judged(guard, "token=wrong", host="bench:8080")[0] == 401
    assert judged(guard, "token=secret", host="bench:8080") is None
    assert judged(guard, host="bench:8080", cookie=f"{COOKIE}=secret") is None
    assert is_loopback("::1") and not is_loopback("192.168.1.4")


def test_the_printed_address_is_one_that_others_reach():
    assert address("127.0.0.1", 8080) == "http://127.0.0.1:8080/"
    assert address("::1", 80, "abc") == "http://[::1]:80/?token=abc"
    for everywhere in ("0.0.0.0", "::"):
        name = host_of(address(everywhere, 8080).removeprefix("http://").rstrip("/"))
        assert name not in ("0.0.0.0", "::", "") and not is_loopback(name)


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

    assert run(page.Page(bench, MagicMock(), client).do(work)) is None
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
        lambda o: o.plank("me", 1),
        lambda o: o.measure("me", {}, ""),
        lambda o: o.set_mode("me", "velocity", 0.1),
    ],
)
def test_nothing_moves_while_another_panel_has_the_drive(bench, act):
    bench.link.claimed_by = "panel-other"
    with pytest.raises(ValueError, match="'panel-other' is in charge"):
        run(act(bench))
    assert bench.link.done() == []
    for stop in (bench.enable("me", False), bench.quick_stop("me"), bench.plank("me", 0)):
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
        "take",
        "release_page",
        "beat",
        "supervise",
        "emergency_stop",
        "constants",
        "say",
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
    operator.take("me", "me")
    with pytest.raises(ValueError, match="the tire stands"):
        run(operator.move_to("me", 120))


def test_beats_go_on_only_with_a_claim(bench):
    bench.beat("me")
    assert bench.link.beats == []
    bench.link.state.accept(samples(1), math.inf)  # for ever fresh
    run(bench.supervise())
    bench.beat("me")
    bench.beat("other")
    assert bench.link.beats == ["me"]


def test_the_claim_is_renewed_and_given_back(bench, monkeypatch):
    clock = Clock()
    monkeypatch.setattr("flatplank_panel.operator.time", clock)
    bench.take("me", "me")
    bench.link.state.accept(samples(1), math.inf)
    for _ in range(30):
        clock.now += 0.1
        bench.beat("me")
        run(bench.supervise())
    assert len(bench.link.asked) in (3, 4)
    bench.charge.release_page("me")
    run(bench.supervise())
    assert bench.link.asked[-1] == ("claim", {"client": ""})


def test_constants_are_those_of_the_nodes(bench):
    run(bench.set_constants("me", {"et_value": 0.05, "slip_angle_offset_deg": 1}))
    assert dict(bench.link.asked) == {
        "parameters of measurement_hub": {"et_value": 0.05},
        "parameters of encoders": {"slip_angle_offset_deg": 1.0},
    }
    with pytest.raises(ValueError, match="not known"):
        run(bench.set_constants("me", {"k_fx1": 1.0}))
    assert len(CONSTANTS) == 5


@pytest.mark.parametrize("name", sorted(WAVEFORMS))
def test_preview_of_every_waveform_is_the_waveform(name):
    wave = WAVEFORMS[name]()
    points = np.array(preview(name, {}, 1.5))
    after = points[points[:, 0] > 1.5]
    assert np.allclose(after[:, 1], [100.0 * wave.slip(x - 1.5) for x in after[:, 0]], atol=0.2)
    assert (points[points[:, 0] < 1.5][:, 1] == 0.0).all()


def test_answers_of_the_analysis_are_strict_json():
    value = {"a": np.array([1.0, math.nan]), "b": (np.float64(2.5), math.inf), 3: "x"}
    assert (
        json.dumps(plain(value), allow_nan=False)
        == '{"a": [1.0, null], "b": [2.5, null], "3": "x"}'
    )


def test_a_bench_in_the_lab_needs_an_interface_and_a_bus_file_that_are_there(tmp_path):
    host = Host(tmp_path, tmp_path / "log")
    (tmp_path / "mine.yaml").write_text("format: something\n")
    wanted = {
        ("eth_of_nobody", ""): "network interface 'eth_of_nobody' is not known",
        ("", "../bench.yaml"): "outside the data folder",
        ("", "gone.yaml"): "give the path of a bus file",
        ("", "mine.yaml"): "mine.yaml",
    }
    for (interface, bus_file), text in wanted.items():
        with pytest.raises(ValueError, match=text):
            host.start("lab", interface=interface, bus_file=bus_file)
    assert not host.running and host.setup is None


def test_who_sets_things_by_hand_is_asked_of_the_bench(bench):
    for there in (True, False):
        bench.link.offered = {"load_to"} if there else set()
        run(bench.measure("me", "name: x", ""))
        assert bench.link.asked[-1][1]["simulated"] is there
