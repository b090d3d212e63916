# SPDX-License-Identifier: Apache-2.0
"""Processes that die, freeze or come twice, and faults that last longer than the bus's
patience."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from ethercat_rig import ATTEMPTS, BENCH, Bench, Emulator, Stalls
from ethercat_scenarios import WITHIN_MS

from flatplank_hw.bus.image import Health
from flatplank_hw.ethercat.namespace import MASTER

HERE = Path(__file__).parent


@pytest.fixture(scope="module")
def rig() -> Iterator[Bench]:
    bench = Bench()
    bench.unload()
    yield bench
    bench.close()


@pytest.fixture
def bench(rig: Bench) -> Bench:
    """The wheel turns; what the test before has broken is mended."""
    rig.revive()
    return rig


def enables(bench: Bench) -> int:
    """How often the wheel's power stage was switched on so far."""
    return bench.emulator.wheel()["enables"]


def wait_for_standstill(bench: Bench) -> dict:
    """Ask the witness until the wheel has rested for a while."""
    end = time.monotonic() + 5
    while time.monotonic() < end:
        wheel = bench.emulator.wheel()
        if wheel["still_ms"] > 60:
            return wheel
    pytest.fail(f"the wheel turns on: {wheel}")


def moment(bench: Bench) -> None:
    """Let the witness count from now, by a fault that does nothing."""
    bench.emulator.send("lose_share", share=0.0)


def test_bus_process_killed(bench: Bench) -> None:
    """The drive's own watchdog is the last line; the node sees LOST images go on."""
    before = enables(bench)
    moment(bench)
    os.kill(bench.client.process.pid, signal.SIGKILL)
    wheel = wait_for_standstill(bench)
    assert wheel["ran_on_ms"] <= WITHIN_MS and wheel["enables"] == before
    inputs = bench.node.run(lambda i: i.health == Health.LOST, what="LOST images")
    assert bench.client.invented > 0
    assert bench.node.run(lambda i: i.cycle > inputs.cycle, what="images go on")
    drive = next(s for s in bench.emulator.send("state")["slaves"] if s["name"] == "wheel_drive")
    assert (drive["state"], drive["code"]) == ("SAFEOP", 0x1B)


def test_bus_process_frozen(bench: Bench) -> None:
    """Stopped for 0.3 s and let go on: the watchdog stopped the wheel, nothing enables it
    again."""
    before = enables(bench)
    moment(bench)
    os.kill(bench.client.process.pid, signal.SIGSTOP)
    wheel = wait_for_standstill(bench)
    assert wheel["ran_on_ms"] <= WITHIN_MS
    os.kill(bench.client.process.pid, signal.SIGCONT)
    bench.node.run(lambda i: i.health == Health.SLAVE_FAULT, what="fault noticed")
    bench.node.run(lambda i: i.health == 0, what="bus well again")
    bench.node.cycles(50)
    assert enables(bench) == before
    assert bench.client.diagnostics()["missed"] > 0
    bench.node.reset()
    bench.node.spin_up()


def test_node_silent(bench: Bench) -> None:
    """A node that sends no commands any more: the guard stops its axis, and only that is held."""
    before = enables(bench)
    moment(bench)
    bench.node.silent = True
    wheel = wait_for_standstill(bench)
    assert wheel["ran_on_ms"] <= WITHIN_MS
    bench.node.silent = False
    bench.node.cycles(30)
    report = bench.client.diagnostics()
    assert report["held"] == {"wheel": "STALE_COMMAND"}
    assert report["health"] == "OK" and bench.node.last.axes[0].error_code == 0x8130
    assert enables(bench) == before
    bench.node.reset()
    bench.node.spin_up()


