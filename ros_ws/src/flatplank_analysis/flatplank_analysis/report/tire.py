# SPDX-License-Identifier: Apache-2.0
"""Which tire a fit and a report are of: the record that is given, else one made from the data."""

from __future__ import annotations

import math
import os
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from flatplank_analysis.models.tire_record import (
    FILE,
    TYPICAL_DEFLECTION,
    TireRecord,
    parse_record,
    read_record,
)
from flatplank_analysis.report.extras import other_measurements
from flatplank_data.campaign import Campaign, Run
from flatplank_data.errors import FlatplankError
from flatplank_data.run_record import RunRecord

BY_ROLLING = 1.022
"""R0 over r_e where nothing else tells R0: 318 mm over 310.8 mm, thesis Tables 5.1, 5.2"""
UNTOLD = {"nominal_load": 4000.0, "nominal_pressure": 2.5}
"""[N], [bar] where no run tells them"""
APART = 1.2
"""loads of this ratio tell R0 by a line through the loaded radii"""


def record_for(
    campaigns: Sequence[Campaign], file: str | os.PathLike[str] | None = None
) -> TireRecord:
    """The record of `file`, else `tire.yaml` of a folder, else one made from the data."""
    record = read_record(file) if file else _of_folders(campaigns)
    return record or made_from(campaigns)


def tires_of(campaigns: Sequence[Campaign]) -> list[str]:
    """Names of the tires in the run records, each once."""
    names = [info.tire for c in campaigns for info in c.infos if info.tire]
    return list(dict.fromkeys(names))


def _of_folders(campaigns: Sequence[Campaign]) -> TireRecord | None:
    stores = {id(run.store): run.store for c in campaigns for run in c.runs}
    for store in stores.values():
        if store.exists(FILE):
            with store.open(FILE) as stream:
                raw: bytes | str = stream.read()
            text = raw.decode("utf-8") if isinstance(raw, bytes) else raw
            return replace(parse_record(text, FILE), origin=f"{FILE} of the folder")
    return None


def made_from(campaigns: Sequence[Campaign]) -> TireRecord:
    """Nominal load and pressure of most runs; R0 by what was measured, best source first."""
    runs = [run for c in campaigns for run in c.runs]
    load, bar = (_usual([getattr(r.info, n) for r in runs]) for n in ("fz", "pressure"))
    unknown = [n for n, v in zip(UNTOLD, (load, bar), strict=True) if not math.isfinite(v)]
    load, bar = (
        v if math.isfinite(v) else u for v, u in zip((load, bar), UNTOLD.values(), strict=True)
    )
    sources = (_by_print, _by_stiffness, _by_loaded_radius, _by_rolling_radius)
    found = (source(campaigns, runs, load, bar) for source in sources)
    radius, how = next((f for f in found if f is not None), (0.3, "a placeholder: not measured"))
    names = tires_of(campaigns)
    origin = f"made from the data: load and pressure of most runs, R0 {how}"
    if unknown:
        origin += f"; no run tells {' and '.join(unknown)}: a placeholder"
    name = names[0] if names else ""
    return TireRecord(name, round(radius, 5), load, bar, placeholder=tuple(unknown), origin=origin)


def _usual(values: Sequence[float]) -> float:
    """The value of most runs; of several the middle one, the upper of two."""
    counts = Counter(v for v in values if math.isfinite(v) and v > 0.0)
    most = max(counts.values(), default=0)
    best = sorted(v for v, n in counts.items() if n == most)
    return best[len(best) // 2] if best else math.nan


Radius = tuple[float, str]


def _by_print(campaigns: Sequence[Campaign], runs: Sequence[Run], load: float, bar: float):
    told = [run.info.extra.get("free_radius") for run in runs]
    return next(((float(v), "of a run record") for v in told if v), None)


def _by_stiffness(
    campaigns: Sequence[Campaign], runs: Sequence[Run], load: float, bar: float
) -> Radius | None:
    """Where the line of a vertical stiffness run reaches Fz = 0."""
    found = [
        r
        for c in campaigns
        for r in other_measurements(c, ("stiffness",)).get("vertical_stiffness", [])
    ]
    if not found:
        return None
    run = min(found, key=lambda r: abs(r["pressure"] - bar))
    radius, force = np.asarray(run["loaded_radius"]), np.asarray(run["fz"])
    inside = (radius >= run["window"][0]) & (radius <= run["window"][1]) & (force > 0.0)
    value = float(np.mean(radius[inside] + force[inside] / run["mean"]))
    return value, "where a stiffness run reaches Fz = 0"


def _by_loaded_radius(
    campaigns: Sequence[Campaign], runs: Sequence[Run], load: float, bar: float
) -> Radius | None:
    """A line through the loaded radii of several loads; of one load with a usual deflection."""
    points = []
    for fz in sorted({r.info.fz for r in runs if _plain(r.info, bar)}):
        run = next(r for r in runs if _plain(r.info, bar) and r.info.fz == fz)
        try:
            table, _ = run.read(("fz", "loaded_radius"))
        except FlatplankError:
            continue
        if table.has("loaded_radius") and table.has("fz"):
            points.append(
                (float(np.median(table["fz"])), float(np.median(table["loaded_radius"])))
            )
    if not points:
        return None
    fz, radius = np.array(points).T
    if fz.max() > APART * fz.min():
        return float(np.polyfit(fz, radius, 1)[1]), "by the loaded radii over load"
    value = float(radius.mean()) / (1.0 - TYPICAL_DEFLECTION * float(fz.mean()) / load)
    return value, "by the loaded radius, with 5 % deflection as a placeholder"


def _plain(info: RunRecord, bar: float) -> bool:
    upright = not info.alpha_deg and not info.gamma_deg
    return upright and info.pressure == bar and info.measurement in ("slip", "free_rolling")


def _by_rolling_radius(
    campaigns: Sequence[Campaign], runs: Sequence[Run], load: float, bar: float
) -> Radius | None:
    told = [r.info.effective_rolling_radius for r in runs]
    known = [v for v in told if math.isfinite(v)]
    if not known:
        return None
    return BY_ROLLING * float(np.median(known)), "by the rolling radius, 2.2 % more as usual"
