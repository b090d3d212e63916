# SPDX-License-Identifier: Apache-2.0
"""An investigation with real plans, journals and log, whose runs and diagnoses are made up, and a
death at any of its steps."""

from __future__ import annotations

import os
import signal
from pathlib import Path
from types import SimpleNamespace

import yaml

from flatplank_analysis.investigation import loop
from flatplank_analysis.investigation.decoys import Decoys
from flatplank_analysis.investigation.planner import DECIDED, Choice
from flatplank_analysis.investigation.settings import Setting
from flatplank_control.bench.results import write_kept_runs
from flatplank_control.investigate.bench import CampaignBench
from flatplank_control.investigate.opening import DiskLog
from flatplank_control.runner.campaign import Conductor, Journal, Outcome, Verdict
from flatplank_control.runner.campaign.quality import Finding
from flatplank_control.runner.campaign.tires import known_tires
from flatplank_data.journals import SUFFIX

ENOUGH = 12
"""runs"""
BAD = 0.01
"""slip whose runs are always rejected"""


class Death:
    """SIGKILL at the n-th step; 0: never."""

    def __init__(self, at: int = 0) -> None:
        self.left = at

    def step(self) -> None:
        self.left -= 1
        if self.left == 0:
            os.kill(os.getpid(), signal.SIGKILL)


class DyingLog(DiskLog):
    """May die before a line, in the middle of it, and after it."""

    def __init__(self, folder: Path, death: Death) -> None:
        super().__init__(folder)
        self.death = death

    def write(self, event) -> None:
        self.death.step()
        if self.death.left == 1:
            with open(self.path, "a", encoding="utf-8") as file:
                file.write('{"event": "ba')
        self.death.step()
        super().write(event)
        self.death.step()


class StubBench(CampaignBench):
    """Sessions know the settings of their runs only."""

    def _records(self) -> list[dict]:
        path = self.folder / "campaign.yaml"
        return yaml.safe_load(path.read_text())["runs"] if path.exists() else []

    def files(self) -> list[str]:
        return [r["file"] for r in self._records() if r["measurement"] == "slip"]

    def session(self, files):
        known = {r["file"]: r for r in self._records()}
        made = [_setting(known[f]) for f in files]
        result = SimpleNamespace(
            search="a search", found=(), verdict="at floor", reason=f"{len(made)} runs",
            to_dict=lambda: {
                "verdict": "at floor", "reason": f"{len(made)} runs", "effects": [],
                "rmse_before": 12.0, "rmse_after": 10.0, "floor_rmse": 10.0,
            },
        )  # fmt: skip
        runs = SimpleNamespace(made=made)
        return SimpleNamespace(diagnose=lambda: result, data=SimpleNamespace(runs=runs))

    def _known(self):
        records = self._records()
        radii = {
            _setting(r).condition: r["effective_rolling_radius"]
            for r in records if r["measurement"] == "slip"
        }  # fmt: skip
        return radii, max((r["run_index"] for r in records), default=-1) + 1


def _setting(r: dict) -> Setting:
    return Setting(
        r.get("kappa", 0.0), r["start"], r["step_position"], r["fz"], r["pressure"],
        r.get("alpha_deg", 0.0),
    )  # fmt: skip


def execute(folder: Path, death: Death):
    """Every run is a file; those of one slip fail."""

    def made(plan, _text, _left) -> None:
        journal = Journal(folder / f"{plan.name}{SUFFIX}", plan.name, plan.digest)
        conductor = Conductor(plan, journal)
        write_kept_runs(conductor, folder)
        while job := conductor.next_job():
            death.step()
            path = folder / f"{job.measurement.name}.parquet"
            path.write_text(str(job.run.key))
            death.step()
            free = job.measurement.measurement == "free_rolling"
            findings = (Finding("settling", 1.0, 0.0 if job.measurement.kappa == BAD else 2.0),)
            facts = {"radius": 0.31} if free else {}
            conductor.finish(job, Outcome(path.name, Verdict(findings), facts))
            death.step()
            write_kept_runs(conductor, folder)

    return made


def choose(_result, _evidence, made, possible, price, left) -> Choice:
    """The first candidate that is affordable, the bad slip first, until there are enough."""
    if len(made) >= ENOUGH:
        return Choice(None, "enough", stop=DECIDED)
    bad = [c for c in possible if c.settings[0].kappa == BAD]
    taken = (bad or possible)[0]
    return Choice(taken, "to go on", price(taken), 1.0)


def investigate(folder: Path, at: int = 0) -> list[dict]:
    """Go on to the end, or to death at step `at`; the events."""
    loop.settings_of = lambda runs: runs.made
    loop.hypothesis_of = lambda search: SimpleNamespace(names=("wear",))
    loop.rows_of = lambda session, files: sorted(files)
    loop.log_e = lambda bet, data, rows: 0.25 * len(rows)
    loop.decoys_of = lambda search: Decoys(2)
    death = Death(at)
    bench = StubBench(folder, known_tires()["TOY"], execute(folder, death))
    log = DyingLog(folder, death)
    loop.Loop(bench, log, 500.0, how=choose).run()
    return log.events
