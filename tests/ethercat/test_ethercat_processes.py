# SPDX-License-Identifier: Apache-2.0
"""Processes that die, freeze or come twice, and faults that last longer than the timeouts
of the bus; each under the same contract."""

from __future__ import annotations

import functools
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path

from ethercat_contract import Contract
from ethercat_rig import BENCH, Bench, Emulator
from stalls import undisturbed

from flatplank_hw.bus.image import Health
from flatplank_sim.emulated import MASTER

HERE = Path(__file__).parent
INTRUDER = """
import pysoem, sys
m = pysoem.Master()
print("waiting", flush=True)
sys.stdin.readline()
m.open("veth0")
m.config_init()
m.close()
"""


def tried(test: Callable[[Bench], None]) -> Callable[[Bench], None]:
    """A test that is made again when it failed beside a stall of the computer."""

    @functools.wraps(test)
    def with_stalls(bench: Bench) -> None:
        undisturbed(bench.stalls, lambda: test(bench))

    return with_stalls


def states(bench: Bench) -> set[str]:
    """AL states of all slaves."""
    return {s["state"] for s in bench.emulator.send("state")["slaves"]}


@tried
def test_bus_process_killed(bench: Bench) -> None:
    """The drive's own watchdog is the last line; the node sees LOST images go on."""
    with Contract(bench, "bus process killed") as contract:
        os.kill(bench.client.process.pid, signal.SIGKILL)
        contract.rests()
        inputs = bench.node.run(lambda i: i.health == Health.LOST, what="LOST images")
        assert bench.client.invented > 0
        assert bench.node.run(lambda i: i.cycle > inputs.cycle, what="images go on")
        slaves = bench.emulator.send("state")["slaves"]
        drive = next(s for s in slaves if s["name"] == "wheel_drive")
        assert (drive["state"], drive["code"]) == ("SAFEOP", 0x1B)


@tried
def test_bus_process_frozen(bench: Bench) -> None:
    """Stopped for a while and let go on: the watchdog stopped the wheel, nothing enables it
    again."""
    with Contract(bench, "bus process frozen") as contract:
        process = bench.client.process
        with ExitStack() as after:
            os.kill(process.pid, signal.SIGSTOP)
            after.callback(os.kill, process.pid, signal.SIGCONT)
            contract.rests()
        bench.node.run(lambda i: i.health == Health.SLAVE_FAULT, what="fault noticed")
        contract.recovers()
        assert bench.client.diagnostics()["missed"] > 0


@tried
def test_node_silent(bench: Bench) -> None:
    """A node that sends no commands any more: the guard stops its axis, and only that is held."""
    with Contract(bench, "node sends no commands") as contract:
        bench.node.silent = True
        contract.rests()
        contract.recovers()
        report = bench.client.diagnostics()
        assert report["held"] == {"wheel": "STALE_COMMAND"}
        assert report["health"] == "OK" and bench.node.last.axes[0].error_code == 0x8130


@tried
def test_node_killed(bench: Bench) -> None:
    """The bus process notices that its parent is gone: stops the axes, leaves the slaves in
    INIT."""
    with Contract(bench, "node killed") as contract:
        bench.client.stop()
        words = [sys.executable, str(HERE / "ethercat_spinning_node.py"), str(BENCH)]
        words += bench.namespace.enter
        with subprocess.Popen(words, stdout=subprocess.PIPE) as node, ExitStack() as after:
            after.callback(node.kill)
            assert node.stdout.readline().strip() == b"turning"
            contract.enables = bench.emulator.wheel()["enables"]
            trips = bench.emulator.send("state")["slaves"][1]["watchdog_trips"]
            contract.mark()
        contract.rests()
        end = time.monotonic() + 5
        while states(bench) != {"INIT"} and time.monotonic() < end:
            pass
        assert states(bench) == {"INIT"}
        assert bench.emulator.send("state")["slaves"][1]["watchdog_trips"] == trips


def test_emulator_killed_and_started_again(bench: Bench) -> None:
    """All slaves gone, and the plant with them; then both as from the factory: full scan, and the
    new shaft never turns."""
    with Contract(bench, "all slaves gone") as contract:
        bench.emulator.close(kill=True)
        bench.node.run(lambda i: i.health == Health.LOST, what="LOST")
        bench.node.cycles(100)
        assert "no answer" in bench.client.diagnostics()["reason"]
        bench.emulator = Emulator(bench.namespace)
        bench.emulator.send("operator", name="unload")
        contract.new_plant()
        contract.recovers()
        assert bench.emulator.wheel()["last_moving_ns"] == -1
        report = bench.client.diagnostics()
        assert report["held"] == {"wheel": "BUS"}
        assert set(report["recovery"]) & {"RECONFIGURE", "RESCAN"}


@tried
def test_second_master_is_refused(bench: Bench) -> None:
    """The lock names the owner; the running bus does not notice.

    The other process is there before the wheel turns: starting one stalls the node by hand.
    """
    words = [sys.executable, str(HERE / "ethercat_second_master.py"), str(BENCH)]
    with started([*words, *bench.namespace.enter]) as second:
        before = bench.client.diagnostics()["wrong_counter"]
        with Contract(bench, "second master", stops=False) as contract:
            go(second)
            text = bench.meanwhile(second).decode()
            bench.node.cycles(20)
            contract.rests()
            report = bench.client.diagnostics()
    assert f"in use by process {bench.client.process.pid}" in text
    assert report["wrong_counter"] == before and report["held"] == {}


