# SPDX-License-Identifier: Apache-2.0
"""Names and units of the channels of a test bench."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from flatplank_data.errors import FlatplankError
from flatplank_data.units import is_bare, to_si


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
    Channel(
        "time", "s", ("et", "time", "t", "elapsed time", "runtime", "timestamp", "stamp"),
        (UnitRule(0.0, "s"),),
    ),
    Channel(
        "kappa", "1",
        ("sl", "sr", "kappa", "slip ratio", "longitudinal slip", "long slip", "longslip"),
        (UnitRule(0.0, "-"), UnitRule(1.5, "%")),
    ),
    Channel(
        "alpha", "rad",
        ("sa", "alpha", "slip angle", "side slip angle", "side slip", "lateral slip angle",
         "slipangl"),
        (UnitRule(0.0, "rad"), UnitRule(0.8, "deg")),
    ),
    Channel(
        "gamma", "rad",
        ("ia", "gamma", "camber", "camber angle", "inclination angle", "inclination", "inclangl"),
        (UnitRule(0.0, "rad"), UnitRule(0.8, "deg")),
    ),
    Channel(
        "fx", "N", ("fx", "force x", "fxw", "longitudinal force", "x force"),
        (UnitRule(0.0, "kN"), UnitRule(50.0, "N")),
    ),
    Channel(
        "fy", "N", ("fy", "force y", "fyw", "lateral force", "side force", "y force"),
        (UnitRule(0.0, "kN"), UnitRule(50.0, "N")),
    ),
    Channel(
        "fz", "N",
        ("fz", "force z", "fzw", "load", "vertical force", "normal force", "vertical load",
         "normal load", "wheel load", "z force"),
        (UnitRule(0.0, "kN"), UnitRule(50.0, "N")),
    ),
    Channel(
        "mx", "N m", ("mx", "moment x", "mxw", "overturning moment", "overturning torque"),
        (UnitRule(0.0, "Nm"),),
    ),
    Channel(
        "my", "N m", ("my", "moment y", "myw", "rolling resistance moment"),
        (UnitRule(0.0, "Nm"),),
    ),
    Channel(
        "mz", "N m",
        ("mz", "moment z", "mzw", "aligning moment", "aligning torque", "self aligning torque",
         "self aligning moment"),
        (UnitRule(0.0, "Nm"),),
    ),
    Channel(
        "pressure", "Pa",
        ("p", "pressure", "inflation pressure", "tire pressure", "tyre pressure", "inflpres",
         "ip"),
        (UnitRule(0.0, "bar"), UnitRule(6.0, "psi"), UnitRule(65.0, "kPa"), UnitRule(1e4, "Pa")),
    ),
    Channel(
        "speed", "m/s",
        ("v", "speed", "velocity", "vx", "road speed", "belt speed", "forward speed", "longvel",
         "trajvelw"),
        (UnitRule(0.0, "m/s"), UnitRule(25.0, "km/h")),
    ),
    Channel(
        "temperature", "K",
        ("tstc", "tread temperature", "tread surface temperature", "tire temperature",
         "tyre temperature"),
        (UnitRule(0.0, "degC"), UnitRule(200.0, "K")),
    ),
)  # fmt: skip
BY_NAME = {channel.name: channel for channel in CHANNELS}
NOT_NEEDED = ("time", "mx", "my", "mz", "temperature")
"""channels that no curve and no comparison needs"""


def _plain(name: str) -> str:
    return re.sub(r"[\W_]+", "", name).lower()


_ALIASES = {_plain(name): (c.name, k) for c in CHANNELS for k, name in enumerate(c.names)}


def channel_named(name: str) -> str | None:
    """The channel that a column of this name is; blanks, hyphens and case do not count."""
    return _ALIASES.get(_plain(name), (None, 0))[0]


def columns_of(header: Sequence[str], given: Mapping[str, str], where: str) -> dict[str, str]:
    """Channel -> column of the file; `given` overrides the names. The first name of `CHANNELS`
    that a file has is used.

    Raises:
        FlatplankError: no such channel or column in `given`.
    """
    asked = {}
    for channel, column in given.items():
        name = channel if channel in BY_NAME else channel_named(channel)
        if name is None:
            known = ", ".join(BY_NAME)
            raise FlatplankError(f"no channel '{channel}'", "--columns", f"known: {known}")
        if column not in header:
            raise FlatplankError(
                f"no column '{column}'", where, f"the file has {', '.join(header)}"
            )
        asked[name] = column
    ranked = sorted(
        (_ALIASES[_plain(name)][1], k, name)
        for k, name in enumerate(header)
        if channel_named(name) and name not in asked.values()
    )
    found = dict(asked)
    for _, _, name in ranked:
        found.setdefault(str(channel_named(name)), name)
    return {c.name: found[c.name] for c in CHANNELS if c.name in found}


def in_si(
    channel: Channel, values: np.ndarray, unit: str | None, size: float, where: str
) -> tuple[np.ndarray, str]:
    """Values in SI, and the unit that was assumed; "" when the file states it.

    size: largest value of all channels with the same unit as this one.

    Raises:
        FlatplankError: the unit is unknown or belongs to another quantity.
    """
    if unit is not None and (channel.unit == "1" or not is_bare(unit)):
        return to_si(values, unit, channel.unit, where), ""
    guess = [g.unit for g in channel.guesses if size >= g.least][-1]
    return to_si(values, guess, channel.unit, where), guess


def sizes(columns: Mapping[str, np.ndarray]) -> dict[str, float]:
    """Channel -> largest value, which decides on its unit; that of Fz decides for all forces."""
    largest = {n: float(np.nanmax(np.abs(v), initial=0.0)) for n, v in columns.items()}
    angle = max(largest.get("alpha", 0.0), largest.get("gamma", 0.0))
    alike = {"N": largest.get("fz", 0.0), "rad": angle}
    return {n: alike.get(BY_NAME[n].unit, size) for n, size in largest.items()}


def check_columns(columns: Sequence[str], where: str) -> None:
    """Raise FlatplankError when Fz, both slips, or both Fx and Fy are missing."""
    if "fz" not in columns:
        raise FlatplankError(
            "no vertical force", where,
            f"name it {', '.join(_names('fz'))}, or say --columns fz=THEIRS",
        )  # fmt: skip
    if not {"alpha", "kappa"} & set(columns):
        raise FlatplankError(
            "neither slip angle nor slip", where,
            f"name them {', '.join(_names('alpha'))}, or {', '.join(_names('kappa'))}, "
            "or say --columns alpha=THEIRS",
        )  # fmt: skip
    if not {"fx", "fy"} & set(columns):
        raise FlatplankError("neither Fx nor Fy", where, "name them fx and fy, or say --columns")


LARGEST_ANGLE = 0.5 * np.pi
"""angle of a wheel that no sweep passes [rad]: it would roll backwards, or lie on its side"""
LARGEST_RATIO = 1000.0**0.5
"""force over load above which the two have units of a ratio of 1000, rather than of 1; a force
smaller than the load by so much is that of no tire which slips: on ice friction is 0.05"""
SWEEPS = {"fx": ("kappa", 0.04), "fy": ("alpha", np.radians(2.0))}
"""force -> its slip, and the least range of a sweep of it [-, rad]"""


def check_values(columns: Mapping[str, np.ndarray], names: Mapping[str, str], where: str) -> None:
    """Raise FlatplankError for values that contradict their unit."""
    for name in ("alpha", "gamma"):
        most = float(np.nanmax(np.abs(columns.get(name, 0.0))))
        if most > LARGEST_ANGLE:
            raise FlatplankError(
                f"'{names[name]}' goes up to {np.degrees(most):.4g} deg", where,
                "correct its unit (deg, rad)",
            )  # fmt: skip
    load = float(np.nanmax(np.abs(columns["fz"])))
    for name in ("fx", "fy"):
        most = float(np.nanmax(np.abs(columns.get(name, 0.0))))
        slip, least = SWEEPS[name]
        swept = slip in columns and np.nanmax(columns[slip]) - np.nanmin(columns[slip]) > least
        if most > LARGEST_RATIO * load or (swept and 0.0 < most < load / LARGEST_RATIO):
            raise FlatplankError(
                f"'{names[name]}' goes up to {most:.4g} N at a load of {load:.4g} N", where,
                f"correct the unit of '{names[name]}' or '{names['fz']}'",
            )  # fmt: skip


def _names(channel: str) -> list[str]:
    return [name.upper() for name in BY_NAME[channel].names[:3]]
