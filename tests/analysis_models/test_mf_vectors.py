# SPDX-License-Identifier: Apache-2.0
"""Magic Formula against numbers of an independent solver, and against itself written out."""

from __future__ import annotations

import json
import math

import mf52_scalar
import mf_scalar
import numpy as np
import pytest

from flatplank_analysis.cli import tire as tire_verb
from flatplank_analysis.models.tire_state import tire_state
from flatplank_data.errors import FlatplankError
from flatplank_tire.magic_formula import (
    DEFAULTS,
    OLD,
    SWITCHES,
    Coefficients,
    combined,
    operating_point,
    pure,
    steady,
    steady_forces,
    turn_slip,
)
from flatplank_tire.magic_formula import moment as moments
from flatplank_tire.magic_formula import moment as resistance
from flatplank_tire.magic_formula import structure as shape
from flatplank_tire.tir import shipped_tir, write_tir

BOOK = {
    "FNOMIN": 4000, "NOMPRES": 220000, "LONGVL": 16.7, "UNLOADED_RADIUS": 0.3135, "WIDTH": 0.205,
    "VERTICAL_STIFFNESS": 2e5, "PFZ1": 0.8, "BREFF": 8, "DREFF": 0.24, "FREFF": 0.01, "Q_RE0": 1,
    "LONGITUDINAL_STIFFNESS": 4e5, "LATERAL_STIFFNESS": 1e5, "PCFX3": 0.2, "PCFY3": 0.5,
    "Q_RA1": 0.79, "Q_RA2": 0.35, "PCX1": 1.6, "PDX1": 1, "PDX2": -0.1, "PKX1": 16,
    "RBX1": 8.3, "RBX2": 5, "RCX1": 0.9, "PCY1": 1.3, "PDY1": 1, "PDY2": -0.05, "PKY1": -15,
    "PKY2": 2, "PKY4": 2, "PKY6": -1, "RBY1": 4.9, "RBY2": 2.2, "RCY1": 1, "QDZ1": 0.12,
    "QBZ1": 10, "QCZ1": 1.1, "QBZ9": 10, "QDZ8": -0.05,
}  # fmt: skip
BOOK_ROWS = [
    # fz, kappa, alpha, gamma, p, Fx, Fy, Mz, sigma_x, sigma_y
    (4000, 0.05, 0, 0, 220000, 2702.570925, 0, 0, 0.16, 0.48),
    (4000, 0.1, 0, 0, 220000, 3804.226065, 0, 0, 0.16, 0.48),
    (4000, 0, 0.05, 0, 220000, 0, -2131.958946, 69.90989142, 0.16, 0.48),
    (4000, 0, 0, 0.05, 220000, 0, -199.8182682, -3.132282184, 0.16, 0.48),
    (4000, 0.05, 0.05, 0, 220000, 2543.799692, -2071.418441, 56.24566967, 0.16, 0.48),
    (6000, 0.05, 0.05, 0.05, 220000, 3754.702493, -2798.846841, 92.90600603, 0.24, 0.576),
    (4000, 0.05, 0.05, 0.02, 180000, 2543.799692, -2125.037539, 55.28749131, 0.1660377358, 0.528),
]
TOYO_ROWS = [
    # fz, kappa, p, gamma [deg], Fx
    (3700, 0, 2.5e5, 0, 209.2775958),
    (3700, 0.01, 2.5e5, 0, 1228.818811),
    (3700, -0.01, 2.5e5, 0, -760.5383075),
    (3700, 0.05, 2.5e5, 0, 3699.473059),
    (3700, -0.05, 2.5e5, 0, -2721.116429),
    (3700, 0.1, 2.5e5, 0, 4045.733513),
    (1850, 0.1, 2.5e5, 0, 1864.763600),
    (5550, -0.1, 2.5e5, 0, -4618.273946),
    (3700, 0.1, 2.0e5, 0, 3992.388249),
    (3700, 0.05, 2.5e5, 5, 3662.476932),
]


