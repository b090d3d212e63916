# SPDX-License-Identifier: Apache-2.0
"""Figures of chapter 5 that need a simulation or a run of the free-rolling controller."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial

import numpy as np

from flatplank_analysis.figures import machine, pieces
from flatplank_analysis.figures.spec import INK, PALETTE, Figure, Panel, Series
from flatplank_analysis.steady.settling import FIT_RANGE, fit_exponential
from flatplank_control.free_rolling.params import FreeRollingParameters
from flatplank_data.table import MeasurementTable
from flatplank_validation.free_rolling.nonlinear import Nonlinear, Run
from flatplank_validation.thesis import rolling
from flatplank_validation.thesis.lab import Lab

ROAD_END = 4.2
ZOOM = 0.03
"""road of the enlarged parts of figures 5.14 to 5.17 [m]"""
LATE = (1.0, 1.4)
"""road of the enlarged part of figure 5.18 [m]"""
GAP = Nonlinear().gap
TIRES = ("michelin", "toyo", "continental")
"""Table 5.2, in the order of the free radius"""
LOADS = (1000.0, 1850.0, 3700.0, 5550.0, 8000.0)


def campaign_of(tire: str, way: str) -> str:
    """Campaign with the nominal free-rolling runs of a tire."""
    return f"{'loads' if tire == 'toyo' else tire}_{way}"


def nominal_runs(tire: str, way: str, lab: Lab) -> list[MeasurementTable]:
    """The three runs of a tire at its nominal point."""
    found = rolling.runs(lab, campaign_of(tire, way))
    return [t for t in found if tire != "toyo" or t.info.fz == rolling.NOMINAL]


def whole_and_zoom(
    name: str, title: str, caption: str, axis: str, lines: Sequence[Series],
    zoom: tuple[float, float] = (0.0, ZOOM), first: float = 0.0, left: Sequence[Series] = (),
) -> Figure:  # fmt: skip
    """The whole road from `first` on, and a part of it enlarged beside; `left`: residuals."""
    panels = [
        Panel(pieces.ROAD, axis, lines, (first, ROAD_END)),
        Panel(pieces.ROAD, axis, lines, zoom, title="enlarged"),
    ]
    if left:
        panels = [pieces.with_residual(panel, left) for panel in panels]
    return Figure(name, title, caption, panels)


def simulated_force(_lab: Lab) -> Iterator[Figure]:
    """Figure 5.14."""
    run = rolling.simulated()
    engaged = _engaged(run)
    lines = [
        Series("simulated", run.position, run.force, color=PALETTE[0]),
        Series("gears engage", run.position[engaged], run.force[engaged], "hollow", INK),
    ]
    settles = rolling.simulated_settling(run)
    caption = f"Simulation of (5.15) to (5.21); within 5 % of 50 N from {settles:.2f} m on."
    yield whole_and_zoom("simulated_force", "Simulated force", caption, pieces.FX, lines)


def _engaged(run: Run) -> np.ndarray:
    first = np.flatnonzero(run.gear_angle >= GAP)
    return first[:1]


def simulated_angle(_lab: Lab) -> Iterator[Figure]:
    """Figure 5.15."""
    run = rolling.simulated()
    line = Series("", run.position, np.degrees(run.gear_angle), color=PALETTE[0])
    caption = "Angle between motor and worm wheel, at the motor; the gap ends at 15°."
    yield whole_and_zoom("simulated_gap", "Simulated gear angle", caption, "θ_D [°]", [line])


def _torque(table: MeasurementTable) -> tuple[np.ndarray, np.ndarray]:
    return table["plank_position"], table["motor_torque"]


Read = tuple[str, str, Callable[[MeasurementTable], tuple], Callable[[Run], np.ndarray]]
FORCE: Read = ("force", pieces.FX, rolling.force, lambda run: run.force)
TORQUE: Read = ("torque", "motor torque M_M [N m]", _torque, lambda run: run.torque)


def beside_simulation(read: Read, better: bool, lab: Lab) -> Iterator[Figure]:
    """Figures 5.16 and 5.17; `better`: 5.18 and 5.19, with measured speed and scaled friction."""
    name, axis, measured, of_run = read
    run = rolling.improved(lab) if better else rolling.simulated()
    x, y = measured(rolling.nominal(lab))
    word = "improved simulation" if better else "simulated"
    lines = [
        Series("measured", x, y, color=PALETTE[1]),
        Series(word, run.position, of_run(run), "model", INK),
    ]
    left = pieces.residual(x, y, run.position, of_run(run), PALETTE[1])
    caption = "The thesis's controller, the Toyo at 3700 N, start angle 0°."
    if better:
        caption += (
            " The simulation has the measured road speed, and its friction is scaled to the "
            "measured torque."
        )
    title = f"{'Longitudinal force' if name == 'force' else 'Motor torque'}, measured and {word}"
    slug = f"rolling_{name}{'_improved' if better else ''}"
    zoom = LATE if better else (0.0, ZOOM)
    first = ZOOM if read is TORQUE else 0.0
    yield whole_and_zoom(slug, title, caption, axis, lines, zoom, first, [left])


def exponential(lab: Lab) -> Iterator[Figure]:
    """Figures 5.20 and E.1."""
    x, y = rolling.force(rolling.nominal(lab))
    fit = fit_exponential(x, y)
    fine = x[(x >= FIT_RANGE[0]) & (x <= FIT_RANGE[1])]
    mark = fit.settles_at()
    told = f"settles at {mark:.2f} m" if np.isfinite(mark) else "does not settle within 5 %"
    lines = [
        Series("measured", x, y, color=PALETTE[0]),
        Series("p₁ exp(−p₂ x) + p₃", fine, fit(fine), "model", INK),
    ]
    marks = [*FIT_RANGE, *([mark] if np.isfinite(mark) else [])]
    panels = (
        Panel(pieces.ROAD, pieces.FX, lines, (0.0, ROAD_END), marks),
        Panel(pieces.ROAD, pieces.FX, lines, (FIT_RANGE[0], ROAD_END), marks, title="enlarged"),
    )
    left = [pieces.residual(x, y, fine, fit(fine), PALETTE[0])]
    caption = f"Exponential function (E.1) between the outer dotted lines; {told}."
    shown = [pieces.with_residual(panel, left) for panel in panels]
    yield Figure("exponential", "Settling distance", caption, shown)


def over_load(axis: str, read: Callable[[MeasurementTable], float], name: str, lab: Lab):
    """Figures 5.21 and 5.22: three runs at each load, both controllers."""
    lines = []
    for k, (way, word) in enumerate(rolling.WAYS.items()):
        found = rolling.runs(lab, f"loads_{way}")
        x = np.array([t.info.fz for t in found]) + 60.0 * (2 * k - 1)
        lines.append(Series(word, x, np.array([read(t) for t in found]), "points"))
    caption = "One point per run, three start angles; the two controllers are drawn side by side."
    panel = Panel(pieces.FZ, axis, lines)
    yield Figure(
        f"{name}_over_load", f"{axis.split(' [')[0].capitalize()} over load", caption, (panel,)
    )


def over_tires(axis: str, read: Callable[[MeasurementTable], float], name: str, lab: Lab):
    """Figures 5.24 and 5.25: three runs of each tire, both controllers."""
    lines = []
    for k, (way, word) in enumerate(rolling.WAYS.items()):
        rows = [
            (1e3 * lab.free_radius(tire) + 0.6 * (2 * k - 1), read(t))
            for tire in TIRES
            for t in nominal_runs(tire, way, lab)
        ]
        x, y = np.array(rows).T
        lines.append(Series(word, x, y, "points"))
    radii = ", ".join(
        f"{tire.capitalize()} {1e3 * lab.free_radius(tire):.0f} mm" for tire in TIRES
    )
    panel = Panel("free radius r₀ [mm]", axis, lines)
    caption = f"One point per run at the nominal point of the tire: {radii}."
    title = f"{axis.split(' [')[0].capitalize()} of three tires"
    yield Figure(f"{name}_over_tires", title, caption, (panel,))


def slips(lab: Lab) -> Iterator[Figure]:
    """Figure 5.23."""
    lines = []
    for table in rolling.starts(lab):
        x, kappa = rolling.slip(table)
        lines.append(Series(f"{table.info.fz:g} N", x, 100.0 * kappa))
    panel = Panel(pieces.ROAD, pieces.SLIP, lines, (0.001, 0.1))
    caption = (
        "Slip with the r_e of the same run; the wheel stands at −100 % until its drive has "
        "started. The thesis's controller."
    )
    yield Figure("rolling_slip", "Slip at the start of free rolling", caption, (panel,))


def efficiency(lab: Lab) -> Iterator[Figure]:
    """Figure 5.4: the right panel of the wheel drive's figure."""
    for figure in machine.transmission(lab.drive):
        panels = [p for p in figure.panels if "efficiency" in p.y_label]
        yield Figure("efficiency", "Efficiency of the wheel drive", figure.caption, panels)


def motor_torque(lab: Lab) -> Iterator[Figure]:
    """Figure 5.13."""
    for figure in machine.transmission(lab.drive):
        panels = [p for p in figure.panels if "torque" in p.y_label]
        yield Figure("motor_torque", figure.title, "Mean over the last half metre.", panels)


def friction(lab: Lab) -> Iterator[Figure]:
    """Figures 5.3 and 5.11."""
    yield from machine.friction(lab.drive)


PARAMETERS = FreeRollingParameters()
steady_over_load = partial(over_load, "steady error [%]", rolling.steady_error, "error")
settling_over_load = partial(over_load, "settling distance [m]", rolling.settling, "settling")
steady_over_tires = partial(over_tires, "steady error [%]", rolling.steady_error, "error")
settling_over_tires = partial(over_tires, "settling distance [m]", rolling.settling, "settling")
