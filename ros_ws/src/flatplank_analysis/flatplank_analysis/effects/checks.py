# SPDX-License-Identifier: Apache-2.0
"""The contract of an effect, tested on a small simulated campaign; the same for every effect."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from flatplank_analysis.contact_patch.tire_runs import coordinates_of
from flatplank_analysis.discovery.effect import KINDS, Effect, call_hook, variants_of
from flatplank_analysis.discovery.model import ParameterSet
from flatplank_analysis.discovery.runs import Coordinate, RunSet
from flatplank_analysis.effects.base import TireEffect
from flatplank_analysis.effects.registry import library
from flatplank_data.errors import FlatplankError
from flatplank_data.names import similar_names
from flatplank_data.run_record import RunRecord
from flatplank_data.table import MeasurementTable

HOOKS = ("motion", "tire", "node", "signal")
"""what an effect may change"""
TEXTS = ("identifier", "title", "coordinate", "source", "what", "check", "removes")


@lru_cache(maxsize=1)
def probe_model():
    """A model of eight simulated runs over the whole plank that differ in everything an effect may
    depend on."""
    from flatplank_analysis.contact_patch.data import from_tables
    from flatplank_analysis.contact_patch.model import TireModel

    settings = itertools.product((-0.1, -0.01, 0.01, 0.1), (1, 2))
    return TireModel(from_tables([_probe_table(i, *s) for i, s in enumerate(settings)]))


def probe_of(effect: type[Effect]):
    """The model of `probe_model`, with the coordinates of `ranges` varied over their range."""
    from flatplank_analysis.contact_patch.model import TireModel

    ranges, model = getattr(effect, "ranges", {}), probe_model()
    if not ranges:
        return model
    shape = model.data.position.shape
    more = {
        name: Coordinate(np.broadcast_to(np.linspace(low, high, shape[1]), shape))
        for name, (low, high) in ranges.items()
    }
    return TireModel(replace(model.data, further=more))


def _probe_table(index: int, kappa: float, start: int) -> MeasurementTable:
    rng = np.random.default_rng(index)
    load, speed, radius = (3000.0, 4500.0, 6000.0)[index % 3], 0.085, 0.31
    time = np.arange(0.0, 50.0, 0.05)
    plank = np.maximum(time - 1.0, 0.0) * speed
    rolled = np.maximum(plank - 0.0015, 0.0) + kappa * np.maximum(plank - 0.7, 0.0)
    fx = 3000.0 * np.tanh(20.0 * kappa) * (1.0 - np.exp(-np.maximum(plank - 0.7, 0.0) / 0.3))
    noise = rng.normal(0.0, 5.0, (5, len(time)))
    wavy = 20.0 * np.sin(2.0 * np.pi * plank / 0.4)
    columns = {
        "time": time,
        "plank_position": plank,
        "wheel_angle": rolled / radius,
        "fx": fx - 100.0 * (plank > 0.01) + noise[0],
        "fy": -600.0 * (1.0 - np.exp(-plank / 0.4)) + noise[1],
        "fz": load + wavy + noise[2],
        "mx": 10.0 * np.sin(plank) + noise[3],
        "mz": 20.0 * np.cos(plank) + noise[4],
    }
    info = RunRecord(
        file=f"probe_{index}", tire="PROBE", kappa=kappa, fz=load, pressure=2.0 + 0.5 * start,
        alpha_deg=1.0, gamma_deg=2.0, start=start, run_index=index,
        effective_rolling_radius=radius, step_position=0.7, speed=speed,
    )  # fmt: skip
    return MeasurementTable(columns, info)


def check_effect(effect: type[Effect]) -> list[str]:
    """Violations of the contract by an effect, one line each; empty when there are none."""
    try:
        return list(_texts(effect)) or list(_behaviour(effect))
    except FlatplankError as error:
        hook = error.where.removeprefix(f"effect {effect.identifier}").lstrip(", ")
        return [f"{hook}: {error.what}" if hook else error.what]


def sound_library(files: Iterable[str | Path] = ()) -> dict[str, type[Effect]]:
    """The library with the effects of the user's files; FlatplankError for one that violates the
    contract."""
    known = library(files)
    for effect in known.values():
        faults = check_effect(effect) if effect.file else []
        if faults:
            remedy = "mend the file; `flatplank effects check FILE` tests it"
            raise FlatplankError(faults[0], f"{effect.file}, effect {effect.identifier}", remedy)
    return known


def _texts(effect: type[Effect]) -> Iterator[str]:
    for name in TEXTS:
        if not str(getattr(effect, name, "")).strip():
            yield f"'{name}' is missing"
    if effect.kind not in KINDS:
        yield f"kind '{effect.kind}' is not one of {', '.join(KINDS)}"
    if not effect.identifier.replace("_", "").isalnum() or not effect.identifier.islower():
        yield "identifier: small letters, digits and _ only"
    shipped = library().get(effect.identifier, effect)
    if shipped is not effect:
        yield f"identifier: '{effect.identifier}' is an effect of the library already"
    places = coordinates_of(probe_of(effect).data)
    if effect.coordinate and effect.coordinate not in places:
        yield f"coordinate '{effect.coordinate}' is not one of {', '.join(places)}"
    if not effect.linear():
        yield "no parameter has a screening step: param(..., screen=...)"
        return
    for p in effect.parameters():
        if hasattr(TireEffect, p.name):
            yield f"{p.name}: a hook has this name: choose another one for the parameter"
        if not p.unit:
            yield f"{p.name}: no unit"
        if not p.lower <= p.null <= p.upper:
            yield f"{p.name}: the null {p.null:g} is outside of {p.lower:g} .. {p.upper:g}"
        if p.screen and not p.lower <= p.null + p.screen <= p.upper:
            yield f"{p.name}: the screening step leaves the range"
    if effect.main_parameter().matters <= 0.0:
        yield f"{effect.main_parameter().name}: no size that matters: param(..., matters=...)"


def _behaviour(effect: type[Effect]) -> Iterator[str]:
    model = probe_of(effect)
    base = np.array([p.null for p in model.parameters])
    at = {p.name: i for i, p in enumerate(model.parameters)}
    base[at["angle_offset"]] = 0.002
    plain = model.predict([ParameterSet(base)])[0]
    residual = model.runs.measured - plain
    settings = variants_of(effect, model.runs, residual)
    if not settings:
        yield "variants() gave nothing"
        return
    for setting in settings:
        null = effect.vector(dict(setting))
        if not np.array_equal(model.predict([ParameterSet(base, ((effect, null),))])[0], plain):
            yield f"changes the prediction at its null ({setting or 'all null'})"
            return
    sets, names = _sets(effect, base, settings[0])
    together = model.predict(sets)
    if not np.isfinite(together).all():
        bad = [n for n, t in zip(names, together, strict=True) if not np.isfinite(t).all()]
        yield f"gives NaN or infinity at {', '.join(bad)}"
        return
    for one, both, name in zip(sets, together, names, strict=True):
        if not np.array_equal(model.predict([one])[0], both):
            yield f"parameter sets influence each other ({name})"
            return
    yield from _other_hooks(effect, model.runs)
    for p, out in zip(effect.linear(), together, strict=False):
        if not np.abs(out - plain).max() > 1e-6:
            yield f"{p.name}: nothing changes at the screening step{_misspelt(effect)}"


def _misspelt(effect: type[Effect]) -> str:
    """Methods that look like a misspelt hook, with all hooks."""
    own = [n for n in vars(effect) if not n.startswith("_") and callable(getattr(effect, n))]
    unknown = [n for n in own if not hasattr(TireEffect, n)]
    near = [f"'{n}' is no hook" for n in unknown if similar_names(n, HOOKS)]
    return f"; {', '.join(near)}; the hooks are {', '.join(HOOKS)}" if near else ""


def _other_hooks(effect: type[Effect], runs: RunSet) -> Iterator[str]:
    own = {p.name: p.null for p in effect.parameters()}
    for name in call_hook(effect, effect.held):
        if name not in own:
            yield f"held() names '{name}', which is no parameter"
    if not np.isfinite(call_hook(effect, effect.size, own)):
        yield "size() is not finite at the null"
    if not call_hook(effect, effect.starts):
        yield "starts() gave nothing"
    if call_hook(effect, effect.scanned, runs) < 1:
        yield "scanned() is below 1"


def _sets(effect: type[Effect], base: np.ndarray, setting) -> tuple[list[ParameterSet], list[str]]:
    """Sets with the screening step of each parameter, then with the ends of the ranges."""
    sets, names = [], []
    for p in effect.linear():
        values = effect.vector(dict(setting) | {p.name: p.null + p.screen})
        sets.append(ParameterSet(base, ((effect, values),)))
        names.append(f"{p.name} = {p.null + p.screen:g}")
    for p in effect.parameters():
        for end in (p.lower, p.upper):
            if np.isfinite(end):
                sets.append(
                    ParameterSet(base, ((effect, effect.vector(dict(setting) | {p.name: end})),))
                )
                names.append(f"{p.name} = {end:g}")
    return sets, names
