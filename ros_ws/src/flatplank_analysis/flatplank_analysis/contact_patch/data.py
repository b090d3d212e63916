# SPDX-License-Identifier: Apache-2.0
"""Alignment of a campaign: filtered runs on common nodes, with all further recorded columns."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from flatplank_analysis.contact_patch.denoising import (
    Common,
    as_input,
    as_load,
    at_rest,
    side_force,
    steps_of,
)
from flatplank_analysis.contact_patch.grid import (
    BEFORE,
    SPEED,
    START,
    node_positions,
    smooth_columns,
    uniform_positions,
)
from flatplank_analysis.contact_patch.signs import wrong_signs
from flatplank_analysis.contact_patch.size import USUAL_LOAD, contact_ratio
from flatplank_analysis.contact_patch.tire_runs import SETTINGS, TireRuns
from flatplank_analysis.discovery.runs import Coordinate, RunSet
from flatplank_data.campaign import Campaign
from flatplank_data.errors import FlatplankError, NothingUsableError
from flatplank_data.problem import Problem, problem_from_error
from flatplank_data.progress import Progress, told
from flatplank_data.run_record import RunRecord
from flatplank_data.table import COLUMN_UNITS, MeasurementTable

COLUMNS = ("time", "plank_position", "wheel_angle", "fx", "fy", "fz", "mx", "mz")
STEPPED = ("step", "double_step", "constant")
"""waveforms whose slip is constant but for steps"""
NEEDED = ("time", "plank_position", "wheel_angle", "fx")
INPUTS = ("fy", "fz", "mx", "mz")
"""channels with possible crosstalk into Fx"""
STIFFNESS = 1.9e5
"""[N/m] longitudinal stiffness of the usual tire for short waves: force error per encoder error"""
STANDING = ("nominal", "alpha", "gamma", "pressure", "start", "session")
"""facts of a run on which the forces of a wheel that stands depend"""
START_TRAVEL, START_ROUGH = 0.08, 2.5
"""[m] of the usual tire, factor on the noise: over the first travel the locked tire is modelled
only roughly, which is the same in all runs, so that no scatter shows it"""
PINION_TURN = 2.0 * np.pi * 0.05
"""[m] plank travel per pinion turn, a placeholder"""
SHARE = 0.8
"""least length of a run, as a share of the usual travel; shorter runs would shorten all others"""
_BRACKETS = re.compile(r"^(.*?)\s*[\[(]([^\])]*)[\])]$")


def load_runs(campaign: Campaign, progress: Progress | None = None) -> TireRuns:
    """Read the slip runs of a campaign; `progress` is told of each run. `campaign.problems` lists
    unusable runs, and channels that only some runs have. NothingUsableError when no run
    remains."""
    tables = []
    for run in told(campaign.runs, progress):
        if run.info.measurement != "slip":
            continue
        table = campaign.try_table(run, COLUMNS, further=True)
        if table is None:
            continue
        try:
            _require(table)
        except FlatplankError as error:
            campaign.add_problem(problem_from_error(error, run.info.file))
            continue
        tables.append(table)
    if not tables:
        first = next((f" (first problem: {p})" for p in campaign.problems if p.fatal), "")
        raise NothingUsableError(
            f"no usable slip run{first}", campaign.path, "measure runs with a slip step"
        )
    short = {i: problem for i, problem in _short_runs(tables)}
    tables = [t for i, t in enumerate(tables) if i not in short]
    for problem in (*short.values(), *_incomplete_channels(tables)):
        campaign.add_problem(problem)
    return from_tables(tables)


def _require(table: MeasurementTable) -> None:
    for need in NEEDED:
        if not table.has(need):
            raise FlatplankError(
                f"no '{need}': not used", table.info.file, "add the column, or leave the run out"
            )


def _short_runs(tables: list[MeasurementTable]) -> Iterator[tuple[int, Problem]]:
    """Runs, by index, that are much shorter than the median of their step position and waveform:
    all runs with the same step are computed up to the shortest."""
    places = [t["plank_position"] for t in tables]
    travel = [float(np.nanmax(p) - np.nanmin(p)) for p in places]
    kinds = [(repr(t.info.step_position), repr(t.info.waveform)) for t in tables]
    for kind in dict.fromkeys(kinds):
        rows = [i for i, k in enumerate(kinds) if k == kind]
        usual = float(np.median([travel[i] for i in rows]))
        for i in rows:
            if travel[i] < SHARE * usual:
                what = f"{travel[i]:.2f} m of road, {usual:.2f} m is usual for its step: not used"
                remedy = "measure it again, or delete it"
                yield i, Problem(tables[i].info.file, what, remedy=remedy)


def _incomplete_channels(tables: list[MeasurementTable]) -> Iterator[Problem]:
    """Channels that only some runs have: the search does not use them."""
    for name in COLUMNS:
        lacking = [t.info.file for t in tables if not t.has(name)]
        if lacking and len(lacking) < len(tables):
            yield Problem(
                lacking[0],
                f"no '{name}', as in {len(lacking)} of {len(tables)} runs: the search goes "
                "without this channel",
                remedy="add the column, or leave these runs out",
                fatal=False,
            )


def from_tables(tables: list[MeasurementTable]) -> TireRuns:
    """Align the runs of a list of measurement tables, with the channels that all have."""
    for table in tables:
        _require(table)
    names = [n for n in COLUMNS[1:] if all(t.has(n) for t in tables)]
    smooth = [_smooth(table, names) for table in tables]
    ends = _common_ends(tables, smooth)
    nodes = [_nodes(s, t, e) for s, t, e in zip(smooth, tables, ends, strict=True)]
    times = np.stack([n[: min(map(len, nodes))] for n in nodes])
    stack = {
        name: np.stack(
            [np.interp(t, s["time"], s[name]) for t, s in zip(times, smooth, strict=True)]
        )
        for name in names
    }
    data = _assemble(tables, stack | {"time": times}, np.array([float(s["step"]) for s in smooth]))
    if not data.runs.repeated:
        standing = np.nan_to_num(np.stack([data.runs.facts[n] for n in STANDING], axis=1))
        rest = at_rest(smooth, data.runs.channels, standing)
        steps = steps_of(tables, data.runs.channels)
        data = replace(data, runs=replace(data.runs, rest=rest, resolution=steps))
    return replace(data, further=further_columns(tables, times))


def _smooth(table: MeasurementTable, names: list[str]) -> dict[str, np.ndarray]:
    info = table.info
    columns = np.stack([table[n] for n in names], axis=1)
    good = np.isfinite(columns).all(axis=1)
    time = table["time"][good]
    columns = columns[good].copy()
    columns[:, 0] = np.abs(columns[:, 0] - columns[0, 0])
    angle = columns[:, 1] - columns[0, 1]
    columns[:, 1] = angle * (1.0 if angle[-1] >= 0.0 else -1.0)
    speed = info.speed if np.isfinite(info.speed) else _speed(time, columns[:, 0])
    time, columns, counted = smooth_columns(time, columns, abs(speed), counted=(0, 1))
    radius = info.effective_rolling_radius if info.effective_rolling_radius > 0.0 else 0.3
    step = float(np.hypot(counted[0], counted[1] * radius))
    return {"time": time, "speed": np.array(abs(speed)), "step": np.array(step)} | {
        n: columns[:, i] for i, n in enumerate(names)
    }


def _speed(time: np.ndarray, position: np.ndarray) -> float:
    moving = (position > 0.2 * position[-1]) & (position < 0.8 * position[-1])
    if moving.sum() < 10:
        return SPEED
    return float(np.polyfit(time[moving], position[moving], 1)[0])


def _step_place(table: MeasurementTable) -> float:
    """Position of the step in travel from the first sample [m]; NaN without a step.

    The record has it as plank position, and the plank of the bench begins 2 cm before zero.
    """
    place = table["plank_position"]
    place = place[np.isfinite(place)]
    forward = place[-1] > place[0]
    return _step_of(table.info) - (float(place[0]) if forward else 0.0)


def _common_ends(tables: list[MeasurementTable], smooth: list[dict]) -> list[float]:
    """Last position [m] per run, equal for runs with the same step."""
    keys = [_grid_key(t) for t in tables]
    shortest: dict[tuple, float] = {}
    for key, s in zip(keys, smooth, strict=True):
        shortest[key] = min(float(s["plank_position"].max()), shortest.get(key, np.inf))
    return [shortest[key] - 0.004 for key in keys]


def _waveform(info: RunRecord) -> str:
    """Name of the waveform; without one it is a step."""
    return str((info.waveform or {}).get("name", "step"))


def _step_of(info: RunRecord) -> float:
    """Plank travel at which the slip steps for the last time [m]."""
    if _waveform(info) != "double_step":
        return info.step_position
    return info.step_position + float((info.waveform or {}).get("length", np.nan))


def _grid_key(table: MeasurementTable) -> tuple:
    step = _step_of(table.info)
    return (None if np.isnan(step) else round(step, 4), table.info.waveform is not None)


def _nodes(smooth: dict, table: MeasurementTable, end: float) -> np.ndarray:
    """Times of the nodes of one run [s]."""
    position, time = smooth["plank_position"], smooth["time"]
    began = int(np.argmax(position > START))
    stretch = SPEED / max(float(smooth["speed"]), 1e-4)
    before = time[began] + stretch * np.array([-BEFORE, -0.3, -0.2, -0.15, -0.1, -0.05, 0.0])
    stepped = _waveform(table.info) in STEPPED
    places = node_positions(_step_of(table.info), end) if stepped else uniform_positions(end)
    places = places[places > position[began] + 1e-4]
    rising = np.maximum.accumulate(position[began:])
    keep = np.concatenate([[True], np.diff(rising) > 0.0])
    at = np.interp(places, rising[keep], time[began:][keep])
    return np.concatenate([np.maximum(before, time[0]), at])


def _facts(tables: list[MeasurementTable]) -> dict[str, np.ndarray]:
    """Settings of the runs (runs,); `session`: index of the day, one for all undated runs."""

    def each(name: str, unknown: float = np.nan) -> np.ndarray:
        values = np.array([getattr(t.info, name) for t in tables], dtype=float)
        return np.where(np.isnan(values), unknown, values)

    return {
        "nominal": each("fz", 4000.0),
        "radius": each("effective_rolling_radius"),
        "alpha": np.radians(each("alpha_deg")),
        "gamma": np.radians(each("gamma_deg")),
        "kappa": each("kappa"),
        "pressure": each("pressure", 2.5),
        "step": np.array([_step_of(t.info) for t in tables]),
        "start": each("start_angle"),
        "order": each("run_index"),
        "speed": each("speed", SPEED),
        "session": np.unique([t.info.date[:10] for t in tables], return_inverse=True)[1] * 1.0,
    }


def _assemble(
    tables: list[MeasurementTable], stack: dict[str, np.ndarray], steps: np.ndarray
) -> TireRuns:
    facts = _facts(tables)
    position, angle = stack["plank_position"], stack["wheel_angle"]
    radius = facts["radius"]
    if not np.isfinite(radius).all():
        guess = (position[:, -1] - position[:, 0]) / np.maximum(angle[:, -1] - angle[:, 0], 1e-6)
        radius = facts["radius"] = np.where(np.isfinite(radius), radius, np.median(guess))
    grids = grid_groups([_grid_key(t) for t in tables])
    nominal = facts["nominal"]
    step = np.array([_step_place(t) for t in tables])
    since = position - np.where(np.isfinite(step), step, 0.0)[:, None]
    turn = angle - angle[:, :1] + facts["start"][:, None]
    condition, labels = _conditions(tables)
    groups = [np.flatnonzero(condition == c) for c in range(len(labels))]
    common = Common(position, turn, grids, groups)
    load, load_mean = _load(stack.get("fz"), nominal, common)
    channels = tuple(n for n in ("fx", "fy", "fz") if n in stack)
    measured = np.stack([stack[n] - load_mean if n == "fz" else stack[n] for n in channels])
    signs = wrong_signs(tables)
    slip = radius[:, None] * (angle - angle[:, :1]) - (position - position[:, :1])
    usual = float(np.median(nominal))
    stiffness = STIFFNESS * usual / USUAL_LOAD / contact_ratio(usual)
    runs = RunSet(
        names=tuple(t.info.name for t in tables),
        condition=condition,
        condition_names=labels,
        channels=channels,
        measured=measured,
        time=stack["time"] - stack["time"][:, :1],
        order=facts["order"],
        coordinates=_coordinates(stack, position, since, turn, slip, load, facts),
        units=("N",) * len(channels),
        input_noise=tuple(
            stiffness * float(np.median(steps)) if n == "fx" else 0.0 for n in channels
        ),
        roughness=roughness_of(position, usual),
        facts=facts,
        contradicted=tuple(str(sign) for sign in signs),
    )
    return TireRuns(
        runs=runs,
        position=position,
        angle=angle - angle[:, :1],
        travel=steps_along(position),
        turned=steps_along(angle),
        step_time=steps_along(stack["time"]),
        load=load,
        **{name: facts[name] for name in SETTINGS},
        since_step=since,
        wheel_turn=turn,
        signals={name: as_input(stack[name], common) for name in INPUTS if name in stack},
        side_force=side_force(stack.get("fy"), position, facts),
        grids=grids,
        signs=signs,
    )


def roughness_of(position: np.ndarray, load: float) -> np.ndarray:
    """`RunSet.roughness` at plank positions [m] under a load [N]: the start is modelled less
    accurately."""
    return 1.0 + (START_ROUGH - 1.0) * (position < START_TRAVEL * contact_ratio(load))


def steps_along(values: np.ndarray) -> np.ndarray:
    """Difference of each sample (runs, samples) from the one before it, zero for the first."""
    return np.diff(values, axis=-1, prepend=values[..., :1])


def grid_groups(keys: list[tuple]) -> list[np.ndarray]:
    """Indices of the runs of each grid."""
    kinds = {key: None for key in keys}
    return [np.array([i for i, k in enumerate(keys) if k == kind]) for kind in kinds]


def _load(
    fz: np.ndarray | None, nominal: np.ndarray, common: Common
) -> tuple[np.ndarray, np.ndarray]:
    """Load on the tire, and the part of Fz that is not fitted as an output: the mean of the run
    and the profile over the plank that all runs share."""
    if fz is None:
        flat = np.repeat(nominal[:, None], common.position.shape[1], axis=1)
        return flat, flat
    profile = np.zeros_like(fz)
    level = fz.mean(axis=1, keepdims=True)
    for rows in common.grids:
        if len(rows) > 2:
            profile[rows] = (fz[rows] - level[rows]).mean(axis=0)
    return as_load(fz, common), level + profile


def _conditions(tables: list[MeasurementTable]) -> tuple[np.ndarray, tuple[str, ...]]:
    keys = [
        (
            t.info.condition,
            t.info.direction,
            None if np.isnan(t.info.step_position) else t.info.step_position,
            None if np.isnan(t.info.speed) else t.info.speed,
            repr(t.info.waveform),
        )
        for t in tables
    ]
    kinds = sorted(dict.fromkeys(keys), key=lambda k: (k[0].sort_key, repr(k[1:])))
    infos = [tables[keys.index(k)].info for k in kinds]
    return np.array([kinds.index(k) for k in keys]), tuple(_labels(infos))


def _labels(infos: list[RunRecord]) -> Iterator[str]:
    """Name of each condition; where several have the same label, with all in which they differ."""
    words = [
        (
            info.condition.label(),
            info.tire,
            "reverse" if info.direction < 0.0 else "forward",
            "no step" if np.isnan(info.step_position) else f"step at {info.step_position} m",
            "speed not given" if np.isnan(info.speed) else f"{info.speed} m/s",
            " ".join(f"{k} {v}" for k, v in (info.waveform or {"waveform": "step"}).items()),
        )
        for info in infos
    ]
    for label, *own in words:
        alike = zip(*(w[1:] for w in words if w[0] == label), strict=True)
        yield ", ".join([label, *(o for o, a in zip(own, alike, strict=True) if len({*a}) > 1)])


def _coordinates(stack, position, since, turn, slip, load, facts) -> dict[str, Coordinate]:
    shape = position.shape
    pinion = 2.0 * np.pi * position / PINION_TURN

    def per_run(values):
        return np.broadcast_to(values[:, None], shape).copy()

    return {
        "distance since the step": Coordinate(since, "m", 54, local=True),
        "slip travel": Coordinate(slip, "m", 40),
        "plank position": Coordinate(position, "m", 82, local=True),
        "wheel angle": Coordinate(np.mod(turn, 2 * np.pi), "rad", 24, 2 * np.pi),
        "pinion angle": Coordinate(np.mod(pinion, 2 * np.pi), "rad", 24, 2 * np.pi),
        "time": Coordinate(stack["time"] - stack["time"][:, :1], "s", 27),
        "load": Coordinate(load, "N", 12),
        "slip level": Coordinate(per_run(facts["kappa"]), "1", 9),
        "run order": Coordinate(per_run(facts["order"]), "-", 27),
    }


def further_columns(
    tables: Sequence[MeasurementTable], times: Sequence[np.ndarray]
) -> dict[str, Coordinate]:
    """Further columns that all runs have, at the node times [s]."""
    names = [n for n in tables[0].columns if n not in COLUMN_UNITS]
    out = {}
    for column in names:
        if all(t.has(column) for t in tables):
            match = _BRACKETS.match(column.strip())
            name, unit = (match[1], match[2]) if match else (column.strip(), "-")
            rows = [_at(t["time"], t[column], at) for t, at in zip(tables, times, strict=True)]
            out[name] = Coordinate(np.stack(rows), unit or "-", 27)
    return out


def _at(time: np.ndarray, values: np.ndarray, nodes: np.ndarray) -> np.ndarray:
    good = np.isfinite(values) & np.isfinite(time)
    return np.interp(nodes, time[good], values[good])
