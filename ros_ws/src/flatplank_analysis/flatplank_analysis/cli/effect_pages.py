# SPDX-License-Identifier: Apache-2.0
"""Writes a page for every effect of the registry: what it is, a picture of its residual after a
fit of the tire, how to check it, what removes it. Called by `flatplank effects --write DIR`.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from itertools import product
from pathlib import Path

import numpy as np

from flatplank_analysis.contact_patch.data import from_tables
from flatplank_analysis.contact_patch.model import TireModel
from flatplank_analysis.discovery.effect import KINDS, Effect, variants_of
from flatplank_analysis.discovery.gram import solve
from flatplank_analysis.discovery.model import ParameterSet
from flatplank_data.files import write_atomic
from flatplank_data.run_record import RunRecord
from flatplank_data.table import MeasurementTable
from flatplank_data.wording import quantity, span

SLIPS = (-0.10, -0.02, 0.0, 0.02, 0.10)
STARTS = (1, 2)
COLOURS = ("#b2182b", "#ef8a62", "#777777", "#67a9cf", "#2166ac")
WIDTH, HEIGHT, LEFT, BOTTOM = 560, 220, 56, 34
OVER = {"wheel angle": ("wheel angle", "wheel angle [rad]"), "time": ("time", "time [s]")}
"""coordinate of an effect -> coordinate on the x axis, its label; others: plank position"""


@lru_cache(maxsize=1)
def stage() -> TireModel:
    """Tire model on a synthetic campaign whose runs differ in all that effects depend on."""
    runs = product(STARTS, SLIPS)
    return TireModel(from_tables([_table(i, kappa, s) for i, (s, kappa) in enumerate(runs)]))


def _table(index: int, kappa: float, start: int) -> MeasurementTable:
    load, radius = (3700.0, 4300.0)[start - 1], 0.31
    time = np.arange(0.0, 122.0, 0.05)
    plank = np.maximum(time - 1.0, 0.0) * 0.0309
    rolled = np.maximum(plank - 0.0015, 0.0) + kappa * np.maximum(plank - 1.0, 0.0)
    level = 3300.0 * np.tanh(22.0 * kappa)
    after = np.maximum(plank - 1.0, 0.0)
    columns = {
        "time": time,
        "plank_position": plank,
        "wheel_angle": rolled / radius,
        "fx": level * (1.0 - np.exp(-after / 0.35)) - 30.0 * (plank > 0.01),
        "fy": -1100.0 * (1.0 - np.exp(-plank / 0.4)),
        "fz": load + 40.0 * np.sin(2.0 * np.pi * plank / 0.9),
        "mx": 20.0 * np.sin(2.0 * np.pi * plank / 0.8),
        "mz": 20.0 * np.cos(2.0 * np.pi * plank / 0.7),
    }
    info = RunRecord(
        file=f"stage_{index}",
        tire="STAGE",
        kappa=kappa,
        fz=load,
        pressure=2.0 + 0.25 * start,
        alpha_deg=1.0,
        gamma_deg=2.0,
        start=start,
        run_index=index,
        effective_rolling_radius=radius,
        step_position=1.0,
        speed=0.0309,
    )
    return MeasurementTable(columns, info)


def left_by(effect: type[Effect]) -> tuple[np.ndarray, dict[str, float]]:
    """Residual of an effect after a linear fit of the tire model, and its parameter values.

    The residual has shape (channels, runs, samples); of several variants it is the largest one.
    """
    model = stage()
    base = np.array([p.null for p in model.parameters])
    sets = [ParameterSet(base)]
    free = [i for i, p in enumerate(model.parameters) if p.screen and not p.known]
    for i in free:
        moved = base.copy()
        moved[i] += 1e-3 * model.parameters[i].screen
        sets.append(ParameterSet(moved))
    variants = variants_of(effect, model.runs, np.zeros_like(model.runs.measured))
    each = []
    for setting in variants:
        named = {p.name: p.null for p in effect.parameters()} | dict(setting)
        named |= {p.name: p.null + p.screen for p in effect.linear()}
        each.append(named)
        sets.append(ParameterSet(base, ((effect, effect.vector(named)),)))
    out = model.predict(sets)
    own = len(free) + 1
    columns = ((out[1:own] - out[0]) * 1e3).reshape(len(free), -1)
    gram = columns @ columns.T
    changes = (out[own:] - out[0]).reshape(len(variants), -1)
    rest = [change - solve(gram, columns @ change)[0] @ columns for change in changes]
    # of several variants (places, periods) the one with the largest residual
    best = int(np.argmax([np.sum(r**2) for r in rest]))
    return rest[best].reshape(out[0].shape), each[best]


def picture(effect: type[Effect]) -> str:
    """The residual that an effect of its screening size leaves, as SVG."""
    model = stage()
    left, _ = left_by(effect)
    channel = int(np.argmax(np.sum(left**2, axis=(1, 2))))
    name, label = OVER.get(effect.coordinate, ("plank position", "plank position [m]"))
    x = model.runs.coordinates[name].values
    lines = []
    for run, kappa in enumerate(model.data.kappa):
        if run < len(SLIPS):
            lines.append((COLOURS[SLIPS.index(float(kappa))], *_thin(x[run], left[channel, run])))
    return _svg(lines, label, f"{model.runs.channels[channel]} [N]")


def _thin(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Means over groups of samples in the order of x, so that an angle that wraps is sorted."""
    order = np.argsort(x, kind="stable")
    groups = np.array_split(order, 110)
    return (np.array([x[g].mean() for g in groups]), np.array([y[g].mean() for g in groups]))


