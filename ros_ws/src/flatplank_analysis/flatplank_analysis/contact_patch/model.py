# SPDX-License-Identifier: Apache-2.0
"""The base of the search: parameter sets with effects -> forces of all runs."""

from __future__ import annotations

import multiprocessing
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import lru_cache

import numpy as np

from flatplank_analysis.contact_patch import kernel
from flatplank_analysis.contact_patch.grid import SPEED
from flatplank_analysis.contact_patch.parameters import (
    among_loads,
    among_pressures,
    base_parameters,
    laws,
    other_starts,
    with_side_slip,
)
from flatplank_analysis.contact_patch.size import USUAL_HALF, contact_ratio
from flatplank_analysis.contact_patch.tire_runs import TireRuns
from flatplank_analysis.discovery.effect import call_hook, hook_error
from flatplank_analysis.discovery.model import FormError, ParameterSet
from flatplank_analysis.discovery.runs import RunSet
from flatplank_analysis.effects.base import Block, Motion, Node, Signal, Tire
from flatplank_analysis.parallel import available_cores

CHUNK = 48
"""parameter sets computed at once"""
LAW_AMONG_SETTINGS = 0.01
"""`FormError.law` where runs differ in side slip, load or pressure: no scatter of the grip hides
the direction of the two forces together, and another tire's law follows load and pressure
otherwise, which shows as a difference between driving and braking, or as a carcass that follows
the load"""
STRETCH_WITH_SIDE_SLIP = 0.012
"""`FormError.stretch` where runs have side slip: the forces turn while they rise"""
MOST_THREADS = 4
"""most threads that solve blocks at a time; more were not measured"""


@lru_cache(maxsize=1)
def threads() -> ThreadPoolExecutor | None:
    """Threads that solve blocks; none in a worker process, which has one core of its own.

    Asked at the first use: the server that forks workers has imported this file, too.
    """
    count = min(MOST_THREADS, available_cores())
    alone = count == 1 or multiprocessing.parent_process() is not None
    return None if alone else ThreadPoolExecutor(count)


