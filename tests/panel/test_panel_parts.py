# SPDX-License-Identifier: Apache-2.0
"""What a page shows and may send, part by part: samples as numbers and words, inputs, requests."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from own_loop import finished
from panel_samples import samples

from flatplank_hw.bus.image import AXES, AxisInputs, Digital, Health
from flatplank_panel import access, validation
from flatplank_panel.access import HEADERS, Guard
from flatplank_panel.bench_state import BenchState, RunStatus, Slip
from flatplank_panel.charge import NotInCharge, PageInCharge
from flatplank_panel.live import rows_of, script
from flatplank_panel.signals import SIGNALS

# samples as numbers


def test_every_column_of_a_row_is_its_sample():
    state = BenchState()
    state.accept(samples(1000), 0.0)
    now = samples(1250, 3.0)
    now.encoders = now.encoders._replace(
        plank_position=0.5, plank_velocity=0.03, wheel_angle=math.pi, wheel_velocity=0.1,
        steer_angle=math.pi / 2.0, road_camber=math.pi / 180.0,
    )  # fmt: skip
    now.drive = now.drive._replace(
        position=math.pi / 3.0, reference_position=math.pi / 6.0, velocity=0.2,
        reference_velocity=0.4, torque=0.7, reference_torque=0.8,
    )  # fmt: skip
    now.hub = now.hub._replace(loaded_radius=0.31)
    now.slip = Slip(1250, 0.05, -0.04)
    state.accept(now, 1.0)
    row = dict(zip((s.key for s in SIGNALS), state.ring.since(1)[0], strict=True))
    contact = now.hub.contact
    assert row == pytest.approx({
        "t": 1.0, "x": 0.5, "v": 0.03, "fx": contact.fx, "fy": contact.fy, "fz": 3.0,
        "mx": contact.mx, "my": contact.my, "mz": contact.mz, "theta": 180.0, "omega": 0.1,
        "steer": 90.0, "camber": 1.0, "rl": 0.31, "pos": 60.0, "pos_ref": 30.0, "vel": 0.2,
        "vel_ref": 0.4, "tq": 0.7, "tq_ref": 0.8, "slip": -4.0, "slip_ref": 5.0,
    })  # fmt: skip


@pytest.mark.parametrize(("off", "kept"), [(250, True), (-250, True), (251, False), (-251, False)])
def test_a_sample_of_another_second_is_not_shown(off, kept):
    now = replace(samples(1000 + off), inputs=samples(1000).inputs, slip=Slip(1000 + off, 0, 0))
    fresh = now.fresh()
    for name in ("hub", "encoders", "drive", "slip"):
        assert (getattr(fresh, name) is not None) == kept, name


def test_the_rate_is_that_of_the_last_second():
    state = BenchState()
    for cycle, now in ((100, 10.0), (200, 10.5), (349, 10.99)):
        state.accept(samples(cycle), now)
    assert state.rate_hz == 0.0
    state.accept(samples(350), 11.0)
    assert state.rate_hz == 250.0
    state.accept(samples(351), 11.5)
    assert state.rate_hz == 250.0
    state.accept(samples(550), 13.0)
    assert state.rate_hz == 100.0
    state.accept(samples(5), 13.5)  # another bus
    state.accept(samples(305), 14.5)
    assert state.rate_hz == 300.0
    assert state.state_texts(14.5)["bench"] == "running, 300 Hz"


@pytest.mark.parametrize(("later", "runs"), [(0.99, True), (1.0, False), (9.0, False)])
def test_a_bench_runs_for_a_second_after_its_last_cycle(later, runs):
    state = BenchState()
    assert not state.running(0.0) and state.state_texts(0.0) == {
        "bench": "not running", "run": "none",
    }  # fmt: skip
    state.accept(samples(1), 5.0)
    state.accept(samples(1), 50.0)  # the same cycle
    assert state.running(5.0 + later) == runs
    assert len(state.axes(5.0 + later)) == 5 * runs
    assert ("cycle" in state.state_texts(5.0 + later)) == runs


def shown(inputs=None, **others) -> dict[str, str]:
    """Words for samples with changes."""
    state, now = BenchState(), samples(7)
    now.inputs = now.inputs._replace(**(inputs or {}))
    for name, changes in others.items():
        setattr(now, name, getattr(now, name)._replace(**changes))
    state.run = RunStatus("TOY_1", "recording")
    state.accept(now, 0.0)
    return state.state_texts(0.5)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({}, {"cycle": "7", "health": "ok", "trigger": "off", "estop": "released", "late": "",
              "run": "TOY_1: recording", "troubles": "", "state": "operation enabled",
              "mode": "velocity", "stop": "", "error": "", "plank": "moving", "filter": "off",
              "saturated": ""}),
        ({"inputs": {"digital": 0}}, {"trigger": "off", "estop": "PRESSED"}),
        ({"inputs": {"digital": Digital.TRIGGER}}, {"trigger": "on", "estop": "PRESSED"}),
        ({"inputs": {"health": Health.SLAVE_FAULT}}, {"health": "slave fault"}),
        ({"drive": {"state": 7, "mode": 99, "error_code": 0x2A, "stop_reason": 99}},
         {"state": "fault", "mode": "none", "error": "0x002A", "stop": "code 99"}),
        ({"hub": {"filter_on": True, "saturated": 0b101}},
         {"filter": "on", "saturated": "C1, C3"}),
        ({"encoders": {"plank_moving": False}}, {"plank": "at rest"}),
    ],
)  # fmt: skip
def test_the_state_in_words(changes, words):
    found = shown(**changes)
    if words.get("stop") == "":
        words = {**words, "stop": found["stop"]}
        assert found["stop"] in ("", "none")
    assert {key: found[key] for key in words} == words


def test_the_drives_in_words():
    state, now = BenchState(), samples(7)
    drives = [AxisInputs(0x0237, 9, 0, 0, 0, 0), AxisInputs(0x0218, -1, 0, 0, 0, 0x2310)]
    now.inputs = now.inputs._replace(axes=(*drives, *now.inputs.axes[2:]))
    state.accept(now, 0.0)
    first, second, *others = state.axes(0.5)
    assert first == {"axis": "wheel", "state": "operation enabled", "word": "0x0237", "mode": "9",
                     "error": "none"}  # fmt: skip
    assert second == {"axis": "plank", "state": "fault", "word": "0x0218", "mode": "-1",
                      "error": "0x2310"}  # fmt: skip
    assert [a["axis"] for a in others] == list(AXES[2:])


def test_numbers_for_the_browser_are_short_and_finite():
    table = np.array([[1.23456789, math.nan], [-math.inf, 1234567.0]])
    assert rows_of(table) == [[1.23457, None], [None, 1234570.0]]


def test_a_script_has_no_numbers_that_json_lacks():
    assert script([1, "a&b"]) == '[1, "a\\u0026b"]'
    with pytest.raises(ValueError):
        script(math.nan)


# who is in charge


def test_charge_goes_from_page_to_page():
    charge = PageInCharge()
    with pytest.raises(NotInCharge, match="only watches: take charge first"):
        charge.require_charge("a")
    with pytest.raises(NotInCharge):
        charge.require_charge("")
    assert not charge.register_heartbeat("", 0.0) and not charge.release_if_silent(99.0)
    charge.take_charge("a", "first", 100.0)
    charge.take_charge("a", "", 105.0)  # again, under another name
    with pytest.raises(NotInCharge, match="^another page is in charge; ask for a hand-over"):
        charge.take_charge("b", "second", 115.0)
    charge.take_charge("b", "second", 115.1)  # ten seconds after the last sign
    with pytest.raises(NotInCharge, match="only watches: second is in charge"):
        charge.require_charge("a")
    charge.release_page("a")
    charge.require_charge("b")
    assert not charge.release_if_silent(125.1) and charge.release_if_silent(125.2)
    assert (charge.holder, charge.name) == ("", "")
    charge.take_charge("c", "third", 126.0)
    assert charge.register_heartbeat("c", 130.0) and not charge.release_if_silent(139.9)
    charge.release_page("c")
    assert (charge.holder, charge.name) == ("", "") and not charge.register_heartbeat("c", 140.0)


# requests


async def judged(scope: dict, host: str = "127.0.0.1") -> tuple[list[dict], list[dict]]:
    """What the guard sends, and what reaches the page behind it."""
    sent, reached = [], []

    async def page(scope, _receive, send) -> None:
        reached.append(scope)
        await send({"type": "http.response.start", "status": 200, "headers": [(b"a", b"b")]})
        await send({"type": "http.response.body", "body": b"x"})

    async def send(message) -> None:
        sent.append(message)

    await Guard(page, host, "secret")(scope, None, send)
    return sent, reached


def scope_of(kind: str, query: bytes = b"", path: str = "/", **headers: str) -> dict:
    pairs = [
        (k.title().encode(), v.encode()) for k, v in {"host": "localhost:81", **headers}.items()
    ]
    return {"type": kind, "path": path, "query_string": query, "headers": pairs}


COOKIE = {"cookie": "flatplank_token_81=secret"}


def test_a_request_with_the_cookie_reaches_the_page():
    sent, reached = finished(judged(scope_of("http", **COOKIE)))
    assert len(reached) == 1 and sent[1] == {"type": "http.response.body", "body": b"x"}
    assert sent[0]["headers"] == [(b"a", b"b"), *HEADERS] and sent[0]["status"] == 200


@pytest.mark.parametrize("given", [{"query": b"token=secret"}, COOKIE])
def test_a_web_socket_with_the_token_reaches_the_page(given):
    _, reached = finished(judged(scope_of("websocket", **given)))
    assert len(reached) == 1


def test_a_web_socket_without_the_token_is_closed():
    sent, reached = finished(judged(scope_of("websocket")))
    assert sent == [{"type": "websocket.close", "code": 1008}] and not reached


def test_what_is_no_request_passes():
    sent, reached = finished(judged({"type": "lifespan"}))
    assert len(reached) == 1 and sent[0]["headers"] == [(b"a", b"b")]


def test_a_refusal_says_why_and_has_the_headers_of_every_answer():
    sent, reached = finished(judged(scope_of("http", b"token=other")))
    assert not reached and sent[0]["status"] == 401
    assert sent[0]["headers"] == [(b"content-type", b"text/plain; charset=utf-8"), *HEADERS]
    assert sent[1]["body"].startswith(b"open the address with the token")


@pytest.mark.parametrize(
    ("query", "target"),
    [(b"token=secret", b"/runs"), (b"a=1&token=secret&b=2%203", b"/runs?a=1&b=2+3")],
)
def test_the_token_is_taken_out_of_the_address(query, target):
    sent, reached = finished(judged(scope_of("http", query, "/runs")))
    told = dict(sent[0]["headers"])
    assert not reached and (sent[0]["status"], told[b"location"]) == (303, target)
    cookie = b"flatplank_token_81=secret; HttpOnly; SameSite=Strict; Path=/"
    assert told[b"set-cookie"] == cookie and told[b"x-frame-options"] == b"DENY"
    assert sent[1] == {"type": "http.response.body", "body": b""}


@pytest.mark.parametrize(
    ("host", "headers", "status"),
    [
        ("127.0.0.1", {"host": "bench:80"}, 400), ("0.0.0.0", {"host": "bench:80"}, 401),
        ("0.0.0.0", {"host": "bench:81", **COOKIE}, None), ("::1", {"host": "[::1]:81"}, 401),
        ("127.0.0.1", {"host": "localhost:81", "origin": "http://localhost:81", **COOKIE}, None),
        ("127.0.0.1", {"host": "localhost:81", "origin": "http://localhost:82", **COOKIE}, 403),
        ("0.0.0.0", {"host": "bench:81", "origin": "http://bench", **COOKIE}, 403),
        ("0.0.0.0", {"host": "bench:81", "origin": "", **COOKIE}, None),
        ("0.0.0.0", {"host": "bench", "cookie": "flatplank_token_80=secret"}, None),
        ("0.0.0.0", {"host": "bench", **COOKIE}, 401), ("127.0.0.1", {}, 400),
    ],
)  # fmt: skip
def test_who_is_refused(host, headers, status):
    found = Guard(None, host, "secret").refusal_of(headers, "")
    assert (found[0] if found else None) == status


@pytest.mark.parametrize(
    ("host", "inside"),
    [("localhost", True), ("127.0.0.1", True), ("127.9.9.9", True), ("::1", True), ("", False),
     ("10.0.0.1", False), ("::", False), ("bench", False), ("localhost.evil", False)],
)  # fmt: skip
def test_addresses_of_this_machine_alone(host, inside):
    assert access.is_loopback(host) == inside


@pytest.mark.parametrize(
    ("host", "token", "url"),
    [("127.0.0.1", "", "http://127.0.0.1:81/"), ("::1", "t", "http://[::1]:81/?token=t"),
     ("0.0.0.0", "t", "http://bench.lab:81/?token=t"), ("::", "", "http://bench.lab:81/")],
)  # fmt: skip
def test_the_address_for_a_browser(monkeypatch, host, token, url):
    monkeypatch.setattr(access, "_outward", lambda: "bench.lab")
    assert access.address(host, 81, token) == url


# inputs


@pytest.mark.parametrize(
    ("value", "found"), [("2.5", 2.5), (0, 0.0), (10, 10.0), (True, 1.0), (" 3 ", 3.0)]
)
def test_a_number_within_its_range(value, found):
    assert validation.number(value, "load", 0.0, 10.0) == found


@pytest.mark.parametrize(
    ("value", "said"),
    [("x" * 50, f"load: give a number, not {'x' * 40!r}"),
     (None, "load: give a number, not 'None'"),
     (-0.1, "load is -0.1 N, must be within 0 .. 10"), (10.1, "load is 10.1 N, must be within"),
     (math.nan, "load is nan, must be finite")],
)  # fmt: skip
def test_another_number_is_refused_in_words(value, said):
    with pytest.raises(ValueError) as raised:
        validation.number(value, "load", 0.0, 10.0, "N")
    assert str(raised.value).startswith(said)


def test_names_notes_and_choices():
    assert validation.name(" mine ") == "mine"
    assert validation.choice("step", ["sine", "step"], "waveform") == "step"
    with pytest.raises(ValueError, match=r"^waveform 'stp' is not known; the nearest is 'step'"):
        validation.choice("stp", ["sine", "step"], "waveform")
    assert validation.note("a\nb\x00\x1b[0m\tc") == "a\nb[0mc" and validation.note(None) == ""
    assert len(validation.note("x" * 2000)) == 2000
    with pytest.raises(ValueError, match="has 2001 characters, at most 2000"):
        validation.note("x" * 2001)


def test_folders_below_the_data_folder(tmp_path):
    base = tmp_path.resolve()
    assert validation.inside(tmp_path, "") == base == validation.inside(tmp_path, None)
    assert validation.inside(tmp_path, " a/../b ") == base / "b"
    assert validation.inside(tmp_path, "x" * 200) == base / ("x" * 200)
    for text in ("x" * 501, "a\x00"):
        with pytest.raises(ValueError, match="^file: not a path"):
            validation.inside(tmp_path, text, "file")
    with pytest.raises(ValueError, match=r"folder '\.\./.*' is outside the data folder"):
        validation.inside(tmp_path, "../" + tmp_path.name + "x")
    made = validation.folder_below(tmp_path, " day/one ")
    assert made == base / "day/one" and made.is_dir()
    assert validation.folder_below(tmp_path, "day/one") == made
    with pytest.raises(ValueError, match="not a name"):
        validation.folder_below(tmp_path, "day/a b")
    assert not (base / "day/a b").exists()


def test_a_setting_has_its_limit():
    assert validation.setting("8000", "fz") == 8000.0
    with pytest.raises(ValueError, match="fz is 8001 N, must be within 0 .. 8000"):
        validation.setting(8001, "fz")


def test_the_constants_of_the_nodes():
    found = {name: c.node for name, c in validation.CONSTANTS.items()}
    assert all(name == c.name == c.info.name for name, c in validation.CONSTANTS.items())
    assert found == {
        "et_value": "measurement_hub", "adapter_thickness": "measurement_hub",
        "wheel_camber_deg": "measurement_hub", "road_camber_offset_deg": "measurement_hub",
        "slip_angle_offset_deg": "encoders",
    }  # fmt: skip
