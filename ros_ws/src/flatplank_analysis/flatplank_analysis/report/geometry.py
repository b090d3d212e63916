# SPDX-License-Identifier: Apache-2.0
"""Table 7.2 for a campaign: what was measured of the tire at rest, else the tire record."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from flatplank_analysis.models.contact import TOYO, ContactGeometry
from flatplank_analysis.models.tire_record import TireRecord
from flatplank_analysis.report.extras import other_measurements
from flatplank_data.campaign import Campaign

MEASURED = "measured in this campaign"


@dataclass(frozen=True)
class Geometry:
    """Contact geometry of the nonlinear model, and where each of its numbers comes from."""

    contact: ContactGeometry = TOYO
    sources: Mapping[str, str] = field(default_factory=dict)
    """field of `contact` -> source"""

    def source(self, name: str) -> str:
        """Where a number comes from."""
        return self.sources.get(name, "not measured")

    def half_length(self, fz: float, bar: float) -> float:
        """a [m] at load [N] and pressure [bar]."""
        return float(self.contact.half_length(fz, 1e5 * bar))


def geometry_of_campaigns(campaigns: Sequence[Campaign], record: TireRecord) -> Geometry:
    """From what the campaigns together have of the tire at rest."""
    found: dict[str, Any] = {}
    kinds = ("stiffness", "footprint")
    for campaign in campaigns:
        found |= other_measurements(campaign, kinds, record.free_radius)
    return geometry_of(found, record)


def geometry_of(extras: Mapping[str, Any], record: TireRecord) -> Geometry:
    """From vertical stiffness runs and footprints; the record where a number was not measured."""
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
        return {"vertical_stiffness": float(np.mean(values / effect))}
    slope, nominal = np.polyfit(change, values, 1)
    return {"vertical_stiffness": float(nominal), "pressure_effect": float(slope / nominal)}