class TireModel:
    """Contact-patch model along (x) and across (y) the wheel; calls the hooks of `TireEffect`."""

    form = FormError(
        0.0012, stretch=0.005, bump=0.002, wave=0.0006, side=0.0018, shift=1.1e-4, reach=USUAL_HALF
    )
    """largest errors on thirteen plants of other form (bristles of the bench, of the blind kit, of
    the tests, and a relaxation), `side` on three of them with side slip; `shift` is the rms of
    nine in the search. 1 N of noise, nothing hidden. `bench-discovery --form` prints them; its
    plain fit of all kinds of tires has a larger `shift`, 0.15 mm"""

    usual_scatter = (0.01, 0.0)
    """assumed scatter of the force (gain, slip offset) from run to run where no repeat shows it.
    Without it, runs that differ by 1 % would show a false friction difference in braking"""

    def __init__(self, data: TireRuns) -> None:
        self.data = data
        self.runs: RunSet = data.runs
        length = contact_ratio(data.reference.load)
        shift, reach = self.form.shift * length, self.form.reach * length
        self.form = replace(self.form, shift=shift, reach=reach)
        if with_side_slip(data):
            self.form = replace(self.form, stretch=STRETCH_WITH_SIDE_SLIP)
        if with_side_slip(data) or among_loads(data) or among_pressures(data):
            self.form = replace(self.form, law=LAW_AMONG_SETTINGS)
        self.laws = laws(data)
        """the law of each run; the pressure does not change its form"""
        self.parameters = base_parameters(data)
        self.starts = other_starts(self.parameters)
        self._names = [p.name for p in self.parameters]
        self._moving = 1.0 - np.exp(-np.maximum(data.position, 0.0) / 0.005)

    def take_references(self, other: TireModel) -> None:
        """Take load, pressure and run order of another campaign as references of effect sizes."""
        self._names = list(other._names)
        self.data = replace(self.data, against=other.data.reference)

    def take_parameters_beside(self, other: TireModel) -> None:
        """Take the parameters that these runs and another campaign determine together."""
        nominal = np.concatenate([other.data.nominal, self.data.nominal])
        pressure = np.concatenate([other.data.pressure, self.data.pressure])
        both = replace(
            other.data, nominal=nominal, pressure=pressure, against=other.data.reference
        )
        self.parameters = base_parameters(both)
        self._names = [p.name for p in self.parameters]

    def scatter_directions(self, base: np.ndarray) -> tuple[dict[str, float], ...]:
        """Directions of the scatter from run to run: gain of both forces, slip offset."""
        value = dict(zip(self._names, base, strict=True))
        gain = ("stiff", "stiff_y", "peak") if "grip_y" in value else ("stiff", "peak")
        return ({name: value[name] for name in gain}, {"slip_offset": 1.0})

    def predict(self, sets: Sequence[ParameterSet]) -> np.ndarray:
        """Predicted channels (sets, channels, runs, samples)."""
        out = np.empty((len(sets), *self.runs.measured.shape))
        kinds: dict[tuple, list[int]] = {}
        for i, one in enumerate(sets):
            kinds.setdefault(tuple(effect for effect, _ in one.effects), []).append(i)
        for effects, rows in kinds.items():
            for start in range(0, len(rows), CHUNK):
                part = rows[start : start + CHUNK]
                for c, channel in enumerate(self._group(effects, [sets[i] for i in part])):
                    out[part, c] = channel
        return out

    def _group(self, effects: tuple, sets: list[ParameterSet]) -> list[np.ndarray]:
        values = np.stack([one.base for one in sets])
        base = {name: values[:, i] for i, name in enumerate(self._names)}
        own = [
            (effect, np.stack([one.effects[i][1] for one in sets]))
            for i, effect in sorted(enumerate(effects), key=lambda item: item[1].order)
        ]
        deep = [(e, e.with_values(v, 2)) for e, v in own]
        if len(sets) > 1 and _alike(values) and all(_alike(v) for e, v in own if _acts_on_tire(e)):
            # parameter sets differ only in what the sensors show: one force for all
            first = [(e, v[:1]) for e, v in own if _acts_on_tire(e)]
            one = {k: v[:1] for k, v in base.items()}
            force = self._forces(one, 1, first, [(e, e.with_values(v, 2)) for e, v in first])
            force = np.broadcast_to(force, (2, len(sets), *force.shape[2:]))
        else:
            force = self._forces(base, len(sets), own, deep)
        return self._signal(base, force, deep)

    def _forces(self, base: dict, sets: int, own: list, deep: list) -> np.ndarray:
        """Forces between tire and road (2, sets, runs, samples)."""
        motion = self._motion(base, sets, deep)
        tire, params = self._tire(base, sets, own, deep)
        return self._force(own, motion, tire, params)

    def _motion(self, base: dict, sets: int, deep: list) -> Motion:
        d = self.data
        shape = (sets, *d.position.shape)
        zero, more, over = np.zeros(sets), d.relative_load - 1.0, d.relative_pressure - 1.0
        # the rolling radius follows load and pressure, whatever radius the runs were made with
        offset = base["slip_offset"][:, None] + base.get("slip_load", zero)[:, None] * more
        offset = offset + base.get("slip_bend", zero)[:, None] * more**2
        offset = offset + base.get("slip_pressure", zero)[:, None] * over
        scale = (1.0 + offset) * d.radius
        rolled = scale[:, :, None] * d.turned
        angle = d.alpha + base.get("angle_offset", zero)[:, None]
        # the road moves at an angle to the wheel plane
        along = np.cos(d.alpha)[:, None] * d.travel
        lateral = -np.tan(angle)[:, :, None] * along
        motion = Motion(d, np.tile(along, (sets, 1, 1)), rolled, lateral)
        if "slip_turned" in base:
            turned = base["slip_turned"][:, None] * (1.0 - np.cos(d.alpha))
            motion.rolled = rolled + turned[:, :, None] * along
        for effect, instance in deep:
            if effect.overrides("motion"):
                _call_hook(effect, instance.motion, motion, ("travel", "rolled", "lateral"), shape)
        return motion

    def _tire(self, base: dict, sets: int, own: list, deep: list) -> tuple[Tire, np.ndarray]:
        d = self.data
        shape = (sets, *d.position.shape)
        params = np.zeros((2, sets, len(d.nominal), kernel.WIDTH))
        self._fill(base, params)
        blocks = [Block(params[axis], kernel.NAMES) for axis in range(2)]
        tire = Tire(d, np.tile(d.load, (sets, 1, 1)), np.ones(shape), *blocks)
        flat = {id(e): e.with_values(v, 1) for e, v in own}
        for effect, instance in deep:
            if effect.overrides("tire"):
                object.__setattr__(instance, "per_run", flat[id(effect)])
                _call_hook(effect, instance.tire, tire, ("load", "friction"), shape)
        return tire, params

    def _fill(self, base: dict, params: np.ndarray) -> None:
        """Fill the tire parameters in x and y, per run."""
        d = self.data
        ratio, over = d.relative_load, d.relative_pressure - 1.0
        zero = np.zeros(len(params[0]))

        def get(name: str) -> np.ndarray:
            return base.get(name, zero)[:, None]

        power = base.get("stiff_load", zero + 1.0)[:, None]
        law = ratio**power * (1.0 + get("stiff_pressure") * over)
        more = ratio - 1.0
        peak = get("peak") * (1.0 + get("peak_load") * more + get("peak_bend") * more**2)
        peak = peak * (1.0 + get("peak_pressure") * over)
        for axis, end in ((0, ""), (1, "_y")):
            p = params[axis]
            p[..., kernel.STIFF] = (get("stiff" + end) if "stiff" + end in base else 1e4) * law
            p[..., kernel.PEAK] = peak * (get("grip_y") if end and "grip_y" in base else 1.0)
            p[..., kernel.CARCASS] = get("carcass" + end) if "carcass" + end in base else 1e5
            for name in [
                "shape",
                "fall",
                "round",
                "tread",
                "patch_order",
                "fixed_length",
                "other_slip",
                "turn_share",
                "turn_rate",
            ]:
                p[..., kernel.NAMES.index(name)] = get(name)
            p[..., kernel.HALF] = get("half") * np.sqrt(ratio)
            p[..., kernel.LOAD_SHARE] = get("load_share") if "load_share" in base else 1.0
            p[..., kernel.PLAY_SOFT] = 10.0
            p[..., kernel.CREEP_TIME] = 10.0
        params[0, ..., kernel.DENOM] = get("denom")
        params[1, ..., kernel.TURN] = get("turn_y") * get("denom")
        params[1, ..., kernel.START] = d.side_force

    def _force(self, own: list, motion: Motion, tire: Tire, params: np.ndarray) -> np.ndarray:
        d = self.data
        sets, runs, samples = motion.travel.shape
        count = sets * runs

        def flat(a: np.ndarray) -> np.ndarray:
            return np.ascontiguousarray(a).reshape(count, samples)

        ds, load, friction = flat(motion.travel), flat(tire.load), flat(tire.friction)
        dw = np.stack([flat(motion.rolled - motion.travel), flat(motion.lateral)])
        dt = np.tile(d.step_time, (sets, 1))
        nominal = np.tile(d.nominal, sets)
        block = params.reshape(2, count, kernel.WIDTH)
        force = np.empty((2, count, samples))
        across = 1 if block[..., kernel.OTHER_SLIP].any() else None
        if any(effect.overrides("node") for effect, _ in own):
            given = ds, dw, dt, load, friction
            self._solve_by_node(own, (sets, runs), given, block, nominal, force, across)
        else:
            todo = _distinct_sets(sets, dw.reshape(2, sets, -1), params, ds, load, friction)

            def part(blocks: np.ndarray, do_x: bool, do_y: bool) -> None:
                kernel.sweep(
                    blocks, do_x, do_y, ds, dw, dt, load, friction, block, nominal, SPEED, force,
                    across,
                )  # fmt: skip

            pool = threads()
            jobs = _jobs(todo, params, 4 * MOST_THREADS if pool else 1)
            each = pool.map if pool else map
            list(each(lambda job: part(*job), jobs))
            shaped = force.reshape(2, sets, runs, samples)
            for axis in range(2):
                shaped[axis, ~todo[axis]] = shaped[axis, 0]
        return force.reshape(2, sets, runs, samples)

    def _solve_by_node(self, own, shape, given, block, nominal, force, across) -> None:
        """Solve node by node, with the effects that need the last force."""
        ds, dw, dt, load, friction = given
        blocks = kernel.blocks_of(np.arange(len(ds)))
        states = kernel.rest(blocks, block, nominal)
        last = np.zeros((2, len(ds), 1))
        active = [e.with_values(v, 1) for e, v in own if e.overrides("node")]
        nodes = [Node(self.data) for _ in active]
        for n in range(ds.shape[1]):
            now = [ds[:, n], dw[0, :, n], dw[1, :, n], load[:, n], friction[:, n]]
            for effect, node in zip(active, nodes, strict=True):
                node.index = n
                node.force_x, node.force_y = (f.reshape(shape).copy() for f in last)
                names = ("travel", "slip", "lateral", "load", "friction")
                for name, value in zip(names, now, strict=True):
                    setattr(node, name, value.reshape(shape).copy())
                _call_hook(type(effect), effect.node, node, names, shape)
                now = [np.reshape(getattr(node, k), -1) for k in names]
            travel, slip, lateral, w, mu = (np.ascontiguousarray(a)[:, None] for a in now)
            both, time = np.stack([slip, lateral]), np.ascontiguousarray(dt[:, n : n + 1])
            kernel.one_node(states, blocks, travel, both, time, w, mu, SPEED, last, across)
            force[:, :, n] = last[:, :, 0]

    def _signal(self, base: dict, force: np.ndarray, deep: list) -> list[np.ndarray]:
        rolling = base["fx_offset"][:, None, None] * self._moving
        fx = force[0] + rolling + base["fx_zero"][:, None, None]
        signal = Signal(self.data, fx, force[1].copy(), np.zeros_like(fx), force[0], force[1])
        names = self.runs.channels
        for effect, instance in deep:
            if effect.overrides("signal"):
                _call_hook(effect, instance.signal, signal, names, force.shape[1:])
        if "fz" in names and np.any(signal.fz):
            signal.fz = self.data.only_common(signal.fz)
        return [getattr(signal, name) for name in names]