def test_node_killed(bench: Bench) -> None:
    """The bus process notices that its parent is gone: stops the axes, leaves the slaves in
    INIT."""
    bench.client.stop()
    words = [sys.executable, str(HERE / "ethercat_spinning_node.py"), str(BENCH)]
    words += bench.namespace.enter
    node = subprocess.Popen(words, stdout=subprocess.PIPE)
    assert node.stdout.readline().strip() == b"turning"
    trips = bench.emulator.send("state")["slaves"][1]["watchdog_trips"]
    moment(bench)
    node.kill()
    node.wait()
    node.stdout.close()
    wheel = wait_for_standstill(bench)
    assert wheel["ran_on_ms"] <= WITHIN_MS and not wheel["enabled"]
    end = time.monotonic() + 5
    states = set()
    while states != {"INIT"} and time.monotonic() < end:
        states = {s["state"] for s in bench.emulator.send("state")["slaves"]}
    assert states == {"INIT"}
    assert bench.emulator.send("state")["slaves"][1]["watchdog_trips"] == trips


def test_emulator_killed_and_started_again(bench: Bench) -> None:
    """All slaves gone, then back as from the factory: full scan, and nothing turns."""
    bench.emulator.close(kill=True)
    bench.node.run(lambda i: i.health == Health.LOST, what="LOST")
    bench.node.cycles(100)
    assert "no answer" in bench.client.diagnostics()["reason"]
    bench.emulator = Emulator(bench.namespace)
    bench.emulator.send("operator", name="unload")
    bench.node.run(lambda i: i.health == 0, seconds=10, what="bus well again")
    bench.node.cycles(50)
    wheel = bench.emulator.wheel()
    assert wheel["enables"] == 0 and not wheel["moving"]
    report = bench.client.diagnostics()
    assert report["held"] == {"wheel": "BUS"}
    assert set(report["recovery"]) & {"RECONFIGURE", "RESCAN"}
    bench.node.reset()
    bench.node.spin_up()


def try_second_master(rig: Bench) -> tuple[str, dict, dict]:
    """What it says, and how the running bus fares.

    The other process is there before the wheel turns: starting one stalls the node by hand.
    """
    words = [sys.executable, str(HERE / "ethercat_second_master.py"), str(BENCH)]
    words += rig.namespace.enter
    with subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as second:
        assert second.stdout.readline().strip() == b"waiting"
        rig.revive()
        second.stdin.write(b"go\n")
        second.stdin.flush()
        text = rig.meanwhile(second).decode()
        rig.node.cycles(20)
        return text, rig.client.diagnostics(), rig.emulator.wheel()


def test_second_master_is_refused(rig: Bench) -> None:
    """The lock names the owner; the running bus does not notice."""
    for _ in range(ATTEMPTS):
        stalls, before = Stalls(rig), rig.client.diagnostics()["wrong_counter"]
        text, report, wheel = try_second_master(rig)
        if not stalls:
            break
    assert f"in use by process {rig.client.process.pid}" in text
    assert report["wrong_counter"] == before and report["held"] == {}
    assert wheel["moving"]


def test_foreign_master_on_the_wire(bench: Bench) -> None:
    """A master that knows no lock resets the slaves: the wheel stops and the bus heals
    afterwards."""
    before = enables(bench)
    moment(bench)
    intruder = "import pysoem; m = pysoem.Master(); m.open('veth0'); m.config_init(); m.close()"
    words = [*bench.namespace.enter, sys.executable, "-c", intruder]
    with subprocess.Popen(words, stdout=subprocess.PIPE) as process:
        bench.meanwhile(process)
    bench.node.run(lambda i: i.health == 0, what="bus well again")
    bench.node.cycles(40)
    wheel = wait_for_standstill(bench)
    assert not wheel["enabled"] and enables(bench) == before
    assert {"LOST", "OK"} <= bench.node.seen
    assert bench.client.diagnostics()["recovery"]["REOPEN"] >= 1


def test_link_down_on_the_near_side(bench: Bench) -> None:
    """The master's own interface goes down for 0.3 s."""
    before = enables(bench)
    moment(bench)
    bench.namespace.run("ip", "link", "set", MASTER, "down")
    bench.node.run(lambda i: i.health == Health.LOST, what="LOST")
    bench.node.cycles(75)
    report = bench.emulator.send("witness")
    wheel = report["axes"]["wheel"]
    bench.namespace.run("ip", "link", "set", MASTER, "up")
    bench.node.run(lambda i: i.health == 0, what="bus well again")
    bench.node.cycles(40)
    ran_on = (wheel["last_moving_ns"] - report["last_frame_ns"]) / 1e6
    assert ran_on <= WITHIN_MS and not wheel["moving"]
    assert enables(bench) == before
    bench.node.reset()
    bench.node.spin_up()


