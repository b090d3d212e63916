# SPDX-License-Identifier: Apache-2.0
"""Names, units and axis systems of the channels of a test bench.

The axis system follows from the signs of two forces: the road pushes a loaded tire upwards, and a
tire that slips to one side towards the other. Each system in use (Pacejka, Tire and Vehicle
Dynamics, 2012, appendix 1) has its own signs for the two. The system found is reported, and the
channels are converted to ISO W.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from flatplank_data.errors import FlatplankError
from flatplank_data.units import canonical_unit, to_si


class UnitRule(NamedTuple):
    """Unit assumed for values of at least `least`; the last rule that applies is used."""

    least: float
    unit: str


class Channel(NamedTuple):
    """A quantity that the analysis uses."""

    name: str
    unit: str
    """internal unit, SI"""
    names: tuple[str, ...]
    """names in files, in lower case; the first that a file has is used"""
    guesses: tuple[UnitRule, ...]
    """rules for the unit where a file states none, by the largest value"""


CHANNELS = (
    Channel("time", "s", ("et", "time", "t", "elapsed_time"), (UnitRule(0.0, "s"),)),
    Channel(
        "kappa", "1",
        ("sl", "sr", "kappa", "slip_ratio", "slip ratio", "longitudinal_slip", "longslip"),
        (UnitRule(0.0, "-"), UnitRule(1.5, "%")),
    ),
    Channel(
        "alpha", "rad",
        ("sa", "alpha", "slip_angle", "slip angle", "slipangl", "sideslip"),
        (UnitRule(0.0, "rad"), UnitRule(0.8, "deg")),
    ),
    Channel(
        "gamma", "rad",
        ("ia", "gamma", "camber", "inclination_angle", "inclination angle", "inclangl"),
        (UnitRule(0.0, "rad"), UnitRule(0.8, "deg")),
    ),
    Channel("fx", "N", ("fx", "force_x", "fx_w"), (UnitRule(0.0, "kN"), UnitRule(50.0, "N"))),
    Channel("fy", "N", ("fy", "force_y", "fy_w"), (UnitRule(0.0, "kN"), UnitRule(50.0, "N"))),
    Channel(
        "fz", "N", ("fz", "force_z", "fz_w", "load"), (UnitRule(0.0, "kN"), UnitRule(50.0, "N"))
    ),
    Channel("mx", "N m", ("mx", "moment_x", "mx_w"), (UnitRule(0.0, "Nm"),)),
    Channel("my", "N m", ("my", "moment_y", "my_w"), (UnitRule(0.0, "Nm"),)),
    Channel("mz", "N m", ("mz", "moment_z", "mz_w"), (UnitRule(0.0, "Nm"),)),
    Channel(
        "pressure", "Pa",
        ("p", "pressure", "inflation_pressure", "inflpres", "ip"),
        (UnitRule(0.0, "bar"), UnitRule(6.0, "psi"), UnitRule(65.0, "kPa"), UnitRule(1e4, "Pa")),
    ),
    Channel(
        "speed", "m/s",
        ("v", "speed", "velocity", "vx", "road_speed", "longvel", "trajvelw"),
        (UnitRule(0.0, "m/s"), UnitRule(25.0, "km/h")),
    ),
)  # fmt: skip
BY_NAME = {channel.name: channel for channel in CHANNELS}


def channel_of(header: Sequence[str]) -> dict[str, str]:
    """Name of a channel -> column of the file, for the channels that the file has."""
    lower = {name.strip().lower(): name for name in reversed(header)}
    found = {}
    for channel in CHANNELS:
        name = next((n for n in channel.names if n in lower), None)
        if name is not None:
            found[channel.name] = lower[name]
    return found


def in_si(
    channel: Channel, values: np.ndarray, unit: str | None, size: float, where: str
) -> tuple[np.ndarray, str]:
    """Values in SI, and the assumption made; "" when the file states the unit.

    size: largest value of all channels with the same unit as this one.

    Raises:
        FlatplankError: the unit is unknown or belongs to another quantity.
    """
    if unit is not None and (channel.unit == "1" or canonical_unit(unit) not in ("", "-")):
        return to_si(values, unit, channel.unit, where), ""
    guess = [g.unit for g in channel.guesses if size >= g.least][-1]
    assumed = len(channel.guesses) > 1 and guess != "-"
    said = f"{channel.name}: no unit, taken to be in {guess} (up to {size:.3g})" if assumed else ""
    return to_si(values, guess, channel.unit, where), said


def sizes(columns: Mapping[str, np.ndarray]) -> dict[str, float]:
    """Channel -> largest value, which decides on its unit; that of Fz decides for all forces."""
    largest = {n: float(np.nanmax(np.abs(v), initial=0.0)) for n, v in columns.items()}
    angle = max(largest.get("alpha", 0.0), largest.get("gamma", 0.0))
    alike = {"N": largest.get("fz", 0.0), "rad": angle}
    return {n: alike.get(BY_NAME[n].unit, size) for n, size in largest.items()}


def check_columns(columns: Sequence[str], where: str) -> None:
    """Raise FlatplankError when Fz, both slips, or both Fx and Fy are missing."""
    if "fz" not in columns:
        raise FlatplankError("no vertical force", where, f"name it {', '.join(_names('fz'))}")
    if not {"alpha", "kappa"} & set(columns):
        raise FlatplankError(
            "neither slip angle nor slip", where,
            f"name them {', '.join(_names('alpha'))}, or {', '.join(_names('kappa'))}",
        )  # fmt: skip
    if not {"fx", "fy"} & set(columns):
        raise FlatplankError("neither Fx nor Fy", where, "name them fx and fy")


def _names(channel: str) -> list[str]:
    return [name.upper() for name in BY_NAME[channel].names[:3]]


UP = 0.05
"""share of the largest load above which the tire is loaded [-]"""
SMALL_ALPHA, SMALL_KAPPA = 0.03, 0.03
"""largest slip at which forces are proportional to slip [rad, -]"""
LEAST_SLOPE = 20
"""least number of samples for a slope"""
CERTAIN = 0.3
"""correlation of force and slip below which the sign is uncertain"""


class System(NamedTuple):
    """An axis system: its signs, and the channels whose signs change in ISO W."""

    title: str
    load: int
    """sign of Fz of a loaded tire"""
    side: int
    """sign of dFy / dalpha"""
    turned: tuple[str, ...]


SYSTEMS = {
    "iso": System("ISO W (ISO 8855: z up, y to the left)", 1, -1, ()),
    "sae": System(
        "SAE J670 (z down, y to the right)", -1, -1, ("alpha", "fy", "fz", "my", "mz")
    ),
    "adapted": System(
        "adapted SAE (z down, y to the right, load and slip angle turned)",
        1, 1, ("fy", "my", "mz"),
    ),
}  # fmt: skip


def in_iso(
    columns: Mapping[str, np.ndarray], wanted: str | None, where: str
) -> tuple[dict[str, np.ndarray], str]:
    """Columns in ISO W, and how their system was found; `wanted` selects one of several.

    Raises:
        FlatplankError: no system has these signs, or the wanted one has others.
    """
    fz = columns["fz"]
    load = int(np.sign(np.median(fz[np.abs(fz) > UP * np.abs(fz).max()])))
    side = _slope_sign(columns, "fy", "alpha", SMALL_ALPHA)
    drive = _slope_sign(columns, "fx", "kappa", SMALL_KAPPA)
    if drive < 0:
        raise FlatplankError(
            "Fx falls where the slip rises: a driven tire would brake", where,
            "turn the sign of the column of the slip, or of Fx",
        )  # fmt: skip
    fitting = [
        name
        for name, system in SYSTEMS.items()
        if system.load == load and side in (0, system.side)
    ]
    seen = f"Fz {'< 0' if load < 0 else '> 0'}"
    seen += ("", ", Fy rises with the slip angle", ", Fy falls with the slip angle")[side]
    if wanted is not None and wanted not in fitting:
        raise FlatplankError(
            f"the signs are not those of {SYSTEMS[wanted].title}: {seen}", where,
            f"leave --axes out, or say --axes {fitting[0]}" if fitting else "turn a column's sign",
        )  # fmt: skip
    if not fitting:
        raise FlatplankError(
            f"no axis system has these signs: {seen}", where,
            "turn the sign of the column of the slip angle, or of Fy",
        )  # fmt: skip
    system = wanted or fitting[0]
    title, _, _, turned = SYSTEMS[system]
    out = {k: -v if k in turned else v for k, v in columns.items()}
    said = f"axes: {title}, by {seen}"
    others = [name for name in fitting if name != system]
    if wanted:
        said = f"axes: {title}, as asked for"
    elif others:
        said += f"; nothing tells it from {' or '.join(others)} (--axes NAME)"
    return out, said


def _slope_sign(columns: Mapping[str, np.ndarray], force: str, slip: str, small: float) -> int:
    """Sign of the force over small slip; 0 when the data do not determine it."""
    if force not in columns or slip not in columns:
        return 0
    near = np.abs(columns[slip]) < small
    x, y = columns[slip][near], columns[force][near]
    if near.sum() < LEAST_SLOPE or np.ptp(x) < 0.2 * small or np.ptp(y) == 0.0:
        return 0
    r = float(np.corrcoef(x, y)[0, 1])
    return int(np.sign(r)) if abs(r) > CERTAIN else 0
