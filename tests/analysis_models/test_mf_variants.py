# SPDX-License-Identifier: Apache-2.0
"""Tire property files of other programs: byte order marks, PAC2002 with inflation pressure,
factors of zero, files of one force only."""

from __future__ import annotations

import math
import warnings
from pathlib import Path

import pytest

from flatplank_analysis.cli.tire import main as tire_verb
from flatplank_analysis.identify.mf.stages import general_start
from flatplank_analysis.models.tire_record import shipped_record, start_tir
from flatplank_analysis.models.tire_state import tire_state
from flatplank_data.errors import FlatplankError
from flatplank_tire.magic_formula import SECTION_OF, SECTIONS
from flatplank_tire.tir import TirFile, check_tir, parse_tir, read_tir, shipped_tir
from flatplank_tire.tir_complete import complete_tir

INCHES = """[UNITS]
LENGTH = 'inch'
FORCE = 'pound_force'
ANGLE = 'radian'
MASS = 'kg'
TIME = 'second'
[MODEL]
FITTYP = 61
LONGVL = 657.48
[DIMENSION]
UNLOADED_RADIUS = 12.3425
[OPERATING_CONDITIONS]
NOMPRES = 220000
[VERTICAL]
FNOMIN = 899.236
[LONGITUDINAL_COEFFICIENTS]
PCX1 = 1.6
PDX1 = 1.1
PKX1 = 22
[LATERAL_COEFFICIENTS]
PCY1 = 1.3
PDY1 = 1.0
PKY1 = -18
PKY2 = 1.8
"""


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "cp1252"])
def test_a_byte_order_mark_is_no_part_of_the_first_section(tmp_path: Path, encoding: str) -> None:
    path = tmp_path / "t.tir"
    path.write_bytes((INCHES + "$ Größe\n").encode(encoding))
    assert read_tir(path).sections == parse_tir(INCHES).sections
    assert read_tir(path).values["UNLOADED_RADIUS"] == pytest.approx(0.3135, rel=1e-4)


def test_a_file_without_units_says_so() -> None:
    without = parse_tir("[MODEL]" + INCHES.partition("[MODEL]")[2])
    assert "[UNITS] is missing: all numbers are taken as SI" in without.warnings()
    assert not any("UNITS" in w for w in parse_tir(INCHES).warnings())


PRESSURE = """[UNITS]
LENGTH = 'meter'
FORCE = 'newton'
ANGLE = 'radians'
MASS = 'kg'
TIME = 'second'
PRESSURE = 'kpa'
[MODEL]
PROPERTY_FILE_FORMAT = 'PAC2002'
LONGVL = 16.7
[TIRE_CONDITIONS]
IP = 180
IP_NOM = 220
[DIMENSION]
UNLOADED_RADIUS = 0.33
[VERTICAL]
FNOMIN = 4000
VERTICAL_STIFFNESS = 2e5
QPFZ1 = 0.7
BREFF = 8
DREFF = 0.25
FREFF = 0.01
[LONGITUDINAL_COEFFICIENTS]
PCX1 = 1.6
PDX1 = 1.1
PKX1 = 22
PPX1 = -0.3
PPX2 = 0.2
PPX3 = -0.15
PPX4 = 0.1
[LATERAL_COEFFICIENTS]
PCY1 = 1.3
PDY1 = 1.0
PKY1 = -18
PKY2 = 1.8
PPY1 = -0.4
PPY2 = -0.5
PPY3 = -0.1
PPY4 = 0.05
[ALIGNING_COEFFICIENTS]
QBZ1 = 9
QCZ1 = 1.1
QDZ1 = 0.1
QPZ1 = 0.6
"""