def _svg(lines, across: str, up: str) -> str:
    low_x, high_x = min(x.min() for _, x, _ in lines), max(x.max() for _, x, _ in lines)
    reach = max(max(abs(y).max() for _, _, y in lines), 0.5)
    span = WIDTH - LEFT - 12

    def place(x: float, y: float) -> str:
        px = LEFT + span * (x - low_x) / (high_x - low_x)
        py = 10 + (HEIGHT - BOTTOM - 10) * (0.5 - 0.5 * y / reach)
        return f"{px:.1f},{py:.1f}"

    middle, floor = 10 + 0.5 * (HEIGHT - BOTTOM - 10), HEIGHT - BOTTOM
    parts = [
        f'''\
<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" \
width="{WIDTH}" height="{HEIGHT}" font-family="sans-serif" font-size="11">
<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>
<path d="M{LEFT},10V{floor}H{WIDTH - 12}M{LEFT},{middle}H{WIDTH - 12}" \
stroke="#bbbbbb" fill="none"/>
<text x="{LEFT - 6}" y="18" text-anchor="end">{reach:.3g}</text>
<text x="{LEFT - 6}" y="{middle + 4}" text-anchor="end">0</text>
<text x="{LEFT - 6}" y="{floor}" text-anchor="end">-{reach:.3g}</text>
<text x="12" y="{middle}" transform="rotate(-90 12 {middle})" text-anchor="middle">{up}</text>
<text x="{LEFT}" y="{floor + 14}">{low_x:.3g}</text>
<text x="{WIDTH - 12}" y="{floor + 14}" text-anchor="end">{high_x:.3g}</text>
<text x="{LEFT + span / 2}" y="{floor + 14}" text-anchor="middle">{across}</text>'''
    ]
    for colour, x, y in lines:
        points = " ".join(place(a, b) for a, b in zip(x, y, strict=True))
        parts.append(f'<polyline points="{points}" fill="none" stroke="{colour}"/>')
    for i, (colour, kappa) in enumerate(zip(COLOURS, SLIPS, strict=True)):
        at = f'x="{LEFT + 70 * i}" y="{HEIGHT - 4}"'
        parts.append(f'<text {at} fill="{colour}">{100 * kappa:+.0f} %</text>')
    return "\n".join([*parts, "</svg>", ""])


def text_of(effect: type[Effect]) -> str:
    """The page of one effect in Markdown."""
    rows = []
    for p in effect.parameters():
        ends = (p.lower, p.upper)
        null, matters = (quantity(v, p.unit, axis=ends) for v in (p.null, p.matters))
        words = p.name, p.title or "-", p.symbol or "-"
        cells = (*words, null, span(*ends, p.unit), matters if p.matters else "-", p.note or "-")
        rows.append(f"| {' | '.join(cells)} |")
    table, name = "\n".join(rows), effect.identifier
    shown = ", ".join(f"{p.name} {quantity(p.null + p.screen, p.unit)}" for p in effect.linear())
    runs = f"\n**Runs that show it.** {effect.shown_by}\n" if effect.shown_by else ""
    return f"""# {effect.title}

`{name}`: {KINDS[effect.kind]}; shows over **{effect.coordinate}**.

**What it is.** {effect.what}

**How to check it.** {effect.check}
{runs}
**What removes it.** {effect.removes}

![what a fit of the tire leaves of it]({name}.svg)

What a fit of the tire leaves of it, for {shown}; one line per slip.

| parameter | title | symbol | null | range | of consequence from | meaning |
|---|---|---|---|---|---|---|
{table}

Source: {effect.source}. Made by `flatplank effects --write docs/reference/effects`.
"""


def index_of(known: Mapping[str, type[Effect]]) -> str:
    """The list of all pages."""
    lines = [
        "# Effects of the library",
        "",
        "Made by `flatplank effects --write docs/reference/effects`.",
        "",
    ]
    for kind, text in KINDS.items():
        lines += [f"## {text[0].upper()}{text[1:]}", ""]
        lines += [
            f"- [{e.title}]({e.identifier}.md) `{e.identifier}`, over {e.coordinate}"
            for e in known.values()
            if e.kind == kind
        ]
        lines.append("")
    return "\n".join(lines)


def write(known: Mapping[str, type[Effect]], folder: Path) -> int:
    """Write all pages; return their number."""
    folder.mkdir(parents=True, exist_ok=True)
    write_atomic(folder / "README.md", index_of(known))
    for effect in known.values():
        write_atomic(folder / f"{effect.identifier}.md", text_of(effect))
        write_atomic(folder / f"{effect.identifier}.svg", picture(effect))
    return len(known)