@pytest.mark.parametrize("row", BOOK_ROWS)
def test_book_set(row: tuple[float, ...]) -> None:
    state = tire_state(Coefficients(BOOK), *row[:5], 16.7)
    found = (state.fx, state.fy, state.mz, state.sigma_x, state.sigma_y)
    assert found == pytest.approx(row[5:], rel=1e-6, abs=1e-9)


def test_book_radius_and_contact() -> None:
    state = tire_state(Coefficients(BOOK), 4000, vx=16.7)
    assert state.re == pytest.approx(0.3063570816, rel=1e-9)
    assert state.a == pytest.approx(0.06955483195, rel=1e-9)


@pytest.mark.parametrize("row", TOYO_ROWS)
def test_toyo_set(row: tuple[float, ...]) -> None:
    fz, kappa, pressure, gamma, fx = row
    state = tire_state(shipped_tir(), fz, kappa, 0, math.radians(gamma), pressure, 0.03)
    assert state.fx == pytest.approx(fx, rel=1e-6)


@pytest.mark.parametrize(
    ("fz", "re"), [(3700, 0.3108766632), (1850, 0.3122844291), (5550, 0.3102223859)]
)
def test_toyo_radius(fz: float, re: float) -> None:
    assert tire_state(shipped_tir(), fz).re == pytest.approx(re, rel=1e-9)


def test_toyo_stiffness_and_side_force() -> None:
    state = tire_state(shipped_tir(), 3700)
    assert state.kx == pytest.approx(102048.22, rel=1e-8)
    assert state.sigma_x == pytest.approx(0.6290342107, rel=1e-8)
    assert state.fy == pytest.approx(869.0, abs=1.0)
    assert abs(tire_state(shipped_tir(), 3700, alpha=math.radians(1.0)).fy) < 10.0


def test_continental_set() -> None:
    tir = shipped_tir("continental_ecocontact")
    assert tire_state(tir, 3250, 0.0).fx == pytest.approx(234.0, rel=1e-9)
    assert tire_state(tir, 3250, 0.01).fx == pytest.approx(1131.204208, rel=1e-9)


def _everything(rng: np.random.Generator) -> dict[str, float]:
    """Every coefficient of the forces away from zero, of a size that a tire may have."""
    values = {k: float(rng.uniform(0.02, 0.2)) * rng.choice([-1, 1]) for k in DEFAULTS}
    values |= {k: float(v) for k, v in BOOK.items()}
    shifts = ("PHX", "PVX", "PHY", "PVY", "QHZ", "RHX", "RHY", "RBY3")
    values |= {k: 0.05 * v for k, v in values.items() if k.startswith(shifts)}
    values |= {k: float(rng.uniform(0.8, 1.2)) for k in DEFAULTS if k[0] == "L" and "_" not in k}
    values |= {"LONGVL": 16.7, "PEX1": -1.5, "PEX4": 0.3, "PEY1": 0.7, "PEY4": 8.0, "PEY5": -12.0}
    values |= {"PDX3": 1.5, "PDY3": 1.2, "PKX3": 0.3, "QEZ1": -2.0, "QBZ10": 0.7, "RVY5": 1.9}
    values |= {"TAN_ALPHA": 0.0, "CAP_E": 1.0, "A_MU": 1.0}
    return values | {"RVY4": 9.0, "RVY6": 12.0, "RBX3": 6.0, "RBY4": 7.0, "PKY5": 1.1, "QSX9": 2.0}


SETTINGS = [{}, {"TAN_ALPHA": 1.0}, {"CAP_E": 0.0}, {"A_MU": 10.0}]
SETTINGS.append({"TAN_ALPHA": 1.0, "CAP_E": 0.0, "A_MU": 10.0})


