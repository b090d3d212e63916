# SPDX-License-Identifier: Apache-2.0
"""Bench on the fast plant: makes runs on request, without files."""

from __future__ import annotations

import json
import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import asdict

import numpy as np

from flatplank_analysis.contact_patch.data import from_tables
from flatplank_analysis.contact_patch.model import TireModel
from flatplank_analysis.contact_patch.session import Session
from flatplank_analysis.discovery.effect import Effect
from flatplank_analysis.effects.registry import library
from flatplank_analysis.investigation.loop import BatchResult
from flatplank_analysis.investigation.planner import Price
from flatplank_analysis.investigation.settings import Candidate, Setting, seed_of
from flatplank_control.investigate.bench import price_of
from flatplank_data.campaign import Campaign
from flatplank_data.campaign import Run as Recorded
from flatplank_data.run_record import RunRecord
from flatplank_data.store import open_store
from flatplank_data.table import MeasurementTable
from flatplank_sim.plant.campaign import Campaign as Plant
from flatplank_sim.plant.campaign import CampaignRun
from flatplank_sim.plant.config import PlantConfig
from flatplank_sim.sealed import conditions
from flatplank_sim.sealed.conditions import LOAD, PRESSURE, Run
from flatplank_sim.sealed.menu import Defects, Force
from flatplank_validation.blind.noise import NOISES, RELATIVE, noise

SCATTER = 0.01
"""scatter of friction and tread stiffness from run to run [-]"""
TIRES = ("friction", "tread_stiffness_x", "carcass_stiffness_x", "contact_half_length")
RATE = 20.0
"""sampling rate [Hz]"""
NEEDED = ("time", "plank_position", "wheel_angle", *RELATIVE)


class FastBench:
    """Bench with a random tire and defects; a run depends only on seed, number and setting."""

    def __init__(
        self,
        seed: int,
        defects: Defects | None = None,
        effects: Mapping[str, type[Effect]] | None = None,
        force: Force = lambda _columns, _run: np.zeros(1),
    ) -> None:
        """force: a force outside the library, added to Fx."""
        random = np.random.default_rng(seed)
        plain = PlantConfig.load("toyo").tire
        self._tire = {n: getattr(plain, n) * random.uniform(0.94, 1.06) for n in TIRES}
        self.defects = {"mains_hum": None, "sensor_noise": {"bridge": 0.0}, **(defects or {})}
        self.seed_number, self.force = seed, force
        self.effects = dict(library() if effects is None else effects)
        self.tables: dict[str, MeasurementTable] = {}
        self._stands: Setting | None = None

    def files(self) -> list[str]:
        """Names of the existing runs."""
        return list(self.tables)

    def session(self, files: Collection[str]) -> Session:
        """Session with these runs."""
        tables = [self.tables[f] for f in files]
        data = from_tables(tables)
        campaign = Campaign("made", [Recorded(t.info, open_store(".")) for t in tables])
        return Session(campaign, data, TireModel(data), self.effects)

    def seed(self) -> Candidate:
        """The first batch: six runs."""
        return seed_of(LOAD, PRESSURE)

    def price(self, candidate: Candidate) -> Price:
        """Cost of a candidate on the real bench."""
        known = {t.info.condition.operating_point[2:5] for t in self.tables.values()}
        first = candidate.settings[0]
        radii = {first.condition: 0.31} if first.condition in known else {}
        return price_of("TOY", candidate.settings, radii, self._stands)

    def plan(self, _number: int, candidate: Candidate) -> str:
        """The plan as JSON, with the number of the first run."""
        settings = [asdict(s) for s in candidate.settings]
        return json.dumps({"first": len(self.tables), "settings": settings})

    def measure(self, _number: int, plan: str, _left: float) -> BatchResult:
        """Make all runs of a plan; all count as good."""
        data = json.loads(plan)
        settings = [Setting(**s) for s in data["settings"]]
        return BatchResult(tuple(self.make(settings, data["first"])))

    def make(self, settings: Sequence[Setting], first: int) -> list[str]:
        """Make runs; returns them by file name."""
        out = []
        for index, s in enumerate(settings, first):
            table = self._table(s, index)
            self.tables[table.info.file] = table
            self._stands = s
            out.append(table.info.file)
        return out

    def _table(self, s: Setting, index: int) -> MeasurementTable:
        random = np.random.default_rng((self.seed_number, index))
        gain = 1.0 + SCATTER * random.standard_normal()
        tire = dict(self._tire)
        for name in TIRES[:2]:
            tire[name] *= gain
        config = PlantConfig.load("toyo", overrides={"defects": self.defects, "tire": tire})
        plant = Plant(config, rate_hz=RATE, tire_step=0.0125)
        radius = round(plant.true_radius(s.fz, config.tire.vertical_stiffness), 5)
        run = CampaignRun(
            kappa=s.kappa, fz=s.fz, pressure=s.pressure, alpha=math.radians(s.alpha_deg),
            start_angle=math.radians(120.0 * (s.start - 1)), run_index=index,
            effective_rolling_radius=radius, step_position=s.step_position,
            start_delay=0.09 + 0.03 * random.random(),
        )  # fmt: skip
        columns = plant.run(run, random)
        where = Run(conditions.Setting(s.kappa), s.start, index)
        columns["fx"] = columns["fx"] + self.force(columns, where)
        dt = float(columns["time"][1] - columns["time"][0])
        for name, share in RELATIVE.items():
            own = noise(NOISES["usual"], len(columns[name]), dt, random, share)
            columns[name] = columns[name] + own
        info = RunRecord(
            file=f"fast_{index:03d}.parquet", tire="FAST", kappa=s.kappa, fz=s.fz,
            pressure=s.pressure, alpha_deg=s.alpha_deg, start=s.start, run_index=index,
            effective_rolling_radius=radius, step_position=s.step_position,
        )  # fmt: skip
        return MeasurementTable({n: columns[n] for n in NEEDED}, info)
