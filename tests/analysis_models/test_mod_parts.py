# SPDX-License-Identifier: Apache-2.0
"""Parts of the transient models and of the tire record, each against numbers known without it."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from flatplank_analysis.models import kernel
from flatplank_analysis.models import nonlinear as nl
from flatplank_analysis.models.base import column, defaults, run_inputs, slip_inputs, stack_runs
from flatplank_analysis.models.contact import TOYO, patch_relaxation
from flatplank_analysis.models.linear import LinearX, LinearY
from flatplank_analysis.models.mf_contact_point import ContactPointMF
from flatplank_analysis.models.mf_tyre import MFTyre
from flatplank_analysis.models.nonlinear import NonlinearX, NonlinearY
from flatplank_analysis.models.relaxation import deflection
from flatplank_analysis.models.shipped import shipped_tir
from flatplank_analysis.models.steady_law import SineLaw, TableLaw, table_law
from flatplank_analysis.models.tir import write_tir
from flatplank_analysis.models.tir_units import DIMENSIONS, UNITS, factor
from flatplank_analysis.models.tire_record import (
    PLACEHOLDER,
    TireRecord,
    parse_record,
    read_record,
    start_tir,
)
from flatplank_analysis.models.tire_state import tire_state
from flatplank_data.errors import FlatplankError

X = np.linspace(0.0, 2.6, 400)
SLIPS = np.linspace(-0.15, 0.15, 61)


def law(peak: float = 3700.0) -> TableLaw:
    return table_law(SLIPS, peak * np.sin(1.4 * np.arctan(9e4 / 1.4 / peak * SLIPS)))


def test_deflection_at_rest_and_over_a_long_way():
    """At rest the slip is taken in full; over a long way it is sigma times the slip."""
    travel = np.array([[0.0, 1e-12, 0.2, 50.0]])
    slip = np.array([[0.01, 0.02, 0.004, -1.0]])
    sigma = np.full((1, 1, 1), 0.5)
    found = deflection(travel[None], slip[None], sigma, np.array([[0.1]]))[0, 0]
    one = 0.13
    two = one * math.exp(-0.4) + 0.5 * 0.004 / 0.2 * -math.expm1(-0.4)
    np.testing.assert_allclose(found, [0.11, one, two, -0.5 * 1.0 / 50.0], rtol=1e-9)


def test_start_forces_in_both_directions():
    run = slip_inputs(X, 0.0, 3700.0, start_fx=-50.0, start_fy=80.0)
    decay = np.exp(-X / 0.45)
    for model, start in ((LinearX(), -50.0), (LinearY(), 80.0)):
        force = model.simulate(np.array([[0.45, 9e4]]), run)[0, 0]
        np.testing.assert_allclose(force, start * decay, rtol=1e-9)
    for model, start in ((NonlinearX(), -50.0), (NonlinearY(), 80.0)):
        force = model.simulate(defaults(model), run)[0, 0]
        assert force[0] == pytest.approx(start, abs=1e-6)
        assert abs(force[-1]) < 2.0
    # a spring without stiffness has no deflection to start from
    assert not LinearX().simulate(np.array([[0.45, 0.0]]), run).any()


def test_patch_relaxes_over_what_adheres():
    """a (1 - theta |slip|/(1 + slip))/(1 + slip), in y without the rolling; at least 1 %."""
    slip, theta, a = np.array([-0.05, 0.0, 0.05, 0.9]), 8.0, 0.07
    base = 1.0 + slip[:3]
    wanted = a * (1.0 - theta * np.abs(slip[:3]) / base) / base
    found = patch_relaxation(slip, theta, a)
    np.testing.assert_allclose(found[:3], wanted)
    assert found[3] == pytest.approx(0.01 * a / 1.9)
    across = patch_relaxation(slip, theta, a, longitudinal=False)
    np.testing.assert_allclose(across[:3], a * (1.0 - theta * np.abs(slip[:3])))
    assert patch_relaxation(np.array(-0.99), 0.0, a) == pytest.approx(10.0 * a)


def test_the_tread_that_the_law_has_and_one_that_is_given():
    """2 c_px a^2 = C_Fk: the same tread said otherwise."""
    run = slip_inputs(X, 0.05, 3700.0)
    a = float(TOYO.half_length(3700.0, 250e3))
    stiffness = law().stiffness().item()
    tied = NonlinearX(lambda _: law()).simulate(np.array([[2e5]]), run)
    same = NonlinearX(lambda _: law(), tread_stiffness=stiffness / (2.0 * a**2))
    np.testing.assert_allclose(same.simulate(np.array([[2e5]]), run), tied, rtol=1e-9)
    hard = replace(same, tread_stiffness=3.0 * stiffness / (2.0 * a**2))
    assert np.abs(hard.simulate(np.array([[2e5]]), run) - tied).max() > 10.0


def test_a_damped_carcass_follows_with_its_time():
    assert nl._followed(np.array([0.0, 0.01, 0.03]), 0.01) == pytest.approx(
        [1.0, -math.expm1(-1.0), -math.expm1(-3.0)]
    )
    assert nl._followed(np.array([0.0, 5.0]), 0.0).tolist() == [1.0, 1.0]
    ratio = np.array([1e-6, 0.5, 40.0])
    late = nl.late_weight(0.2 * ratio, np.full(3, 0.2))
    assert late == pytest.approx([0.5, 1.0 / -math.expm1(-0.5) - 2.0, 1.0 - 1.0 / 40.0], abs=1e-4)


@pytest.mark.parametrize("force", [-2500.0, -40.0, 0.0, 1500.0])
def test_the_slip_that_gives_the_start_force(force):
    for one in (law(), SineLaw(*(np.array([[v]]) for v in (9e4, 3700.0, 1.4, 30.0)))):
        slip = nl.start_slip(one, np.array([[force]]))
        assert one.force(slip)[0] == pytest.approx(force, abs=1e-6)
        assert abs(slip.item()) < 0.08
    # beyond the peak there is none: the search ends inside of the table's reach
    assert abs(nl.start_slip(law(), np.array([[9e9]])).item()) <= 0.2


def test_a_table_of_a_law():
    one = law()
    inner = np.array([[-0.1234, 0.0, 0.0321]])
    wanted = 3700.0 * np.sin(1.4 * np.arctan(9e4 / 1.4 / 3700.0 * inner))
    found, slope = one.force(inner)
    np.testing.assert_allclose(found, wanted, atol=1.5)
    numeric = (one.force(inner + 1e-4)[0] - one.force(inner - 1e-4)[0]) / 2e-4
    np.testing.assert_allclose(slope, numeric, rtol=0.02, atol=200.0)
    # straight beyond its ends
    ends = one.force(np.array([[0.15, 0.16, 0.17]]))[0][0]
    assert ends[2] - ends[1] == pytest.approx(ends[1] - ends[0])
    assert one.force(np.array([[-0.16]]))[0] == pytest.approx(
        2.0 * one.force(np.array([[-0.15]]))[0] - one.force(np.array([[-0.14]]))[0], rel=0.01
    )
    assert one.stiffness().item() == pytest.approx(
        (one.force(np.array([[0.005]]))[0] - one.force(np.array([[-0.005]]))[0]).item() / 0.01
    )
    lanes = table_law(SLIPS, np.vstack([one.force(SLIPS[None])[0][0]] * 2) * [[1.0], [3.0]])
    found = lanes.force(np.full((2, 1), 0.02))[0][:, 0]
    assert found[1] == pytest.approx(3.0 * found[0])
    assert lanes.stiffness()[:, 0] == pytest.approx([1.0, 3.0] * one.stiffness()[0], rel=1e-3)
    rows = TableLaw(one.first, one.step, np.vstack([one.values, 2.0 * one.values]))
    both = rows.force(np.array([[0.02, 0.03]]))[0][0]
    assert both == pytest.approx([1.0, 2.0] * one.force(np.array([[0.02, 0.03]]))[0][0])
    for bad in ([0.0], [0.0, 0.0], [0.1, 0.0]):
        with pytest.raises(FlatplankError, match="increasing slips"):
            table_law(np.array(bad), np.zeros(len(bad)))


def test_slope_of_the_smooth_law_is_its_derivative():
    sine = SineLaw(*(np.array([[v]]) for v in (9e4, 3700.0, 1.4, 25.0)))
    slip = np.array([[-0.08, -0.01, 0.0, 0.03]])
    force, slope = sine.force(slip)
    assert force[0, 2] == 25.0 and sine.stiffness().item() == slope[0, 2] == 9e4
    numeric = (sine.force(slip + 1e-7)[0] - sine.force(slip - 1e-7)[0]) / 2e-7
    np.testing.assert_allclose(slope, numeric, rtol=1e-5)
    assert sine.force(np.array([[1e6]]))[0].item() == pytest.approx(
        25.0 + 3700.0 * math.sin(1.4 * math.pi / 2.0), rel=1e-4
    )


def test_machine_code_and_python_are_one_function():
    """What is compiled is tested as it is written."""
    inputs = stack_runs([slip_inputs(X[::8], k, 3700.0, start_fx=-30.0) for k in (-0.1, 0.02)])
    lanes = np.array([[2e5], [3e5]])
    fast = NonlinearX().simulate(lanes, inputs)
    compiled, kernel.compiled = kernel.compiled, kernel.march
    try:
        plain = NonlinearX().simulate(lanes, inputs)
    finally:
        kernel.compiled = compiled
    np.testing.assert_allclose(plain, fast, atol=1e-9)


def test_magic_formula_starts_at_the_measured_force():
    even = {"LATERAL_STIFFNESS": 1e5, "PHY1": 0.0, "PVY1": 0.0}
    c = shipped_tir().replaced(even).coefficients
    state = tire_state(c, 3700.0)
    still = slip_inputs(X, 0.0, 3700.0, start_fx=-60.0, start_fy=state.fy)
    across = replace(still, start_fx=np.array([state.fx]), start_fy=np.array([50.0]))
    out = MFTyre(c).simulate_all(np.zeros((1, 0)), still)
    assert out["fx"][0, 0, 0] == pytest.approx(-60.0, rel=0.06)
    side = MFTyre(c, (), "fy").simulate(np.zeros((1, 0)), across)[0, 0]
    assert side[0] == pytest.approx(50.0, rel=0.06)
    np.testing.assert_allclose(
        side - state.fy, (side[0] - state.fy) * np.exp(-X / state.sigma_y), atol=2.0
    )
    away = out["fx"][0, 0] - state.fx
    np.testing.assert_allclose(away, away[0] * np.exp(-X / state.sigma_x), atol=2.0)
    point = ContactPointMF(c).simulate(np.zeros((1, 0)), still)[0, 0]
    assert point[0] == pytest.approx(-60.0, abs=0.5)
    sigma = state.kx / c.LONGITUDINAL_STIFFNESS
    np.testing.assert_allclose(
        point - state.fx, (point[0] - state.fx) * np.exp(-X / sigma), atol=3.0
    )
    # and a step of 5 % ends at the steady force, from whatever force it begins
    long = slip_inputs(np.linspace(0.0, 8.0, 300), 0.05, 3700.0, start_fx=900.0)
    steady = ContactPointMF(c).simulate(np.zeros((1, 0)), long)[0, 0]
    assert steady[0] == pytest.approx(900.0, rel=0.01)
    assert steady[-1] == pytest.approx(tire_state(c, 3700.0, 0.05).fx, rel=1e-3)
    # a tire that pushes without slip: the start force is beside that
    pushes = shipped_tir().replaced(even | {"PVX1": 0.02}).coefficients
    own = tire_state(pushes, 3700.0)
    begun = MFTyre(pushes).simulate(np.zeros((1, 0)), replace(still, start_fx=np.array([own.fx])))
    assert abs(own.fx) > 50.0
    np.testing.assert_allclose(begun[0, 0], own.fx, rtol=0.02)
    # far beyond what the tire can hold the search for the start stays on the rising branch
    huge = ContactPointMF(c).simulate(np.zeros((1, 0)), replace(still, start_fx=np.array([9e3])))
    assert np.isfinite(huge).all() and huge.max() < 5e3


def test_inputs_say_what_moved():
    run = slip_inputs(np.array([0.0, 0.1, 0.3]), 0.02, 3000.0, alpha=0.1, speed=0.05)
    np.testing.assert_allclose(run.travel[0], [0.0, 0.1, 0.2])
    np.testing.assert_allclose(run.slip_x[0], [0.0, 0.002, 0.004])
    np.testing.assert_allclose(run.slip_y[0], np.tan(0.1) * run.travel[0])
    np.testing.assert_allclose(run.dt[0], [0.0, 2.0, 4.0])
    back = run_inputs(np.array([0.3, 0.1]), np.array([1.0, 0.5]), 0.3, 3000.0, alpha=0.1)
    assert back.travel[0, 1] == pytest.approx(0.2 * math.cos(0.1))
    assert back.slip_x[0, 1] == pytest.approx(-0.15 + 0.2 * math.cos(0.1))
    assert back.slip_y[0, 1] == pytest.approx(0.2 * math.sin(0.1)) and not back.dt.any()
    short = slip_inputs(np.array([0.0, 0.1]), 0.02, 4000.0, start_fy=3.0)
    both = stack_runs([run, short])
    assert both.travel[1].tolist() == [0.0, 0.1, 0.0] and both.fz[1].tolist() == [4000.0] * 3
    assert both.start_fy.tolist() == [0.0, 3.0] and both.shape == (2, 3)
    assert column(np.ones((4, 2)), 1).shape == (4, 1)
    assert column(np.ones((4, 2, 3)), 1).shape == (4, 3)


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
    text = record.to_yaml()
    assert "width" not in text and "origin" not in text and "rim" not in text
    assert replace(parse_record(text, ""), width=math.nan).to_yaml() == text


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("free_radius: 5", "free_radius: 5 is not in m"), ("width: x", "width: 'x' is not in m"),
        ("nominal_load: 20", "not in N"), ("nominal_pressure: 16", "not in bar"),
        ("rim_radius: 0.9", "not in m"), ("radius: 1", "unknown key radius"),
        ("contact: [1]", "contact has no keys"), ("contact: {q_ra3: 1}", "unknown key q_ra3"),
        ("contact: {q_ra1: x}", "contact: not a number"),
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


def test_what_a_state_needs_of_its_file():
    c = shipped_tir().coefficients
    with pytest.raises(FlatplankError, match="PHYP1, PHYP2, QCRP1, QDRP1 missing"):
        tire_state(c, 3700.0, turn_slip=0.1)
    assert math.isnan(tire_state(c.replaced({"Q_RA1": 0.0, "Q_RA2": 0.0}), 3700.0).a)
    assert tire_state(c, 3700.0).a == pytest.approx(0.0708, abs=2e-4)
    for n, of in ((1, "QSY"), (6, "QSY"), (1, "QSX"), (14, "QSX")):
        name = "my" if of == "QSY" else "mx"
        none = c.replaced(
            {f"QSY{i}": 0.0 for i in range(1, 9)} | {f"QSX{i}": 0.0 for i in range(1, 15)}
        )
        assert math.isnan(getattr(tire_state(none, 3700.0), name))
        assert math.isfinite(getattr(tire_state(none.replaced({f"{of}{n}": 0.01}), 3700.0), name))
    own, nominal = (tire_state(c, 3700.0, pressure=p) for p in (None, c.NOMPRES))
    assert own.to_json() == nominal.to_json()
    assert tire_state(c, 3700.0, 0.02).to_json()["fx"] == tire_state(c, 3700.0, 0.02).fx