@pytest.mark.parametrize("switches", SETTINGS, ids=lambda s: "+".join(s) or "as MF-Tyre")
@pytest.mark.parametrize("seed", range(8))
def test_every_term_against_the_formulas_spelt_out(seed: int, switches: dict[str, float]) -> None:
    rng = np.random.default_rng(seed)
    values = _everything(rng) | switches
    c = Coefficients(values)
    for _ in range(20):
        point = [rng.uniform(1500, 7000), *rng.uniform(-0.2, 0.2, 2), rng.uniform(-0.1, 0.1)]
        point += [rng.uniform(1.6e5, 2.8e5), rng.choice((-1.0, 1.0)) * rng.uniform(3.0, 40.0)]
        o = operating_point(c, *point)
        found, wanted = steady(c, o), mf_scalar.forces(values, *point)
        for name in ("fx", "fy", "mz"):
            assert float(getattr(found, name)) == pytest.approx(wanted[name], rel=1e-9), name
        assert float(found.kya) == pytest.approx(wanted["ky"], rel=1e-12)
        mx = float(moments.overturning(c, o, found.fy))
        assert mx == pytest.approx(wanted["mx"], rel=1e-9)
        my = float(resistance.rolling_resistance(c, o, found.fx))
        assert my == pytest.approx(wanted["my"], rel=1e-9)


def test_the_verb_tells_my_where_the_file_has_it(tmp_path, capsys) -> None:
    """Negative as it rolls forward; 5.2 has a share of the load, and so has 6.1 without QSY7."""
    tir = shipped_tir()
    assert math.isnan(tire_state(tir, 3700.0).my)
    write_tir(tir.replaced({"QSY1": 0.01, "QSY3": 0.002}), tmp_path / "mine.tir")
    assert "[ROLLING_COEFFICIENTS]" in (tmp_path / "mine.tir").read_text()
    words = [str(tmp_path / "mine.tir"), "--fz", "3000", "--vx", "16.7"]
    assert tire_verb.main([*words, "--json"]) == 0
    my = json.loads(capsys.readouterr().out)["my"]
    radius = tir.coefficients.UNLOADED_RADIUS
    speed = 16.7 / tir.coefficients.LONGVL
    assert my == pytest.approx(-radius * 3000.0 * (0.01 + 0.002 * speed), rel=1e-9)
    old = Coefficients(BOOK | {"QSY1": 0.01, "QSY7": 0.3, "QSY8": -0.4}, OLD)
    assert tire_state(old, 3000.0, pressure=2e5).my == pytest.approx(-0.3135 * 30.0, rel=1e-9)
    assert tire_state(old, 3000.0, vx=-1.0).my == pytest.approx(0.3135 * 30.0, rel=1e-9)


def test_the_verb_tells_mx_where_the_file_has_it(tmp_path, capsys) -> None:
    tir = shipped_tir()
    assert math.isnan(tire_state(tir, 3700.0, alpha=0.05).mx)
    values = {"QSX1": 0.01, "QSX2": 0.9, "QSX3": 0.03}
    write_tir(tir.replaced(values), tmp_path / "mine.tir")
    words = [str(tmp_path / "mine.tir"), "--fz", "3700", "--alpha", "0.05", "--gamma", "0.02"]
    assert tire_verb.main([*words, "--json"]) == 0
    state = json.loads(capsys.readouterr().out)
    arm = 0.01 - 0.9 * 0.02 + 0.03 * state["fy"] / 3700.0
    assert state["mx"] == pytest.approx(0.3173 * 3700.0 * arm, rel=1e-9)


def test_arrays_in_pieces_equal_single_points() -> None:
    rng = np.random.default_rng(3)
    c = Coefficients(_everything(rng))
    fz, kappa, alpha = (rng.uniform(*b, 9000) for b in ((1e3, 7e3), (-0.1, 0.1), (-0.1, 0.1)))
    fx, fy, mz = steady_forces(c, fz, kappa, alpha, 0.03, 2e5, 16.7)
    for i in (0, 4095, 4096, 8999):
        one = tire_state(c, fz[i], kappa[i], alpha[i], 0.03, 2e5, 16.7)
        assert (fx[i], fy[i], mz[i]) == pytest.approx((one.fx, one.fy, one.mz), rel=1e-12)


