# SPDX-License-Identifier: Apache-2.0
"""Tire and contact geometry of a fit or report. The tire record is the given one, otherwise made
from the data; the geometry (Table 7.2) is measured at rest, otherwise that of the record.
"""

from __future__ import annotations

import dataclasses
import math
import os
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from flatplank_analysis.models.base import TOYO, ContactGeometry
from flatplank_analysis.models.tire_record import (
    FILE,
    TYPICAL_DEFLECTION,
    TireRecord,
    parse_record,
    read_record,
)
from flatplank_analysis.report.extras import inside_window, measured_at_rest, stiffness_runs
from flatplank_analysis.starts import mean_over_starts
from flatplank_data.campaign import Campaign, Run
from flatplank_data.errors import FlatplankError
from flatplank_data.machine import USUAL_RADIUS
from flatplank_data.run_record import RunRecord

BY_ROLLING = TOYO.free_radius / USUAL_RADIUS
"""R0 / r_e of the tire of the thesis (Tables 5.1, 5.2), used where R0 has no other source"""
UNTOLD = {"nominal_load": 4000.0, "nominal_pressure": 2.5}
"""defaults [N], [bar] where no run states them"""
APART = 1.2
"""least ratio of two loads for R0 from a line through the loaded radii"""
MEASURED = "measured in this campaign"


def record_for(
    campaigns: Sequence[Campaign], file: str | os.PathLike[str] | None = None
) -> TireRecord:
    """The record in `file`, otherwise `tire.yaml` of a folder, otherwise one made from the
    data."""
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
            return dataclasses.replace(parse_record(text, FILE), origin=f"{FILE} of the folder")
    return None


def made_from(campaigns: Sequence[Campaign]) -> TireRecord:
    """A record with the most frequent load and pressure, and R0 from the best measurement."""
    runs = [run for c in campaigns for run in c.runs]
    usual = {"nominal_load": _usual(r.info.fz for r in runs)}
    usual |= {"nominal_pressure": _usual(r.info.pressure for r in runs)}
    unknown = [name for name, value in usual.items() if not math.isfinite(value)]
    load, bar = (UNTOLD[n] if n in unknown else v for n, v in usual.items())
    radius, how = (
        _by_record(runs)
        or _by_stiffness(campaigns, bar)
        or _by_loaded_radius(runs, load, bar)
        or _by_rolling_radius(runs)
        or (0.3, "a placeholder: not measured")
    )
    names = tires_of(campaigns)
    origin = f"made from the data: load and pressure of most runs, R0 {how}"
    if unknown:
        origin += f"; no run tells {' and '.join(unknown)}: a placeholder"
    name = names[0] if names else ""
    return TireRecord(name, round(radius, 5), load, bar, placeholder=tuple(unknown), origin=origin)


def _usual(values: Iterable[float]) -> float:
    """The most frequent value; of several such values the middle one, of two the upper one."""
    counts = Counter(v for v in values if math.isfinite(v) and v > 0.0)
    most = max(counts.values(), default=0)
    best = sorted(v for v, n in counts.items() if n == most)
    return best[len(best) // 2] if best else math.nan


Radius = tuple[float, str]
"""R0 [m], and its source"""


def _by_record(runs: Sequence[Run]) -> Radius | None:
    recorded = (run.info.extra.get("free_radius") for run in runs)
    return next(((float(v), "of a run record") for v in recorded if v), None)


def _by_stiffness(campaigns: Sequence[Campaign], bar: float) -> Radius | None:
    """R0 where the line of a vertical stiffness run reaches Fz = 0."""
    found = stiffness_runs(campaigns)
    if not found:
        return None
    run = min(found, key=lambda r: abs(r["pressure"] - bar))
    return inside_window(run)[2], "where a stiffness run reaches Fz = 0"


def _by_loaded_radius(runs: Sequence[Run], load: float, bar: float) -> Radius | None:
    """R0 by a line through loaded radii; with one load by a typical deflection."""
    points = []
    first = {r.info.fz: r for r in reversed(runs) if _plain(r.info, bar)}
    for _, run in sorted(first.items(), key=lambda item: item[0]):
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


def _by_rolling_radius(runs: Sequence[Run]) -> Radius | None:
    recorded = [r.info.effective_rolling_radius for r in runs]
    known = [v for v in recorded if math.isfinite(v)]
    if not known:
        return None
    more = f"{100.0 * (BY_ROLLING - 1.0):.2g} % more as usual"
    return BY_ROLLING * float(np.median(known)), f"by the rolling radius, {more}"


@dataclass(frozen=True)
class Geometry:
    """Contact geometry of the nonlinear model, and the source of each of its numbers."""

    contact: ContactGeometry = TOYO
    sources: Mapping[str, str] = field(default_factory=dict)
    """field of `contact` -> source"""

    def source(self, name: str) -> str:
        """Source of a number."""
        return self.sources.get(name, "not measured")

    def half_length(self, fz: float, bar: float) -> float:
        """a [m] at load [N] and pressure [bar]."""
        return float(self.contact.half_length(fz, 1e5 * bar))


def geometry_of_campaigns(campaigns: Sequence[Campaign], record: TireRecord) -> Geometry:
    """Geometry from the measurements at rest in all campaigns."""
    return geometry_of(measured_at_rest(campaigns, record.free_radius), record)


def geometry_of(extras: Mapping[str, Any], record: TireRecord) -> Geometry:
    """Geometry from vertical stiffness runs and footprints, otherwise from the record."""
    contact, sources = record.geometry()
    found = _stiffness(extras.get("vertical_stiffness", []), contact)
    length = extras.get("contact_length")
    if length and not length["remark"]:
        found |= {"q_ra1": length["q_ra1"], "q_ra2": length["q_ra2"], "free_radius": length["r_0"]}
    sources |= dict.fromkeys(found, MEASURED)
    if "free_radius" in found:
        sources["free_radius"] = "run record of the footprints, else the tire record"
    return Geometry(dataclasses.replace(contact, **found), sources)


def _stiffness(runs: list[Mapping[str, Any]], contact: ContactGeometry) -> dict[str, float]:
    """C_z0 at the nominal pressure, and p_Fz1 (7.21) when there are two pressures."""
    known = [r for r in runs if np.isfinite(r["mean"]) and np.isfinite(r["pressure"])]
    if not known:
        return {}
    change = np.array([1e5 * r["pressure"] / contact.nominal_pressure - 1.0 for r in known])
    values = np.array([r["mean"] for r in known])
    if np.ptp(change) < 0.01:
        effect = 1.0 + contact.pressure_effect * change
        found = mean_over_starts(values / effect, [r["start"] for r in known])
        return {"vertical_stiffness": float(found)}
    slope, nominal = np.polyfit(change, values, 1)
    return {"vertical_stiffness": float(nominal), "pressure_effect": float(slope / nominal)}
