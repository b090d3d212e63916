# SPDX-License-Identifier: Apache-2.0
"""Sweeps as the search takes them: a run is one visit to a condition, a node one bin of the slip.

Nodes are the bins of the slip while it rises, then those while it falls, each the mean of its
samples. Where the conditions were swept one way only, they are the bins of that way.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from flatplank_analysis.discovery.runs import Coordinate, RunSet
from flatplank_analysis.slip_sweeps.channels import BY_NAME
from flatplank_analysis.slip_sweeps.conditions import (
    BINS,
    FORCE,
    LEAST,
    SweepCondition,
)
from flatplank_analysis.slip_sweeps.conditions import (
    BY_NAME as HELD,
)
from flatplank_analysis.slip_sweeps.curves import COMMON, FEW, rises
from flatplank_analysis.slip_sweeps.study import Study
from flatplank_data.errors import FlatplankError

AXES = ("fz", "kappa", "alpha", "gamma", "pressure", "speed")
"""channels on which a tire file depends"""
CHANNEL = "of "
"""what the name of a channel begins with among the facts of the runs"""
SHOWN = {"time": "s", "distance": "m", "temperature": "K", "rate": "rad/s"} | {
    name: BY_NAME[name].unit for name in AXES
}
"""coordinate -> unit"""
SAME_LAW = ("pressure", "speed")
"""levels that do not change the form of the law: with the others alike its error is the same"""
LEAST_RANGE = {"temperature": 2.0}
"""range below which a coordinate is constant [K]: the accuracy of an infrared sensor"""

_Visit = tuple[str, np.ndarray, Mapping[str, np.ndarray], tuple]
"""condition, samples, columns of the file, and what says by which law the force comes"""


def runs_of(studies: Sequence[Study], swept: str) -> RunSet:
    """The runs of all sweeps of a slip (alpha or kappa).

    Raises:
        FlatplankError: the slip was not swept.
    """
    found = [
        (
            f"{one.path}: {c.label}" if len(studies) > 1 else c.label,
            visit,
            columns,
            (one.path, *(v for name, v in c.held.items() if name not in SAME_LAW)),
        )
        for one, columns in zip(studies, _one_after_the_other(studies, swept), strict=True)
        for c in one.conditions
        if c.swept == swept
        for visit in _visits(c)
    ]
    if not found:
        what = f"no sweep of the {BY_NAME[swept].names[2]}"
        raise FlatplankError(what, studies[0].path, "give a recording with one")
    force = FORCE[swept]
    ways = _ways(found, swept)
    binned = [_binned(columns, rows, swept, ways) for _, rows, columns, *_ in found]
    laws = list(dict.fromkeys(law for *_, law in found))
    begins = dict(zip((one.path for one in studies), _begins(studies), strict=True))
    labels = list(dict.fromkeys(label for label, *_ in found))
    condition = np.array([labels.index(label) for label, *_ in found])
    known = [n for n in (*SHOWN, force) if all(n in one for one in binned)]
    of = {name: np.array([one[name] for one in binned]) for name in known}
    nodes = of[force].shape[1]
    return RunSet(
        names=tuple(f"{label}, visit {np.sum(condition[:i] == condition[i]) + 1}"
                    for i, (label, *_) in enumerate(found)),
        condition=condition,
        condition_names=tuple(labels),
        channels=(force,),
        units=("N",),
        measured=of[force][None],
        # the bins as if they were of equal length: the noise has a memory over bins
        time=np.tile(np.arange(nodes, dtype=float), (len(found), 1)),
        order=np.array([begins[str(law[0])] + float(rows[0]) for _, rows, _, law in found]),
        coordinates={
            name: Coordinate(of[name], SHOWN[name]) for name in SHOWN
            if name in of and _varies(name, of[name])
        },
        facts={f"{CHANNEL}{name}": of[name] for name in SHOWN if name in of}
        | {"law": np.array([laws.index(law) for *_, law in found])},
        inputs={swept: of[swept]},
    )  # fmt: skip


def _begins(studies: Sequence[Study]) -> list[int]:
    """Number of samples before each file."""
    counts = [len(one.columns["fz"]) for one in studies]
    return [sum(counts[:k]) for k in range(len(counts))]


def _one_after_the_other(studies: Sequence[Study], swept: str) -> list[dict[str, np.ndarray]]:
    """Columns of each file with what is derived from them; time and distance of a file go on where
    the file before it ended."""
    out: list[dict[str, np.ndarray]] = []
    ends: dict[str, float] = {}
    for one in studies:
        columns = {**one.columns, **_derived(one.columns, swept)}
        for name in ("time", "distance"):
            if out and name in columns and name in ends:
                values = columns[name]
                columns[name] = values - values[0] + ends[name]
        ends = {n: float(columns[n][-1]) for n in ("time", "distance") if n in columns}
        out.append(columns)
    return out


def _varies(name: str, values: np.ndarray) -> bool:
    """Whether a coordinate takes more than one level; without levels, any values."""
    if name in HELD:
        return HELD[name].several(values.ravel())
    return float(np.ptp(values)) > LEAST_RANGE.get(name, 0.0)


def _derived(columns: Mapping[str, np.ndarray], swept: str) -> dict[str, np.ndarray]:
    """Rate of the slip and distance rolled, where the file has times (and a speed)."""
    time = columns.get("time")
    if (
        swept not in columns
        or time is None
        or not np.isfinite(time).all()
        or np.any(np.diff(time) <= 0.0)
    ):
        return {}
    out = {"rate": np.gradient(columns[swept], time)}
    if "speed" in columns:
        step = np.diff(time, prepend=time[0])
        out["distance"] = np.cumsum(np.abs(columns["speed"]) * step)
    return out


def _visits(condition: SweepCondition) -> Iterator[np.ndarray]:
    """Samples of each visit to a condition."""
    rows = condition.samples
    gaps = np.flatnonzero(np.diff(rows) > max(len(rows) // 2, LEAST)) + 1
    yield from np.split(rows, gaps)


def _ways(found: Sequence[_Visit], swept: str):
    """Directions of the slip that all visits have: (True, False), (True,) or (False,)."""
    both = [_filled(columns[swept][rows]) for _, rows, columns, *_ in found]
    ways = tuple(w for w in (True, False) if all(one[w] > COMMON for one in both))
    return ways or (None,)


def _filled(slip: np.ndarray) -> dict[bool, float]:
    """Share of the bins that each direction fills."""
    bins, rising = _bins(slip), rises(slip)
    return {
        way: float((np.bincount(bins[rising == way], minlength=BINS) >= FEW).mean())
        for way in (True, False)
    }


def _bins(slip: np.ndarray) -> np.ndarray:
    edges = np.linspace(slip.min(), slip.max(), BINS + 1)
    return np.clip(np.digitize(slip, edges) - 1, 0, BINS - 1)


def _binned(columns: Mapping[str, np.ndarray], rows: np.ndarray, swept: str, ways):
    """Means of each channel in the bins; an empty bin takes the values between its neighbours."""
    slip = columns[swept][rows]
    bins, rising = _bins(slip), rises(slip)
    out: dict[str, list[np.ndarray]] = {}
    for way in ways:
        chosen = np.ones(len(rows), bool) if way is None else rising == way
        count = np.bincount(bins[chosen], minlength=BINS)
        good = np.flatnonzero(count >= FEW)
        for name in (*SHOWN, FORCE[swept]):
            if name in columns and np.isfinite(columns[name]).all():
                total = np.bincount(bins[chosen], columns[name][rows][chosen], minlength=BINS)
                means = np.interp(np.arange(BINS), good, total[good] / count[good])
                out.setdefault(name, []).append(means if way is not False else means[::-1])
    return {name: np.concatenate(parts) for name, parts in out.items()}
