# SPDX-License-Identifier: Apache-2.0
"""From a campaign to aligned runs: filtered increments of position and angle, load, forces."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from flatplank_analysis.contact_patch.before import side_before
from flatplank_analysis.contact_patch.denoising import Common, as_input, as_load
from flatplank_analysis.contact_patch.further import coordinate_of, further_columns
from flatplank_analysis.contact_patch.grid import (
    BEFORE,
    SPEED,
    START,
    node_positions,
    smooth_columns,
    uniform_positions,
)
from flatplank_analysis.contact_patch.references import References
from flatplank_analysis.contact_patch.rest import at_rest, steps_of
from flatplank_analysis.contact_patch.side_force import side_force
from flatplank_analysis.contact_patch.signs import WrongSign, wrong_signs
from flatplank_analysis.contact_patch.truncated import ended_early
from flatplank_analysis.discovery.runs import Coordinate, RunSet
from flatplank_data.campaign import Campaign
from flatplank_data.errors import FlatplankError, NothingUsableError
from flatplank_data.problem import Problem, problem_of
from flatplank_data.table import MeasurementTable

COLUMNS = ("time", "plank_position", "wheel_angle", "fx", "fy", "fz", "mx", "mz")
NEEDED = ("time", "plank_position", "wheel_angle", "fx")
INPUTS = ("fy", "fz", "mx", "mz")
"""channels that may speak over into Fx"""
STIFFNESS = 1.9e5
"""[N/m] of a car tire in x for short waves: what a step of an encoder is worth"""
START_TRAVEL, START_ROUGH = 0.08, 2.5
"""[m], 1: over the first travel the locked tire is only roughly modelled, the same in all runs, so
that no scatter would warn"""
PINION_TURN = 2.0 * np.pi * 0.05
"""[m] plank travel of one pinion turn, placeholder of the bench"""


@dataclass(frozen=True)
class TireRuns:
    """Inputs of the tire model on the nodes; arrays (runs, samples) unless said otherwise."""

    runs: RunSet
    position: np.ndarray
    """plank travel [m]"""
    angle: np.ndarray
    """wheel angle since the start [rad]"""
    travel: np.ndarray
    """increments of plank travel [m]; first column 0"""
    turned: np.ndarray
    """increments of the wheel angle [rad]; first column 0"""
    step_time: np.ndarray
    """increments of time [s]; first column 0"""
    load: np.ndarray
    """denoised vertical load [N]"""
    nominal: np.ndarray
    """(runs,) nominal load [N]"""
    radius: np.ndarray
    """(runs,) effective rolling radius [m]"""
    alpha: np.ndarray
    """(runs,) side slip angle [rad]"""
    gamma: np.ndarray
    """(runs,) camber [rad]"""
    kappa: np.ndarray
    """(runs,) commanded slip"""
    pressure: np.ndarray
    """(runs,) [bar]"""
    since_step: np.ndarray
    """travel since the step [m], negative before"""
    wheel_turn: np.ndarray
    """wheel angle in space, start angle included [rad]"""
    signals: dict[str, np.ndarray]
    """measured channels as inputs, without their noise"""
    load_mean: np.ndarray
    """(runs, samples) what the load channel is judged against"""
    side_force: np.ndarray
    """(runs,) Fy of a turned wheel before the plank moves [N]; 0 where the wheel is straight"""
    grids: list[np.ndarray]
    """runs that share their nodes"""
    signs: tuple[WrongSign, ...] = ()
    """columns and keys whose sign is the other way round"""
    further: Mapping[str, Coordinate] = field(default_factory=dict)
    """columns of other names that all runs have: what was recorded beside the channels"""
    against: References | None = None
    """of another campaign, whose fit these runs are asked about"""

    @cached_property
    def reference(self) -> References:
        """What the sizes of effects are told against."""
        return self.against or References.of(self)

    @cached_property
    def side_before(self) -> np.ndarray:
        """(runs,) sign of the last slip before each run; 0 where none is known."""
        return side_before(self.runs.order, self.kappa)

    def coordinate(self, name: str) -> np.ndarray:
        """A coordinate of the runs, a channel, or a further column by name (runs, samples)."""
        return coordinate_of(self, name).values

    def only_common(self, values: np.ndarray) -> np.ndarray:
        """Remove the run mean and the profile shared by all runs on the same nodes (..., R, N)."""
        out = values - values.mean(axis=-1, keepdims=True)
        for rows in self.grids:
            if len(rows) > 2:
                out[..., rows, :] -= out[..., rows, :].mean(axis=-2, keepdims=True)
        return out


def load_runs(campaign: Campaign) -> TireRuns:
    """Read the slip runs of a campaign; unusable ones, and channels that only some runs have,
    are told in `campaign.problems`. NothingUsableError when no run is left."""
    tables = []
    for run in campaign.runs:
        if run.info.measurement != "slip":
            continue
        table = campaign.try_table(run, COLUMNS, further=True)
        if table is None:
            continue
        try:
            _require(table)
        except FlatplankError as error:
            campaign.note(problem_of(error, run.info.file))
            continue
        tables.append(table)
    if not tables:
        first = next((f" (first problem: {p})" for p in campaign.problems if p.fatal), "")
        raise NothingUsableError(
            f"no usable slip run{first}", campaign.path, "measure runs with a slip step"
        )
    short = {i: _short(tables[i], *travels) for i, *travels in ended_early(tables)}
    tables = [t for i, t in enumerate(tables) if i not in short]
    for problem in (*short.values(), *_dropped(tables)):
        campaign.note(problem)
    return from_tables(tables)


def _short(table: MeasurementTable, travel: float, usual: float) -> Problem:
    return Problem(
        table.info.file,
        f"{travel:.2f} m of road, {usual:.2f} m is usual for its step: not used",
        remedy="measure it again, or delete it",
    )


def _require(table: MeasurementTable) -> None:
    for need in NEEDED:
        if not table.has(need):
            raise FlatplankError(
                f"no '{need}': not used", table.info.file, "add the column, or leave the run out"
            )


def _common(tables: list[MeasurementTable]) -> list[str]:
    """Channels that every run has, `time` not among them."""
    return [n for n in COLUMNS[1:] if all(t.has(n) for t in tables)]


def _dropped(tables: list[MeasurementTable]) -> Iterator[Problem]:
    """Channels that some runs have and others lack: the search goes without them."""
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
    """Align the runs of a list of measurement tables, with the channels that all of them have."""
    for table in tables:
        _require(table)
    names = _common(tables)
    smooth = [_smooth(table, names) for table in tables]
    ends = _common_ends(tables, smooth)
    nodes = [_nodes(s, t, e) for s, t, e in zip(smooth, tables, ends, strict=True)]
    count = min(len(n) for n in nodes)
    picked = [_pick(s, n[:count]) for s, n in zip(smooth, nodes, strict=True)]
    stack = {name: np.stack([p[name] for p in picked]) for name in picked[0]}
    times = [n[:count] for n in nodes]
    data = _assemble(tables, stack, np.array([float(s["step"]) for s in smooth]))
    if not data.runs.repeated:
        rest, steps = at_rest(smooth, data.runs.channels), steps_of(tables, data.runs.channels)
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
    """Place of the step in travel from the first sample [m]; NaN where there is none.

    It is recorded as a plank position, and the plank of the bench begins 2 cm before zero.
    """
    place = table["plank_position"]
    place = place[np.isfinite(place)]
    forward = place[-1] > place[0]
    return table.info.step_position - (float(place[0]) if forward else 0.0)


def _common_ends(tables: list[MeasurementTable], smooth: list[dict]) -> list[float]:
    """Runs with the same step end at the same node."""
    keys = [_grid_key(t) for t in tables]
    ends = [float(s["plank_position"].max()) for s in smooth]
    return [
        min(e for e, other in zip(ends, keys, strict=True) if other == key) - 0.004 for key in keys
    ]


def _grid_key(table: MeasurementTable) -> tuple:
    step = table.info.step_position
    return (None if step != step else round(step, 4), table.info.waveform is not None)


def _nodes(smooth: dict, table: MeasurementTable, end: float) -> np.ndarray:
    """Times of the nodes of one run [s]."""
    position, time = smooth["plank_position"], smooth["time"]
    began = int(np.argmax(position > START))
    stretch = SPEED / max(float(smooth["speed"]), 1e-4)
    before = time[began] + stretch * np.array([-BEFORE, -0.3, -0.2, -0.15, -0.1, -0.05, 0.0])
    step = table.info.step_position
    waveform = table.info.waveform
    shape = str((waveform or {}).get("kind", (waveform or {}).get("shape", "step")))
    places = uniform_positions(end) if shape != "step" else node_positions(step, end)
    places = places[places > position[began] + 1e-4]
    rising = np.maximum.accumulate(position[began:])
    keep = np.concatenate([[True], np.diff(rising) > 0.0])
    at = np.interp(places, rising[keep], time[began:][keep])
    return np.concatenate([np.maximum(before, time[0]), at])


def _pick(smooth: dict, nodes: np.ndarray) -> dict[str, np.ndarray]:
    skip = ("time", "speed", "step")
    return {"time": nodes} | {
        k: np.interp(nodes, smooth["time"], v) for k, v in smooth.items() if k not in skip
    }


def _facts(tables: list[MeasurementTable]) -> dict[str, np.ndarray]:
    def each(get):
        return np.array([get(t.info) for t in tables], dtype=float)

    return {
        "nominal": each(lambda i: i.fz if i.fz == i.fz else 4000.0),
        "radius": each(lambda i: i.effective_rolling_radius),
        "alpha": np.radians(each(lambda i: i.alpha_deg)),
        "gamma": np.radians(each(lambda i: i.gamma_deg)),
        "kappa": each(lambda i: i.kappa),
        "pressure": each(lambda i: i.pressure if i.pressure == i.pressure else 2.5),
        "step": each(lambda i: i.step_position),
        "start": each(lambda i: i.start_angle),
        "order": each(lambda i: i.run_index),
        "speed": each(lambda i: i.speed if i.speed == i.speed else SPEED),
        "session": _sessions(tables),
    }


def _sessions(tables: list[MeasurementTable]) -> np.ndarray:
    """Number of the day on which each run was made; without a date all are of one session."""
    days = [t.info.date[:10] for t in tables]
    return np.array([sorted(set(days)).index(day) for day in days], dtype=float)


def _assemble(
    tables: list[MeasurementTable], stack: dict[str, np.ndarray], steps: np.ndarray
) -> TireRuns:
    facts = _facts(tables)
    position, angle = stack["plank_position"], stack["wheel_angle"]
    radius = facts["radius"]
    if not np.isfinite(radius).all():
        guess = (position[:, -1] - position[:, 0]) / np.maximum(angle[:, -1] - angle[:, 0], 1e-6)
        radius = facts["radius"] = np.where(np.isfinite(radius), radius, np.median(guess))
    grids = _grid_groups([_grid_key(t) for t in tables])
    nominal = facts["nominal"]
    step = np.array([_step_place(t) for t in tables])
    since = position - np.where(np.isfinite(step), step, 0.0)[:, None]
    turn = angle - angle[:, :1] + facts["start"][:, None]
    condition, labels = _conditions(tables)
    groups = [np.flatnonzero(condition == c) for c in range(len(labels))]
    common = Common(position, turn, grids, groups)
    load, load_mean = _load(stack.get("fz"), nominal, common)
    channels, measured = _channels(stack, load_mean)
    signs = wrong_signs(tables)
    slip = radius[:, None] * (angle - angle[:, :1]) - (position - position[:, :1])
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
            STIFFNESS * float(np.median(steps)) if n == "fx" else 0.0 for n in channels
        ),
        roughness=1.0 + (START_ROUGH - 1.0) * (position < START_TRAVEL),
        facts=facts,
        contradicted=tuple(str(sign) for sign in signs),
    )
    return TireRuns(
        runs=runs,
        position=position,
        angle=angle - angle[:, :1],
        travel=_steps(position),
        turned=_steps(angle),
        step_time=_steps(stack["time"]),
        load=load,
        nominal=nominal,
        radius=radius,
        alpha=facts["alpha"],
        gamma=facts["gamma"],
        kappa=facts["kappa"],
        pressure=facts["pressure"],
        since_step=since,
        wheel_turn=turn,
        signals={name: as_input(stack[name], common) for name in INPUTS if name in stack},
        load_mean=load_mean,
        side_force=side_force(stack.get("fy"), position, facts),
        grids=grids,
        signs=signs,
    )


def _steps(values: np.ndarray) -> np.ndarray:
    return np.diff(values, axis=-1, prepend=values[..., :1])


def _grid_groups(keys: list[tuple]) -> list[np.ndarray]:
    kinds = {key: None for key in keys}
    return [np.array([i for i, k in enumerate(keys) if k == kind]) for kind in kinds]


def _load(
    fz: np.ndarray | None, nominal: np.ndarray, common: Common
) -> tuple[np.ndarray, np.ndarray]:
    """Load for the tire, and the part of it that the load channel does not judge: the mean of
    the run and the profile over the plank that all runs share."""
    if fz is None:
        flat = np.repeat(nominal[:, None], common.position.shape[1], axis=1)
        return flat, flat
    profile = np.zeros_like(fz)
    level = fz.mean(axis=1, keepdims=True)
    for rows in common.grids:
        if len(rows) > 2:
            profile[rows] = (fz[rows] - level[rows]).mean(axis=0)
    return as_load(fz, common), level + profile


def _channels(
    stack: dict[str, np.ndarray], load_mean: np.ndarray
) -> tuple[tuple[str, ...], np.ndarray]:
    names = [n for n in ("fx", "fy", "fz") if n in stack]
    values = [stack[n] - load_mean if n == "fz" else stack[n] for n in names]
    return tuple(names), np.stack(values)


def _conditions(tables: list[MeasurementTable]) -> tuple[np.ndarray, tuple[str, ...]]:
    keys = [
        (
            t.info.condition,
            t.info.direction,
            None if t.info.step_position != t.info.step_position else t.info.step_position,
            None if t.info.speed != t.info.speed else t.info.speed,
            repr(t.info.waveform),
        )
        for t in tables
    ]
    kinds = sorted(dict.fromkeys(keys), key=lambda k: (k[0].sort_key, repr(k[1:])))
    labels = [k[0].label() for k in kinds]
    for i, k in enumerate(kinds):
        if labels.count(k[0].label()) > 1:
            labels[i] += f", step at {k[2]} m, {k[3] or SPEED} m/s"
    return np.array([kinds.index(k) for k in keys]), tuple(labels)


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
        "run order": Coordinate(per_run(facts["order"]), "1", 27),
    }
