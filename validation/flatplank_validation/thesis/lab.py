# SPDX-License-Identifier: Apache-2.0
"""Measures what the chapters ask for, once: campaigns on the twin with the machine of the thesis.

The parasitic fit is made first, from three unloaded turns (Appendix C); every campaign uses it.
What a folder already has is not measured again, so that an interrupted command goes on.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from flatplank_analysis.report.analysis import analyse
from flatplank_analysis.report.results import CampaignResult
from flatplank_control.bench.results import write_campaign
from flatplank_control.bench.setup import BenchSetup
from flatplank_control.calibration.parasitic import UnloadedTurns, identify_turn
from flatplank_control.free_rolling.params import THESIS_LEAD_ALPHA
from flatplank_control.runner.campaign import Conductor, Journal, load_plan
from flatplank_control.runner.campaign.conductor import Job, Outcome
from flatplank_control.runner.measurement import Measurement
from flatplank_control.runner.plans import plan_of
from flatplank_data.campaign import CAMPAIGN_FILE, Campaign
from flatplank_data.exporters import export_campaign
from flatplank_data.journals import SUFFIX
from flatplank_data.run_record import RunRecord
from flatplank_data.table import MeasurementTable
from flatplank_hw.hub.parasitic import ParasiticFit, load_fit
from flatplank_sim.plant import PlantConfig
from flatplank_sim.simulator import speeds_on_twin, turn_on_twin
from flatplank_sim.twin.campaign import run_on_twin
from flatplank_sim.twin.log import TableLog
from flatplank_sim.twin.twin import Twin
from flatplank_sim.twin.twin_bench import TwinBench
from flatplank_validation.truth import truth_row

PLANS = Path(__file__).parent / "plans"
PRESET = "thesis2023"
TIRE = "toyo"
MOUNTING_DATE = "2023-01-01"
"""date of the parasitic fit: it is part of the fit's file only"""
THESIS_CONTROLLER = {"automatic": False, "lead_alpha": THESIS_LEAD_ALPHA}
"""the controller as printed: gains of (5.10) to (5.12), 2 N m at the start"""
LOADS, PRESSURES = (1850.0, 3700.0, 5550.0), (2.5, 2.0)
"""Table 6.1 [N], [bar]"""
FOOTPRINTS, FRICTION, STARTS = "footprints", "friction", "starts"
START_LOADS = (3700.0, 1000.0, 1850.0, 5550.0, 8000.0)
"""loads of figure 5.23, the first over the whole road [N]"""
START_ROAD = 0.3
"""road of the others [m]"""


@dataclass(frozen=True)
class Measured:
    """One folder of runs: its plan, and what differs from the usual bench."""

    plan: str
    parameters: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    """node -> parameters"""
    plant: str = ""
    """file laid over the plant"""
    seed: int = 1
    """of the plant's noise: two runs of one seed differ in nothing else"""


def _rolling(plan: str) -> dict[str, Measured]:
    thesis = {"free_rolling_controller": THESIS_CONTROLLER}
    return {f"{plan}_thesis": Measured(plan, thesis), f"{plan}_ours": Measured(plan)}


CAMPAIGNS: dict[str, Measured] = {
    "longitudinal": Measured("longitudinal"),
    "angles": Measured("angles", seed=2),
    "repeats": Measured("repeats", seed=3),
    "repeats_torn": Measured("repeats_torn", plant="torn_plant.yaml", seed=5),
    "repaired": Measured("nominal", plant="repaired_plant.yaml", seed=4),
    "filtered": Measured("filter"),
    "unfiltered": Measured("filter", {"measurement_hub": {"filter_on": False}}, seed=2),
    "standing": Measured("standing"),
    **_rolling("loads"),
    **_rolling("michelin"),
    **_rolling("continental"),
    **_rolling("racing"),
}
"""name of a folder -> what is measured into it"""


@dataclass(frozen=True)
class Turn:
    """The unloaded turns, and the fit made of them."""

    samples: UnloadedTurns
    fit: ParasiticFit
    left: Mapping[str, tuple[float, float]]
    """fx, fz: once per turn before and after the filter [N]"""


