# SPDX-License-Identifier: Apache-2.0
"""The linear loop against the thesis and against the numbers recomputed for this project."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import control
from flatplank_control.cli.tune import main as tune
from flatplank_control.free_rolling import FreeRollingController, FreeRollingParameters
from flatplank_control.free_rolling.design import Machine, crossover_for, design_gains
from flatplank_control.free_rolling.loop import controller_of, draw, loop_of, margins, plant_of
from flatplank_control.free_rolling.loop import figures as figures_of
from flatplank_control.free_rolling.params import THESIS_LEAD_ALPHA
from flatplank_hw.samples import EncoderSample, HubSample, Wrench
from flatplank_validation.free_rolling.linear import (
    Actuator,
    controller,
    figures,
    real_loop,
    settling_time,
    thesis_loop,
)

P = FreeRollingParameters(automatic=False)
THESIS = replace(P, lead_alpha=THESIS_LEAD_ALPHA)


def test_inertias():
    assert Actuator().j_eff == pytest.approx(1009.30, abs=0.005)
    assert Actuator().j_tw == pytest.approx(14.08, abs=0.005)
    assert Actuator().gear == pytest.approx(1425.04)


def test_loop_with_the_inertia_of_the_formula():
    loop = figures(thesis_loop())
    assert loop.phase_margin == pytest.approx(39.92, abs=0.05)
    assert loop.crossover == pytest.approx(3.144, abs=0.002)
    assert loop.gain_margin == math.inf
    assert loop.bandwidth == pytest.approx(5.22, abs=0.03)
    assert loop.peak == pytest.approx(3.93, abs=0.01)
    assert loop.peak_at == pytest.approx(2.55, abs=0.01)
    assert loop.dip_at == pytest.approx(0.678, abs=0.002)


def test_loop_with_the_printed_inertia_is_not_the_thesis():
    loop = figures(thesis_loop(j_eff=1287.0))
    assert loop.phase_margin == pytest.approx(39.56, abs=0.05)
    assert loop.bandwidth == pytest.approx(4.36, abs=0.01)
    assert loop.peak == pytest.approx(4.16, abs=0.01)
    assert loop.peak_at == pytest.approx(2.13, abs=0.01)
    assert loop.dip_at == pytest.approx(0.601, abs=0.002)


@pytest.mark.parametrize(("band", "time"), [(0.005, 32.73), (0.02, 17.39), (0.05, 7.25)])
def test_settling_time(band, time):
    assert settling_time(thesis_loop(), band) == pytest.approx(time, abs=0.02)


def test_tune_without_delay_is_the_loop_of_the_thesis(capsys, tmp_path):
    """39.9 deg, 5.2 Hz, and a step that is drawn to the end of its 32.7 s."""
    picture = tmp_path / "tune.png"
    words = ["--cfk", "90.65", "--sigma", "0.4505", "--delay-cycles", "0"]
    assert tune([*words, "--figure", str(picture)]) == 0
    (line,) = [x for x in capsys.readouterr().out.splitlines() if x.startswith("thesis")]
    for part in ("39.92 deg", "3.14 Hz", "bandwidth 5.22 Hz", "settles to 0.5 % in 32.7 s"):
        assert part in line, line
    assert picture.stat().st_size > 10_000


def test_the_picture_of_a_loop_has_its_curves(monkeypatch, tmp_path):
    """Of a loop that is known in closed form, and of one that is unstable and has no step."""
    drawn = []
    monkeypatch.setattr(
        "matplotlib.figure.Figure.savefig", lambda f, path: drawn.append((f, path))
    )
    s = control.tf("s")
    draw(tmp_path / "a.svg", {"good": 2.0 / (s + 1.0) ** 2, "bad": 50.0 / (s + 1.0) ** 3})
    ((figure, path),) = drawn
    assert path == tmp_path / "a.svg"
    size, phase, step, poles = figure.axes
    for panel, order, gain in ((size, 2, 2.0), (size, 3, 50.0)):
        line = next(x for x in panel.get_lines() if x.get_label() == {2: "good", 3: "bad"}[order])
        f = line.get_xdata()
        assert f[0] < 0.1 and f[-1] > 10.0
        known = gain / (1.0 + (2.0 * np.pi * f) ** 2) ** (order / 2.0)
        np.testing.assert_allclose(line.get_ydata(), known, rtol=1e-6)
    for line, order in zip(phase.get_lines(), (2, 3), strict=False):
        known = -order * np.degrees(np.arctan(2.0 * np.pi * line.get_xdata()))
        np.testing.assert_allclose(line.get_ydata(), known, atol=1e-6)
    (curve, settled) = step.get_lines()
    t, y = curve.get_data()
    # s^2 + 2 s + 3: natural frequency sqrt(3), decay 1
    w = np.sqrt(2.0)
    known = (2.0 / 3.0) * (1.0 - np.exp(-t) * (np.cos(w * t) + np.sin(w * t) / w))
    np.testing.assert_allclose(y, known, atol=1e-4)
    end = settled.get_xdata()[0]
    outside = np.abs(known / (2.0 / 3.0) - 1.0) > 0.005
    assert end == pytest.approx(t[outside][-1], abs=0.02) and t[-1] == pytest.approx(
        1.1 * end, 1e-2
    )
    points = {x.get_label(): x for x in poles.get_lines()}
    at = np.sort_complex(points["good x"].get_xdata() + 1j * points["good x"].get_ydata())
    np.testing.assert_allclose(at, [-1.0 - 1j * w, -1.0 + 1j * w], atol=1e-6)
    assert len(points["bad x"].get_xdata()) == 3 and "good o" in points
    for panel, level in ((size, 1.0), (phase, -180.0)):
        assert [x.get_ydata()[0] for x in panel.get_lines()[2:]] == [level]
    assert {"good", "bad"} <= {t.get_text() for t in size.get_legend().get_texts()}
    assert all(panel.get_xlabel() and panel.get_ylabel() for panel in figure.axes)


def test_the_printed_inertia_is_that_of_half_the_efficiency():
    """1287 kg m2 of table 5.1 is (5.5) with 0.50 in place of 0.392."""
    assert Actuator(efficiency=0.50).j_eff == pytest.approx(1287.0, abs=0.5)


@pytest.mark.parametrize("rate", [250.0, 500.0, 1000.0])
def test_margin_with_the_real_delay(rate, capsys):
    ours, thesis = (figures(real_loop(replace(p, rate_hz=rate))) for p in (P, THESIS))
    with capsys.disabled():
        print(
            f"\n{rate:.0f} Hz, 2 cycles + hold: phase margin {ours.phase_margin:.2f} deg at "
            f"{ours.crossover:.3f} Hz, gain margin {ours.gain_margin:.2f} "
            f"(thesis as printed {thesis.phase_margin:.2f} deg, {thesis.gain_margin:.2f})"
        )
    assert ours.phase_margin >= 30.0
    assert ours.gain_margin >= 2.0


def test_delay_costs_what_was_computed_and_the_lead_gives_it_back():
    assert figures(real_loop(THESIS)).phase_margin == pytest.approx(28.6, abs=0.1)
    designed = figures(thesis_loop()).phase_margin
    assert figures(real_loop(P)).phase_margin == pytest.approx(designed, abs=0.1)


def test_four_times_the_stiffness_at_the_same_relaxation_length():
    stiff = Actuator(slip_stiffness=4 * 24.5)
    assert figures(thesis_loop(stiff)).phase_margin == pytest.approx(29.0, abs=0.5)
    assert abs(figures(real_loop(THESIS, stiff)).phase_margin) < 1.0
    same = Actuator(slip_stiffness=4 * 24.5, relaxation_length=4 * 0.4505)
    assert figures(thesis_loop(same)).phase_margin == pytest.approx(39.8, abs=0.1)


@pytest.mark.parametrize("p", [P, THESIS], ids=["ours", "thesis"])
def test_the_core_is_the_discrete_controller_of_the_analysis(p):
    """Impulse response of the class against that of the transfer function."""
    p = replace(p, reference=0.0, start_torque=0.0, torque_min=-100.0, torque_max=100.0)
    core = FreeRollingController(p)
    wanted = control.sample_system(controller(p), 1.0 / p.rate_hz, "bilinear")
    n = 60
    errors = np.random.default_rng(2).normal(0.0, 100.0, n)
    _, y = control.forced_response(wanted, np.arange(n) / p.rate_hz, errors)
    out = []
    for k, e in enumerate(errors):
        w = Wrench(-e, 0.0, 3700.0, 0.0, 0.0, 0.0)
        hub = HubSample(k, k, w, w, 0.3, 0.0, 3700.0, False, 0)
        enc = EncoderSample(k, k, 0.1, 0.03, 0, 0, 0, 0, math.nan, 0, 0, True, False, 0.0)
        out.append(core.step(hub, enc).value)
    assert out == pytest.approx(np.ravel(y).tolist(), rel=1e-6, abs=1e-9)


OTHER = Machine(
    gear=1000.0,
    efficiency=0.5,
    inertia=800.0,
    effective_radius=0.4,
    loaded_radius=0.35,
    speed=0.02,
)


@pytest.mark.parametrize("machine", [None, OTHER])
@pytest.mark.parametrize("sigma", [0.3, math.inf, math.nan])
def test_the_plant_is_that_of_the_formula(machine, sigma):
    """By hand, (5.9c): i eta C r_e / (J s (s + V / sigma) + C r_e r_l)."""
    m = machine or Machine()
    for omega in (0.5, 5.0, 50.0):
        s = 1j * omega
        drag = m.speed / 0.3 if sigma == 0.3 else 0.0
        known = m.gear * m.efficiency * 4e5 * m.effective_radius / (
            m.inertia * s * (s + drag) + 4e5 * m.effective_radius * m.loaded_radius
        )  # fmt: skip
        assert m.response(omega, 4e5, sigma) == pytest.approx(known, rel=1e-12)
        if sigma == 0.3:
            assert plant_of(4e5, 0.3, machine)(s) == pytest.approx(known, rel=1e-9)


@pytest.mark.parametrize(
    ("delay", "omega"), [(0.0, 20.0), (0.01, 20.0), (0.016, 20.0), (0.032, 10.0), (0.064, 5.0)]
)
def test_the_crossover_leaves_the_delay_its_phase(delay, omega):
    assert crossover_for(delay) == pytest.approx(omega)


@pytest.mark.parametrize("machine", [None, OTHER])
@pytest.mark.parametrize("delay", [0.0, 0.01, 0.05])
def test_the_loop_of_the_designed_gains_crosses_where_it_is_to(machine, delay):
    gains = design_gains(4e5, 0.3, delay, machine)
    omega = crossover_for(delay)
    loop = controller_of(gains)(1j * omega) * (machine or Machine()).response(omega, 4e5, 0.3)
    assert abs(loop) == pytest.approx(1.0, rel=1e-9)
    assert gains.integral / gains.proportional == pytest.approx(omega / 15.0)
    assert gains.lead_alpha == 0.08
    assert gains.lead_time * omega == pytest.approx(1.0 / math.sqrt(0.08))
    assert design_gains(4e5, math.nan, delay) == design_gains(4e5, math.inf, delay)


@pytest.mark.parametrize("delay", [0.0, 0.012])
def test_the_delay_turns_the_loop_and_leaves_its_size(delay):
    gains = design_gains(4e5, 0.3, 0.01)
    loop = loop_of(gains, 4e5, 0.3, delay)
    plain = controller_of(gains) * plant_of(4e5, 0.3)
    for omega in (1.0, 20.0, 60.0):
        turned = loop(1j * omega) / plain(1j * omega)
        assert turned == pytest.approx(np.exp(-1j * omega * delay), abs=1e-6)


def test_a_slow_sampled_loop_has_its_margin():
    """0.15 / s, held for 0.1 s: it crosses at 0.15 rad/s with 90 deg less half a sample."""
    loop = control.sample_system(control.tf([0.15], [1.0, 0.0]), 0.1, "zoh")
    phase, crossover, _ = margins(loop)
    assert crossover == pytest.approx(0.15, rel=1e-3)
    assert phase == pytest.approx(90.0 - math.degrees(0.15 * 0.05), abs=0.05)


def test_figures_of_a_loop_in_closed_form():
    """2 / s (1 + s): H has its peak at sqrt(1.5) rad/s, 4 / sqrt(7), and -3 dB at 2.54 rad/s."""
    found = figures_of(control.tf([2.0], [1.0, 1.0, 0.0]))
    turn = 2.0 * math.pi
    assert found.peak_at == pytest.approx(math.sqrt(1.5) / turn, rel=1e-3)
    assert found.peak == pytest.approx(20.0 * math.log10(4.0 / math.sqrt(7.0)), abs=1e-3)
    # |H|^2 = 4 / ((2 - w^2)^2 + w^2) = 10^-0.3
    square = 0.5 * (3.0 + math.sqrt(9.0 - 4.0 * (4.0 - 4.0 * 10.0**0.3)))
    assert found.bandwidth == pytest.approx(math.sqrt(square) / turn, rel=1e-3)
    crosses = math.sqrt(0.5 * (math.sqrt(17.0) - 1.0))
    assert found.crossover == pytest.approx(crosses / turn, rel=1e-6)
    assert found.phase_margin == pytest.approx(math.degrees(math.atan(1.0 / crosses)), abs=1e-3)
    assert found.gain_margin == math.inf and math.isnan(found.dip_at)


def test_poles_far_from_the_others_are_not_drawn(monkeypatch, tmp_path):
    drawn = []
    monkeypatch.setattr("matplotlib.figure.Figure.savefig", lambda f, path: drawn.append(f))
    s = control.tf("s")
    far = {"real": 2.0 * 900.0 / ((s + 1.0) ** 2 * (s + 900.0)),
           "turning": 9e4 / ((s + 1.0) * (s**2 + 60.0 * s + 9e4))}  # fmt: skip
    draw(tmp_path / "a.svg", far)
    shown = {line.get_label(): line for line in drawn[0].axes[3].get_lines()}
    assert len(shown["real x"].get_xdata()) == 2
    assert len(shown["turning x"].get_xdata()) == 1
