# SPDX-License-Identifier: Apache-2.0
"""Records of a motion, cut at the turning points of a swing, and their table for the search."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import least_squares

from flatplank_analysis.discovery.runs import Coordinate, RunSet
from flatplank_data.errors import FlatplankError
from flatplank_data.names import nearest_hint

BEGIN = ("begin x", "begin v")
"""facts of a run: position and speed at its first node"""
FINE = 20
"""values of an input between two nodes"""


def _held(at: np.ndarray, time: np.ndarray, values: np.ndarray) -> np.ndarray:
    return np.asarray(values, float)[np.maximum(np.searchsorted(time, at, "right") - 1, 0)]


BETWEEN: dict[str, Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]] = {
    "line": np.interp,
    "held": _held,
    "spline": lambda at, time, values: CubicSpline(time, values)(at),
}
"""what an input does between two samples: a straight line, the value of the last sample (a
command that a computer holds), a cubic spline"""


def between(name: str) -> str:
    """Name of the fact that has an input also between the nodes."""
    return f"{name} between nodes"


@dataclass(frozen=True)
class Record:
    """A position over time, measured once. Time [s] may have steps of any size."""

    name: str
    time: np.ndarray
    position: np.ndarray
    inputs: Mapping[str, np.ndarray] = field(default_factory=dict)
    """commands or excitations of the machine, over the same time"""
    facts: Mapping[str, float | bool] = field(default_factory=dict)
    """numbers of the record: masses, lengths, voltages"""
    condition: str = ""
    """records with the same condition are repeats; empty: a condition of its own"""
    coordinates: Mapping[str, tuple[np.ndarray, str]] = field(default_factory=dict)
    """further coordinates over which effects may show, over the same time, with a unit"""
    span: tuple[float, float] | None = None
    """part of the record that is used [s], None: all"""
    begin: tuple[float, float] | None = None
    """initial position and speed; None: the first recorded position, at rest"""


def table_of(
    records: Sequence[Record],
    channel: str,
    unit: str,
    nodes: int,
    resolution: float | None = None,
    alike: bool = True,
    inputs: Mapping[str, str] | None = None,
) -> RunSet:
    """Records at a number of nodes each, evenly over the used time.

    alike: all end with the shortest one, so that their nodes are at the same times. resolution:
    smallest change of the position that is recorded; None: determined from the records. It is the
    noise floor where no record is repeated. inputs: input -> what it does between two samples, one
    of `BETWEEN`; a straight line where nothing is said. Raises FlatplankError for records that do
    not match.
    """
    _check(records)
    shapes = _shapes(records, inputs or {})
    spans = [r.span or (float(r.time[0]), float(r.time[-1])) for r in records]
    if alike:
        shortest = min(b - a for a, b in spans)
        spans = [(a, a + shortest) for a, _ in spans]
    at = np.array([np.linspace(a, b, nodes) for a, b in spans])
    fine = np.array([np.linspace(a, b, FINE * (nodes - 1) + 1) for a, b in spans])
    measured = np.array(
        [np.interp(t, r.time, r.position) for t, r in zip(at, records, strict=True)]
    )
    time = at - at[:, :1]
    names = [r.condition or r.name for r in records]
    kinds = list(dict.fromkeys(names))
    begin = [r.begin or (measured[i, 0], 0.0) for i, r in enumerate(records)]
    speed = np.gradient(measured, axis=1) / np.gradient(time, axis=1)
    facts = {k: np.array([r.facts[k] for r in records]) for k in records[0].facts}
    facts |= dict(zip(BEGIN, np.array(begin, dtype=float).T, strict=True))
    facts |= {between(k): _over(records, fine, k, shape) for k, shape in shapes.items()}
    per = f"{unit}/s" if "/" not in unit else f"{unit} per s"
    further = {
        k: Coordinate(_at(records, at, lambda r, k=k: r.coordinates[k][0]), u)
        for k, (_, u) in records[0].coordinates.items()
    }
    return RunSet(
        names=tuple(r.name for r in records),
        condition=np.array([kinds.index(n) for n in names]),
        condition_names=tuple(kinds),
        channels=(channel,),
        units=(unit,),
        measured=measured[None],
        time=time,
        order=np.arange(len(records), dtype=float),
        coordinates={"time": Coordinate(time.copy(), "s"), "speed": Coordinate(speed, per)}
        | further,
        inputs={k: _over(records, at, k, shape) for k, shape in shapes.items()},
        resolution=(max(map(step_of, (r.position for r in records))) if resolution is None
                    else resolution,),
        facts=facts,
    )  # fmt: skip


def _check(records: Sequence[Record]) -> None:
    """Raise with one line when the records do not fit into one table."""
    if not records:
        raise FlatplankError("no records", "table_of", "give at least two conditions")
    first = records[0]
    for r in records:
        where, given = f"record {r.name}", {"positions": r.position}
        given |= {f"values of {k}": v for k, v in r.inputs.items()}
        given |= {f"values of {k}": v for k, (v, _) in r.coordinates.items()}
        for name, values in given.items():
            if len(values) != len(r.time):
                what = f"{len(values)} {name} for {len(r.time)} times"
                raise FlatplankError(f"{where}: {what}", "table_of", "one for each")
        if len(r.time) < 2 or np.any(np.diff(r.time) <= 0.0):
            raise FlatplankError(f"{where}: time does not rise", "table_of", "sort its rows")
        for kind in ("facts", "inputs", "coordinates"):
            lacks = [k for k in getattr(first, kind) if k not in getattr(r, kind)]
            if lacks:
                what = f"no {kind[:-1]} '{lacks[0]}', which {first.name} has"
                raise FlatplankError(f"{where}: {what}", "table_of", "give all records the same")


def _shapes(records: Sequence[Record], given: Mapping[str, str]) -> dict[str, str]:
    """What each input does between two samples."""
    known = records[0].inputs
    for name, shape in given.items():
        if name not in known:
            what = f"no input '{name}'{nearest_hint(name, known)}"
            raise FlatplankError(what, "table_of", f"there: {', '.join(known) or 'none'}")
        if shape not in BETWEEN:
            what = f"input {name}: unknown shape '{shape}'{nearest_hint(shape, BETWEEN)}"
            raise FlatplankError(what, "table_of", f"known: {', '.join(BETWEEN)}")
    return {name: given.get(name, "line") for name in known}


def _over(records: Sequence[Record], at: np.ndarray, name: str, shape: str) -> np.ndarray:
    return _at(records, at, lambda r: r.inputs[name], BETWEEN[shape])


def _at(records, at, values, shape=np.interp) -> np.ndarray:
    return np.array([shape(t, r.time, values(r)) for t, r in zip(at, records, strict=True)])


def step_of(signal: np.ndarray) -> float:
    """Resolution of a signal: median of its smallest changes; of a smooth signal, its noise."""
    change = np.sort(np.abs(np.diff(signal)))
    change = change[change > 1e-9 * max(np.ptp(signal), 1e-300)]
    return float(np.median(change[: max(len(signal) // 200, 1)])) if len(change) else 0.0


SMALL = 40.0
"""least amplitude of a half swing, in steps of the record's resolution"""


