# SPDX-License-Identifier: Apache-2.0
"""Axis systems of test benches.

The axis system follows from the signs of three forces: the road pushes a loaded tire upwards, a
tire that slips to one side towards the other, and a tire that leans to one side towards this side.
Each system in use (Pacejka, Tire and Vehicle Dynamics, 2012, appendix 1) has its own signs for the
three. The system found is reported, and the channels are converted to ISO W.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from flatplank_analysis.slip_sweeps.channels import BY_NAME
from flatplank_data.errors import FlatplankError

UP = 0.05
"""share of the largest load above which the tire is loaded [-]"""
SMALL_ALPHA, SMALL_KAPPA = 0.03, 0.03
"""largest slip at which forces are proportional to slip [rad, -]"""
LEAST_SLOPE = 20
"""least number of samples for a slope"""
CERTAIN = 0.3
"""correlation of force and slip, or camber, below which the sign is uncertain"""


class System(NamedTuple):
    """An axis system: its signs, and the channels whose signs change in ISO W."""

    title: str
    load: int
    """sign of Fz of a loaded tire"""
    side: int
    """sign of dFy / dalpha"""
    lean: int
    """sign of dFy / dgamma"""
    turned: tuple[str, ...]


SYSTEMS = {
    "iso": System("ISO W (ISO 8855: z up, y to the left)", 1, -1, -1, ()),
    "sae": System(
        "SAE J670 (z down, y to the right)", -1, -1, 1, ("alpha", "fy", "fz", "my", "mz")
    ),
    "adapted": System(
        "adapted SAE (z down, y to the right, load and slip angle turned)",
        1, 1, 1, ("fy", "my", "mz"),
    ),
}  # fmt: skip
COUNTED_OTHERWISE = {"alpha": "slip angle", "gamma": "camber"}
"""angles that some programs count the other way than their axis system does"""


class Signs(NamedTuple):
    """Signs that the data show; 0: not determined."""

    load: int
    side: int
    lean: int

    def of(self, system: System, turned: str = "") -> bool:
        """Whether a system has these signs, with one angle counted the other way."""
        side = system.side * (-1 if turned == "alpha" else 1)
        lean = system.lean * (-1 if turned == "gamma" else 1)
        return self.load == system.load and self.side in (0, side) and self.lean in (0, lean)

    def __str__(self) -> str:
        text = f"Fz {'< 0' if self.load < 0 else '> 0'}"
        text += ("", ", Fy rises with the slip angle", ", Fy falls with the slip angle")[self.side]
        return text + ("", ", Fy rises with camber", ", Fy falls with camber")[self.lean]


def in_iso(
    columns: Mapping[str, np.ndarray], wanted: str | None, turn: Sequence[str], where: str
) -> tuple[dict[str, np.ndarray], str]:
    """Columns in ISO W, and how their system was found.

    wanted: one of `SYSTEMS`, or None; turn: channels that the file counts the other way.

    Raises:
        FlatplankError: no system has these signs, or the wanted one has others; no such channel.
    """
    for name in turn:
        if name not in columns or name not in BY_NAME:
            known = ", ".join(name for name in columns if name in BY_NAME)
            raise FlatplankError(f"no channel '{name}' to turn", "--turn", f"known: {known}")
    given = {k: -v if k in turn else v for k, v in columns.items()}
    signs = _signs(given)
    if slope_sign(given, "fx", "kappa", SMALL_KAPPA) < 0:
        raise FlatplankError(
            "Fx falls where the slip rises: a driven tire would brake", where,
            "turn the sign of the slip or of Fx: --turn kappa, or --turn fx",
        )  # fmt: skip
    fitting = list(_fitting(signs, turn))
    chosen = next((f for f in fitting if wanted in (None, f[0])), None)
    if chosen is None:
        raise _contradiction(signs, wanted, [name for name, _ in fitting], where)
    name, angle = chosen
    system = SYSTEMS[name]
    away = {*system.turned} ^ ({angle} - {""})
    said = f"axes: {system.title}, {'as asked for' if wanted else f'by {signs}'}"
    if turn:
        said += f"; turned as asked for: {', '.join(turn)}"
    if angle:
        said += f"; the {COUNTED_OTHERWISE[angle]} is counted the other way"
        said += f", by {signs}" if wanted else ""
    alike = [other for other, more in fitting if other != name and not more]
    if alike and not wanted:
        said += f"; nothing tells it from {' or '.join(alike)} (--axes NAME)"
    return {k: -v if k in away else v for k, v in given.items()}, said


def _fitting(signs: Signs, turn: Sequence[str]) -> Iterator[tuple[str, str]]:
    """Systems with these signs; then those with an angle that is counted the other way.

    ISO with an angle counted otherwise, and adapted SAE with the other one, are mirror images.
    """
    yield from ((name, "") for name, system in SYSTEMS.items() if signs.of(system))
    for name, system in SYSTEMS.items():
        angles = [a for a in COUNTED_OTHERWISE if a not in turn and signs.lean]
        yield from ((name, angle) for angle in angles if signs.of(system, angle))


def _contradiction(
    signs: Signs, wanted: str | None, fitting: Sequence[str], where: str
) -> FlatplankError:
    remedy = "turn the sign of the slip angle or of Fy: --turn alpha, or --turn fy"
    if wanted is None:
        return FlatplankError(f"no axis system has these signs: {signs}", where, remedy)
    if fitting:
        remedy = f"leave --axes out, or say --axes {fitting[0]}"
    if signs.load == SYSTEMS[wanted].load:
        remedy += ", or --turn the channel that is counted the other way"
    what = f"the signs are not those of {SYSTEMS[wanted].title}: {signs}"
    return FlatplankError(what, where, remedy)


def _signs(columns: Mapping[str, np.ndarray]) -> Signs:
    fz = columns["fz"]
    load = -1 if np.median(fz[np.abs(fz) > UP * np.abs(fz).max()]) < 0.0 else 1
    return Signs(load, slope_sign(columns, "fy", "alpha", SMALL_ALPHA), _lean_sign(columns))


def slope_sign(columns: Mapping[str, np.ndarray], force: str, slip: str, small: float) -> int:
    """Sign of a force or moment over small slip; 0 when the data do not determine it."""
    if force not in columns or slip not in columns:
        return 0
    near = (np.abs(columns[slip]) < small) & np.isfinite(columns[force])
    x, y = columns[slip][near], columns[force][near]
    if near.sum() < LEAST_SLOPE or np.ptp(x) < 0.2 * small or np.ptp(y) == 0.0:
        return 0
    r = float(np.corrcoef(x, y)[0, 1])
    return int(np.sign(r)) if abs(r) > CERTAIN else 0


def _lean_sign(columns: Mapping[str, np.ndarray]) -> int:
    """Sign of the side force over camber, at small slip and apart from what the slip explains."""
    if not {"fy", "gamma"} <= columns.keys():
        return 0
    near = np.isfinite(columns["fy"])
    for slip, small in (("alpha", SMALL_ALPHA), ("kappa", SMALL_KAPPA)):
        if slip in columns:
            near &= np.abs(columns[slip]) < small
    if near.sum() < LEAST_SLOPE:
        return 0
    fz, gamma, fy = (columns[name][near] for name in ("fz", "gamma", "fy"))
    others = [fz]
    if "alpha" in columns:
        others += [columns["alpha"][near] * fz, columns["alpha"][near] * fz**2]
    lean, rest = (_without(np.column_stack(others), values) for values in (gamma * np.abs(fz), fy))
    if np.ptp(gamma) == 0.0 or not rest.any():
        return 0
    r = float(lean @ rest / np.sqrt((lean @ lean) * (rest @ rest)))
    return int(np.sign(r)) if abs(r) > CERTAIN else 0


def _without(others: np.ndarray, values: np.ndarray) -> np.ndarray:
    """What is left of values after the best sum of the columns of `others`."""
    return values - others @ np.linalg.lstsq(others, values, rcond=None)[0]