def by_hand(bar: float, fz: float = 4000.0, kappa: float = 0.05, alpha: float = 0.05) -> dict:
    """PAC2002 with inflation pressure (Adams/Tire, PAC2002): Fx0, Fy0 and Mz0 of PRESSURE."""
    d, f0 = bar / 2.2 - 1.0, 4000.0

    def curve(peak: float, shape: float, slope: float, slip: float) -> float:
        return peak * math.sin(shape * math.atan(slope / (shape * peak) * slip))

    stiff_x = 22.0 * fz * (1.0 - 0.3 * d + 0.2 * d**2)
    load = fz / (1.8 * f0 * (1.0 - 0.5 * d))
    stiff_y = -18.0 * f0 * (1.0 - 0.4 * d) * math.sin(2.0 * math.atan(load))
    fx = curve(1.1 * fz * (1.0 - 0.15 * d + 0.1 * d**2), 1.6, stiff_x, kappa)
    fy = curve(fz * (1.0 - 0.1 * d + 0.05 * d**2), 1.3, stiff_y, alpha)
    trail = fz * 0.1 * (1.0 - 0.6 * d) * 0.33 / f0
    trail *= math.cos(1.1 * math.atan(9.0 * alpha)) * math.cos(alpha)
    stiffness = 2e5 * (1.0 + 0.7 * d)
    radius = 0.33 - f0 / stiffness * (0.25 * math.atan(8.0 * fz / f0) + 0.01 * fz / f0)
    return {"fx": fx, "fy": fy, "mz": -trail * fy, "re": radius}


@pytest.mark.parametrize("bar", [1.8, 2.2, 2.9])
def test_pac2002_follows_the_inflation_pressure(bar: float) -> None:
    tir = parse_tir(PRESSURE)
    assert tir.law == "PAC2002"
    wanted = by_hand(bar)
    across = tire_state(tir, 4000.0, alpha=0.05, pressure=1e5 * bar, vx=16.7)
    along = tire_state(tir, 4000.0, kappa=0.05, pressure=1e5 * bar, vx=16.7)
    assert along.fx == pytest.approx(wanted["fx"], rel=1e-6)
    assert [across.fy, across.mz, across.re] == pytest.approx(
        [wanted["fy"], wanted["mz"], wanted["re"]], rel=1e-6
    )
    assert not any("not used" in w for w in tir.warnings())


def test_the_pressure_is_that_of_the_file_unless_another_is_given() -> None:
    tir = parse_tir(PRESSURE)
    assert tire_state(tir, 4000.0, 0.05).fx == pytest.approx(by_hand(1.8)["fx"], rel=1e-6)
    newer = shipped_tir().replaced({"INFLPRES": 2.0e5})
    assert tire_state(newer, 3700.0, 0.1).fx == pytest.approx(3992.388249, rel=1e-6)
    assert tire_state(shipped_tir(), 3700.0, 0.1).fx == pytest.approx(4045.733513, rel=1e-6)


def test_pac2002_without_a_nominal_pressure_says_that_none_acts() -> None:
    without = parse_tir(PRESSURE.replace("IP_NOM = 220\n", ""))
    assert tire_state(without, 4000.0, 0.05).fx == pytest.approx(by_hand(2.2)["fx"], rel=1e-6)
    assert any("IP_NOM is missing" in w for w in without.warnings())
    other = parse_tir(PRESSURE.replace("'PAC2002'", "'PAC2002'\nFITTYP = 61"))
    assert other.law == "6.1"


def test_a_whole_file_of_pac2002_is_the_same_tire() -> None:
    given = parse_tir(PRESSURE)
    one, other = (
        tire_state(t, 3000.0, 0.03, 0.02).to_json() for t in (given, complete_tir(given))
    )
    assert one == other and one["mz"] is not None


def every_part() -> TirFile:
    """A file in which every coefficient acts."""
    small = {k: 0.03 for k in SECTION_OF if k[0] in "PQRS" and not k.startswith("PT")}
    named = dict.fromkeys(SECTIONS["SCALING_COEFFICIENTS"].split(), 1.0)
    sizes = {"WIDTH": 0.2, "LONGITUDINAL_STIFFNESS": 3e5, "LATERAL_STIFFNESS": 1e5}
    main = {"PCX1": 1.6, "PDX1": 1.0, "PKX1": 20.0, "PCY1": 1.3, "PDY1": 1.0, "PKY1": -15.0}
    own = {"PKY2": 1.8, "PKY4": 2.0, "QCZ1": 1.1, "QBZ1": 9.0, "Q_RE0": 1.0, "RBX1": 8.0}
    return parse_tir(INCHES).replaced(small | named | sizes | main | own | {"QSY7": 0.9})


STATES = ((0.0, 0.0, 0.0), (0.05, 0.04, 0.03), (-0.2, -0.1, -0.05))