def half_swings(record: Record, most: int = 30) -> Iterator[Record]:
    """The record cut at its turning points; at most `most` pieces, evenly chosen."""
    turns = turning_points(record.time, record.position, step_of(record.position))
    halves = list(zip(turns, turns[1:, 0], strict=False))
    for i, ((begin, top), end) in enumerate(halves[:: max(1, -(-len(halves) // most))]):
        yield Record(
            f"{record.name}, half swing {i + 1}",
            record.time,
            record.position,
            record.inputs,
            record.facts,
            coordinates=record.coordinates,
            span=(begin, end),
            begin=(top, 0.0),
        )


def turning_points(time: np.ndarray, position: np.ndarray, step: float) -> np.ndarray:
    """Time [s] and position of every resolved turning point of a swing (turns, 2)."""
    side, turns, last = 0.0, [], 0
    for i, x in enumerate(position):
        if abs(x) > SMALL * step and np.sign(x) != side:
            turns.append((last, i))
            side, last = np.sign(x), i
    spans = [*turns[1:], (last, len(time))]
    peaks = [a + int(np.argmax(np.abs(position[a:b]))) for a, b in spans]
    near = 0.15 * float(np.median(np.diff(time[peaks]))) if len(peaks) > 2 else 0.0
    kept = [p for p in peaks if time[0] + 2.0 * near < time[p] < time[-1] - 2.0 * near]
    return np.array([_vertex(time, position, time[p], near) for p in kept]).reshape(-1, 2)


def _vertex(time: np.ndarray, position: np.ndarray, at: float, near: float) -> tuple[float, float]:
    """Vertex of two half parabolas: with dry friction the curvature changes at the turn."""
    rows = np.flatnonzero(np.abs(time - at) < near)
    t, x = time[rows] - at, position[rows]

    def off(z):
        u = t - near * z[0]
        return (z[1] + np.where(u < 0.0, z[2], z[3]) * (u / near) ** 2) * scale - x

    scale = float(np.abs(x).max())
    bend = np.polyfit(t / near, x / scale, 2)
    z = least_squares(off, [0.0, bend[2], bend[0], bend[0]]).x
    return at + near * z[0], z[1] * scale
