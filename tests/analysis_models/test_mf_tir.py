# SPDX-License-Identifier: Apache-2.0
"""Tire property files: written from the format's description, with its mistakes."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from flatplank_analysis.models.tire_state import tire_state
from flatplank_data.errors import FlatplankError
from flatplank_tire.magic_formula import NOT_OF, SECTION_OF
from flatplank_tire.tir import (
    SHIPPED,
    check_tir,
    format_tir,
    parse_tir,
    read_tir,
    shipped_tir,
    write_tir,
)
from flatplank_tire.tir_complete import HEAD, RANGES, complete_tir

TEXT = """[MDI_HEADER]
FILE_TYPE                = 'tir'
FILE_VERSION             = 3.0
FILE_FORMAT              = 'ASCII'
! : a comment of the header
$----------------------------------------------------------------units
[UNITS]
 LENGTH                  = 'meter'
 FORCE                   = 'newton'
 ANGLE                   = 'radians'
 MASS                    = 'kg'
 TIME                    = 'second'
$----------------------------------------------------------------model
[MODEL]
 PROPERTY_FILE_FORMAT    = 'MF_05'
 FITTYP                  = 61                $ MF 6.1
 VXLOW                   = 1.0
 LONGVL                  = 16.7
[DIMENSION]
UNLOADED_RADIUS          = 0.3135            $ Free tyre radius
WIDTH                    = 0.205
[OPERATING_CONDITIONS]
NOMPRES                  = 2.2E5
[VERTICAL]
FNOMIN                   = 4000
VERTICAL_STIFFNESS       = 2.0e+05
[SHAPE]
{radial width}
 1.0    0.0
 1.0    0.4
