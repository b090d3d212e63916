# SPDX-License-Identifier: Apache-2.0
"""Bus files: what is in ours, what is refused and with which words, and the round trip."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import yaml
from ethercat_rig import BUS_FILES

from flatplank_hw.bus.image import AXES
from flatplank_hw.ethercat import busfile
from flatplank_hw.ethercat.layout import TYPES, Layout, range_of_type
from flatplank_hw.ethercat.reader import BusFileError, parse_bus, read_bus_file
from flatplank_hw.ethercat.writer import write_bus

FILES = sorted(BUS_FILES.glob("*.yaml"))


def bench() -> dict[str, Any]:
    """Our bench file as plain data, to be spoilt."""
    return yaml.safe_load((BUS_FILES / "bench.yaml").read_text())


@pytest.mark.parametrize("path", FILES, ids=lambda p: p.stem)
def test_round_trip(path: Path) -> None:
    bus = read_bus_file(path)
    assert parse_bus(yaml.safe_load(write_bus(bus))) == bus


def test_the_bench_has_every_channel() -> None:
    bus = read_bus_file(BUS_FILES / "bench_five_axes.yaml")
    inputs = {e.channel for s in bus.slaves for e in s.input_entries} - {""}
    outputs = {e.channel for s in bus.slaves for e in s.output_entries} - {""}
    assert inputs == busfile.INPUTS and outputs == busfile.OUTPUTS
    assert {s.axis for s in bus.slaves} - {""} == set(AXES)


def test_placeholders_are_marked() -> None:
    """Nothing in our files claims to be a maker's identity that is not."""
    for path in FILES:
        for slave in read_bus_file(path).slaves:
            assert slave.placeholder or slave.device == "coupler", f"{path.name}: {slave.name}"


def spoil(raw: dict[str, Any], where: list[Any], value: Any) -> None:
    for key in where[:-1]:
        raw = raw[key]
    raw[where[-1]] = value


ROWS = ["slaves", 1, "outputs", 0, "entries"]
ENTRY = [*ROWS, 0]
VOLTS = ["slaves", 2, "inputs", 0, "entries", 0, "full_scale_volts"]


@pytest.mark.parametrize(
    ("where", "value", "words"),
    [
        (["format"], "flatplank-bus/9", "this version reads 'flatplank-bus/1'"),
        (["rate"], 250, "unknown key 'rate'.*rate_hz"),
        (["rate_hz"], 5000, "5000 is outside 50..2000"),
        (["rate_hz"], "fast", "'fast' is not a whole number"),
        (["slaves"], [], "no slaves"),
        (["slaves"], {"a": 1}, "expected a list"),
        (["slaves", 0], "coupler", "expected a mapping"),
        (["slaves", 0, "device"], "drve", "unknown device 'drve'.*drive"),
        (["slaves", 1, "vendor"], True, "True is not a whole number"),
        (["slaves", 1, "vendor"], -1, "-1 is outside"),
        (["slaves", 1, "name"], "coupler", "two slaves are named 'coupler'"),
        ([*ENTRY, "channel"], "wheel.controlword", "unknown channel.*wheel.control_word"),
        ([*ENTRY, "channel"], "wheel.status_word", "unknown channel 'wheel.status_word'"),
        ([*ENTRY, "type"], "uint17", "unknown type 'uint17'.*uint1"),
        ([*ENTRY, "object"], "0x60zz:0", "'0x60zz' is not a whole number"),
        ([*ENTRY, "object"], "0x10:0", "outside"),
        ([*ROWS, 1, "channel"], "wheel.control_word", "given twice"),
        ([*ROWS, 5, "unit_nm"], 0, "needs unit_nm"),
        (VOLTS, 0, "needs full_scale_volts"),
        (VOLTS, float("nan"), "not a number"),
        (["slaves", 1, "outputs", 0, "pdo"], 0x1200, "outside"),
        (["slaves", 1, "mailbox"], {"out_sise": 5}, "unknown key 'out_sise'.*out_size"),
        (["slaves", 1, "sdos", 0, "type"], "floatish", "unknown type"),
    ],
)  # fmt: skip
def test_refusals(where: list[Any], value: Any, words: str) -> None:
    raw = bench()
    spoil(raw, where, value)
    with pytest.raises(BusFileError, match=words) as caught:
        parse_bus(raw, "my.yaml")
    assert str(caught.value).startswith("my.yaml") and "\n" not in str(caught.value)


@pytest.mark.parametrize("text", ["a: [", "- 1\n", "\0", "just words"])
def test_files_that_are_no_bus_files(tmp_path: Path, text: str) -> None:
    path = tmp_path / "bad.yaml"
    path.write_text(text)
    with pytest.raises(ValueError, match=r"bad\.yaml") as caught:
        read_bus_file(path)
    assert "\n" not in str(caught.value)


# --- layouts ------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", TYPES)
def test_extremes_of_every_type(kind: str) -> None:
    bits = TYPES[kind][0]
    odd = Layout([("", 3), (kind, bits), ("", 5)])
    even = Layout([(kind, bits)])
    for value in (*range_of_type(kind), 0):
        assert odd.unpack(odd.pack((5, value, 9)))[1] == value
        assert even.unpack(even.pack((value,))) == (value,)


def test_shifting_and_struct_agree() -> None:
    kinds = ["uint16", "int8", "int32", "uint8", "int64"]
    values = (65535, -128, -5, 200, -(2**63))
    whole = Layout([(k, TYPES[k][0]) for k in kinds])
    pieces = Layout([*((k, TYPES[k][0]) for k in kinds), ("bool", 1)])
    assert pieces.pack((*values, 1))[:-1] == whole.pack(values)
    assert pieces.unpack(whole.pack(values) + b"\0") == (*values, 0)