def test_lanes_of_coefficients_do_not_influence_each_other() -> None:
    base = Coefficients(BOOK)
    sets = base.replaced({"PKX1": np.array([[16.0], [20.0]]), "QBZ1": np.array([[10.0], [9.0]])})
    kappa = np.linspace(-0.1, 0.1, 7)
    o = operating_point(sets, 4000.0, kappa, 0.02, 0.01, 220000.0, 16.7)
    both = steady(sets, o)
    for i, change in enumerate(({"PKX1": 16.0, "QBZ1": 10.0}, {"PKX1": 20.0, "QBZ1": 9.0})):
        c = base.replaced(change)
        one = steady(c, operating_point(c, 4000.0, kappa, 0.02, 0.01, 220000.0, 16.7))
        np.testing.assert_array_equal(both.fx[i], one.fx)
        np.testing.assert_array_equal(both.mz[i], one.mz)


def test_deflection_carries_the_load_with_and_without_the_quadratic_term() -> None:
    for q_fz2 in (0.0, 12.0):
        c = Coefficients(BOOK | {"Q_FZ2": q_fz2})
        o = operating_point(c, np.array([1000.0, 4000.0, 7000.0]), 0.0, 0.0, 0.0, 200000.0, 16.7)
        rho = shape.deflection(c, o, 0.0, 0.0, 0.0) / c.UNLOADED_RADIUS
        slope = math.sqrt((2e5 * 0.3135 / 4000) ** 2 - 4 * q_fz2)
        load = (slope * rho + q_fz2 * rho**2) * (1 + 0.8 * o.dpi) * 4000
        np.testing.assert_allclose(load, o.fz, rtol=1e-12)


def test_no_load_gives_no_force() -> None:
    fx, fy, mz = steady_forces(Coefficients(BOOK), np.array([0.0, -50.0]), 0.05, 0.05, vx=16.7)
    assert np.all(fx == 0.0)
    assert np.all(fy == 0.0)
    assert np.all(np.abs(mz) < 1e-12)


def test_radius_that_grows_with_speed_agrees_with_its_own_speed() -> None:
    c = Coefficients(BOOK | {"Q_V1": 0.002})
    o = operating_point(c, 4000.0, 0.1, 0.0, 0.0, 220000.0, 40.0)
    radius, omega = shape.rolling(c, o, 40.0)
    assert omega * radius == pytest.approx(44.0, rel=1e-12)
    growth = 0.3135 * 0.002 * (omega * 0.3135 / 16.7) ** 2
    assert radius == pytest.approx(tire_state(Coefficients(BOOK), 4000).re + growth, rel=1e-12)


@pytest.mark.parametrize("seed", range(8))
def test_every_term_of_5_2_against_the_formulas_spelt_out(seed: int) -> None:
    """With every coefficient of 6.1 given, too: 5.2 has none of them."""
    rng = np.random.default_rng(seed)
    values = _everything(rng) | {"PTX1": 2.3, "PTX2": 1.4, "PTX3": -0.2, "PTY1": 2.1, "PTY2": 1.9}
    c = Coefficients(values, OLD)
    for _ in range(20):
        point = [rng.uniform(1500, 7000), *rng.uniform(-0.2, 0.2, 2), rng.uniform(-0.1, 0.1)]
        speed = rng.uniform(3.0, 40.0)
        wanted = mf52_scalar.forces(values, *point, speed)
        found = tire_state(c, *point, rng.uniform(1.6e5, 2.8e5), speed).to_json()
        for name, value in wanted.items():
            assert found[name] == pytest.approx(value, rel=1e-9), name


def test_5_2_and_6_1_agree_without_camber_and_pressure() -> None:
    old, new = Coefficients(BOOK, OLD), Coefficients(BOOK)
    for row in BOOK_ROWS:
        fz, kappa, alpha = row[:3]
        at = (fz, kappa, alpha, 0.0, BOOK["NOMPRES"], 16.7)
        assert tire_state(old, *at) == tire_state(new, *at)