def _alike(values: np.ndarray) -> bool:
    return not (values != values[0]).any()


def _acts_on_tire(effect) -> bool:
    """True when an effect acts between tire and road, not only on the sensors."""
    return any(effect.overrides(hook) for hook in ("motion", "tire", "node"))


def _call_hook(effect, hook, argument, names: Sequence[str], shape: tuple[int, ...]) -> None:
    """Call a hook; the arrays that it may change must keep their shape."""
    call_hook(effect, hook, argument)
    for name in names:
        found = np.shape(getattr(argument, name))
        if found != shape:
            raise hook_error(effect, hook, f"'{name}' has shape {found}, not {shape}")


def _jobs(
    todo: np.ndarray, params: np.ndarray, parts: int
) -> Iterator[tuple[np.ndarray, bool, bool]]:
    """Blocks of elements and the directions to solve, in so many jobs of each kind.

    Both directions are solved where they depend on each other, by friction or a compliant drive.
    """
    runs = params.shape[2]
    give = params[0, ..., kernel.GIVE] * params[1, ..., kernel.TURN]
    coupled = params[..., kernel.OTHER_SLIP].any(axis=(0, 2)) | give.any(axis=1)
    alone = ~coupled
    for wanted, do_x, do_y in (
        (coupled & todo.any(axis=0), True, True),
        (alone & todo[0], True, False),
        (alone & todo[1], False, True),
    ):
        blocks = kernel.blocks_of(np.flatnonzero(np.repeat(wanted, runs)))
        for part in np.array_split(blocks, parts):
            if len(part):
                yield part, do_x, do_y


def _distinct_sets(sets: int, dw, params, ds, load, friction) -> np.ndarray:
    """(2, sets): False where a set has the same inputs as the first one in that direction."""
    out = np.ones((2, sets), dtype=bool)
    common = [a.reshape(sets, -1) for a in (ds, load, friction)]
    for i in range(1, sets):
        if params[:, i, :, kernel.OTHER_SLIP].any() or params[:, 0, :, kernel.OTHER_SLIP].any():
            continue
        if not all(np.array_equal(a[i], a[0]) for a in common):
            continue
        moved = [not np.array_equal(dw[axis, i], dw[axis, 0]) for axis in range(2)]
        give = params[0, :, :, kernel.GIVE]
        own = moved[0] or not np.array_equal(give[i], give[0])
        moved[1] |= own and bool(params[1, i, :, kernel.TURN].any())
        for axis in range(2):
            same = np.array_equal(params[axis, i], params[axis, 0])
            out[axis, i] = moved[axis] or not same
    return out