[LONGITUDINAL_COEFFICIENTS]
PCX1                     = 1.6
PDX1                     = 1.0
PKX1                     = 16               ! slip stiffness
[LATERAL_COEFFICIENTS]
PCY1                     = 1.3
PDY1                     = 1
PKY1                     = -15
PKY2                     = 2
[OWN_SECTION]
OWN_KEY                  = 'kept as it is'
"""


def test_values_comments_and_unknown_parts() -> None:
    tir = parse_tir(TEXT, "a.tir")
    check_tir(tir)
    assert tir.values["UNLOADED_RADIUS"] == 0.3135
    assert tir.values["VERTICAL_STIFFNESS"] == 2e5
    assert tir.coefficients.PKY4 == 2.0
    assert tir.entries["OWN_KEY"].value == "'kept as it is'"
    assert tir.kept["SHAPE"] == ("{radial width}", "1.0    0.0", "1.0    0.4")
    assert tire_state(tir, 4000, 0.05, vx=16.7).fx == pytest.approx(2702.570925, rel=1e-9)


def test_round_trip_keeps_everything(tmp_path: Path) -> None:
    tir = parse_tir(TEXT)
    write_tir(tir.replaced({"PKX1": 17.5, "QDZ1": 0.1}), tmp_path / "b.tir")
    again = read_tir(tmp_path / "b.tir")
    assert again.values == tir.values | {"PKX1": 17.5, "QDZ1": 0.1}
    assert again.kept == tir.kept
    assert {k: e.value for k, e in again.sections["OWN_SECTION"].items()} == {
        "OWN_KEY": "'kept as it is'"
    }
    assert format_tir(again) == format_tir(parse_tir(format_tir(again)))


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("PDX1                     = 1.0", "", "missing PDX1"),
        ("WIDTH                    = 0.205", "PKX1 = 15", "PKX1 is 15 in line 21 and 16 here"),
        ("PDX1                     = 1.0", "PKX1 = 15", "PKX1 stands twice, first in line"),
        ("'meter'", "'cubit'", "unit of LENGTH is cubit"),
        ("= 61 ", "= 70 ", "not Magic Formula 5.2 or 6.0 to 6.2"),
        ("= 61 ", "= 52 \n[LATERAL_COEFFICIENTS]\nPCY2 = 0.8", "PCY2 is of .* motorcycles"),
        ("2.0e+05", "2,0e5", "is not a number"),
        ("2.0e+05", "nan", "= nan is not a number"),
        ("FNOMIN                   = 4000", "FNOMIN = 0", "FNOMIN = 0 is not positive"),
    ],
)
def test_mistakes_are_one_line_with_place_and_remedy(
    tmp_path: Path, old: str, new: str, says: str
) -> None:
    path = tmp_path / "bad.tir"
    path.write_text(TEXT.replace(old, new))
    with pytest.raises(FlatplankError, match=says) as error:
        read_tir(path)
    text = str(error.value)
    assert "\n" not in text
    assert "bad.tir" in text
    assert "; " in text


def test_missing_file_is_one_line() -> None:
    with pytest.raises(FlatplankError, match="No such file"):
        read_tir("nowhere.tir")


def test_warnings() -> None:
    assert "VXLOW" not in " ".join(parse_tir(TEXT).warnings(vx=-1.0))
    assert "VXLOW" in " ".join(parse_tir(TEXT).warnings(vx=-0.99))
    said = " | ".join(parse_tir(TEXT).warnings(vx=0.03))
    assert "VXLOW = 1 m/s is above the speed of 0.03 m/s" in said
    assert "LATERAL_STIFFNESS is missing: sigma_y is not known" in said
    assert "VXLOW" not in " ".join(parse_tir(TEXT).warnings(vx=16.7))
    assert any("PKY2 = 0" in w for w in shipped_tir().warnings())


@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_sets(name: str) -> None:
    tir = shipped_tir(name)
    check_tir(tir)
    assert tir.values["VXLOW"] == 0.0 and tir.path == f"{name}.tir"
    state = tire_state(tir, tir.values["FNOMIN"])
    plain = state.to_json()
    assert plain["sigma_y"] is None
    assert math.isnan(state.sigma_y)
    wanted = {"fx", "fy", "mz", "mx", "my", "re", "a", "sigma_x", "sigma_y", "kx", "ky"}
    assert set(plain) == wanted


FIELD = """[UNITS]
LENGTH = 'mm'
FORCE = 'kN'
ANGLE = 'degrees'
MASS = 'kg'
TIME = 'second'
PRESSURE = 'bar'
[MODEL]
FITTYP = 62
LONGVL = 16700
VXLOW =
[DIMENSION]
UNLOADED_RADIUS = 313.5
WIDTH =
[OPERATING_CONDITIONS]
NOMPRES = 2.2
[INERTIA]
MASS =
[VERTICAL]
FNOMIN = 4
VERTICAL_STIFFNESS =
[LONGITUDINAL_COEFFICIENTS]
PCX1 = 1.6
PDX1 = 1
PDX2 = -.1
PKX1 = 16
[LATERAL_COEFFICIENTS]
PCY1 = 1.3
PDY1 = 1
PKY1 = -15
PKY2 = 2
"""


def test_what_the_tools_of_the_field_write_is_read(tmp_path: Path) -> None:
    """A key in two sections, empty values, other units, no vertical stiffness."""
    path = tmp_path / "field.tir"
    path.write_text(FIELD)
    tir = read_tir(path)
    assert tir.values["UNLOADED_RADIUS"] == pytest.approx(0.3135)
    assert tir.values["FNOMIN"] == 4000.0
    assert tir.values["NOMPRES"] == pytest.approx(2.2e5)
    assert "WIDTH" not in tir.values
    state = tire_state(tir, 4000, 0.05, vx=16.7)
    # row of the independent solver, set "book"
    assert state.fx == pytest.approx(2702.570925, rel=1e-9)
    assert math.isnan(state.re)
    assert state.to_json()["re"] is None
    said = " | ".join(tir.warnings())
    assert "VERTICAL_STIFFNESS is missing: R_e" in said
    assert "converted to SI from LENGTH mm, FORCE kN, PRESSURE bar" in said
    assert "per radian" in said
    assert "not in the file, taken with their defaults: " in said
    assert "PKX2" in said


def test_what_is_written_again_has_the_units_of_the_file(tmp_path: Path) -> None:
    changed = parse_tir(FIELD).replaced({"FNOMIN": 4500.0, "VERTICAL_STIFFNESS": 2e5})
    write_tir(changed, tmp_path / "again.tir")
    again = read_tir(tmp_path / "again.tir")
    assert again.sections["VERTICAL"]["FNOMIN"].value == "4.5"
    assert again.values["VERTICAL_STIFFNESS"] == pytest.approx(2e5)
    assert again.sections["UNITS"]["MASS"].value == "'kg'"


OLD_TEXT = (
    TEXT.replace("= 61 ", "= 6  ").replace("NOMPRES                  = 2.2E5", "")
    + """
