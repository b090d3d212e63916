# SPDX-License-Identifier: Apache-2.0
"""Units of files against values worked out by hand from their definitions."""

from __future__ import annotations

import numpy as np
import pytest

from flatplank_data.errors import FlatplankError
from flatplank_data.units import UNITS, conversions, is_bare, is_unit, to_si, units_of

#: unit -> SI unit, value of one unit in SI (NIST Special Publication 811, 2008, appendix B.8)
VALUES = {
    "s": ("s", 1.0), "ms": ("s", 0.001), "us": ("s", 0.000001), "ns": ("s", 0.000000001),
    "min": ("s", 60.0), "h": ("s", 3600.0), "d": ("s", 86400.0),
    "m": ("m", 1.0), "mm": ("m", 0.001), "cm": ("m", 0.01), "km": ("m", 1000.0),
    "in": ("m", 0.0254), "ft": ("m", 0.3048), "mi": ("m", 1609.344),
    "rad": ("rad", 1.0), "mrad": ("rad", 0.001), "deg": ("rad", 0.017453292519943295),
    "gon": ("rad", 0.015707963267948967), "rev": ("rad", 6.283185307179586),
    "n": ("N", 1.0), "dan": ("N", 10.0), "kn": ("N", 1000.0), "kgf": ("N", 9.80665),
    "lbf": ("N", 4.4482216152605), "kip": ("N", 4448.2216152605),
    "pa": ("Pa", 1.0), "hpa": ("Pa", 100.0), "kpa": ("Pa", 1000.0), "mpa": ("Pa", 1000000.0),
    "bar": ("Pa", 100000.0), "mbar": ("Pa", 100.0), "atm": ("Pa", 101325.0),
    "psi": ("Pa", 6894.757293168),
    "kg": ("kg", 1.0), "lb": ("kg", 0.45359237),
    "v": ("V", 1.0), "mv": ("V", 0.001), "k": ("K", 1.0),
    "1": ("1", 1.0), "%": ("1", 0.01),
    "nm": ("N m", 1.0), "knm": ("N m", 1000.0), "nmm": ("N m", 0.001),
    "g": ("m/s2", 9.80665), "mph": ("m/s", 0.44704), "kph": ("m/s", 0.2777777777777778),
    "rpm": ("rad/s", 0.10471975511965977), "1/min": ("rad/s", 0.10471975511965977),
}  # fmt: skip
SPELLINGS = {
    ("N", 4.4482216152605): ("lb", "lbs", "LBF", "lbf.", "[lb]", "(lbf)", "pounds"),
    ("N", 9.80665): ("kg", "kp", "kgf", "kilopond"),
    ("N m", 1.3558179483314004): (
        "ft-lb", "ft-lbs", "ft-lbf", "lbf-ft", "lb-ft", "ft.lb", "ft lbf", "ft·lbf", "ftlb",
        "lbf*ft", "FT-LB",
    ),
    ("N m", 0.1129848290276167): ("in-lb", "in-lbf", "lbf-in", "lb.in", "inlb", "in·lbf"),
    ("N m", 1.0): ("N-m", "N m", "N.m", "N·m", "N*m", "Nm", "nm", "newton meter"),
    ("N m", 1000.0): ("kN-m", "kN m", "kNm"),
    ("m/s", 0.3048): ("ft/s", "ft/sec", "feet per second"),
    ("m/s", 0.44704): ("mph", "MPH", "mi/h", "mi/hr", "miles per hour", "mile/h"),
    ("m/s", 1.0 / 3.6): ("km/h", "kph", "kmh", "km/hr", "KPH"),
    ("m/s", 1.0): ("m/s", "m s-1", "m.s-1", "meters per second"),
    ("m/s2", 1.0): ("m/s2", "m/s^2", "m/s**2", "m/s²"),
    ("rad", 0.017453292519943295): ("deg", "°", "degree", "Degrees", "[deg]", "deg."),
    ("rad/s", 0.017453292519943295): ("deg/s", "°/s", "deg/sec", "degrees per second"),
    ("rad/s", 0.10471975511965977): ("rpm", "1/min", "U/min", "rev/min", "r/min"),
    ("Pa", 6894.757293168): ("psi", "psig", "psi(g)", "PSI", "lbf/in2", "lbf/in²", "psi g"),
    ("Pa", 1e5): ("bar", "bar(g)", "barg", "bar (g)", "bar(rel)", "[bar(g)]", "barü"),
    ("Pa", 1000.0): ("kPa", "kPa(g)", "kpag", "kN/m2"),
    ("Pa", 98066.5): ("kgf/cm2", "kg/cm²", "kg/cm2"),
    ("Pa", 1e6): ("MPa", "N/mm2"),
    ("N/m", 1000.0): ("N/mm", "kN/m"),
    ("N/m", 175.12683524647636): ("lbf/in", "lb/in"),
    ("1", 0.01): ("%", "percent", "perc", "pct"),
    ("1", 1.0): ("", "-", "none", "1", "[-]", "unitless", "[]", "[ ]", "bool"),
    ("N", 1000.0): ("kN", "[ kN ]", "([kN])", "'kN'", "{kN}", '"kn"', " kN. "),
    ("s", 1.0): ("sec", "seconds", "S"),
    ("s", 86400.0): ("d", "day", "days"),
    ("s", 1e-6): ("µs", "μs", "us", "usec"),
    ("m", 0.0254): ("in", "inch", "inches"),
}  # fmt: skip


