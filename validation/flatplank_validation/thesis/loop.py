# SPDX-License-Identifier: Apache-2.0
"""Figures 5.5 to 5.8: the linear loop of the free-rolling controller."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache

import numpy as np

import control
from flatplank_analysis.figures.spec import MUTED, PALETTE, Figure, Panel, Series
from flatplank_validation.free_rolling.linear import Loop, figures, settling_time, thesis_loop
from flatplank_validation.thesis.lab import Lab

END = 40.0
"""end of the step response: behind the settling time of 32.7 s [s]"""
HZ = np.geomspace(1e-2, 1e2, 1500)
FREQUENCY = "frequency [Hz]"
BAND = 0.005
"""band of the settling time: 0.5 % gives the thesis's 32.7 s"""


@cache
def numbers() -> Loop:
    """Margins, bandwidth, peak of H, dip of S."""
    return figures(thesis_loop())


@cache
def settles() -> float:
    """Settling time of H [s]."""
    return settling_time(thesis_loop(), BAND)


@cache
def sag() -> float:
    """Least |H| between zero frequency and the peak [dB]."""
    h = _decibel(_closed()[1](_s()))
    peak = int(np.argmax(h))
    return float(h[:peak].min())


def _s() -> np.ndarray:
    return 2j * np.pi * HZ


def _decibel(values: np.ndarray) -> np.ndarray:
    return 20.0 * np.log10(np.abs(values))


def _closed() -> tuple[control.TransferFunction, control.TransferFunction]:
    """S and H of (5.13)."""
    loop = thesis_loop()
    return control.feedback(1, loop), control.feedback(loop, 1)


def step(_lab: Lab) -> Iterator[Figure]:
    """Figure 5.5."""
    t, y = control.step_response(_closed()[1], np.linspace(0.0, END, 8001))
    lines = [Series("", np.asarray(t), np.asarray(y), color=PALETTE[0])]
    panel = Panel("time [s]", "Fx over its reference [-]", lines, (0.0, END), (settles(),))
    caption = f"Dotted: within {100 * BAND:g} % from {settles():.1f} s on."
    yield Figure("step_response", "Step response of H", caption, (panel,))


def bode(_lab: Lab) -> Iterator[Figure]:
    """Figure 5.6."""
    response = thesis_loop()(_s())
    phase = np.degrees(np.unwrap(np.angle(response)))
    cross, margin = numbers().crossover, numbers().phase_margin
    arrow = Series(
        f"phase margin {margin:.1f}°", np.array([cross, cross]),
        np.array([-180.0, margin - 180.0]), "joined", PALETTE[1],
    )  # fmt: skip
    level = Series("−180°", HZ, np.full_like(HZ, -180.0), "line", MUTED, legend=False)
    reach = (float(HZ[0]), float(HZ[-1]))
    panels = (
        Panel("", "|L| [dB]", [Series("", HZ, _decibel(response), color=PALETTE[0])], reach,
              (cross,), logarithmic="x"),
        Panel(FREQUENCY, "phase of L [°]",
              [Series("L", HZ, phase, color=PALETTE[0], legend=False), level, arrow], reach,
              (cross,), logarithmic="x"),
    )  # fmt: skip
    caption = f"Dotted: crossover at {cross:.2f} Hz. The phase does not reach −180°."
    yield Figure("open_loop", "Open loop C P", caption, panels, stacked=True)


def sensitivities(_lab: Lab) -> Iterator[Figure]:
    """Figure 5.7."""
    reach = (float(HZ[0]), float(HZ[-1]))
    size, turned = [], []
    for name, system in zip("SH", _closed(), strict=True):
        response = system(_s())
        phase = np.degrees(np.unwrap(np.angle(response)))
        size.append(Series(name, HZ, _decibel(response)))
        turned.append(Series(name, HZ, phase))
    marks = (numbers().dip_at, numbers().peak_at, numbers().bandwidth)
    panels = (
        Panel("", "magnitude [dB]", size, reach, marks, logarithmic="x"),
        Panel(FREQUENCY, "phase [°]", turned, reach, marks, logarithmic="x"),
    )
    caption = "Dotted: dip of S, peak of H, bandwidth of H."
    yield Figure("sensitivities", "S and H", caption, panels, stacked=True)


def poles(_lab: Lab) -> Iterator[Figure]:
    """Figure 5.8."""
    s, h = _closed()
    marks = [("poles of S and H", h.poles(), "cross"), ("zeros of H", h.zeros(), "hollow"),
             ("zeros of S", s.zeros(), "square")]  # fmt: skip
    lines = [
        Series(label, np.real(found), np.imag(found), style, PALETTE[k])
        for k, (label, found, style) in enumerate(marks)
    ]
    near = [replace_range(lines, -0.3, 0.1)]
    panels = (Panel("real part [rad/s]", "imaginary part [rad/s]", lines), *near)
    caption = "Right: close to the imaginary axis, where a pole and a zero of H nearly cancel."
    yield Figure("poles", "Poles and zeros of S and H", caption, panels)


def replace_range(lines: list[Series], low: float, high: float) -> Panel:
    """The same points, those between two real parts."""
    return Panel("real part [rad/s]", "", lines, (low, high))


def stable(_lab: Lab) -> str:
    """Whether all poles of H lie in the left half plane."""
    return "stable" if np.all(_closed()[1].poles().real < 0.0) else "unstable"


def cancelled(_lab: Lab) -> str:
    """Whether the nearest pole and zero of H are closer than a picture of the map shows: a
    hundredth of its width."""
    h = _closed()[1]
    poles, zeros = h.poles(), h.zeros()
    apart = np.min(np.abs(poles[:, None] - zeros[None, :]))
    return "nearly cancel" if apart < 0.01 * np.ptp(np.real(poles)) else "apart"
