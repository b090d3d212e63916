# SPDX-License-Identifier: Apache-2.0
"""The proposed run is made on the machine, and the class becomes its true member."""

from __future__ import annotations

import math

import numpy as np
import pytest

from flatplank_analysis.contact_patch.session import Session
from flatplank_analysis.discovery.nextrun import CLEAR
from flatplank_analysis.discovery.rivals import indecisive_difference
from flatplank_analysis.discovery.verdict import FOUND, GROUP, Diagnosis
from flatplank_analysis.effects.registry import library
from flatplank_data.run_record import RunRecord
from flatplank_data.table import MeasurementTable
from flatplank_sim.plant.campaign import COLUMNS, Campaign, CampaignRun
from flatplank_sim.plant.config import PlantConfig
from flatplank_validation.blind.noise import NOISES, noise

SHAFT, TIRE = "parasitic_force", "nonuniformity_1"
SCATTER = 0.01
"""standard deviation of the grip from run to run [-]"""


class Bench:
    """A plant whose shaft is bent; its tire scatters from run to run."""

    def __init__(self, seed: int) -> None:
        self.random = np.random.default_rng(seed)
        self.tables: list[MeasurementTable] = []

    def make(self, kappa: float, start: float, step_position: float, **others: float) -> None:
        known = {"kappa": kappa, "fz": 3700.0, "pressure": 2.5} | others
        grip = 1.0 + SCATTER * self.random.normal()
        plain = PlantConfig.load("toyo").tire
        scattered = {n: grip * getattr(plain, n) for n in ("friction", "tread_stiffness_x")}
        bent = {"parasitic_shaft": {"fx": 80.0, "fz": 100.0}}
        plant = Campaign(PlantConfig.load("toyo", overrides={"defects": bent, "tire": scattered}))
        radius = plant.true_radius(known["fz"], plain.vertical_stiffness)
        known |= {"step_position": step_position, "effective_rolling_radius": radius}
        turned = 120.0 * (start - 1.0)
        made = len(self.tables)
        run = CampaignRun(start_angle=math.radians(turned), run_index=made, **known)
        columns = plant.run(run, self.random)
        dt = float(columns["time"][1] - columns["time"][0])
        for name in ("fx", "fy", "fz"):
            slow = noise(NOISES["usual"], len(columns["time"]), dt, self.random)
            columns[name] = columns[name] + slow
        info = RunRecord(
            file=f"run_{made}.parquet", start_angle_deg=turned, run_index=made, **known
        )
        self.tables.append(MeasurementTable({c: columns[c] for c in COLUMNS}, info))

    def diagnosis(self) -> Diagnosis:
        effects = {name: library()[name] for name in (SHAFT, TIRE)}
        return Session.of_tables(self.tables, effects).diagnose()


def test_the_proposed_run_excludes_the_rival_as_promised():
    """A force that turns with the wheel and one that grows with the load: the load was one."""
    bench = Bench(seed=5)
    for kappa in (-0.02, 0.02):
        for start in (1, 2, 3):
            bench.make(kappa, start, 1.5)
    before = bench.diagnosis()
    assert before.verdict == GROUP
    (found,) = before.found
    assert {found.decision.term.effect.identifier, *found.alike} == {SHAFT, TIRE}
    proposal = before.next_run
    assert proposal["expected"] > CLEAR * proposal["needed"]

    settings = dict(proposal["settings"])
    for start in settings.pop("starts") * proposal["repeats"]:
        bench.make(start=start, **settings)
    after = bench.diagnosis()
    assert after.verdict == FOUND
    (found,) = after.found
    assert found.decision.term.effect.identifier == SHAFT and not found.alike
    (rival,) = found.rivals
    # the noise of more runs is another: both numbers scale with it
    needed = indecisive_difference(found.decision, [found.decision])
    promised = proposal["expected"] / proposal["needed"]
    assert rival.excess / needed == pytest.approx(promised, rel=0.2)
