# SPDX-License-Identifier: Apache-2.0
"""From nothing to OP, and all that can keep a bus from it: one line with the remedy, no
traceback."""

from __future__ import annotations

import contextlib
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
import yaml
from ethercat_rig import BENCH, BUS_FILES, Emulator, InsistentNode, namespace

from flatplank_hw.ethercat.busfile import BusFile
from flatplank_hw.ethercat.master import BusClient, BusError
from flatplank_hw.ethercat.reader import BusFileError, read_bus_file
from flatplank_hw.ethercat.writer import write_bus
from flatplank_sim.emulated import MASTER, BenchNamespace

STUB = ("--plant", "ethercat_stub_plant:make")


@pytest.fixture(scope="module")
def wire() -> Iterator[BenchNamespace]:
    with namespace() as ns:
        yield ns


@pytest.fixture
def emulator(wire: BenchNamespace) -> Iterator[Emulator]:
    with contextlib.closing(Emulator(wire, BENCH, *STUB)) as running:
        yield running


@pytest.fixture
def client(wire: BenchNamespace, emulator: Emulator) -> Iterator[BusClient]:
    with BusClient(BENCH, MASTER, launch=wire.enter) as started:
        yield started


def changed(tmp_path: Path, slaves: list) -> Path:
    """A bus file with other slaves."""
    bus = read_bus_file(BENCH)
    path = tmp_path / "bus.yaml"
    path.write_text(write_bus(BusFile(bus.name, tuple(slaves))))
    return path


def refused(client: BusClient) -> str:
    """Why the bus does not start; always one line, and the process is gone."""
    with pytest.raises(BusError) as caught:
        client.start()
    text = str(caught.value)
    assert "\n" not in text and "Traceback" not in text
    assert client.process is None
    return text


@pytest.mark.parametrize("name", ["minimal", "bench", "bench_five_axes"])
def test_in_op_within_two_seconds(wire: BenchNamespace, name: str) -> None:
    path = BUS_FILES / f"{name}.yaml"
    emulator = Emulator(wire, path, *STUB)
    client = BusClient(path, MASTER, launch=wire.enter)
    try:
        start = time.monotonic()
        client.start()
        assert time.monotonic() - start <= 2.0
        node = InsistentNode(client)
        node.spin_up()
        states = {s["state"] for s in emulator.send("state")["slaves"]}
        assert states == {"OP"} and node.gaps == 0
    finally:
        client.stop()
        emulator.close()


def test_channels_arrive_where_they_belong(client: BusClient) -> None:
    """Every channel of the stub plant has a value of its own."""
    node = InsistentNode(client)
    node.cycles(5)
    inputs = node.last
    assert inputs.bridge_volts == pytest.approx((1, -2, 3, -4, 5, -6), abs=2e-6)
    assert inputs.lvdt_volts == pytest.approx(7.5, abs=2e-6)
    assert inputs.steer_counts == -inputs.plank_counts < 0
    assert (inputs.camber_counts, inputs.road_counts) == (2**31 - 1, -5)
    assert inputs.digital == 2 and len(inputs.axes) == 5


def test_sdo_services(emulator: Emulator, client: BusClient) -> None:
    """Strings, numbers, long objects in segments, aborts with their text, unknown slaves."""
    node = InsistentNode(client)
    node.cycles(5)
    assert client.sdo_read("wheel_drive", 0x1008) == b"wheel_drive"
    assert client.sdo_read("wheel_drive", 0x6085) == (500_000_000).to_bytes(4, "little")
    client.sdo_write("wheel_drive", 0x6085, 0, (7).to_bytes(4, "little"))
    assert client.sdo_read("wheel_drive", 0x6085) == (7).to_bytes(4, "little")
    with pytest.raises(LookupError, match="0x06020000"):
        client.sdo_read("wheel_drive", 0x5FFF)
    with pytest.raises(LookupError, match="0x08000022"):
        client.sdo_write("bridges_a", 0x1C13, 0, b"\0")
    with pytest.raises(LookupError, match="wheel_drive"):
        client.sdo_read("wheel_driv", 0x1008)
    emulator.send("mailbox_hang", slave="bridges_a")
    with pytest.raises(LookupError, match="no answer within 20 ms"):
        client.sdo_read("bridges_a", 0x1008)
    emulator.send("mend")
    node.cycles(20)
    assert client.diagnostics()["health"] == "OK"


def test_wrong_identity(wire: BenchNamespace, emulator: Emulator) -> None:
    emulator.send("identity", slave="wheel_drive", vendor=0x00ABCDEF)
    text = refused(BusClient(BENCH, MASTER, launch=wire.enter))
    assert "slave 2" in text and "0x00ABCDEF" in text and "wheel_drive" in text