@pytest.mark.parametrize("law", [61, 6])
def test_a_coefficient_of_zero_gives_numbers_or_one_line(law: int) -> None:
    """No traceback, no warning of numpy, and no empty number where nothing is missing."""
    tire = every_part().replaced({"FITTYP": law, "VERTICAL_STIFFNESS": 2e5})
    refused = set()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for key in SECTION_OF:
            zero = tire.replaced({key: 0.0})
            try:
                states = [tire_state(checked(zero), 4000.0, *s).to_json() for s in STATES]
            except FlatplankError as error:
                refused.add(key)
                assert key in str(error) and "not positive" in str(error)
                continue
            empty = {name for state in states for name, value in state.items() if value is None}
            known = {"LONGITUDINAL_STIFFNESS": {"sigma_x"}, "LATERAL_STIFFNESS": {"sigma_y"}}
            assert empty == (known.get(key, set()) if law == 61 else empty & known.get(key, set()))
    lengths = {"UNLOADED_RADIUS", "VERTICAL_STIFFNESS", "Q_RE0"}
    assert refused == lengths | {"FNOMIN", "NOMPRES", "LFZO", "LONGVL"}


def checked(tir: TirFile) -> TirFile:
    """The file as `read_tir` would have it."""
    check_tir(tir)
    return tir


def test_a_road_without_friction_across_has_no_side_force() -> None:
    ice = every_part().replaced({"LMUY": 0.0, "RVY1": 0.0, "RVY2": 0.0, "RVY3": 0.0})
    state = tire_state(ice, 4000.0, 0.05, 0.05)
    assert abs(state.fy) < 1e-3
    assert state.fx == pytest.approx(tire_state(every_part(), 4000.0, 0.05, 0.05).fx)


def only(kind: str) -> TirFile:
    head, _, rest = INCHES.partition("[LONGITUDINAL_COEFFICIENTS]")
    along, _, across = rest.partition("[LATERAL_COEFFICIENTS]")
    parts = {"x": f"[LONGITUDINAL_COEFFICIENTS]{along}", "y": f"[LATERAL_COEFFICIENTS]{across}"}
    return parse_tir(head + parts[kind])


def test_a_file_of_one_force_is_read_and_the_other_is_not_known(tmp_path: Path) -> None:
    along, across = (checked(only(kind)) for kind in "xy")
    both = tire_state(parse_tir(INCHES), 4000.0, 0.05, 0.05)
    x, y = (tire_state(tir, 4000.0, 0.05, 0.05) for tir in (along, across))
    assert (x.fx, x.kx, y.fy, y.ky) == (both.fx, both.kx, both.fy, both.ky)
    assert all(math.isnan(v) for v in (x.fy, x.ky, x.mz, x.sigma_y, y.fx, y.kx, y.sigma_x))
    assert "no PCY1, PDY1, PKY1: Fy and its stiffness are not known" in along.warnings()
    again = tire_state(complete_tir(along), 4000.0, 0.05, 0.05)
    assert again.fx == x.fx and math.isnan(again.fy)


def test_a_part_of_a_force_is_refused() -> None:
    with pytest.raises(FlatplankError, match="missing PDY1"):
        checked(parse_tir(INCHES.replace("PDY1 = 1.0\n", "")))
    none = INCHES.partition("[LONGITUDINAL_COEFFICIENTS]")[0]
    with pytest.raises(FlatplankError, match="missing PCX1, PDX1, PKX1"):
        checked(parse_tir(none))


def test_the_verb_prints_a_dash_for_a_moment_without_coefficients(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "t.tir"
    path.write_text(INCHES)
    tire_verb([str(path), "--fz", "4000", "--alpha", "0.05"])
    out, err = capsys.readouterr()
    rows = {line.split()[0]: line.split()[1] for line in out.splitlines()[1:]}
    assert rows["mz"] == "-" and rows["fy"] != "-"
    assert "no coefficient of the aligning moment" in err


def test_a_fit_starts_from_the_contact_geometry_of_the_record() -> None:
    """Table I.1 and Table 7.2 of the thesis differ in PFZ1; a tire has one."""
    record = shipped_record("toyo")
    started = start_tir(record, general_start()).values
    assert started["PFZ1"] == record.contact["pressure_effect"] == 0.8451
    assert started["VERTICAL_STIFFNESS"] == record.contact["vertical_stiffness"]