class Lab:
    """Everything measured and analysed, each when it is first asked for."""

    def __init__(
        self,
        folder: Path,
        jobs: int,
        say: Callable[[str], None] = lambda text: print(text, file=sys.stderr, flush=True),
        campaigns: Mapping[str, Measured] | None = None,
    ) -> None:
        self.folder, self.jobs, self.say = folder, jobs, say
        self.campaigns = CAMPAIGNS if campaigns is None else campaigns
        self._results: dict[tuple[str, ...], CampaignResult] = {}
        self._made = {
            FOOTPRINTS: self._footprints, FRICTION: self._friction, STARTS: self._starts,
        }  # fmt: skip
        self.kept: dict[str, Any] = {}
        """tables and simulations that several figures need"""

    @property
    def bench(self) -> BenchSetup:
        """The bench of the thesis without a filter."""
        return BenchSetup(tire=TIRE, preset=PRESET, pace="hold")

    @cached_property
    def plant(self) -> PlantConfig:
        """The simulated machine and its tire, for what only the plant knows."""
        return PlantConfig.load(TIRE, preset=PRESET)

    @cached_property
    def turn(self) -> Turn:
        """Three unloaded turns and their fit, made anew: seconds."""
        self.say("three unloaded turns, and the parasitic fit")
        samples = turn_on_twin(self.bench)
        path = self.folder / "parasitic.yaml"
        left = identify_turn(samples, "thesis", MOUNTING_DATE, path)
        return Turn(samples, load_fit(path), left)

    def measured(self, name: str) -> Path:
        """Folder of a campaign with all its runs."""
        if name in self._made:
            return self._made[name]()
        what = self.campaigns[name]
        folder = self.folder / name
        plan = load_plan(PLANS / f"{what.plan}.yaml")
        journal = Journal(folder / f"{plan.name}{SUFFIX}", plan.name, plan.digest)
        conductor = Conductor(plan, journal)
        if conductor.over:
            return folder
        setup = self._setup(what)
        first, began = conductor.done, time.monotonic()

        def progress(now: Conductor, _job: Job, outcome: Outcome) -> None:
            each = (time.monotonic() - began) / max(now.done - first, 1)
            left = each * (now.total - now.done) / 60.0
            self.say(f"{name} {now.done}/{now.total} {outcome.file}; {left:.0f} min left")

        run_on_twin(conductor, setup, folder, jobs=self.jobs, progress=progress)
        return folder

    def _setup(self, what: Measured) -> BenchSetup:
        fit = self.folder / "parasitic.yaml"
        if not fit.exists():
            _ = self.turn
        hub = {"parasitic_fit": str(fit), "filter_on": True}
        hub |= what.parameters.get("measurement_hub", {})
        parameters = {**what.parameters, "measurement_hub": hub}
        plant = str(PLANS / what.plant) if what.plant else ""
        return replace(self.bench, parameters=parameters, plant_file=plant, seed=what.seed)

    def _footprints(self) -> Path:
        """Footprints by the plant's own contact length: the twin has no ink and paper."""
        tables = []
        for bar in PRESSURES:
            rows = [truth_row(self.plant, fz, bar) for fz in LOADS]
            prints = {
                "fz": np.array(LOADS),
                "half_length": np.array([row.contact_half_length for row in rows]),
            }
            info = RunRecord(
                file=f"TOY_PRINT_p{10 * bar:g}", tire="TOY", measurement="footprint", pressure=bar,
                extra={"free_radius": self.plant.tire.free_radius},
            )  # fmt: skip
            tables.append(MeasurementTable(prints, info))
        folder = self.folder / FOOTPRINTS
        export_campaign(tables, folder)
        return folder

    def _friction(self) -> Path:
        """Motor torque of the unloaded wheel at constant speeds (section 5.5)."""
        folder = self.folder / FRICTION
        if not (folder / CAMPAIGN_FILE).exists():
            self.say("friction torque of the unloaded wheel")
            export_campaign([speeds_on_twin(self.bench)], folder)
        return folder

    def _starts(self) -> Path:
        """Free rolling under the thesis's controller, with the samples before the trigger."""
        folder = self.folder / STARTS
        if (folder / CAMPAIGN_FILE).exists():
            return folder
        made = []
        setup = self._setup(self.campaigns["loads_thesis"])
        for k, fz in enumerate(START_LOADS):
            self.say(f"start of free rolling at {fz:g} N")
            m = Measurement(measurement="free_rolling", fz=fz, run_index=k)
            m = replace(m, end_position=START_ROAD) if k else m
            bench = TwinBench(Twin(setup), TableLog(folder, whole=True))
            bench.perform(plan_of(m))
            made.append((m.record(), bench.kept[0].name))
        write_campaign(folder, m.tire, made)
        return folder

    def tables(self, name: str, columns: Sequence[str]) -> list[MeasurementTable]:
        """The samples of all runs of a campaign."""
        return [run.table(columns) for run in Campaign.load(self.measured(name)).runs]

    def result(self, *names: str, models: bool = True) -> CampaignResult:
        """Analysis of these campaigns together, with the footprints and stiffness of the tire;
        `models`: with the nonlinear model and the Magic Formula, which take most of the time."""
        if names not in self._results:
            first, *others = [Campaign.load(self.measured(name)) for name in names]
            for other in others:
                first = first.merged(other)

            def progress(done: int, of: int, label: str) -> None:
                self.say(f"analysis of {' and '.join(names)} {done}/{of} {label}")

            self._results[names] = analyse(
                first, jobs=self.jobs, nonlinear=models, magic=models, progress=progress
            )
        return self._results[names]

    @property
    def matrix(self) -> CampaignResult:
        """Tables 6.1 and 6.2: the whole matrix of the Toyo, and its standing tire."""
        return self.result("longitudinal", "angles", "standing", FOOTPRINTS)

    @property
    def drive(self) -> CampaignResult:
        """The longitudinal part with the friction of the wheel drive."""
        return self.result("longitudinal", FRICTION, models=False)

    @property
    def repeats(self) -> CampaignResult:
        """Ten runs of each of four conditions."""
        return self.result("repeats", "repeats_torn", models=False)

    @staticmethod
    def free_radius(tire: str) -> float:
        """r_0 of a tire of the plant [m]."""
        return PlantConfig.load(tire).tire.free_radius

    @property
    def repaired(self) -> CampaignResult:
        """The nominal point after the play of the road was reduced (section 7.1)."""
        return self.result("repaired", "standing", FOOTPRINTS)
