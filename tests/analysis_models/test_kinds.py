# SPDX-License-Identifier: Apache-2.0
"""Cleat, parking, turning, camber sweep: what they tell is what the simulated tire is made of."""

from __future__ import annotations

import numpy as np
import pytest

from flatplank_analysis.identify.results import to_plain
from flatplank_analysis.kinds.camber_sweep import camber_sweep
from flatplank_analysis.kinds.cleat import cleat, envelope
from flatplank_analysis.kinds.parking import parking, twisted
from flatplank_analysis.kinds.record_fit import relaxed
from flatplank_analysis.kinds.turning import brush, turning
from flatplank_analysis.report.extras import RUN_BY_RUN
from flatplank_analysis.report_files.build import build
from flatplank_control.bench.results import write_campaign
from flatplank_control.bench.setup import BenchSetup
from flatplank_control.runner.measurement import Measurement
from flatplank_control.runner.plans import axes_of, plan_of
from flatplank_data.campaign import Campaign
from flatplank_data.errors import FlatplankError
from flatplank_data.run_record import RunRecord
from flatplank_data.table import MeasurementTable
from flatplank_sim.plant import PlantConfig
from flatplank_sim.twin.log import TableLog
from flatplank_sim.twin.twin import Twin
from flatplank_sim.twin.twin_bench import TwinBench
from flatplank_validation.truth import truth_row

LOAD = 3700.0
RUNS = {
    "cleat": Measurement(measurement="cleat", cleat_mm=10.0, end_position=2.4),
    "parking": Measurement(
        measurement="parking", profile="parking", profile_time=40.0,
        profile_parameters={"amplitude": 0.3, "rate": 0.035, "cycles": 1},
    ),
    "turning": Measurement(
        measurement="turning", profile="impulse", step_position=0.5, end_position=1.8,
        profile_parameters={"amplitude": 0.02, "start": 0.5, "length": 2.0},
    ),
    "camber_sweep": Measurement(
        measurement="camber_sweep", profile="sine", step_position=0.4, end_position=2.0,
        profile_parameters={"amplitude": 0.05, "period": 20.0},
    ),
}  # fmt: skip


@pytest.fixture(scope="module")
def campaign(tmp_path_factory) -> Campaign:
    """One run of every kind on the twin."""
    folder = tmp_path_factory.mktemp("kinds")
    listed = []
    for m in RUNS.values():
        bench = TwinBench(Twin(BenchSetup(pace="hold", axes=axes_of(m))), TableLog(folder))
        bench.perform(plan_of(m))
        listed.append((m.record(), bench.kept[0].name))
    write_campaign(folder, "TOY", listed)
    return Campaign.load(folder)


@pytest.fixture(scope="module")
def tire():
    config = PlantConfig.load("toyo")
    return config.tire, truth_row(config, LOAD, 2.5)


def table_of(campaign: Campaign, kind: str) -> MeasurementTable:
    return next(r for r in campaign.runs if r.info.measurement == kind).table()


def test_cleat(campaign, tire):
    found = cleat(table_of(campaign, "cleat"))
    _, truth = tire
    # the record begins at the motion trigger, 20 mm before which the machine's zero lies
    assert found.middle.value == pytest.approx(1.98, abs=0.003)
    assert found.stiffness_over_cleat == pytest.approx(truth.vertical_stiffness, rel=0.03)
    assert found.stiffness.value == pytest.approx(truth.vertical_stiffness, rel=0.15)
    assert found.effective_height.max() == pytest.approx(0.010, rel=0.15)
    # up, then down again: the tire is held back before the cleat and pushed behind it
    before = (found.distance > -0.06) & (found.distance < -0.02)
    assert found.effective_slope[before].min() > 0.05
    assert found.fx[before].max() < 0.0
    assert found.rmse_fz < 0.06 * found.rise
    # its key in report.json, older than the name of the field
    assert to_plain(found)["longitudinal_stiffness"] == found.fx_slope


def test_parking(campaign, tire):
    """A line of bristles under a parabola: C = 2/3 c a^3, M_max = 3/8 mu a Fz."""
    found = parking(table_of(campaign, "parking"))
    config, truth = tire
    a = truth.contact_half_length
    assert found.stiffness.value == pytest.approx(
        2.0 / 3.0 * config.tread_stiffness_y * a**3, rel=0.15
    )
    assert found.saturation.value == pytest.approx(0.375 * truth.friction * a * LOAD, rel=0.1)
    assert found.rmse < 0.02 * found.saturation.value
    assert 0.3 * found.largest < found.residual_moment < found.largest
    assert found.loss == pytest.approx(62.0, rel=0.1)


