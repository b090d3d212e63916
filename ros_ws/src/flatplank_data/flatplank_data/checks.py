# SPDX-License-Identifier: Apache-2.0
"""Checks of a table when it is read: each is a function from a table to remarks."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from flatplank_data.lost import lost_samples
from flatplank_data.problem import Problem
from flatplank_data.spikes import bad_samples
from flatplank_data.stamps import order_of
from flatplank_data.stops import LOCKED
from flatplank_data.table import STANDARD_COLUMNS, MeasurementTable
from flatplank_data.unit_checks import wrong_units

#: kind of measurement -> columns that it cannot do without
REQUIRED: dict[str, tuple[str, ...]] = {
    "slip": ("time", "plank_position", "fx"),
    "free_rolling": ("time", "plank_position", "fx"),
    "cleat": ("time", "plank_position", "fx"),
    "stiffness": ("fz", "loaded_radius"),
    "stiffness_vertical": ("fz", "loaded_radius"),
    "stiffness_longitudinal": ("plank_position", "wheel_angle", "fx", "fz"),
    "stiffness_lateral": ("plank_position", "fx", "fy", "fz"),
    "locked_wheel": ("plank_position", "fx", "fz"),
    "unloaded_turn": ("motor_velocity", "motor_torque"),
    "footprint": ("fz", "half_length"),
}
ROLLING = ("slip", "free_rolling", "cleat")
FITTED = ("slip", "cleat")
"""kinds whose samples along the road are fitted, not only their mean"""
UNSTATED_STEP = 0.01
"""largest relative change of wheel speed over road speed in a run without a step [-]"""
BACKWARD_LIMIT = 2e-3
"""backward travel of the plank above this is an error [m]"""

Remark = tuple[str, str, str, bool]
"""(what is wrong; row, column or key; remedy; true when the run cannot be used)"""


def run_checks(table: MeasurementTable) -> tuple[MeasurementTable, list[Problem]]:
    """The table without bad samples, and all remarks; stops at the first fatal one, which would
    cause the rest."""
    found = _remarks(table, RECORD_CHECKS)
    if not any(problem.fatal for problem in found):
        table, bad = without_bad_samples(table)
        found += bad
    if not any(problem.fatal for problem in found):
        found += _remarks(table, CHECKS)
    return table, found


def _remarks(
    table: MeasurementTable, checks: Sequence[Callable[[MeasurementTable], Iterator[Remark]]]
) -> list[Problem]:
    found: list[Problem] = []
    for check in checks:
        found += [Problem(table.info.file, *remark) for remark in check(table)]
        if any(problem.fatal for problem in found):
            break
    return found


def without_bad_samples(table: MeasurementTable) -> tuple[MeasurementTable, list[Problem]]:
    """The table without the rows of spikes and stuck stretches, and a remark per column.

    A run to be fitted is refused when too much is missing then, as when samples were lost.
    """
    bad = list(bad_samples(table))
    if not bad:
        return table, []
    keep = np.ones(len(table), dtype=bool)
    for found in bad:
        keep[found.rows] = False
    left = table.rows(keep)
    refused = table.info.measurement in FITTED and not lost_samples(left).allows_fit
    what = "too much to leave out" if refused else "left out"
    remedy = "check the cable of this channel"
    return left, [
        Problem(table.info.file, f"{b.words}: {what}", f"column '{b.column}'", remedy, refused)
        for b in bad
    ]


def columns_present(table: MeasurementTable) -> Iterator[Remark]:
    """Check that the columns which this kind of measurement needs exist."""
    for name in REQUIRED.get(table.info.measurement, ()):
        if name not in table:
            what = f"no column '{name}' (has {', '.join(table.columns) or 'none'})"
            yield what, "", f"add '{name}', or map a foreign name to it", True
    if len(table) == 0:
        yield "no samples", "", "record or export it again", True


def slip_channels(table: MeasurementTable) -> Iterator[Remark]:
    """Warn of a slip step without these columns: it is kept, but no model is fitted to it."""
    for name in ("wheel_angle", "fz") if table.info.measurement == "slip" else ():
        if name not in table and len(table.columns) > len(REQUIRED["slip"]):
            remedy = f"add '{name}', or map a foreign name to it"
            yield f"no column '{name}': no fit", "", remedy, False


def not_a_number(table: MeasurementTable) -> Iterator[Remark]:
    """Check for NaN where a value is needed; a column that is all NaN was not measured."""
    needed = REQUIRED.get(table.info.measurement, ())
    for name, values in table.columns.items():
        if name not in STANDARD_COLUMNS and name not in needed:
            continue
        bad = ~np.isfinite(values)
        if not bad.any() or (bad.all() and name not in needed):
            continue
        place = f"row {int(np.argmax(bad)) + 1}, column '{name}'"
        what = f"{int(bad.sum())} of {bad.size} values are not numbers"
        yield what, place, "repair or leave out the run", name in needed


def time_increases(table: MeasurementTable) -> Iterator[Remark]:
    """Check that no stamp is repeated and none is earlier than the one before it."""
    if "time" not in table or not table.has("time"):
        return
    stamps = table["time"]
    stands = np.diff(stamps) == 0.0
    order = order_of(stamps)
    if stands.size and stands.all():
        what = f"all stamps are {stamps[0]:g} s"
        yield what, "column 'time'", "record or export the stamps again", True
    elif order.back:
        back, now = stamps[order.back - 2], stamps[order.back - 1]
        what = f"time does not increase: {now:g} s after {back:g} s"
        remedy = "give each recording of the file its own file, or sort the rows"
        yield what, f"row {order.back}", remedy, True
    elif stands.any():
        what = f"time does not increase: {int(stands.sum())} stamps are repeated"
        remedy = "remove the repeated rows, or write the stamps with more digits"
        yield what, f"row {int(np.argmax(stands)) + 2}", remedy, True


def units_agree(table: MeasurementTable) -> Iterator[Remark]:
    """Check that no column is in another unit than it says; see `unit_checks`."""
    found = wrong_units(table)
    if found:
        ways = " or ".join(f"'{w.column}' is in {w.unit}, not in {w.expected}" for w in found)
        remedy = f"write the unit, as '{found[0].column} [{found[0].unit}]'"
        if any(w.column in ("fz", "pressure") for w in found):
            remedy += f", or correct '{found[0].column}' of the run record"
        yield f"{found[0].text}: {ways}", f"column '{found[0].column}'", remedy, True


def angle_continues(table: MeasurementTable) -> Iterator[Remark]:
    """Check that the wheel turns by less than half a turn between two samples."""
    step = np.diff(table.get("wheel_angle"))
    if (np.abs(step) > np.pi).any():
        row = int(np.argmax(np.abs(step) > np.pi)) + 2
        what = f"jumps by {step[row - 2]:.4g} rad, more than half a turn"
        yield what, f"row {row}, column 'wheel_angle'", "repair the samples", True


def samples_lost(table: MeasurementTable) -> Iterator[Remark]:
    """Report lost samples; a run for fits that has lost many is refused."""
    found = lost_samples(table)
    if not found.lost:
        return
    if found.allows_fit or table.info.measurement not in FITTED:
        yield str(found), "column 'time'", "see why the recorder did not keep up", False
    else:
        remedy = "measure it again: no model is fitted across them"
        yield str(found), "column 'time'", remedy, True


def position_increases(table: MeasurementTable) -> Iterator[Remark]:
    """Check that the plank travels in one direction."""
    if table.info.measurement not in ROLLING:
        return
    travel = table["plank_position"] * (1.0 if table.info.direction >= 0 else -1.0)
    fall = np.maximum.accumulate(travel) - travel
    if (fall > BACKWARD_LIMIT).any():
        what = f"plank position goes back by {1e3 * fall.max():.1f} mm"
        place = f"row {int(np.argmax(fall > BACKWARD_LIMIT)) + 1}, column 'plank_position'"
        remedy = "cut the return stroke off, or set 'direction: -1' for a reversed run"
        yield what, place, remedy, True


def plank_moves(table: MeasurementTable) -> Iterator[Remark]:
    if table.info.measurement not in ROLLING:
        return
    travel = float(np.ptp(table["plank_position"]))
    if travel < 0.01:
        what = f"zero speed: the plank travels {1e3 * travel:.1f} mm"
        remedy = "check the plank encoder; repeat the run"
        yield what, "column 'plank_position'", remedy, True


def reaches_step(table: MeasurementTable) -> Iterator[Remark]:
    """Check that a slip run continues after its step."""
    info = table.info
    if info.measurement != "slip" or not np.isfinite(info.step_position):
        return
    last, step = float(np.max(table["plank_position"])), info.step_position
    if last < step + 0.05:
        what = f"the run ends at {last:.3f} m, before the step at {step:g} m has acted"
        yield what, f"row {len(table)}", "repeat the run, or correct 'step_position'", True


def units_of_record(table: MeasurementTable) -> Iterator[Remark]:
    """Check that the values of the run record fit its units."""
    kappa, pressure = table.info.kappa, table.info.pressure
    radius = table.info.effective_rolling_radius
    if abs(kappa) > 0.95:
        yield f"kappa {kappa:g} is no slip", "key 'kappa'", "0.05 means 5 %", True
    if pressure > 20.0:
        yield f"pressure {pressure:g} bar", "key 'pressure'", "write it in bar", True
    if radius > 2.0:
        what = f"effective rolling radius {radius:g} m"
        yield what, "key 'effective_rolling_radius'", "write it in m", True


def load_positive(table: MeasurementTable) -> Iterator[Remark]:
    """Check the sign of Fz: in ISO W the road pushes up, fz > 0."""
    if table.info.measurement not in ROLLING or not table.has("fz"):
        return
    mean, nominal = float(np.nanmean(table["fz"])), table.info.fz
    if mean <= 0.0:
        remedy = "ISO W has fz > 0 on a loaded tire: turn the sign, or the tire was not loaded"
        yield f"mean vertical force {mean:.0f} N", "column 'fz'", remedy, True
    elif np.isfinite(nominal) and abs(mean - nominal) > 0.25 * nominal:
        what = f"mean vertical force {mean:.0f} N, nominal {nominal:.0f} N"
        yield what, "column 'fz'", "check 'fz' of the run record and the unit", False


def slip_sign(table: MeasurementTable) -> Iterator[Remark]:
    """Check the wheel speed against the slip: omega r_e / (V cos alpha) - 1 is near kappa."""
    info = table.info
    if not (table.has("wheel_velocity") and table.has("plank_velocity")):
        return
    if info.is_step and not np.isfinite(info.step_position):
        yield from _unstated_step(table)
        return
    if not info.is_step:
        return
    after = table["plank_position"] > info.step_position + 0.1
    if after.sum() < 3:
        return
    speed = float(np.nanmean(table["plank_velocity"][after])) * np.cos(np.radians(info.alpha_deg))
    omega = float(np.nanmean(table["wheel_velocity"][after]))
    radius = info.effective_rolling_radius
    if np.isfinite(radius) and abs(omega) * radius < LOCKED * abs(speed):
        what = "the wheel stood while the plank moved: it was stopped, or never driven"
        remedy = "see why the drive stopped (stop_text of /wheel_drive/status), make the run again"
        yield what, "column 'wheel_velocity'", remedy, True
    elif speed * omega < 0.0:
        remedy = "forward rolling has both positive: turn the sign of one"
        yield "wheel and plank turn against each other", "column 'wheel_velocity'", remedy, True
    elif np.isfinite(radius) and speed != 0.0:
        kappa = omega * radius / speed - 1.0
        if abs(info.kappa) >= 0.005 and kappa * info.kappa < 0 and abs(kappa) > 0.002:
            what = f"kappa is {info.kappa:+g} but the wheel ran at {kappa:+.4f}"
            yield what, "key 'kappa'", "driving is positive (ISO): turn the sign", True
        elif abs(kappa - info.kappa) > 0.01 + 0.25 * abs(info.kappa):
            what = f"desired slip {info.kappa:+g}, measured {kappa:+.4f}"
            fatal = abs(kappa - info.kappa) > 0.02 + 0.5 * abs(info.kappa)
            remedy = "check 'effective_rolling_radius' and the step"
            yield what, "key 'kappa'", remedy, bool(fatal)


def _unstated_step(table: MeasurementTable) -> Iterator[Remark]:
    """Report a run without a recorded step whose slip changes: compares wheel speed over road
    speed early (15 to 30 %) and late (80 to 95 %) in the travel."""
    x = table["plank_position"]
    begin, length = float(x.min()), float(np.ptp(x))
    parts = [
        (x > begin + a * length) & (x < begin + b * length) for a, b in ((0.15, 0.3), (0.8, 0.95))
    ]
    if min(part.sum() for part in parts) < 3:
        return
    turned = [
        float(np.nanmean(table["wheel_velocity"][p]) / np.nanmean(table["plank_velocity"][p]))
        for p in parts
    ]
    change = turned[1] / turned[0] - 1.0 if turned[0] else np.nan
    if abs(change) > UNSTATED_STEP:
        what = f"no step is stated, but the slip changes by {100.0 * change:+.1f} %"
        remedy = "write 'kappa', 'step_position' and 'effective_rolling_radius'"
        yield what, "key 'step_position'", remedy, True


RECORD_CHECKS = (columns_present, slip_channels, not_a_number, time_increases, samples_lost)
"""checks of the record itself"""
CHECKS = (
    units_agree, angle_continues, position_increases, plank_moves, reaches_step, units_of_record,
    load_positive, slip_sign,
)  # fmt: skip
"""checks of what was measured, without bad samples"""
