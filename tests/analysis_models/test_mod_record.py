# SPDX-License-Identifier: Apache-2.0
"""Tire records against numbers known without them; units of a tire property file."""

from __future__ import annotations

import math
from dataclasses import fields, replace
from types import MappingProxyType

import pytest

from flatplank_analysis.models.tire_record import (
    PLACEHOLDER,
    TireRecord,
    parse_record,
    read_record,
    start_tir,
)
from flatplank_data.errors import FlatplankError
from flatplank_tire.magic_formula.coefficients import DIMENSIONS, UNITS, factor
from flatplank_tire.tir import shipped_tir, write_tir


def test_what_a_record_does_not_know_is_typical_and_said():
    record = TireRecord("A", 0.3, 3000.0, 2.5, source="sheet", contact={"q_ra1": 0.8},
                        placeholder=("free_radius",))  # fmt: skip
    found, sources = record.geometry()
    assert found.vertical_stiffness == pytest.approx(3000.0 / (0.05 * 0.3))
    assert found.nominal_pressure == pytest.approx(2.5e5) and found.free_radius == 0.3
    assert (found.pressure_effect, found.q_ra1, found.q_ra2) == (0.85, 0.8, 0.29)
    assert sources["q_ra1"] == sources["nominal_pressure"] == "not measured: tire record A, sheet"
    for name in ("vertical_stiffness", "pressure_effect", "q_ra2", "free_radius"):
        assert sources[name] == PLACEHOLDER
    assert record.headline() == "A: R0 0.3 m, nominal 3000 N and 2.5 bar ()"
    assert replace(record, name="", description="new").headline().startswith("without a name: ")
    assert "bar, new" in replace(record, description="new").headline()
    text = replace(record, contact=MappingProxyType(record.contact)).to_yaml()
    assert "width" not in text and "origin" not in text and "rim" not in text
    assert replace(parse_record(text, ""), width=math.nan).to_yaml() == text


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("free_radius: 5", "free_radius is 5 m, must be within 0.1 .. 1"),
        ("width: x", "width must be a number, not 'x'"),
        ("nominal_load: 20", "20 N"), ("nominal_pressure: 16", "16 bar"),
        ("rim_radius: 0.9", "0.9 m"), ("radius: 1", "unknown parameter 'radius'"),
        ("contact: [1]", "contact: expected names with values"),
        ("contact: {q_ra3: 1}", "contact is 'q_ra3'; the nearest is 'q_ra"),
        ("contact: {q_ra1: x}", "contact: q_ra1 must be a number"),
    ],
)  # fmt: skip
def test_mistakes_of_a_record(line, words):
    known = {"name": "A", "free_radius": 0.3, "nominal_load": 3000, "nominal_pressure": 2.5}
    key, value = line.split(": ", 1)
    text = "format: flatplank-tire/1\n" + "".join(
        f"{k}: {v}\n" for k, v in {**known, key: value}.items()
    )
    with pytest.raises(FlatplankError) as error:
        parse_record(text, "a.yaml")
    assert words in str(error.value) and "a.yaml" in str(error.value)
    whole = parse_record(text.replace(line, f"{key}: {known[key]}") if key in known
                         else text.replace(line + "\n", ""), "a.yaml")  # fmt: skip
    assert (whole.name, whole.origin, whole.contact) == ("A", "a.yaml", {})