@pytest.mark.parametrize(
    ("drop", "words"),
    [
        (slice(0, 5), "5 of 9 slaves on 'veth0', missing from 'encoders_b' on"),
        (slice(0, 8), "missing from 'digital_out' on"),
    ],
)
def test_slaves_missing(wire: BenchNamespace, tmp_path: Path, drop: slice, words: str) -> None:
    there = changed(tmp_path, list(read_bus_file(BENCH).slaves[drop]))
    with contextlib.closing(Emulator(wire, there, *STUB)):
        assert words in refused(BusClient(BENCH, MASTER, launch=wire.enter))


@pytest.mark.usefixtures("emulator")
def test_one_slave_too_many(wire: BenchNamespace, tmp_path: Path) -> None:
    known = changed(tmp_path, list(read_bus_file(BENCH).slaves[:8]))
    text = refused(BusClient(known, MASTER, launch=wire.enter))
    assert "unknown: 'digital_out'" in text


def test_state_refused_at_start(wire: BenchNamespace, emulator: Emulator) -> None:
    emulator.send("al_refuse", slave="bridges_b", state="OP", code=0x0030)
    text = refused(BusClient(BENCH, MASTER, launch=wire.enter))
    assert "not all slaves reach OP" in text and "bridges_b: SAFEOP with error 0x0030" in text


def test_configuration_refused(wire: BenchNamespace, emulator: Emulator) -> None:
    emulator.send("mailbox_abort", slave="wheel_drive", code=0x06090030)
    text = refused(BusClient(BENCH, MASTER, launch=wire.enter))
    assert "wheel_drive refuses 0x605A:0" in text


@pytest.mark.usefixtures("emulator")
def test_pdos_differ_from_the_bus_file(wire: BenchNamespace, tmp_path: Path) -> None:
    """The slave has more process data than the file says."""
    text = BENCH.read_text().replace(
        '    - {object: "0x603F:0", type: uint16, channel: wheel.error_code, name: Error code}\n',
        "",
    )
    short = tmp_path / "short.yaml"
    short.write_text(text)
    words = refused(BusClient(short, MASTER, launch=wire.enter))
    assert "slave 'wheel_drive' has 18 input bytes, the bus file 16" in words


def test_no_slaves(wire: BenchNamespace) -> None:
    assert "no slaves on 'veth0'; check the cable" in refused(
        BusClient(BENCH, MASTER, launch=wire.enter)
    )


def test_reason_told_between_two_looks(monkeypatch: pytest.MonkeyPatch) -> None:
    """The process says why and ends while the client has just given up waiting for a message."""
    receive = BusClient._receive
    client = BusClient(BENCH, "eth77")

    def late(self: BusClient, timeout: float) -> dict | None:
        assert self.process is not None
        self.process.wait(20.0)
        monkeypatch.setattr(BusClient, "_receive", receive)
        return None

    monkeypatch.setattr(BusClient, "_receive", late)
    assert "eth77" in refused(client)


def test_no_such_interface(wire: BenchNamespace) -> None:
    text = refused(BusClient(BENCH, "eth77", launch=wire.enter))
    assert "'eth77' is not there; found:" in text and "veth0" in text


def test_interface_name_too_long(wire: BenchNamespace) -> None:
    text = refused(BusClient(BENCH, "a_name_of_16_cha", launch=wire.enter))
    assert "at most 15 characters" in text


def test_no_permission(wire: BenchNamespace) -> None:
    poor = [*wire.enter, "setpriv", "--bounding-set=-net_raw", "--inh-caps=-net_raw"]
    text = refused(BusClient(BENCH, MASTER, launch=poor))
    assert "sudo setcap" in text and "cap_net_raw" in text


def test_bus_file_missing_or_wrong(tmp_path: Path) -> None:
    with pytest.raises(BusFileError, match="No such file"):
        BusClient(tmp_path / "none.yaml", MASTER)
    raw = yaml.safe_load(BENCH.read_text())
    raw["slaves"][1]["vendr"] = raw["slaves"][1].pop("vendor")
    wrong = tmp_path / "wrong.yaml"
    wrong.write_text(yaml.safe_dump(raw))
    with pytest.raises(BusFileError, match="unknown key 'vendr'.*vendor"):
        BusClient(wrong, MASTER)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--interface", "eth77", "--bus", str(BENCH)), "eth77"),
        (("--interface", "a_name_of_16_cha", "--bus", str(BENCH)), "at most 15 characters"),
        (("--interface", "lo", "--bus", "none.yaml"), "none.yaml"),
        (("--interface", "lo", "--bus", str(BENCH), "--plant", "nothing:there"), "nothing"),
    ],
)
def test_emulator_refuses(arguments: tuple[str, ...], words: str) -> None:
    if "--plant" not in arguments:
        arguments = (*arguments, *STUB)
    result = subprocess.run(
        [sys.executable, "-m", "flatplank_sim.emulator", *arguments],
        capture_output=True,
        text=True,
        check=False,
    )
    assert result.returncode == 2
    assert words in result.stderr and len(result.stderr.strip().splitlines()) == 1