@pytest.mark.parametrize("name", SWITCHES)
def test_a_switch_is_an_option_is_kept_in_the_file_and_changes_forces(
    name: str, tmp_path, capsys
) -> None:
    """Of the verb, of a file that is written, of the coefficients."""
    file, value = tmp_path / "tire.tir", 1.0 - DEFAULTS[name] if name != "A_MU" else 10.0
    tir = shipped_tir().replaced({"LMUY": 0.7, "PEY1": 1.4, "PEX1": 1.4})
    write_tir(tir, file)
    at = ["--fz", "3700", "--kappa", "0.1", "--alpha", "0.3", "--json"]
    assert tire_verb.main([str(file), *at]) == 0
    usual = json.loads(capsys.readouterr().out)
    assert tire_verb.main([str(file), *at, f"--{name.lower().replace('_', '-')}", str(value)]) == 0
    other = json.loads(capsys.readouterr().out)
    assert other["fy"] != pytest.approx(usual["fy"], rel=1e-6)
    write_tir(tir.replaced({name: value}), file)
    assert tire_verb.main([str(file), *at]) == 0
    assert json.loads(capsys.readouterr().out) == other


@pytest.mark.parametrize("words", [("--alpha", "2"), ("--gamma", "-5"), ("--alpha", "nan")])
def test_an_angle_in_degrees_is_refused(words, tmp_path) -> None:
    write_tir(shipped_tir(), tmp_path / "tire.tir")
    with pytest.raises(FlatplankError, match="rad"):
        tire_verb.main([str(tmp_path / "tire.tir"), "--fz", "3700", *words])


TURNING = BOOK | {
    "TAN_ALPHA": 1, "PKY7": 0.1, "QDZ9": 0.02, "PDXP1": 0.4, "PDXP2": 0.1, "PDXP3": 0.3,
    "PKYP1": 1.2, "PDYP1": 0.4, "PDYP2": 0.1, "PDYP3": 0.2, "PDYP4": 0.3, "PHYP1": 1.1,
    "PHYP2": 0.15, "PHYP3": 0.05, "PHYP4": -4, "PECP1": 0.5, "QDTP1": 10, "QCRP1": 0.2,
    "QCRP2": 0.1, "QBRP1": 0.1, "QDRP1": 0.8,
}  # fmt: skip
TURNING_ROWS = [
    # fz, kappa, alpha, phi; zeta_1, 2, 3, zeta_4 - 1, 5, 6, 7, zeta_8 - 1 of another program
    (3000.0, 0.05, 0.0, 0.1, 0.999925281538, 0.999457839066, 0.999999304524, 0.00489107084907,
     0.954207921543, 0.999995085924, 0.937125540177, -3.24253467786),
    (4000.0, 0.0, 0.08, -0.2, 0.999685645091, 0.998484297499, 0.999988872556, -0.010483156646,
     0.847235868239, 0.99998034413, 0.918673586351, 7.85777934315),
    (6000.0, -0.1, -0.05, 0.5, 0.997841831739, 0.993371545617, 0.999565610176, 0.0316288620785,
     0.537832171662, 0.999877169822, 0.890509374021, -23.5474111522),
    (5000.0, 0.02, 0.1, 1.5, 0.981916866278, 0.963687721476, 0.96654815207, 0.0943308813029,
     0.208001795646, 0.998896155092, 0.898430264828, -64.878240214),
]  # fmt: skip