def test_turning(campaign, tire):
    found = turning(table_of(campaign, "turning"))
    config, truth = tire
    a = truth.contact_half_length
    bristles = 2.0 * a * config.tread_stiffness_y
    at_rest = 1.0 / (1.0 / truth.carcass_stiffness_y + 1.0 / bristles)
    assert found.half_length.value == pytest.approx(a, rel=0.03)
    assert found.cornering_stiffness.value == pytest.approx(truth.cornering_stiffness, rel=0.1)
    sigma = truth.cornering_stiffness / at_rest
    assert found.relaxation_length.value == pytest.approx(sigma, rel=0.1)
    assert found.rmse < 1.5
    assert to_plain(found)["angle_left"]["value"] == found.remaining_angle.value


def test_camber_sweep(campaign, tire):
    """A line of bristles on a path of the curvature gamma/r_e: C = 2/3 c a^3 / r_e."""
    found = camber_sweep(table_of(campaign, "camber_sweep"))
    config, truth = tire
    spin = config.camber_factor / truth.effective_rolling_radius
    true = 2.0 / 3.0 * config.tread_stiffness_y * truth.contact_half_length**3 * spin
    assert found.camber_stiffness.value == pytest.approx(true, rel=0.05)
    low, high = found.camber_stiffness.interval()
    assert high - low < 0.1 * true
    assert found.relaxation_length.value == pytest.approx(0.58, abs=0.06)
    assert abs(found.direct_share.value) < 0.1


def test_every_kind_has_its_figure_and_table_in_the_report(campaign, tmp_path):
    page = build(campaign, tmp_path).read_text()
    for kind in RUN_BY_RUN:
        assert (tmp_path / "tables" / f"{kind}.csv").exists()
        assert list((tmp_path / "figures").glob(f"{kind.removesuffix('_sweep')}*.png"))
    assert "Cleat of 10 mm, Fz 3700 N, 2.5 bar" in page
    assert "slip runs in" not in page


def test_relaxation_over_travel_is_that_of_a_step_and_of_a_ramp():
    x = 0.01 * np.arange(200)
    (ramp,) = relaxed(x, 0.01, np.array([0.3]))
    assert ramp == pytest.approx(x - 0.3 * (1.0 - np.exp(-x / 0.3)), abs=1e-12)


def test_a_linear_brush_in_steady_side_slip():
    x = 0.004 * np.arange(2000)
    heading = np.full((1, len(x)), 0.01)
    force, moment = brush(x, heading, np.array([5e4]), np.array([0.5]), np.array([0.07]))
    assert force[0, -1] == pytest.approx(-500.0, rel=0.03)
    # the pneumatic trail of a brush that sticks is a third of its half length
    assert moment[0, -1] == pytest.approx(500.0 * 0.07 / 3.0, rel=0.06)


def test_twisting_follows_masing_s_rule():
    angle = np.concatenate([np.linspace(0, 0.3, 100), np.linspace(0.3, -0.3, 200)])
    (m,) = twisted(angle, np.array([1000.0]), np.array([100.0]), np.array([1.0]))
    first = 100.0 * (1.0 - np.exp(-10.0 * angle[:100]))
    assert m[:100] == pytest.approx(first, abs=0.1)
    back = m[99] - 200.0 * (1.0 - np.exp(-5.0 * (0.3 - angle[100:])))
    assert m[100:] == pytest.approx(back, abs=0.3)


def test_two_cams_see_the_height_and_no_slope_on_top():
    x = np.array([[-0.5, 0.0, 0.5]])
    w, slope = envelope(x, 0.01, 0.01, np.array([[0.3]]), np.array([[0.004]]))
    assert w[0] == pytest.approx([0.0, 0.01, 0.0])
    assert slope[0] == pytest.approx([0.0, 0.0, 0.0], abs=1e-12)


@pytest.mark.parametrize("kind", RUN_BY_RUN)
def test_a_run_that_shows_nothing_is_refused_with_its_name(kind):
    x = np.linspace(0.0, 2.0, 4000)
    zero = {n: np.zeros_like(x) for n in ("fx", "fy", "mz", "steer_angle", "total_camber")}
    columns = {"plank_position": x, "fz": np.full_like(x, LOAD), **zero}
    given = {"parameters": {"measurement": {"cleat_mm": 10.0}}}
    table = MeasurementTable(columns, RunRecord(file="run.csv", measurement=kind, **given))
    with pytest.raises(FlatplankError, match=r"run\.csv"):
        RUN_BY_RUN[kind](table)
