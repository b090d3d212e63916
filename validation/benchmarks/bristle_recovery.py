# SPDX-License-Identifier: Apache-2.0
"""Accuracy of the fits on the simulated plant without defects, whose brush-model tire differs from
the fitted models.

Limits: r_e, C_z, a within 1 %; C_Fk within 3 %; c_cx, sigma_x within 7 %, with the stated bias of
the model.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from flatplank_analysis.report.radii import radius_values
from flatplank_analysis.report.results import CampaignResult
from flatplank_analysis.steady.stiffness import fit_contact_length, vertical_stiffness
from flatplank_data.run_record import RunRecord
from flatplank_data.table import MeasurementTable
from flatplank_sim.plant.config import PlantConfig
from flatplank_validation.truth import TruthRow, truth_row
from plant_points import analyse_runs, simulate_point

LOADS = (1850.0, 3700.0, 5550.0)


class Row(NamedTuple):
    """One quantity at one load."""

    fz: float
    name: str
    true: float
    found: float
    limit: float
    """limit of the relative error [-]"""
    stated: float = 0.0
    """bias of the model, as stated by the fit [-]"""

    @property
    def error(self) -> float:
        """Relative error [-]."""
        return self.found / self.true - 1.0

    @property
    def corrected(self) -> float:
        """Relative error, corrected by the stated bias [-]."""
        return (1.0 + self.error) / (1.0 + self.stated) - 1.0


def measure(loads: tuple[float, ...] = LOADS, seed: int = 0) -> list[Row]:
    """All quantities at each load, from nine slips x three starts."""
    config = PlantConfig.load()
    bar = config.tire.nominal_pressure_bar
    truths = [truth_row(config, fz, bar) for fz in loads]
    return [row for truth in truths for row in _point(truth, config, seed)]


def _point(truth: TruthRow, config: PlantConfig, seed: int) -> Iterator[Row]:
    made = simulate_point(fz=truth.fz, seed=seed)
    load = float(np.mean([np.mean(run.table["fz"][-2000:]) for run in made]))
    point = analyse_runs(made)
    (radius,) = radius_values(CampaignResult("", "", [point], ()))
    here = truth_row(config, load, truth.pressure)
    yield Row(truth.fz, "r_e", here.effective_rolling_radius, radius.corrected.value, 0.01)
    yield Row(truth.fz, "C_z", truth.vertical_stiffness, _stiffness(config), 0.01)
    yield Row(truth.fz, "a", truth.contact_half_length, _half_length(truth, config), 0.01)
    fit = point.carcass
    if fit is None:
        return
    yield Row(truth.fz, "C_Fk", here.slip_stiffness, fit.slip_stiffness.value, 0.03)
    bias = fit.model_bias
    yield Row(truth.fz, "c_cx", here.carcass_stiffness_x, fit.c_cx.value, 0.07, bias["c_cx"])
    length = here.relaxation_length_x
    yield Row(truth.fz, "sigma_x", length, fit.sigma_x.value, 0.07, bias["sigma_x"])


def _stiffness(config: PlantConfig) -> float:
    """C_z from heights and forces of a loading on the resting plank."""
    made = [simulate_point(fz=fz, slips=(0.0,), starts=(1,))[0].table for fz in LOADS]
    height = np.array([t["loaded_radius"][:5].mean() for t in made])
    force = np.array([t["fz"][:5].mean() for t in made])
    fine = np.linspace(height.min(), height.max(), 200)
    down = np.interp(fine, height[::-1], force[::-1])[::-1]
    columns = {"loaded_radius": fine[::-1], "fz": down}
    info = RunRecord(measurement="stiffness", pressure=config.tire.nominal_pressure_bar)
    return vertical_stiffness(MeasurementTable(columns, info)).mean


def _half_length(truth: TruthRow, config: PlantConfig) -> float:
    """Half contact length a at a load, by (7.20) fitted to the footprints of three loads."""
    rows = [truth_row(config, fz, truth.pressure) for fz in LOADS]
    stiffness = np.full(len(rows), truth.vertical_stiffness)
    radius = config.tire.free_radius
    a = np.array([r.contact_half_length for r in rows])
    fit = fit_contact_length(np.array(LOADS), a, stiffness, radius)
    return float(fit.half_length(truth.fz, truth.vertical_stiffness))


def main() -> None:
    """Print the table."""
    print("| Fz [N] | quantity | true | found | error | stated bias | without it | wanted |")
    print("|---|---|---|---|---|---|---|---|")
    for r in measure():
        stated = f"{100 * r.stated:+.1f} %" if r.stated else ""
        without = f"{100 * r.corrected:+.1f} %" if r.stated else ""
        print(
            f"| {r.fz:g} | {r.name} | {r.true:.5g} | {r.found:.5g} | {100 * r.error:+.2f} % "
            f"| {stated} | {without} | {100 * r.limit:g} % |"
        )


if __name__ == "__main__":
    main()