@tried
def test_foreign_master_on_the_wire(bench: Bench) -> None:
    """A master that knows no lock resets the slaves: the wheel stops and the bus heals
    afterwards."""
    with (
        started([*bench.namespace.enter, sys.executable, "-c", INTRUDER]) as intruder,
        Contract(bench, "foreign master") as contract,
    ):
        before = taken_in_again(bench)
        go(intruder)
        bench.meanwhile(intruder)
        contract.recovers()
        contract.rests(since="left_op_ns")
        assert {"LOST", "OK"} <= bench.node.seen
        assert taken_in_again(bench) > before


def taken_in_again(bench: Bench) -> int:
    """How many times slaves that had lost their state were taken in again. Whether the socket is
    reopened before, for the other master's frames, depends on when these come."""
    steps = bench.client.diagnostics()["recovery"]
    return sum(steps.get(step, 0) for step in ("RECONFIGURE", "RESCAN"))


def started(words: list[str]) -> subprocess.Popen[bytes]:
    """Another process, which waits until it is told to go."""
    process = subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    assert process.stdout.readline().strip() == b"waiting"
    return process


def go(process: subprocess.Popen[bytes]) -> None:
    process.stdin.write(b"go\n")
    process.stdin.flush()


@tried
def test_link_down_on_the_near_side(bench: Bench) -> None:
    """The master's own interface goes down for 0.3 s."""
    with Contract(bench, "link down on the near side") as contract, ExitStack() as after:
        bench.namespace.run("ip", "link", "set", MASTER, "down")
        after.callback(bench.namespace.run, "ip", "link", "set", MASTER, "up")
        bench.node.run(lambda i: i.health == Health.LOST, what="LOST")
        bench.node.cycles(75)
        contract.rests(since="last_frame_ns")
        assert f"sudo ip link set {MASTER} up" in bench.client.diagnostics()["reason"]


@tried
def test_another_slave_in_the_place_of_one(bench: Bench) -> None:
    """Exchanged during a run: the full scan refuses it and says which; nothing goes on."""
    with Contract(bench, "another slave in the place of one") as contract:
        bench.emulator.send("identity", slave="encoders_b", product=0x12345678)
        bench.emulator.send("power_off", slave="encoders_b")
        bench.node.cycles(150)
        contract.rests()
        bench.emulator.send("mend", fault="power_off")
        bench.node.cycles(400)
        report = bench.client.diagnostics()
        assert "encoders_b" in report["reason"] and "0x12345678" in report["reason"]
        assert bench.node.last.health != 0
        contract.not_enabled()


@tried
def test_long_cut_ends_in_a_full_scan(bench: Bench) -> None:
    """Longer than the recovery waits; the slaves behind the cut are taken in again."""
    with Contract(bench, "cable cut for long") as contract:
        scans = bench.client.diagnostics()["recovery"].get("RESCAN", 0)
        bench.emulator.send("cable_cut", behind="bridges_b")
        bench.node.cycles(350)
        contract.rests()
        assert "missing from 'encoders_a' on" in bench.client.diagnostics()["reason"]
        contract.recovers()
        assert bench.client.diagnostics()["recovery"]["RESCAN"] > scans


@tried
def test_state_refused_until_allowed(bench: Bench) -> None:
    """A slave that will not go to OP again, with its own code."""
    with Contract(bench, "a slave refuses OP") as contract:
        bench.emulator.send("al_refuse", slave="bridges_a", state="OP", code=0x0020)
        bench.emulator.send("al_drop", slave="bridges_a", state="SAFEOP", code=0x0020)
        bench.node.cycles(250)
        contract.rests()
        report = bench.client.diagnostics()
        assert "bridges_a: SAFEOP with error 0x0020" in report["reason"]
        assert bench.node.last.health != 0


@tried
def test_operators_emergency_stop(bench: Bench) -> None:
    """The mushroom button of the plant, through the digital input terminal."""
    with Contract(bench, "mushroom button") as contract:
        bench.emulator.send("operator", name="emergency_stop", arguments=[True])
        bench.node.cycles(40)
        contract.rests()
        assert bench.client.diagnostics()["held"] == {"wheel": "EMERGENCY_STOP"}
        bench.node.reset()
        bench.node.cycles(30)
        contract.not_enabled()
        bench.emulator.send("operator", name="emergency_stop", arguments=[False])


@tried
def test_stopping_the_bus_stops_the_wheel_first(bench: Bench) -> None:
    """An orderly end while the wheel turns: quick stop, then INIT, without any watchdog."""
    with Contract(bench, "bus ended in order") as contract:
        trips = [s["watchdog_trips"] for s in bench.emulator.send("state")["slaves"]]
        bench.client.stop()
        contract.rests()
        state = bench.emulator.send("state")
        assert state["drive_faults"] == {"wheel": 0}, "stopped by the drive, not by the bus"
        assert {s["state"] for s in state["slaves"]} == {"INIT"}
        assert [s["watchdog_trips"] for s in state["slaves"]] == trips
