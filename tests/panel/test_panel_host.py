# SPDX-License-Identifier: Apache-2.0
"""What nodes the host of the panel starts, with what values, and what it refuses."""

from __future__ import annotations

from pathlib import Path

import pytest

from flatplank_control.calibration.book import book_for
from flatplank_data.errors import FlatplankError
from flatplank_panel import host as hosts
from flatplank_panel.host import Host, interfaces, presets, read_parameters, simulated_tires


class Nodes:
    """Processes that start and end when they are told to."""

    made: list[Nodes]

    def __init__(self, setup, log) -> None:
        self.setup, self.log, self.said = setup, log, []
        self.gone: dict[str, int] = {}
        Nodes.made.append(self)

    def start(self) -> None:
        self.said.append("start")

    def stop(self) -> None:
        self.said.append("stop")

    def ended(self) -> dict[str, int]:
        return dict(self.gone)


@pytest.fixture
def host(monkeypatch, tmp_path) -> Host:
    Nodes.made = []
    monkeypatch.setattr(hosts, "BenchProcesses", Nodes)
    monkeypatch.setattr(hosts, "interfaces", lambda: ["eth7"])
    return Host(tmp_path, tmp_path / "log", {"hub": {"a": 1}}, "/bench2")


def test_a_bench_is_started_once_and_ended(host, tmp_path):
    assert not host.running and host.newly_ended() == {}
    tire = simulated_tires()[-1]
    setup = host.start("sim", tire, "", "7", "500", interface="eth9", bus_file="../x")
    (nodes,) = Nodes.made
    assert nodes.setup is setup is host.setup and nodes.log == tmp_path / "log"
    assert (setup.kind, setup.tire, setup.preset, setup.seed) == ("sim", tire, "", 7)
    assert (setup.rate_hz, setup.interface, setup.bus_file) == (500, "", "")
    assert (setup.data, setup.namespace) == (str(tmp_path), "/bench2")
    assert setup.parameters == {"hub": {"a": 1}} and setup.calibration == str(
        book_for(tmp_path).path
    )
    with pytest.raises(ValueError, match="running already"):
        host.start("sim")
    nodes.gone = {"hub": -9}
    assert host.newly_ended() == {"hub": -9} and host.newly_ended() == {}
    nodes.gone = {"hub": -9, "drive": 1}
    assert host.newly_ended() == {"drive": 1}
    assert host.running
    host.stop()
    host.stop()
    assert nodes.said == ["start", "stop"] and not host.running and host.setup is None


@pytest.mark.parametrize(
    ("given", "said"),
    [({"kind": "moon"}, "bench 'moon' is not known"), ({"tire": "x"}, "tire 'x' is not known"),
     ({"preset": "x"}, "preset 'x' is not known"), ({"seed": -1}, "seed is -1, must be"),
     ({"seed": 2**31}, "seed is 2"), ({"rate": 49}, "bus rate is 49 Hz"),
     ({"rate": 1001}, "bus rate is 1001 Hz, must be within 50 .. 1000")],
)  # fmt: skip
def test_a_bench_of_other_values_is_not_started(host, given, said):
    with pytest.raises(ValueError, match=f"^{said}"):
        host.start(**{"kind": "sim", **given})
    assert not host.running and host.setup is None


def test_the_wiring_of_the_lab(host, tmp_path):
    packaged = hosts.config_file("flatplank_hw", "bus/bench.yaml")
    (tmp_path / "own.yaml").write_bytes(Path(packaged).read_bytes())
    found = []
    for given in ("", " bench ", "own.yaml"):
        setup = host.start("lab", interface="eth7", bus_file=given)
        found.append((setup.interface, setup.bus_file))
        host.stop()
    assert found == [("eth7", ""), ("eth7", "bench"),
                     ("eth7", str((tmp_path / "own.yaml").resolve()))]  # fmt: skip
    with pytest.raises(ValueError, match="network interface 'eth9' is not known"):
        host.start("lab", interface="eth9")


def test_without_a_simulator_there_are_the_usual_tire_and_no_presets(monkeypatch):
    assert len(simulated_tires()) == len(set(simulated_tires())) > 1
    assert next(iter(presets().items())) == ("", "none") and len(presets()) > 1

    def none() -> None:
        raise FlatplankError("not installed")

    monkeypatch.setattr(hosts, "simulator", none)
    assert simulated_tires() == ["toyo"] and presets() == {"": "none"}


def test_interfaces_that_can_carry_a_bus(monkeypatch):
    monkeypatch.setattr(hosts.socket, "if_nameindex", lambda: [(1, "lo"), (2, "eth7"), (3, "b")])
    assert interfaces() == ["eth7", "b"]


def test_parameters_in_a_file(tmp_path):
    path = tmp_path / "p.yaml"
    path.write_text("hub:\n  ros__parameters: {a: 1}\ndrive:\n  ros__parameters: {b: x}\n")
    assert read_parameters(path) == {"hub": {"a": 1}, "drive": {"b": "x"}}
    path.write_text("")
    assert read_parameters(path) == {}
    path.write_text("- 1")
    with pytest.raises(ValueError, match="expected node names"):
        read_parameters(path)
    with pytest.raises(ValueError, match=r"gone.yaml: cannot be read \(No such file"):
        read_parameters(tmp_path / "gone.yaml")
