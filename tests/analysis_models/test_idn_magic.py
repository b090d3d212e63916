# SPDX-License-Identifier: Apache-2.0
"""Magic Formula identification: truth back, stages, constraints, and honest statements."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from flatplank_analysis.identify.campaign import FitFile, fit_campaign, parse_fit, read_fit_file
from flatplank_analysis.identify.mf.fit import MFFit, fit_magic_formula
from flatplank_analysis.identify.mf.points import SteadyPoints, merge, steady_points
from flatplank_analysis.identify.mf.stages import COEFFICIENTS, PREDICTIONS, STAGES
from flatplank_data.errors import FlatplankError
from flatplank_tire.magic_formula import SECTION_OF, operating_point, steady_forces
from flatplank_tire.magic_formula import structure as shape
from flatplank_tire.tir import shipped_tir
from flatplank_validation.fits.campaigns import SLIPS, Truth, simulate_runs

TRUTH = shipped_tir().replaced(
    {"PCX1": 1.5, "PEX1": -0.5, "PEX2": 0.3, "PEX3": 0.0, "PEX4": 0.1, "PKX3": 0.2, "RBX1": 14.0,
     "RBX2": 9.0, "RCX1": 1.05, "PPX1": -0.5, "PPX2": 1.5, "PPX3": 0.1, "PPX4": -0.3}
)  # fmt: skip
FX = FitFile(stages=("pure_x", "combined", "pressure"))


def points_x(
    pressures: tuple[float, ...] = (2.0e5, 2.5e5, 3.0e5),
    loads: tuple[float, ...] = (1850.0, 3700.0, 5550.0),
    noise: float = 8.0,
    seed: int = 0,
) -> SteadyPoints:
    rows = [(fz, k, 0.0, p) for fz in loads for p in pressures for k in SLIPS]
    rows += [(loads[-1], k, a, 2.5e5) for k in SLIPS for a in np.radians((-5.0, 3.0, 10.0))]
    fz, kappa, alpha, pressure = np.repeat(np.array(rows), 3, axis=0).T
    fx = steady_forces(TRUTH.coefficients, fz, kappa, alpha, 0.0, pressure, 0.03)[0]
    rng = np.random.default_rng(seed)
    fx = fx * (1.0 + 0.005 * rng.standard_normal(len(fx))) + noise * rng.standard_normal(len(fx))
    return steady_points({"fx": fx}, fz=fz, kappa=kappa, alpha=alpha, pressure=pressure)


@pytest.fixture(scope="module")
def full() -> MFFit:
    return fit_magic_formula(points_x(), shipped_tir(), FX)


def test_truth_comes_back_inside_wide_intervals(full: MFFit) -> None:
    estimates = full.estimates
    assert len(estimates) == 23
    outside = []
    for name, e in estimates.items():
        low, high = e.interval(0.999)
        if not low <= getattr(TRUTH.coefficients, name) <= high:
            outside.append(name)
    assert not outside
    assert full.relative_errors["fx"] < 0.01
    assert full.tir.values["PKX1"] == estimates["PKX1"].value
    assert full.tir.values["PKY1"] == shipped_tir().values["PKY1"]
    json.dumps(full.to_json())


def test_taking_a_pressure_out_changes_the_statement_by_itself(full: MFFit) -> None:
    assert all(full.estimates[n].determined for n in ("PPX1", "PPX2", "PPX3", "PPX4"))
    two = fit_magic_formula(points_x(pressures=(2.0e5, 2.5e5)), shipped_tir(), FX)
    pairs = {c.names: c for c in two.confusions}
    assert ("PPX1", "PPX2") in pairs
    assert ("PPX3", "PPX4") in pairs
    said = pairs["PPX1", "PPX2"]
    assert "cannot be told apart with 2 pressures (2.0 bar, 2.5 bar)" in said.statement
    assert said.remedy.startswith("measure a pressure of ")
    assert not two.estimates["PPX2"].determined
    one = fit_magic_formula(points_x(pressures=(2.5e5,)), shipped_tir(), FX)
    assert "PPX1" not in one.estimates
    assert any("PPX1" in s and "1 pressure (2.5 bar)" in s for s in one.skipped)


def test_taking_the_loads_out_changes_the_statement_by_itself() -> None:
    one = fit_magic_formula(points_x(loads=(3700.0,)), shipped_tir(), FX)
    group = next(c for c in one.confusions if "PKX2" in c.names)
    assert {"PDX2", "PKX2"} & set(group.names)
    assert "1 load (3700 N)" in group.statement
    assert "load" in group.remedy
    assert not one.estimates["PKX2"].determined
    assert one.estimates["PKX1"].determined


def test_fixed_bounded_and_prior() -> None:
    settings = FitFile(
        stages=("pure_x",),
        fixed={"PKX3": 0.2},
        bounds={"PDX1": (0.5, 0.9)},
        prior={"PEX3": (0.4, 0.001)},
    )
    found = fit_magic_formula(points_x(), shipped_tir(), settings)
    assert "PKX3" not in found.estimates
    assert found.tir.values["PKX3"] == 0.2
    assert found.estimates["PDX1"].at_bound == "upper"
    assert not found.estimates["PDX1"].determined
    assert found.estimates["PEX3"].value == pytest.approx(0.4, abs=0.005)


def test_one_stage_alone_leaves_the_rest() -> None:
    settings = FitFile(stages=("combined",))
    found = fit_magic_formula(points_x(), TRUTH, settings)
    assert set(found.estimates) == set(STAGES["combined"].outputs["fx"].split())
    assert found.tir.values["PKX1"] == TRUTH.values["PKX1"]
    with pytest.raises(FlatplankError, match="no stage cambers"):
        fit_magic_formula(points_x(), TRUTH, FitFile(stages=("cambers",)))


def test_curvature_stays_at_one_and_friction_positive() -> None:
    kappa = np.repeat(np.array(SLIPS), 3)
    # Nearly bilinear data pull the curvature factor up against 1.
    fx = np.clip(1e5 * kappa, -2500.0, 2500.0)
    points = steady_points({"fx": fx}, fz=np.full(27, 3700.0), kappa=kappa, pressure=2.5e5)
    found = fit_magic_formula(points, shipped_tir(), FitFile(stages=("pure_x",)))
    c = found.tir.coefficients
    assert c.PEX1 * (1.0 + abs(c.PEX4)) <= 1.01
    assert c.PDX1 > 0.0
    assert c.PCX1 > 0.0


def test_radius_stiffness_and_contact() -> None:
    c = TRUTH.replaced({"LATERAL_STIFFNESS": 1.2e5, "PCFY1": 0.2, "PCFY3": 0.4}).coefficients
    grid = [(f, p) for f in (1e3, 2e3, 3e3, 4e3, 5e3, 6e3, 8e3) for p in (2e5, 2.5e5, 3e5)]
    fz, pressure = np.array(grid).T
    o = operating_point(c, fz, 0.0, 0.0, 0.0, pressure, 0.03)
    rows = {
        "re": shape.effective_radius(c, o, 0.0),
        "a": shape.contact_half_length(c, o),
        "rho": shape.deflection(c, o, 0.0, 0.0, 0.0),
        "cx": shape.stiffness_x(c, o),
        "cy": shape.stiffness_y(c, o),
    }
    # Alternating scatter of 1e-4 keeps the errors from vanishing.
    wave = 1.0 + 1e-4 * (-1.0) ** np.arange(len(fz))
    points = steady_points({k: v * wave for k, v in rows.items()}, fz=fz, pressure=pressure)
    start = shipped_tir().replaced({"VERTICAL_STIFFNESS": 1.8e5, "PFZ1": 0.3, "DREFF": 0.2})
    found = fit_magic_formula(points, start, FitFile(stages=("radius", "stiffness")))
    for name in ("VERTICAL_STIFFNESS", "PFZ1", "Q_RA1", "LONGITUDINAL_STIFFNESS", "PCFY3"):
        assert found.estimates[name].value == pytest.approx(getattr(c, name), rel=0.02), name
    again = shape.effective_radius(found.tir.coefficients, o, 0.0)
    np.testing.assert_allclose(again, rows["re"], atol=1e-4)


def test_radius_over_side_slip_and_camber() -> None:
    c = shipped_tir().replaced({"Q_REA": 0.3, "Q_REG": -0.2}).coefficients
    slips, cambers = np.radians((0.0, 2.0, 5.0, 10.0)), np.radians((0.0, 5.0))
    rows = [(f, a, g) for f in (1850.0, 2800.0, 3700.0, 5550.0) for a in slips for g in cambers]
    fz, alpha, gamma = np.array(rows).T
    o = operating_point(c, fz, 0.0, alpha, gamma, 2.5e5, 0.03)
    re = shape.effective_radius(c, o, 0.0) + 2e-5 * (-1.0) ** np.arange(len(fz))
    points = steady_points({"re": re}, fz=fz, alpha=alpha, gamma=gamma, pressure=2.5e5)
    settings = FitFile(stages=("radius",))
    found = fit_magic_formula(points, shipped_tir(), settings).estimates
    assert found["Q_REA"].value == pytest.approx(0.3, abs=0.02)
    assert found["Q_REG"].value == pytest.approx(-0.2, abs=0.05)
    straight = points.rows(points.alpha == 0.0)
    lone = fit_magic_formula(straight, shipped_tir(), settings)
    assert not lone.estimates["Q_REA"].determined
    said = next(s for s in lone.confusions if "Q_REA" in s.names)
    assert "slip angle" in said.statement + said.remedy


def test_camber_and_side_force_with_moment() -> None:
    moment = {"QBZ1": 9.0, "QCZ1": 1.2, "QDZ1": 0.11, "QEZ1": -1.0, "QDZ8": -0.05}
    side = {"PKY2": 1.6, "PKY4": 2.0, "PKY6": -0.9}
    c = shipped_tir().replaced(moment | side).coefficients
    angles = np.radians((-8.0, -4.0, -2.0, -1.0, 0.0, 1.0, 2.0, 4.0, 8.0))
    rows = [
        (f, a, g) for f in (1850.0, 3700.0, 5550.0) for a in angles for g in (-0.07, 0.0, 0.07)
    ]
    fz, alpha, gamma = np.repeat(np.array(rows), 2, axis=0).T
    _, fy, mz = steady_forces(c, fz, 0.0, alpha, gamma, 2.5e5, 0.03)
    rng = np.random.default_rng(2)
    fy, mz = fy + 5.0 * rng.standard_normal(len(fy)), mz + 0.3 * rng.standard_normal(len(mz))
    points = steady_points({"fy": fy, "mz": mz}, fz=fz, alpha=alpha, gamma=gamma, pressure=2.5e5)
    start = shipped_tir().replaced({"PKY4": 2.0})
    found = fit_magic_formula(points, start, FitFile(stages=("pure_y", "aligning", "camber")))
    assert found.estimates["PKY1"].value == pytest.approx(c.PKY1, rel=0.03)
    assert found.estimates["PKY6"].value == pytest.approx(-0.9, abs=0.1)
    assert found.estimates["QDZ1"].value == pytest.approx(0.11, rel=0.03)
    assert found.relative_errors["fy"] < 0.01
    assert found.relative_errors["mz"] < 0.05


def test_merged_campaigns_keep_their_runs_apart() -> None:
    first, second = points_x(seed=1), points_x(seed=2)
    both = merge([first, second])
    assert len(both) == len(first) + len(second)
    assert len(np.unique(both.run)) == len(both)
    radius = steady_points({"re": np.array([0.31])}, fz=np.array([3700.0]), pressure=2.5e5)
    mixed = merge([first, radius])
    assert len(mixed.with_output("re")) == 1
    assert len(mixed.with_output("fx")) == len(first)


def test_campaign_fit_from_runs() -> None:
    loads = (2500.0, 3700.0, 5000.0)
    runs = [
        r
        for i, f in enumerate(loads)
        for r in simulate_runs(Truth(fz=f, slip_stiffness=25.0 * f), np.random.default_rng(i))
    ]
    found = fit_campaign(runs, FitFile("mf", stages=("pure_x", "stiffness")), start=shipped_tir())
    stiffness = found.estimates["PKX1"]
    assert stiffness.value == pytest.approx(25.0, rel=0.05)
    assert found.estimates["LONGITUDINAL_STIFFNESS"].value == pytest.approx(2.0e5, rel=0.1)


def test_every_stage_names_known_coefficients_and_outputs() -> None:
    for stage in STAGES.values():
        for output, names in stage.outputs.items():
            assert output in PREDICTIONS
            for name in names.split():
                assert name in COEFFICIENTS
    for name, limit in COEFFICIENTS.items():
        assert name in SECTION_OF
        assert limit.lower <= limit.start <= limit.upper
        assert limit.size > 0.0


FIT_FILE = """
format: flatplank-fit/1
model: mf
campaigns: [one, two]
tire: start.tir
stages: [pure_x, pressure]
fixed: {PKX3: 0.0}
bounds: {PCX1: [1.0, 2.0]}
prior: {PEX4: [0.0, 0.1]}
weights: {fx: 2.0}
"""


def test_fit_file_round_trip(tmp_path: Path) -> None:
    path = tmp_path / "fit.yaml"
    path.write_text(FIT_FILE)
    fit = read_fit_file(path)
    assert fit.stages == ("pure_x", "pressure")
    assert fit.prior["PEX4"] == (0.0, 0.1)
    nonlinear = parse_fit(
        "{format: flatplank-fit/1, model: nonlinear, fixed: {friction: 0.9}, "
        "bounds: {c_cx: [1e5, 3e5]}, geometry: {q_ra1: 0.9}}"
    )
    options = nonlinear.carcass_options()
    assert options["friction"] == 0.9
    assert options["bounds"] == (1e5, 3e5)
    assert options["geometry"].q_ra1 == 0.9


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (
            ("stages: [pure_x", "stages: [pure_z"),
            "stages: unknown name 'pure_z'; the nearest is 'pure_",
        ),
        (("weights", "wieghts"), "unknown parameter 'wieghts'; the nearest is 'weights'"),
        (("[1.0, 2.0]", "[2.0, 1.0]"), "bounds of PCX1 are 2, 1"),
        (("[0.0, 0.1]", "[0.0, 0.0]"), "prior of PEX4 has spread 0"),
        (("{PKX3: 0.0}", "{PKX3: much}"), "fixed: PKX3 must be a number, not 'much'"),
        (("flatplank-fit/1", "flatplank-fit/9"), "format is not flatplank-fit/1"),
        (("{PKX3: 0.0}", "{PKX3: 0.0"), "not YAML"),
    ],
)
def test_fit_file_mistakes_are_one_line(
    tmp_path: Path, change: tuple[str, str], says: str
) -> None:
    path = tmp_path / "fit.yaml"
    path.write_text(FIT_FILE.replace(*change))
    with pytest.raises(FlatplankError) as error:
        read_fit_file(path)
    assert says in str(error.value)
    assert "fit.yaml" in str(error.value)
    assert "\n" not in str(error.value)


def test_a_second_solution_is_named_until_a_load_decides(full: MFFit) -> None:
    """Three loads take K_xk with PKX2 of either sign; far loads tell them apart."""
    assert not full.estimates["PKX2"].determined
    said = next(c for c in full.confusions if c.names == ("PKX2", "PKX3"))
    assert "second solution (PKX2 = " in said.statement and "3 loads" in said.statement
    assert said.remedy == "measure a load of 8000 N"
    loads = (1000.0, 1850.0, 3700.0, 5550.0, 8000.0)
    more = fit_magic_formula(points_x(loads=loads, noise=2.0), shipped_tir(), FX)
    assert more.estimates["PKX2"].determined
    low, high = more.estimates["PKX2"].interval(0.999)
    assert low < TRUTH.coefficients.PKX2 < high


def test_a_second_solution_that_only_the_noise_excludes_stays_open() -> None:
    """Such draws pass a test of the odds by luck; intervals of lucky draws hold too rarely."""
    loads = (1850.0, 3700.0, 5550.0, 7400.0)
    found = fit_magic_formula(points_x(loads=loads, noise=2.0, seed=1), shipped_tir(), FX)
    said = next(c for c in found.confusions if c.names == ("PKX2", "PKX3"))
    assert "that only the noise of these runs excludes" in said.statement
    assert not found.estimates["PKX3"].determined


def test_pressure_of_a_curve_that_was_not_measured_is_not_fitted() -> None:
    points = points_x()
    side = dict(points.measured) | {"fy": np.full(len(points), 5.0)}
    straight = replace(points, measured=side).rows(np.abs(points.alpha) < 1e-6)
    found = fit_magic_formula(straight, shipped_tir(), FitFile(stages=("pure_x", "pressure")))
    assert "PPY1" not in found.estimates
    assert any("PPY1" in text and "slip angle" in text for text in found.skipped)