[SCALING_COEFFICIENTS]
LGAY                     = 0.9
[LATERAL_COEFFICIENTS]
PHY3                     = 0.03
PVY3                     = -0.2
"""
)


@pytest.mark.parametrize("version", ["5", "6", "21", "52"])
def test_files_of_5_2_are_read_with_their_law(tmp_path: Path, version: str) -> None:
    path = tmp_path / "old.tir"
    path.write_text(OLD_TEXT.replace("= 6  ", f"= {version}  "))
    tir = read_tir(path)
    assert tir.law == "5.2"
    c = tir.coefficients
    assert (c.law, c.LGAY, c.PHY3, c.LGAX) == ("5.2", 0.9, 0.03, 1.0)
    side = tire_state(tir, 4000, gamma=0.05).fy - tire_state(tir, 4000).fy
    stiffness = tire_state(tir, 4000).ky
    # small camber: its shift times the cornering stiffness, and its own force
    assert side == pytest.approx(0.045 * (0.03 * stiffness - 0.2 * 4000), rel=0.01)
    again = tmp_path / "again.tir"
    write_tir(tir, again)
    assert read_tir(again).coefficients.__dict__ == c.__dict__
    said = " | ".join(tir.warnings())
    assert "PHY3" not in said and "the contact length is not known" in said
    assert tire_state(tir, 4000).to_json()["a"] is None


def test_what_the_law_does_not_have_is_not_used_and_named() -> None:
    mixed = parse_tir(OLD_TEXT + "PPY1 = 0.4\nPKY4 = 2\n")
    assert mixed.coefficients.PPY1 == 0.0
    said = " | ".join(mixed.warnings())
    assert "Magic Formula 5.2 has no PPY1: not used; write FITTYP = 61 if" in said
    new = parse_tir(OLD_TEXT.replace("= 6  ", "= 61 "))
    assert new.coefficients.PHY3 == 0.0
    assert "Magic Formula 6.1 has no PHY3, LGAY: not used; write FITTYP = 6 if" in " | ".join(
        new.warnings()
    )


def test_without_fittyp_the_coefficients_tell_the_law() -> None:
    line = " FITTYP                  = 6                 $ MF 6.1\n"
    without = parse_tir(OLD_TEXT.replace(line, ""))
    assert "FITTYP" not in without.entries and without.law == "5.2"
    assert any("taken as Magic Formula 5.2" in w for w in without.warnings())
    plain = TEXT.replace(line.replace("= 6  ", "= 61 "), "")
    assert parse_tir(plain).law == "6.1"
    assert parse_tir(plain.replace("'MF_05'", "'PAC2002'")).law == "PAC2002"


def _as_simple_readers_do(text: str) -> dict[str, dict[str, float | str]]:
    """Sections of KEY = VALUE, split at the first '=', '$' begins a comment; no key twice."""
    sections: dict[str, dict[str, float | str]] = {}
    for line in (line.strip() for line in text.splitlines()):
        if line.startswith("["):
            assert line.endswith("]") and line[1:-1] not in sections
            here = sections.setdefault(line[1:-1], {})
        elif line and line[0] not in "!$":
            key, value = (part.strip() for part in line.split("$")[0].split("="))
            assert value and key == key.upper() and key not in here
            here[key] = value.strip("'") if value[0] == "'" else float(value)
    return sections


@pytest.mark.parametrize("name", SHIPPED)
def test_a_whole_file_leaves_nothing_to_the_defaults_of_other_programs(
    name: str, tmp_path: Path
) -> None:
    """Programs take other values for what is not given, or refuse the file."""
    tir = shipped_tir(name)
    ranges = {"fz": (1800.0, 5600.0), "kappa": (-0.1, 0.1)}
    write_tir(complete_tir(tir, ranges), tmp_path / "whole.tir")
    found = _as_simple_readers_do((tmp_path / "whole.tir").read_text())
    assert {*HEAD, *RANGES} <= found.keys()
    made = complete_tir(tir, ranges)
    assert all(isinstance(e.value, str) for s in made.sections.values() for e in s.values())
    assert found["UNITS"] == {"LENGTH": "meter", "FORCE": "newton", "ANGLE": "radians",
                              "MASS": "kg", "TIME": "second"}  # fmt: skip
    assert found["MODEL"]["FITTYP"] == 61.0 and found["MODEL"]["TYRESIDE"] == "LEFT"
    for key, section in SECTION_OF.items():
        unknown = math.isnan(tir.values.get(key, getattr(tir.coefficients, key)))
        if not (key in NOT_OF[tir.law] or section.startswith("FLATPLANK") or unknown):
            nominal = {"INFLPRES": tir.coefficients.NOMPRES}
            wanted = nominal.get(key, getattr(tir.coefficients, key))
            assert found[section][key] == pytest.approx(wanted), key
    assert found["VERTICAL_FORCE_RANGE"] == {"FZMIN": 1800.0, "FZMAX": 5600.0}
    assert found["SLIP_ANGLE_RANGE"] == {"ALPMIN": -1.5, "ALPMAX": 1.5}
    again = read_tir(tmp_path / "whole.tir")
    assert format_tir(complete_tir(again)) == format_tir(complete_tir(tir, ranges))
    states = [tire_state(t, 3000, 0.03, 0.02).to_json() for t in (again, tir)]
    assert states[0] == states[1]


def test_ranges_of_a_whole_file_are_those_of_the_last_fit() -> None:
    """A file that is written again without new ranges keeps those that it has."""
    first = complete_tir(parse_tir(TEXT), {"fz": (1000.0, 5000.0)})

    def loads(tir) -> list[str]:
        return [e.value for e in tir.sections["VERTICAL_FORCE_RANGE"].values()]

    assert loads(first) == ["1000.0", "5000.0"] == loads(complete_tir(first))
    assert loads(complete_tir(first, {"fz": (2000.0, 3000.0)})) == ["2000.0", "3000.0"]
    assert (
        loads(complete_tir(first, {}))
        == ["0.0", "100000.0"]
        == loads(complete_tir(parse_tir(TEXT)))
    )


def test_a_template_without_numbers_is_told_from_a_tire() -> None:
    empty = parse_tir(TEXT).replaced({"PDX1": 0.0, "PKY1": 0.0})
    said = " | ".join(empty.warnings())
    assert "PDX1 = 0: Fx is zero but" in said and "PKY1 = 0: Fy is zero but" in said
    assert "is zero but" not in " | ".join(parse_tir(TEXT).warnings())


def test_a_whole_file_of_other_units_is_the_same_tire(tmp_path: Path) -> None:
    given = parse_tir(FIELD).replaced({"VERTICAL_STIFFNESS": 2e5})
    write_tir(complete_tir(given, {"fz": (1000.0, 5000.0)}), tmp_path / "whole.tir")
    again = read_tir(tmp_path / "whole.tir")
    assert again.sections["VERTICAL_FORCE_RANGE"]["FZMAX"].value == "5.0"
    assert tire_state(again, 3000, 0.03, 0.02).fx == tire_state(given, 3000, 0.03, 0.02).fx
