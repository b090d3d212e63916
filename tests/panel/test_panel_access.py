# SPDX-License-Identifier: Apache-2.0
"""Who may do what, and with which inputs: charge, validation, guard, address, lab bench."""

from __future__ import annotations

import asyncio
import math

import pytest

from flatplank_panel import validation as check
from flatplank_panel.access import (
    COOKIE,
    Guard,
    address,
    cookie_of,
    host_of,
    is_loopback,
)
from flatplank_panel.charge import HOLDER_TIMEOUT_S, NotInCharge, PageInCharge
from flatplank_panel.host import Host


def test_one_in_charge_until_it_is_silent():
    charge = PageInCharge()
    charge.take_charge("a", "first", 0.0)
    with pytest.raises(NotInCharge, match="first is in charge"):
        charge.take_charge("b", "second", HOLDER_TIMEOUT_S - 0.1)
    assert charge.register_heartbeat("a", 1.0) and not charge.register_heartbeat("b", 1.0)
    assert not charge.release_if_silent(0.9 + HOLDER_TIMEOUT_S)
    assert charge.release_if_silent(1.1 + HOLDER_TIMEOUT_S)
    charge.take_charge("b", "second", 1.2 + HOLDER_TIMEOUT_S)
    with pytest.raises(NotInCharge):
        charge.require_charge("a")
    charge.require_charge("b")


@pytest.mark.parametrize("value", ["nan", math.inf, None, "1e999", "x", "", 11])
def test_numbers_are_checked(value):
    with pytest.raises(ValueError, match="load"):
        check.number(value, "load", 0.0, 10.0, "N")


@pytest.mark.parametrize(
    "path", ["..", "/etc/passwd", "a/../../b", "a\x00b", "x\u2028y", "x" * 600]
)
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
    return guard.refusal_of({k.replace("_", "-"): v for k, v in headers.items()}, query)


def test_guard_on_loopback_refuses_other_sites():
    guard, t = Guard(None, "127.0.0.1", "secret"), "token=secret"
    assert judged(guard, t, host="127.0.0.1:8080") is None
    assert judged(guard, t, host="localhost:8080", origin="http://localhost:8080") is None
    assert judged(guard, t, host="127.0.0.1:8080", origin="http://evil.example")[0] == 403
    assert judged(guard, t, host="127.0.0.1:8080", origin="http://127.0.0.1:9")[0] == 403
    assert judged(guard, t, host="evil.example:8080")[0] == 400
    assert judged(guard, t)[0] == 400


@pytest.mark.parametrize("here, host", [("0.0.0.0", "bench:80"), ("127.0.0.1", "127.0.0.1:80")])
def test_guard_wants_the_token_everywhere(here: str, host: str):
    """On the loopback address every other user of this machine is somebody else, too."""
    with pytest.raises(ValueError, match="token"):
        Guard(None, here, "")
    guard = Guard(None, here, "secret")
    assert judged(guard, host=host)[0] == 401
    assert judged(guard, "token=wrong", host=host)[0] == 401
    assert judged(guard, "token=secret", host=host) is None
    name = cookie_of({"host": host})
    assert judged(guard, host=host, cookie=f"{name}=secret") is None
    assert judged(guard, host=host, cookie=f"{COOKIE.format(9)}=secret")[0] == 401
    assert is_loopback("::1") and not is_loopback("192.168.1.4")


def answered(query: str, **headers: str) -> list[dict]:
    """What the guard sends for a page that answers with 200."""

    async def page(_scope, _receive, send) -> None:
        await send({"type": "http.response.start", "status": 200, "headers": []})

    sent: list[dict] = []

    async def send(message) -> None:
        sent.append(message)

    scope = {
        "type": "http", "path": "/", "query_string": query.encode(),
        "headers": [(k.encode(), v.encode()) for k, v in headers.items()],
    }  # fmt: skip
    asyncio.run(Guard(page, "127.0.0.1", "secret")(scope, None, send))
    return sent


def test_the_token_leaves_the_address_and_no_frame_may_show_the_page():
    host = "127.0.0.1:8080"
    first, _ = answered("tab=Runs&token=secret", host=host)
    told = dict(first["headers"])
    assert (first["status"], told[b"location"]) == (303, b"/?tab=Runs")
    cookie = told[b"set-cookie"].decode()
    assert "HttpOnly" in cookie and "SameSite=Strict" in cookie
    (second,) = answered("", host=host, cookie=cookie.partition(";")[0])
    refused = answered("", host=host)[0]
    assert (second["status"], refused["status"]) == (200, 401)
    for message in (first, second, refused):
        assert dict(message["headers"])[b"x-frame-options"] == b"DENY"
        policy = dict(message["headers"])[b"content-security-policy"].decode()
        assert "frame-ancestors 'none'" in policy and "default-src 'self'" in policy


def test_the_printed_address_is_one_that_others_reach():
    assert address("127.0.0.1", 8080) == "http://127.0.0.1:8080/"
    assert address("::1", 80, "abc") == "http://[::1]:80/?token=abc"
    for everywhere in ("0.0.0.0", "::"):
        name = host_of(address(everywhere, 8080).removeprefix("http://").rstrip("/"))
        assert name not in ("0.0.0.0", "::", "") and not is_loopback(name)


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
