# SPDX-License-Identifier: Apache-2.0
"""What the channels of a test bench are called, and what they are written in."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from flatplank_data.errors import FlatplankError
from flatplank_data.units import canonical, to_si


class Guess(NamedTuple):
    """A unit for values that are at least so large; the last that fits is taken."""

    least: float
    unit: str


class Channel(NamedTuple):
    """A quantity of which the analysis knows the meaning."""

    name: str
    unit: str
    """inside, SI"""
    names: tuple[str, ...]
    """in files, in lower case; the first that a file has is taken"""
    guesses: tuple[Guess, ...]
    """where a file gives no unit: by the largest size that occurs"""


CHANNELS = (
    Channel("time", "s", ("et", "time", "t", "elapsed_time"), (Guess(0.0, "s"),)),
    Channel(
        "kappa", "1",
        ("sl", "sr", "kappa", "slip_ratio", "slip ratio", "longitudinal_slip", "longslip"),
        (Guess(0.0, "-"), Guess(1.5, "%")),
    ),
    Channel(
        "alpha", "rad",
        ("sa", "alpha", "slip_angle", "slip angle", "slipangl", "sideslip"),
        (Guess(0.0, "rad"), Guess(0.8, "deg")),
    ),
    Channel(
        "gamma", "rad",
        ("ia", "gamma", "camber", "inclination_angle", "inclination angle", "inclangl"),
        (Guess(0.0, "rad"), Guess(0.8, "deg")),
    ),
    Channel("fx", "N", ("fx", "force_x", "fx_w"), (Guess(0.0, "kN"), Guess(50.0, "N"))),
    Channel("fy", "N", ("fy", "force_y", "fy_w"), (Guess(0.0, "kN"), Guess(50.0, "N"))),
    Channel("fz", "N", ("fz", "force_z", "fz_w", "load"), (Guess(0.0, "kN"), Guess(50.0, "N"))),
    Channel("mx", "N m", ("mx", "moment_x", "mx_w"), (Guess(0.0, "Nm"),)),
    Channel("my", "N m", ("my", "moment_y", "my_w"), (Guess(0.0, "Nm"),)),
    Channel("mz", "N m", ("mz", "moment_z", "mz_w"), (Guess(0.0, "Nm"),)),
    Channel(
        "pressure", "Pa",
        ("p", "pressure", "inflation_pressure", "inflpres", "ip"),
        (Guess(0.0, "bar"), Guess(6.0, "psi"), Guess(65.0, "kPa"), Guess(1e4, "Pa")),
    ),
    Channel(
        "speed", "m/s",
        ("v", "speed", "velocity", "vx", "road_speed", "longvel", "trajvelw"),
        (Guess(0.0, "m/s"), Guess(25.0, "km/h")),
    ),
)  # fmt: skip
BY_NAME = {channel.name: channel for channel in CHANNELS}


def channel_of(header: Sequence[str]) -> dict[str, str]:
    """Our name -> the column of the file that holds it."""
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
    """Values in SI, and what was assumed; "" when the file says the unit.

    size: the largest that occurs in the channels that share a unit with this one.

    Raises:
        FlatplankError: the unit is unknown or belongs to another quantity.
    """
    if unit is not None and (channel.unit == "1" or canonical(unit) not in ("", "-")):
        return to_si(values, unit, channel.unit, where), ""
    guess = [g.unit for g in channel.guesses if size >= g.least][-1]
    assumed = len(channel.guesses) > 1 and guess != "-"
    said = f"{channel.name}: no unit, taken to be in {guess} (up to {size:.3g})" if assumed else ""
    return to_si(values, guess, channel.unit, where), said


def sizes(columns: Mapping[str, np.ndarray]) -> dict[str, float]:
    """Channel -> by what size its unit is guessed: all forces are written as the load is."""
    largest = {n: float(np.nanmax(np.abs(v), initial=0.0)) for n, v in columns.items()}
    angle = max(largest.get("alpha", 0.0), largest.get("gamma", 0.0))
    alike = {"N": largest.get("fz", 0.0), "rad": angle}
    return {n: alike.get(BY_NAME[n].unit, size) for n, size in largest.items()}


def needed(columns: Sequence[str], where: str) -> None:
    """FlatplankError when slip or forces are missing."""
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
