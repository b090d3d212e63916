# SPDX-License-Identifier: Apache-2.0
"""Checks on import: each is one function from a table to remarks; the registry runs them all."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator

import numpy as np

from flatplank_data.lost import lost_samples
from flatplank_data.problem import Problem
from flatplank_data.table import STANDARD_COLUMNS, MeasurementTable

#: columns without which a measurement of a kind is of no use
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
"""what happens along the road is fitted, not only its mean"""
UNSAID_STEP = 0.01
"""a freely rolling wheel keeps its speed over the road so well over a run [-]"""
LOCKED = 0.05
"""a wheel whose rim is slower than this share of the road stands"""
BACKWARD_LIMIT = 2e-3
"""the plank may fall back by this much before it counts as an error [m]"""

Check = Callable[[MeasurementTable], Iterable[Problem]]
CHECKS: list[Check] = []


def check(function: Check) -> Check:
    """Register a check."""
    CHECKS.append(function)
    return function


def run_checks(table: MeasurementTable) -> list[Problem]:
    """All remarks on a table; stops at the first fatal one, the rest would follow from it."""
    found: list[Problem] = []
    for function in CHECKS:
        found.extend(function(table))
        if any(problem.fatal for problem in found):
            break
    return found


@check
def columns_present(table: MeasurementTable) -> Iterator[Problem]:
    """The columns that this kind of measurement needs are there."""
    for name in REQUIRED.get(table.info.measurement, ()):
        if name not in table:
            have = ", ".join(table.columns) or "none"
            yield Problem(
                table.info.file,
                f"no column '{name}' (has {have})",
                remedy=f"add '{name}', or map a foreign name to it",
            )
    if len(table) == 0:
        yield Problem(table.info.file, "no samples", remedy="record or export it again")


@check
def slip_channels(table: MeasurementTable) -> Iterator[Problem]:
    """A slip step without these is kept for what it can tell, but no model is fitted to it."""
    for name in ("wheel_angle", "fz") if table.info.measurement == "slip" else ():
        if name not in table and len(table.columns) > len(REQUIRED["slip"]):
            remedy = f"add '{name}', or map a foreign name to it"
            yield Problem(table.info.file, f"no column '{name}': no fit", "", remedy, fatal=False)


@check
def not_a_number(table: MeasurementTable) -> Iterator[Problem]:
    """No NaN where a value is needed; a column that is NaN throughout was not measured."""
    needed = REQUIRED.get(table.info.measurement, ())
    for name, values in table.columns.items():
        if name not in STANDARD_COLUMNS and name not in needed:
            continue
        bad = ~np.isfinite(values)
        if not bad.any() or (bad.all() and name not in needed):
            continue
        place = f"row {int(np.argmax(bad)) + 1}, column '{name}'"
        what = f"{int(bad.sum())} of {bad.size} values are not numbers"
        yield Problem(table.info.file, what, place, "repair or leave out the run", name in needed)


@check
def time_increases(table: MeasurementTable) -> Iterator[Problem]:
    """Time strictly increases."""
    if "time" not in table or not table.has("time"):
        return
    step = np.diff(table["time"])
    if (step <= 0.0).any():
        row = int(np.argmax(step <= 0.0)) + 2
        yield Problem(
            table.info.file, "time does not increase", f"row {row}", "sort or mend the samples"
        )


@check
def samples_lost(table: MeasurementTable) -> Iterator[Problem]:
    """A run that lacks samples is told; one that lacks many and would be fitted is refused."""
    found = lost_samples(table)
    if not found.lost:
        return
    if found.harmless or table.info.measurement not in FITTED:
        remedy = "see why the recorder did not keep up"
        yield Problem(table.info.file, str(found), "column 'time'", remedy, fatal=False)
    else:
        remedy = "measure it again: no model is fitted across them"
        yield Problem(table.info.file, str(found), "column 'time'", remedy)


@check
def position_increases(table: MeasurementTable) -> Iterator[Problem]:
    """The plank goes one way."""
    if table.info.measurement not in ROLLING:
        return
    travel = table["plank_position"] * (1.0 if table.info.direction >= 0 else -1.0)
    fall = np.maximum.accumulate(travel) - travel
    if (fall > BACKWARD_LIMIT).any():
        row = int(np.argmax(fall > BACKWARD_LIMIT)) + 1
        yield Problem(
            table.info.file,
            f"plank position goes back by {1e3 * fall.max():.1f} mm",
            f"row {row}, column 'plank_position'",
            "cut the return stroke off, or set 'direction: -1' for a reversed run",
        )


@check
def plank_moves(table: MeasurementTable) -> Iterator[Problem]:
    """The plank has a speed."""
    if table.info.measurement not in ROLLING:
        return
    travel = float(np.ptp(table["plank_position"]))
    if travel < 0.01:
        yield Problem(
            table.info.file,
            f"zero speed: the plank travels {1e3 * travel:.1f} mm",
            "column 'plank_position'",
            "check the plank encoder; repeat the run",
        )


@check
def reaches_step(table: MeasurementTable) -> Iterator[Problem]:
    """A slip run goes on after its step."""
    info = table.info
    if info.measurement != "slip" or not np.isfinite(info.step_position):
        return
    last = float(np.max(table["plank_position"]))
    if last < info.step_position + 0.05:
        yield Problem(
            info.file,
            f"the run ends at {last:.3f} m, before the step at {info.step_position:g} m has acted",
            f"row {len(table)}",
            "repeat the run, or correct 'step_position'",
        )


@check
def units_of_record(table: MeasurementTable) -> Iterator[Problem]:
    """The run record is in the units that it says."""
    info = table.info
    if abs(info.kappa) > 0.95:
        yield Problem(
            info.file, f"kappa {info.kappa:g} is no slip", "key 'kappa'", "0.05 means 5 %"
        )
    if info.pressure > 20.0:
        yield Problem(
            info.file, f"pressure {info.pressure:g} bar", "key 'pressure'", "write it in bar"
        )
    if info.effective_rolling_radius > 2.0:
        remedy = "write it in m"
        yield Problem(
            info.file,
            f"effective rolling radius {info.effective_rolling_radius:g} m",
            "key 'effective_rolling_radius'",
            remedy,
        )


@check
def load_positive(table: MeasurementTable) -> Iterator[Problem]:
    """ISO W: the road pushes up, fz > 0."""
    if table.info.measurement not in ROLLING or not table.has("fz"):
        return
    mean = float(np.nanmean(table["fz"]))
    if mean <= 0.0:
        yield Problem(
            table.info.file,
            f"mean vertical force {mean:.0f} N",
            "column 'fz'",
            "ISO W has fz > 0 on a loaded tire: turn the sign, or the tire was not loaded",
        )
    elif np.isfinite(table.info.fz) and abs(mean - table.info.fz) > 0.25 * table.info.fz:
        yield Problem(
            table.info.file,
            f"mean vertical force {mean:.0f} N, nominal {table.info.fz:.0f} N",
            "column 'fz'",
            "check 'fz' of the run record and the unit",
            fatal=False,
        )


@check
def slip_sign(table: MeasurementTable) -> Iterator[Problem]:
    """The wheel turns as the desired slip says: omega r_e / (V cos alpha) - 1 is near kappa."""
    info = table.info
    if not (table.has("wheel_velocity") and table.has("plank_velocity")):
        return
    if info.is_step and not np.isfinite(info.step_position):
        yield from _unsaid_step(table)
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
        yield Problem(
            info.file,
            "the wheel stood while the plank moved: it was stopped, or never driven",
            "column 'wheel_velocity'",
            "see why the drive stopped (stop_text of /wheel_drive/status), make the run again",
        )
    elif speed * omega < 0.0:
        yield Problem(
            info.file,
            "wheel and plank turn against each other",
            "column 'wheel_velocity'",
            "forward rolling has both positive: turn the sign of one",
        )
    elif np.isfinite(radius) and speed != 0.0:
        kappa = omega * radius / speed - 1.0
        if abs(info.kappa) >= 0.005 and kappa * info.kappa < 0 and abs(kappa) > 0.002:
            yield Problem(
                info.file,
                f"kappa is {info.kappa:+g} but the wheel ran at {kappa:+.4f}",
                "key 'kappa'",
                "driving is positive (ISO): turn the sign",
            )
        elif abs(kappa - info.kappa) > 0.01 + 0.25 * abs(info.kappa):
            yield Problem(
                info.file,
                f"desired slip {info.kappa:+g}, measured {kappa:+.4f}",
                "key 'kappa'",
                "check 'effective_rolling_radius' and the step",
                fatal=abs(kappa - info.kappa) > 0.02 + 0.5 * abs(info.kappa),
            )


def _unsaid_step(table: MeasurementTable) -> Iterator[Problem]:
    """A run said to have no step whose wheel gets faster or slower: the wheel over the road in
    the middle of its first and of its last third."""
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
    if abs(change) > UNSAID_STEP:
        yield Problem(
            table.info.file,
            f"no step is said, but the slip changes by {100.0 * change:+.1f} %",
            "key 'step_position'",
            "write 'kappa', 'step_position' and 'effective_rolling_radius'",
        )