@pytest.mark.parametrize("row", TURNING_ROWS)
def test_factors_of_turn_slip_are_those_of_another_program(row: tuple[float, ...]) -> None:
    c = Coefficients(TURNING)
    o = operating_point(c, *row[:3], 0.0, 220000, 16.7)
    spin = turn_slip.spin_of(c, o, row[3], 0.3)
    upright = pure.cornering_stiffness(c, o) * turn_slip.zeta_3(c, o, spin)
    found = [
        turn_slip.zeta_1(c, o, spin),
        turn_slip.zeta_2(c, o, spin),
        turn_slip.zeta_3(c, o, spin),
        turn_slip.shift_y(c, o, spin, pure.camber_stiffness(c, o), upright, 0.0),
        turn_slip.zeta_5(c, o, spin),
        turn_slip.zeta_6(c, o, spin),
        *turn_slip.residual_moment(c, o, spin, pure.lateral(c, o).mu_y, combined.weight_y(c, o)),
    ]
    assert [float(v) for v in found] == pytest.approx(row[4:], rel=1e-9)


@pytest.mark.parametrize("seed", range(8))
def test_turn_slip_against_the_formulas_spelt_out(seed: int) -> None:
    rng = np.random.default_rng(seed)
    values = _everything(rng) | {"PHYP1": 1.1, "QDRP1": 0.8, "QCRP1": 0.2, "PECP1": 0.4}
    c = Coefficients(values)
    for _ in range(20):
        point = [rng.uniform(1500, 7000), *rng.uniform(-0.2, 0.2, 2), rng.uniform(-0.1, 0.1)]
        point += [rng.uniform(1.6e5, 2.8e5), 16.7]
        o, curvature = operating_point(c, *point), float(rng.uniform(-0.5, 0.5))
        radius = float(shape.rolling(c, o, 16.7)[0])
        found = steady(c, o, curvature)
        wanted = mf_scalar.forces(values, *point, turn=(curvature, radius))
        for name in ("fx", "fy", "mz"):
            assert float(getattr(found, name)) == pytest.approx(wanted[name], rel=1e-9), name


def test_a_small_camber_is_the_same_with_turn_slip_and_without() -> None:
    """A wheel that turns left spins its contact as one that leans to the right."""
    flat = TURNING | {"PHYP3": 0.0, "PKY7": 0.0, "QDZ9": 0.0, "TAN_ALPHA": 0}
    here = [
        tire_state(Coefficients(flat), 4000, gamma=1e-5, vx=16.7, turn_slip=t) for t in (None, 0.0)
    ]
    ratio = flat["UNLOADED_RADIUS"] / here[0].re
    assert here[1].fy == pytest.approx(ratio * here[0].fy, rel=1e-3)
    assert here[1].mz == pytest.approx(ratio * here[0].mz, rel=1e-3)
    left = tire_state(Coefficients(flat), 4000, vx=16.7, turn_slip=0.05)
    # pushed out of the curve, and turned back
    assert left.fy < 0.0 and left.mz < 0.0


def test_without_load_a_turning_wheel_has_no_force() -> None:
    state = tire_state(Coefficients(TURNING), 0.0, 0.05, 0.05, 0.02, vx=16.7, turn_slip=0.3)
    assert (state.fx, state.fy, state.mz) == pytest.approx((0.0, 0.0, 0.0), abs=1e-9)


def test_turn_slip_is_an_option_of_files_that_have_it(tmp_path, capsys) -> None:
    given = {k: v for k, v in TURNING.items() if k in turn_slip.COEFFICIENTS}
    write_tir(shipped_tir().replaced(given), tmp_path / "mine.tir")
    told = []
    for more in ([], ["--turn-slip", "0.2"]):
        words = [str(tmp_path / "mine.tir"), "--fz", "3700", "--alpha", "0.02", "--json", *more]
        assert tire_verb.main(words) == 0
        told.append(json.loads(capsys.readouterr().out))
    assert told[0]["fx"] != told[1]["fx"]
    with pytest.raises(FlatplankError, match="PHYP1, PHYP2, QCRP1, QDRP1 missing or zero"):
        tire_state(shipped_tir(), 3700, turn_slip=0.2)
    with pytest.raises(FlatplankError, match=r"5.2 has no turn slip"):
        tire_state(Coefficients(BOOK, OLD), 3700, turn_slip=0.2)
