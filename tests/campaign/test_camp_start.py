# SPDX-License-Identifier: Apache-2.0
"""Free rolling and slip from the first centimetres, for every tire; the thesis's way beside it."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest

from flatplank_control.free_rolling.design import Machine, design_gains
from flatplank_control.free_rolling.loop import phase_margin
from flatplank_control.free_rolling.params import THESIS_LEAD_ALPHA, FreeRollingParameters
from flatplank_validation.bench.driven_plank import DrivenPlank
from flatplank_validation.bench.start_bench import StartBench
from flatplank_validation.bench.start_cases import FURTHER, TOYO, like
from flatplank_validation.truth import truth_row
from flatplank_validation.verbs import bench_start
from flatplank_validation.verbs.bench_start import CASES, kept

POSITION, FORCE = 0, 1
TIRES = list(CASES)


@cache
def automatic(tire: str, fz: float) -> tuple[np.ndarray, StartBench]:
    bench = StartBench(tire, controller={"automatic": True})
    return bench.free_rolling(fz, 1.0), bench


def settled_at(rows: np.ndarray) -> float:
    """Road [m] behind which the true force, over 20 mm, stays within 5 % of 50 N."""
    window = 160
    smooth = np.convolve(rows[:, FORCE], np.ones(window) / window, "valid")
    outside = np.flatnonzero(np.abs(smooth - 50.0) > 2.5)
    return float(rows[outside[-1] + window // 2, POSITION]) if outside.size else 0.0


@pytest.mark.parametrize(("tire", "fz"), TIRES)
def test_free_rolling_within_5_percent_after_0_3_m(tire, fz):
    rows, bench = automatic(tire, fz)
    assert settled_at(rows) <= 0.3
    late = rows[rows[:, POSITION] > 0.5, FORCE]
    assert late.mean() == pytest.approx(50.0, rel=0.01)
    assert np.ptp(late) < 50.0
    assert bench.stop_reason == 0


@pytest.mark.parametrize(("tire", "fz"), TIRES)
def test_the_tire_is_known_after_the_first_centimetres(tire, fz):
    _, bench = automatic(tire, fz)
    truth = truth_row(bench.config, fz, bench.config.tire.nominal_pressure_bar)
    felt = bench.controller.tire
    assert felt.stiffness == pytest.approx(truth.standstill_stiffness_x, rel=0.06)
    assert felt.effective_radius == pytest.approx(truth.effective_rolling_radius, rel=0.003)


def test_the_thesis_controller_oscillates_on_the_racing_tire_and_ours_does_not(capsys):
    truth = truth_row(automatic("racing", 3700.0)[1].config, 3700.0, 1.6)
    delay = FreeRollingParameters().loop_delay
    tire = (truth.standstill_stiffness_x, truth.relaxation_length_x)
    thesis = StartBench("racing", controller={"lead_alpha": THESIS_LEAD_ALPHA})
    rows = thesis.free_rolling(3700.0, 1.5)
    swing = np.ptp(rows[rows[:, POSITION] > 1.0, FORCE])
    ours, bench = automatic("racing", 3700.0)
    calm = np.ptp(ours[ours[:, POSITION] > 0.5, FORCE])
    margins = [
        phase_margin(gains, *tire, delay)
        for gains in (thesis.controller.gains, bench.controller.gains)
    ]
    with capsys.disabled():
        print(
            f"\nracing tire: thesis {margins[0]:.1f} deg, swings by {swing:.0f} N; "
            f"ours {margins[1]:.1f} deg, {calm:.0f} N"
        )
    assert margins[0] < 0.0 and swing > 200.0
    assert margins[1] > 30.0 and calm < 50.0


@pytest.mark.parametrize(("share", "sigma", "rate", "cycles"), FURTHER)
def test_five_further_tires_and_delays(share, sigma, rate, cycles, capsys):
    bench = StartBench(
        "toyo",
        rate_hz=rate,
        overrides={**like(share * TOYO, sigma), "command_delay_cycles": cycles},
        controller={"automatic": True, "delay_cycles": float(cycles)},
    )
    rows = bench.free_rolling(3700.0, 0.8)
    truth = truth_row(bench.config, 3700.0, 2.5)
    assert truth.relaxation_length_x == pytest.approx(sigma, rel=0.05)
    tire = (truth.standstill_stiffness_x, truth.relaxation_length_x)
    delay = (cycles + 0.5) / rate
    margin = phase_margin(bench.controller.gains, *tire, delay)
    felt = bench.controller.tire
    with capsys.disabled():
        print(
            f"\nC_x {tire[0] / 1e3:.0f} (felt {felt.stiffness / 1e3:.0f}) N/mm, sigma {sigma:g} "
            f"(felt {felt.relaxation:.2f}) m, delay {1e3 * delay:.0f} ms: margin {margin:.1f} deg"
        )
    assert margin >= 30.0
    assert np.ptp(rows[rows[:, POSITION] > 0.4, FORCE]) < 50.0
    assert settled_at(rows) <= 0.3


def test_closed_form_gains_are_those_of_python_control():
    import control

    m, tire, delay = Machine(), (4.0e5, 0.3), 0.010
    gains = design_gains(*tire, delay)
    s = control.tf("s")
    turn = tire[0] * m.effective_radius
    plant = (
        m.gear
        * m.efficiency
        * turn
        / (m.inertia * s * (s + m.speed / tire[1]) + turn * m.loaded_radius)
    )
    lead = (gains.lead_time * s + 1) / (gains.lead_alpha * gains.lead_time * s + 1)
    loop = (gains.proportional + gains.integral / s) * lead * plant
    omega = np.logspace(0.0, 2.5, 20_000)
    response = loop(1j * omega)
    last = np.flatnonzero(np.abs(response) > 1.0)[-1]
    turned = np.degrees(np.angle(response[last]) - omega[last] * delay)
    assert omega[last] == pytest.approx(20.0, rel=0.01)
    assert 180.0 + turned == pytest.approx(phase_margin(gains, *tire, delay), abs=0.5)


@pytest.mark.parametrize(("tire", "fz"), [("toyo", 1850.0), ("toyo", 3700.0), ("racing", 3700.0)])
def test_a_slip_step_can_be_given_at_0_3_m(tire, fz, capsys):
    residual = {}
    for name, follow in {"thesis": 0.0, "ours": 0.25}.items():
        bench = StartBench(tire, sequencer={"follow_until": follow})
        rows = bench.slip(fz, 0.0, at=0.28, distance=0.32)
        before = rows[(rows[:, POSITION] > 0.28) & (rows[:, POSITION] < 0.3), FORCE]
        residual[name] = float(before.mean())
    with capsys.disabled():
        print(
            f"\n{tire} {fz:.0f} N: force before a step at 0.3 m {residual['thesis']:.0f} N "
            f"with the wheel's own start, {residual['ours']:.1f} N with the travel made up"
        )
    assert abs(residual["ours"]) < 5.0 < abs(residual["thesis"])
    assert math.isfinite(residual["ours"])


@pytest.mark.parametrize("tire", ["toyo", "racing"])
def test_with_a_driven_plank_the_tire_rolls_freely_after_0_3_m(tire):
    bench = DrivenPlank(tire, controller={"automatic": True})
    assert settled_at(bench.free_rolling(3700.0, 1.0)) <= 0.3
    assert bench.stop_reason == 0
    rows = DrivenPlank(tire, sequencer={"follow_until": 0.25}).slip(3700.0, 0.0, 0.28, 0.32)
    before = rows[(rows[:, POSITION] > 0.28) & (rows[:, POSITION] < 0.3), FORCE]
    assert abs(before.mean()) < 5.0
    assert rows[:, FORCE].min() > -250.0


@pytest.mark.parametrize(
    ("swing", "expected"), [(0.0, 0.04 * math.log(20.0)), (8.0, 0.04 * math.log(50.0 / 6.5)),
                            (60.0, math.nan)],
)  # fmt: skip
def test_a_start_has_settled_where_the_machine_moves_the_steady_force(swing, expected):
    """50 N (1 - exp(-x/0.04 m)), and what the road adds: 8 N over the pinion's turn."""
    x = np.arange(0.0, 2.5, 0.03092 / 250.0)
    force = 50.0 * (1.0 - np.exp(-x / 0.04)) + 0.5 * swing * np.sin(2.0 * math.pi * x / 0.314)
    found = bench_start.settled(np.column_stack([x, force]))
    # the mean over 20 mm, and a crest of the road near by
    assert found == pytest.approx(expected, abs=0.03, nan_ok=True)


def test_on_the_machine_of_the_thesis_our_controller_is_as_wanted():
    """Its hub is off by 0.5 N beside the filter, and its road moves the force by 4 N."""
    ours = bench_start.free_rolling("toyo", 3700.0, "ours", "thesis2023")
    assert kept({"ours": ours}), ours
    assert 0.2 < ours["hub_error_n"] < 1.0