def test_another_slave_in_the_place_of_one(bench: Bench) -> None:
    """Exchanged during a run: the full scan refuses it and says which; nothing goes on."""
    before = enables(bench)
    bench.emulator.send("identity", slave="encoders_b", product=0x12345678)
    bench.emulator.send("power_off", slave="encoders_b")
    bench.node.cycles(150)
    bench.emulator.send("mend", fault="power_off")
    bench.node.cycles(400)
    report = bench.client.diagnostics()
    assert "encoders_b" in report["reason"] and "0x12345678" in report["reason"]
    assert bench.node.last.health != 0 and enables(bench) == before
    bench.emulator.send("mend")
    bench.node.run(lambda i: i.health == 0, seconds=8, what="bus well again")


def test_long_cut_ends_in_a_full_scan(bench: Bench) -> None:
    """Longer than the patience of the ladder; the slaves behind the cut are taken in again."""
    before = enables(bench)
    bench.emulator.send("cable_cut", behind="bridges_b")
    bench.node.cycles(350)
    assert "missing from 'encoders_a' on" in bench.client.diagnostics()["reason"]
    bench.emulator.send("mend")
    bench.node.run(lambda i: i.health == 0, seconds=8, what="bus well again")
    bench.node.cycles(40)
    assert enables(bench) == before
    assert bench.client.diagnostics()["recovery"]["RESCAN"] >= 1


def test_state_refused_until_allowed(bench: Bench) -> None:
    """A slave that will not go to OP again, with its own code."""
    before = enables(bench)
    bench.emulator.send("al_refuse", slave="bridges_a", state="OP", code=0x0020)
    bench.emulator.send("al_drop", slave="bridges_a", state="SAFEOP", code=0x0020)
    bench.node.cycles(250)
    report = bench.client.diagnostics()
    assert "bridges_a: SAFEOP with error 0x0020" in report["reason"]
    assert bench.node.last.health != 0
    bench.emulator.send("mend")
    bench.node.run(lambda i: i.health == 0, seconds=8, what="bus well again")
    assert enables(bench) == before


def test_operators_emergency_stop(bench: Bench) -> None:
    """The mushroom button of the plant, through the digital input terminal."""
    before = enables(bench)
    bench.emulator.send("operator", name="emergency_stop", arguments=[True])
    bench.node.cycles(40)
    wheel = bench.emulator.wheel()
    assert wheel["ran_on_ms"] <= WITHIN_MS and not wheel["enabled"]
    assert bench.client.diagnostics()["held"] == {"wheel": "EMERGENCY_STOP"}
    bench.node.reset()
    bench.node.cycles(30)
    assert enables(bench) == before, "reset while the button is in"
    bench.emulator.send("operator", name="emergency_stop", arguments=[False])
    bench.node.cycles(30)
    assert enables(bench) == before, "released, not yet reset"
    bench.node.reset()
    bench.node.spin_up()


def test_stopping_the_bus_stops_the_wheel_first(bench: Bench) -> None:
    """An orderly end while the wheel turns: quick stop, then INIT, without any watchdog."""
    trips = [s["watchdog_trips"] for s in bench.emulator.send("state")["slaves"]]
    moment(bench)
    bench.client.stop()
    wheel = wait_for_standstill(bench)
    assert wheel["ran_on_ms"] <= WITHIN_MS and not wheel["enabled"]
    state = bench.emulator.send("state")
    slaves = state["slaves"]
    assert state["drive_faults"] == {"wheel": 0}, "stopped by the drive, not by the bus"
    assert {s["state"] for s in slaves} == {"INIT"}
    assert [s["watchdog_trips"] for s in slaves] == trips
    assert bench.client.last_report["health"] == "OK"