def test_a_record_of_a_tire_property_file_and_back(tmp_path):
    tir = shipped_tir().replaced({"WIDTH": 0.2, "RIM_RADIUS": 0.21})
    path = tmp_path / "mine.tir"
    write_tir(tir, path)
    c, record = tir.coefficients, read_record(path)
    assert (record.name, record.start_file, record.origin) == ("mine", str(path), str(path))
    assert (record.free_radius, record.width, record.rim_radius) == (c.UNLOADED_RADIUS, 0.2, 0.21)
    assert record.nominal_pressure == pytest.approx(1e-5 * c.NOMPRES)
    assert record.nominal_load == c.FNOMIN
    wanted = (c.VERTICAL_STIFFNESS, c.PFZ1, c.Q_RA1, c.Q_RA2)
    assert tuple(record.contact.values()) == wanted
    bare = tmp_path / "bare.tir"
    write_tir(tir.replaced({"Q_RA1": 0.0, "WIDTH": 0.0}), bare)
    assert set(read_record(bare).contact) == {"vertical_stiffness", "pressure_effect"}
    assert math.isnan(read_record(bare).width)
    lines = path.read_text().splitlines()
    bare.write_text("\n".join(x for x in lines if not x.startswith("VERTICAL_STIFFNESS")))
    assert set(read_record(bare).contact) == {"q_ra1", "q_ra2"}
    # the numbers of the record go before those of its start file
    other = replace(
        record, free_radius=0.33, nominal_load=2900.0, nominal_pressure=2.2, width=math.nan
    )
    started = start_tir(other, {}).coefficients
    assert (started.UNLOADED_RADIUS, started.FNOMIN, started.WIDTH) == (0.33, 2900.0, 0.2)
    assert pytest.approx(2.2e5) == started.NOMPRES and started.PKX1 == c.PKX1
    with pytest.raises(FlatplankError, match="is not there"):
        start_tir(replace(record, start_file="gone.tir"), {})
    shipped = start_tir(replace(other, start_file="toyo_nanoenergy.tir"), {}).coefficients
    assert shipped.PKX1 == c.PKX1
    with pytest.raises(FlatplankError, match="missing PCX1"):
        start_tir(replace(other, start_file=""), {"PKX1": 21.0})
    values = {k: getattr(c, k) for k in ("PCX1", "PDX1", "PCY1", "PDY1", "PKY1")}
    general = start_tir(replace(other, start_file=""), values | {"PKX1": 21.0}).coefficients
    assert (general.PKX1, general.UNLOADED_RADIUS) == (21.0, 0.33)
    assert general.VERTICAL_STIFFNESS == c.VERTICAL_STIFFNESS and general.Q_RA1 == c.Q_RA1
    # a start file beside the record is found from anywhere
    yaml = tmp_path / "mine.yaml"
    yaml.write_text(replace(other, start_file="mine.tir").to_yaml())
    assert read_record(yaml).start_file == str(path)
    for given in ("", "toyo_nanoenergy.tir", str(path)):
        yaml.write_text(replace(other, start_file=given).to_yaml())
        assert read_record(yaml).start_file == given
    for text, words in (("a: [", "not YAML"), ("a: 1", "format is not"),
                        ("format: flatplank-tire/1\nname: A", "missing free_radius")):  # fmt: skip
        yaml.write_text(text)
        with pytest.raises(FlatplankError, match=words):
            read_record(yaml)
    with pytest.raises(FlatplankError, match="give a tire record"):
        read_record(tmp_path / "none.yaml")


def test_factors_of_units():
    """Powers of the units: a stiffness is force over length, a pressure is its own quantity."""
    units = {"LENGTH": 1e-3, "FORCE": 1e3, "TIME": 60.0, "PRESSURE": 1e5}
    for key, wanted in (("WIDTH", 1e-3), ("VXLOW", 1e-3 / 60.0), ("NOMPRES", 1e5), ("FNOMIN", 1e3),
                        ("VERTICAL_STIFFNESS", 1e6), ("YAW_STIFFNESS", 1.0), ("PKX1", 1.0),
                        ("VERTICAL_DAMPING", 6e7)):  # fmt: skip
        assert factor(key, units) == pytest.approx(wanted), key
        assert factor(key, {}) == 1.0
    assert "PKX1" not in DIMENSIONS and set(UNITS["ANGLE"].values()) == {1.0}


def test_a_record_file_says_where_it_is_and_what_is_wrong(tmp_path):
    path = tmp_path / "mine.yaml"
    head = "format: flatplank-tire/1\nname: 7\nfree_radius: '0.3'\nnominal_load: 3000\n"
    path.write_text(
        head + "nominal_pressure: 2.5\nrim: 5\nplaceholder: [1]\nmounted: 2023-03-01\n"
    )
    record = read_record(str(path))
    assert record.origin == str(path) and (record.name, record.rim) == ("7", "5")
    assert (record.free_radius, record.placeholder) == (0.3, ("1",))
    assert record.mounted == "2023-03-01" and parse_record(record.to_yaml(), "").rim == "5"
    for content, words in (
        (b"format: flatplank-tire/1\nname: [\n", "mine.yaml line 3: not YAML"),
        (b"\xff", "mine.yaml: is no text; give a tire record"),
        (b"a: \x00", "mine.yaml: not YAML"),
        (b"format: flatplank-tire/1\n5: 1\n", "unknown parameter '5'; known are "),
        (head.encode() + b"nominal_pressure: 2\ncontact: {3: 1}\n", "contact is '3'; known are "),
        (b"- 1", "format is not flatplank-tire/1; begin with format: flatplank-tire/1"),
        (b"format: flatplank-tire/1", "missing name, free_radius, nominal_load, nominal_pressure"),
    ):
        path.write_bytes(content)
        with pytest.raises(FlatplankError) as error:
            read_record(path)
        assert words in str(error.value)


RANGES = {f.name: f.metadata for f in fields(TireRecord) if f.metadata.get("bounds")}


@pytest.mark.parametrize("key", RANGES)
def test_ends_of_a_range_are_in_it(key):
    low, high = RANGES[key]["bounds"]
    numbers = {"free_radius": 0.3, "nominal_load": 3000.0, "nominal_pressure": 2.5}

    def text(value):
        rows = [f"{k}: {v}" for k, v in (numbers | {key: value}).items()]
        return "\n".join(["format: flatplank-tire/1", "name: A", *rows])

    for value in (low, high):
        assert getattr(parse_record(text(value), "a"), key) == value
    for value in (0.999 * low, 1.001 * high, ".nan"):
        with pytest.raises(FlatplankError, match="must be within|must be finite"):
            parse_record(text(value), "a")
