# SPDX-License-Identifier: Apache-2.0
"""Figure 4.1 and Appendix C: the parasitic signal of the preloaded shaft, before and after its
filter."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np

from flatplank_analysis.figures import pieces
from flatplank_analysis.figures.spec import PALETTE, Figure, Panel, Series
from flatplank_data.table import MeasurementTable
from flatplank_hw.hub import HubParameters
from flatplank_hw.hub.appendix_a import gains, wheel_from_volts
from flatplank_hw.hub.parasitic import CHANNELS, INDEX, ParasiticFit
from flatplank_validation.thesis.lab import Lab
from flatplank_validation.thesis.registry import AtMost, Chapter, Entry, Near, Row, Same

TURN = "wheel angle θ [°]"
FITTED = (360.0, 720.0)
"""part of the three turns that is fitted [deg]"""
SLIPS = (0.0, 0.01, -0.01, -0.05)
"""panels (a) to (d) of figures C.5 and C.6 [-]"""
FORCES = {"fx": pieces.FX, "fz": pieces.FZ}
COLUMNS = ("plank_position", "wheel_angle", "fx", "fz")
ROLLING = (0.3, 4.0)
"""road on which two equal runs are compared [m]"""
SPACING = 0.005
"""grid of that road [m]"""


class Forces(NamedTuple):
    """Forces at the wheel [N], shape (n,)."""

    fx: np.ndarray
    fz: np.ndarray


def forces_of(channels: np.ndarray) -> Forces:
    """Fx and Fz [N] of channels C1, C2, C3, C5, C6 (5, n) [V] by (A.1)."""
    volts = np.zeros((6, channels.shape[1]))
    volts[list(INDEX)] = channels
    wrench = wheel_from_volts(tuple(volts), gains(HubParameters()))
    return Forces(np.asarray(wrench.fx), np.asarray(wrench.fz))


def signal_of(fit: ParasiticFit, angle: np.ndarray) -> np.ndarray:
    """The fitted signal (5, n) [V] at wheel angles (n,) [rad], without its constant part."""
    a, b, c = np.array([(s.amplitude_v, s.frequency, s.phase_rad) for s in fit.sines]).T[..., None]
    return a * np.sin(b * angle + c)


class Turns(NamedTuple):
    """The unloaded turns: angle since the start [deg], channels and fitted signal (5, n) [V]."""

    angle: np.ndarray
    channels: np.ndarray
    signal: np.ndarray

    def forces(self, filtered: bool) -> Forces:
        """Forces without their mean."""
        found = forces_of(self.channels - self.signal if filtered else self.channels)
        return Forces(*(f - f.mean() for f in found))


def turns(lab: Lab) -> Turns:
    samples, fit = lab.turn.samples, lab.turn.fit
    angle = np.degrees(samples.angle - samples.angle[0])
    return Turns(angle, samples.volts[:, INDEX].T, signal_of(fit, samples.angle))


def free_turn(lab: Lab) -> Iterator[Figure]:
    """Figure C.1: parasitic forces of the freely turning wheel."""
    t = turns(lab)
    found = t.forces(filtered=False)
    lines = [Series(n, t.angle, v) for n, v in (("Fx", found.fx), ("Fz", found.fz))]
    panel = Panel(TURN, "force less its mean [N]", lines, (0.0, 1080.0))
    caption = "Three turns of the unloaded wheel at constant speed."
    yield Figure("parasitic_forces", "Parasitic forces", caption, (panel,))


def channels(lab: Lab) -> Iterator[Figure]:
    """Figure C.2: the five bridge signals."""
    t = turns(lab)
    lines = [
        Series(name, t.angle, 1e3 * (volts - volts.mean()))
        for name, volts in zip(CHANNELS, t.channels, strict=True)
    ]
    panel = Panel(TURN, "bridge output less its mean [mV]", lines, (0.0, 1080.0), marks=FITTED)
    caption = "The same turns. The turn between the dotted lines is fitted."
    yield Figure("parasitic_channels", "Parasitic bridge outputs", caption, (panel,))


def fitted(lab: Lab) -> Iterator[Figure]:
    """Figure C.3: the fitted turn, channel by channel."""
    t = turns(lab)
    panels = []
    for k, name in enumerate(CHANNELS):
        mean = t.channels[k].mean()
        last = k == len(CHANNELS) - 1
        measured, sine = 1e3 * (t.channels[k] - mean), 1e3 * t.signal[k]
        label = TURN if last else ""
        panels.append(pieces.pair(label, f"{name} [mV]", t.angle, measured, sine, "fit", FITTED))
    caption = "Bridge output less its mean, A sin(B x + C) of (C.1), and what the fit leaves."
    yield Figure("parasitic_fit", "Fit of every channel", caption, panels, stacked=True)


def before_and_after(lab: Lab) -> Iterator[Figure]:
    """Figures 4.1 and C.4: forces without and with the filter."""
    t = turns(lab)
    plain, filtered = t.forces(filtered=False), t.forces(filtered=True)
    panels = [
        Panel(
            TURN if name == "fz" else "",
            f"{name.capitalize()} less its mean [N]",
            [
                Series("without the filter", t.angle, getattr(plain, name), color=PALETTE[1]),
                Series("with the filter", t.angle, getattr(filtered, name), color=PALETTE[0]),
            ],
            (0.0, 1080.0),
        )
        for name in FORCES
    ]
    caption = "The unloaded wheel; the fit uses the second turn only."
    yield Figure("parasitic_filter", "Without and with the filter", caption, panels, stacked=True)


class Pair(NamedTuple):
    """Two equal runs, one without the filter, on one grid of the road."""

    position: np.ndarray
    angle: np.ndarray
    """of the run without the filter [rad]"""
    difference: Forces
    """unfiltered less filtered [N]"""
    calculated: Forces
    """from the fit and the wheel angle [N]"""

    def compared(self, name: str) -> tuple[complex, complex]:
        """Once-per-turn part of both [N], as complex amplitudes over the wheel angle."""
        x = self.angle
        basis = np.column_stack([np.ones_like(x), x - x.mean(), np.cos(x), np.sin(x)])
        values = np.column_stack([getattr(self.difference, name), getattr(self.calculated, name)])
        part = np.linalg.lstsq(basis, values, rcond=None)[0]
        one, other = part[2] - 1j * part[3]
        return complex(one), complex(other)


def pairs(lab: Lab) -> dict[float, Pair]:
    """The pairs by slip."""
    if "pairs" not in lab.kept:
        plain, filtered = (
            {t.info.kappa: t for t in lab.tables(name, COLUMNS)}
            for name in ("unfiltered", "filtered")
        )
        lab.kept["pairs"] = {k: _pair(plain[k], filtered[k], lab.turn.fit) for k in SLIPS}
    return lab.kept["pairs"]


def _pair(plain: MeasurementTable, filtered: MeasurementTable, fit: ParasiticFit) -> Pair:
    x = np.arange(*ROLLING, SPACING)

    def on(table: MeasurementTable, name: str) -> np.ndarray:
        return np.interp(x, table["plank_position"], table[name])

    angle = on(plain, "wheel_angle")
    made = forces_of(signal_of(fit, angle))
    return Pair(
        x, angle, Forces(*(on(plain, n) - on(filtered, n) for n in FORCES)), made
    )  # fmt: skip


def under_load(name: str, lab: Lab) -> Iterator[Figure]:
    """Figures C.5 (fx) and C.6 (fz): measured and calculated parasitic force at four slips."""
    found = pairs(lab)
    panels = []
    for letter, kappa in zip("abcd", SLIPS, strict=True):
        pair = found[kappa]
        label = pieces.ROAD if kappa == SLIPS[-1] else ""
        panel = pieces.pair(
            label, f"{name.capitalize()} [N]", pair.position, getattr(pair.difference, name),
            getattr(pair.calculated, name), "calculated", ROLLING,
        )  # fmt: skip
        panels.append(replace(panel, title=f"({letter}) κ = {pieces.percent(kappa)}"))
    word = "longitudinal" if name == "fx" else "vertical"
    caption = (
        "Measured: two equal runs, the one without the filter less the other. Calculated: by the "
        "fit from the wheel angle. Below: their difference."
    )
    yield Figure(
        f"parasitic_{name}", f"Parasitic {word} force under load", caption, panels, stacked=True
    )


def amplitude(name: str, after: bool, lab: Lab) -> float:
    """Once-per-turn amplitude of the third turn, which the fit does not use [N]."""
    return lab.turn.left[name][int(after)]


def remaining(name: str, kappa: float, lab: Lab) -> float:
    """Amplitude of what differs between measured and calculated force [N]."""
    one, other = pairs(lab)[kappa].compared(name)
    return abs(one - other)


def phase(name: str, kappa: float, lab: Lab) -> float:
    """Phase between measured and calculated force [deg]."""
    one, other = pairs(lab)[kappa].compared(name)
    return float(np.degrees(np.angle(one / other)))


ABOUT = Near(50.0, "‘approximately 300 N’ is rounded to 100 N")
LEFT = "the plant's shaft gives a pure sine, so that less is left than on the machine"
WHY_LOAD = (
    "the two runs are two runs: what differs between them from run to run is in the difference"
)
TURNING = np.degrees(np.arctan(25.0 / 300.0))
NEAR_PHASE = Near(float(TURNING), "25 N of 300 N left by the filter turn the phase by so much")


def _amplitudes() -> Iterator[Row]:
    place = "Appendix C, text to figure C.4"
    for name in FORCES:
        word = name.capitalize()
        yield Row(f"{word} amplitude without the filter", "N", 300.0, place,
                  partial(amplitude, name, False), ABOUT,
                  "the plant's preload is 250 N at the hub")  # fmt: skip
        yield Row(f"{word} amplitude with the filter", "N", 25.0, place,
                  partial(amplitude, name, True), AtMost("‘approximately 25 N’ is left"),
                  LEFT)  # fmt: skip


def _under_load(name: str) -> Iterator[Row]:
    figure = "C.5" if name == "fx" else "C.6"
    for kappa in SLIPS:
        at = f"κ = {pieces.percent(kappa)}"
        yield Row(f"{at}: measured less calculated, amplitude", "N", 25.0,
                  f"figure {figure}: ‘approximately equal’", partial(remaining, name, kappa),
                  AtMost("what the filter leaves, ‘approximately 25 N’"), WHY_LOAD)  # fmt: skip
        yield Row(f"{at}: measured to calculated, phase", "°", 0.0,
                  f"figure {figure}: ‘approximately equal’", partial(phase, name, kappa),
                  NEAR_PHASE, WHY_LOAD)  # fmt: skip


def periods(lab: Lab) -> str:
    """Whether every channel has one period per turn."""
    once = all(abs(s.frequency - 1.0) < 0.05 for s in lab.turn.fit.sines)
    return "one per turn" if once else "not one per turn"


CHAPTER = Chapter(
    "C",
    "Appendix C: parasitic signal filtering",
    (
        Entry("C.1", "Parasitic forces of the turning wheel", free_turn, (
            Row("periods of the signals", "", "one per turn", "Appendix C", periods, Same()),
        )),
        Entry("C.2", "Bridge outputs of the turning wheel", channels,
              note="Its numbers are those of figures C.1 and C.4."),
        Entry("C.3", "The fitted turn", fitted, note="Its numbers are those of figure C.4."),
        Entry("C.4", "Without and with the filter", before_and_after, tuple(_amplitudes())),
        Entry("C.5", "Longitudinal force under load", partial(under_load, "fx"),
              tuple(_under_load("fx"))),
        Entry("C.6", "Vertical force under load", partial(under_load, "fz"),
              tuple(_under_load("fz"))),
    ),
)  # fmt: skip