def test_every_unit_of_the_table_has_its_value():
    assert VALUES.keys() == UNITS.keys()
    for unit, (si, value) in VALUES.items():
        assert to_si(np.array([1.0]), unit, si, "")[0] == pytest.approx(value, rel=1e-12), unit


@pytest.mark.parametrize("meaning", SPELLINGS, ids=str)
def test_a_unit_is_read_however_it_is_written(meaning):
    si, value = meaning
    for text in SPELLINGS[meaning]:
        found = to_si(np.array([0.0, 1.0]), text, si, "")
        assert found == pytest.approx([0.0, value], rel=1e-12), text


def test_temperatures_have_another_zero():
    assert to_si(np.array([0.0, 100.0]), "°C", "K", "") == pytest.approx([273.15, 373.15])
    assert to_si(np.array([32.0, 212.0]), "degF", "K", "") == pytest.approx([273.15, 373.15])


@pytest.mark.parametrize(
    ("unit", "expected", "words"),
    [
        ("bar(a)", "Pa", "absolute pressure"),
        ("psia", "Pa", "absolute pressure"),
        ("kX", "N", "unknown unit 'kX'"),
        ("lb", "m", "does not fit a quantity in m"),
        ("ft-lb", "N", "does not fit a quantity in N"),
        ("0,00000", "s", "unknown unit"),
        ("N/", "N", "unknown unit"),
        ("", "N", "does not fit"),
    ],
)
def test_other_units_are_refused(unit, expected, words):
    with pytest.raises(FlatplankError, match=words.replace("(", r"\(")):
        to_si(np.zeros(1), unit, expected, "a.csv")


def test_a_bare_number_is_no_unit():
    assert is_bare("-") and is_bare("[1]") and not is_bare("%") and not is_bare("m")
    assert is_unit("kN") and is_unit("%") and not is_unit("1") and not is_unit("fx")
    assert not conversions("12.5") and not conversions("Round 9")


@pytest.mark.parametrize(
    ("text", "si", "factor"),
    [("m/s/s", "m/s2", 1.0), ("ft/s2", "m/s2", 0.3048), ("N/mm2", "Pa", 1e6)],
)
def test_powers_of_a_unit(text, si, factor):
    ((found, by, offset),) = conversions(text)
    assert (found, offset) == (si, 0.0) and by == pytest.approx(factor)


def test_the_simple_units_of_a_quantity():
    assert units_of("m/s")["ft/s"] == pytest.approx(0.3048)
    assert {"kn", "lbf", "kgf"} <= units_of("N").keys()


UNKNOWN = ("[", "]", "[kN", "kN]", "(kN]", "N/N2", "m2", "1/s", "kg s", "N m2", "s-1", "V/m", "-1",
           "psi(x)", "m/", "/s", "kN s", "m0", "N-", "mm mm")  # fmt: skip


@pytest.mark.parametrize("text", UNKNOWN)
def test_what_no_column_has_is_no_unit(text):
    """Areas, frequencies and the like are units, but no quantity here has them."""
    assert conversions(text) == () and not is_unit(text) and not is_bare(text)


@pytest.mark.parametrize(
    ("text", "meanings"),
    [
        ("kg", {("kg", 1.0), ("N", 9.80665)}),
        ("lb", {("kg", 0.45359237), ("N", 4.4482216152605)}),
        ("kg/cm2", {("Pa", 98066.5)}),
        ("kg m", {("N m", 9.80665)}),
        ("kg m/s2", set()),
        ("N/N", {("1", 1.0)}),
        ("mm/m", {("1", 1e-3)}),
        ("m2/m", {("m", 1.0)}),
        ("rad/min", {("rad/s", 1.0 / 60.0)}),
        ("g", {("m/s2", 9.80665)}),
    ],
)
def test_all_meanings_of_a_unit(text, meanings):
    found = sorted((si, factor) for si, factor, _ in conversions(text))
    assert [si for si, _ in found] == [si for si, _ in sorted(meanings)]
    assert [f for _, f in found] == pytest.approx([f for _, f in sorted(meanings)])


def test_all_simple_units_of_a_quantity_are_offered():
    expected = {
        "m": {"m", "mm", "cm", "km", "in", "ft", "mi"},
        "s": {"s", "ms", "us", "ns", "min", "h", "d"},
        "rad/s": {"rpm", "1/min", "deg/s"},
        "m/s": {"mph", "kph", "mm/s", "ft/s"},
        "N m": {"nm", "knm", "nmm"},
        "1": {"1", "%"},
        "x": set(),
    }
    for si, units in expected.items():
        assert units_of(si).keys() == units, si
    assert units_of("rad/s")["deg/s"] == pytest.approx(0.017453292519943295)
    assert units_of("m/s")["mm/s"] == pytest.approx(1e-3)


def test_an_absolute_pressure_is_told_from_a_wrong_quantity():
    with pytest.raises(FlatplankError) as raised:
        to_si(np.zeros(1), "bar", "N", "a.csv")
    assert "does not fit a quantity in N" in str(raised.value) and "a.csv" in str(raised.value)
