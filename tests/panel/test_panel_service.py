# SPDX-License-Identifier: Apache-2.0
"""Analysts at one service: nobody acts on the campaign of another, nobody ends another's work."""

from __future__ import annotations

import asyncio
from pathlib import Path

import numpy as np
import pytest
from made_up import campaign
from own_loop import finished

from flatplank_control.calibration.parasitic import UnloadedTurns, identify_turn
from flatplank_control.runner.campaign import Conductor, Journal, Outcome, Verdict, plan_from_text
from flatplank_control.runner.campaign.quality import Finding
from flatplank_data.folders import stamp_of
from flatplank_data.journals import verdicts_of
from flatplank_panel.analysis import browse_jobs, fit_jobs
from flatplank_panel.service import AnalysisService, PageAnalysis


def quiet(_text: str, _share: float) -> None:
    """Progress that nobody looks at."""


class Slow:
    """An analysis that notes what it is asked; `diagnose` ends only when it is cancelled."""

    def __init__(self) -> None:
        self.asked: list[tuple[str, str]] = []
        self.ended: list[str] = []
        self.lock = asyncio.Lock()

    async def ask(self, job, progress, **about):
        async with self.lock:
            self.asked.append((job, about["folder"]))
            progress(job, 0.5)
            try:
                await asyncio.sleep(3600.0 if job == "diagnose" else 0.0)
            except asyncio.CancelledError:
                self.ended.append(about["folder"])
                raise
            return {}


@pytest.fixture
def service(tmp_path) -> AnalysisService:
    for name in "xy":
        (tmp_path / name).mkdir()
    made = AnalysisService(tmp_path)
    made.fit_jobs = Slow()
    return made


def test_each_page_acts_on_the_campaign_that_it_shows(service, tmp_path):
    async def work():
        a, b = PageAnalysis(service), PageAnalysis(service)
        await a.open("x")
        await b.open("y", "y/other.yaml")
        await a.add("drive_backlash")
        await b.undo()

    finished(work())
    x, y = str(tmp_path / "x"), str(tmp_path / "y")
    assert service.fit_jobs.asked == [("open", x), ("open", y), ("add", x), ("undo", y)]


def test_cancel_ends_only_the_work_of_the_page_that_asks(service, tmp_path):
    async def work():
        a, b = PageAnalysis(service), PageAnalysis(service)
        await a.open("x")
        await b.open("y")
        search = asyncio.create_task(a.diagnose())
        while not a.progress[0]:
            await asyncio.sleep(0)
        waiting = asyncio.create_task(b.compare())
        while not b.busy:
            await asyncio.sleep(0)
        b.cancel()
        with pytest.raises(ValueError, match="cancelled"):
            await waiting
        assert a.busy and not service.fit_jobs.ended
        queued = asyncio.create_task(a.add("drive_backlash"))
        await asyncio.sleep(0)
        a.cancel()
        for own in (search, queued):
            with pytest.raises(ValueError, match="cancelled"):
                await own
        assert not a.busy and a.progress == ("", 0.0)

    finished(work())
    assert service.fit_jobs.ended == [str(tmp_path / "x")]


def test_a_search_goes_on_without_its_page_and_other_pages_show_it(service, tmp_path):
    async def work():
        a, b = PageAnalysis(service), PageAnalysis(service)
        await a.open("x")
        await b.open("x")
        search = asyncio.create_task(a.diagnose())
        while not a.progress[0]:
            await asyncio.sleep(0)
        a.leave()  # as a refresh does
        assert not service.fit_jobs.ended and b.searched and b.progress == ("diagnose", 0.5)
        again = asyncio.create_task(b.diagnose())
        await asyncio.sleep(0)
        assert service.fit_jobs.asked.count(("diagnose", str(tmp_path / "x"))) == 1
        b.cancel()
        for own in (search, again):
            with pytest.raises(ValueError, match="cancelled"):
                await own
        assert not b.searched

    finished(work())
    assert service.fit_jobs.ended == [str(tmp_path / "x")]


def test_what_is_put_away_is_forgotten(service):
    async def work():
        analysis = PageAnalysis(service)
        await analysis.open("x")
        analysis.next_run = {"runs": [{}]}
        search = asyncio.create_task(analysis.diagnose())
        while not analysis.busy:
            await asyncio.sleep(0)
        analysis.close_campaign()
        # at once, although the work has yet to hear of it
        assert not analysis.busy and analysis.progress == ("", 0.0) and not search.done()
        assert analysis.next_run == {}
        with pytest.raises(ValueError, match="cancelled"):
            await search
        for ask in (
            analysis.compare,
            analysis.diagnose,
            analysis.report,
            lambda: analysis.add("x"),
        ):
            with pytest.raises(ValueError, match="open a campaign first"):
                await ask()
        with pytest.raises(ValueError, match="open a campaign first"):
            analysis.plan_next()

    finished(work())


@pytest.mark.parametrize(
    ("folder", "model", "why"),
    [("../x", "", "outside"), ("z", "", "no such"), ("x", "../m.yaml", "outside"),
     ("x", "m.txt", "yaml")],
)  # fmt: skip
def test_folder_and_model_are_checked(service, folder, model, why):
    with pytest.raises(ValueError, match=why):
        finished(PageAnalysis(service).open(folder, model))
    assert service.fit_jobs.asked == []


def test_a_request_says_all_that_it_is_about(tmp_path):
    """Between two requests nothing is kept that one page could change for another."""
    folders = [str(campaign(tmp_path / name)) for name in "xy"]
    models = [f"{folder}/model.yaml" for folder in folders]
    for folder, model in zip(folders, models, strict=True):
        assert fit_jobs.open_(quiet, folder, model)["file"] == model
    fit_jobs.add(quiet, folders[0], models[0], "drive_backlash")
    held = [fit_jobs.open_(quiet, f, m) for f, m in zip(folders, models, strict=True)]
    assert [len(h["effects"]) for h in held] == [1, 0]
    assert [Path(m).exists() for m in models] == [True, False]


def test_a_cancelled_worker_is_followed_by_a_new_one(tmp_path):
    campaign(tmp_path / "x")

    async def work():
        service = AnalysisService(tmp_path)
        analysis = PageAnalysis(service)
        opening = asyncio.create_task(analysis.open("x"))
        while not analysis.progress[0].startswith("reading run "):
            assert not opening.done(), "it was read before it could be cancelled"
            await asyncio.sleep(0.0)
        first = service.fit_jobs._process
        analysis.cancel()
        with pytest.raises(ValueError, match="cancelled"):
            await opening
        await first.wait()
        assert (await analysis.open("x"))["runs"] == 9
        second = service.fit_jobs._process
        service.close()
        await second.wait()

    finished(work())


@pytest.mark.parametrize(
    ("name", "seed", "why"),
    [("x", 1, "already"), ("", 1, "name"), ("../z", 1, "outside"), ("a b", 1, "name"),
     ("z", "x", "seed"), ("z", -1, "seed")],
)  # fmt: skip
def test_a_simulated_campaign_needs_a_new_plain_name_and_a_seed(
    service, tmp_path, name, seed, why
):
    with pytest.raises(ValueError, match=why):
        finished(PageAnalysis(service).simulate(name, seed))
    assert service.fit_jobs.asked == [] and not (tmp_path / "z").exists()


def test_a_campaign_is_simulated_below_the_data_folder(service, tmp_path):
    assert finished(PageAnalysis(service).simulate(" day/z ", 3)) == "day/z"
    assert service.fit_jobs.asked == [("simulate", str(tmp_path / "day" / "z"))]


def test_only_unloaded_turns_are_identified(tmp_path):
    for name, kind in (("turn", "unloaded_turn"), ("slip", "slip")):
        (tmp_path / name).mkdir()
        (tmp_path / name / "run.yaml").write_text(f"tire: TOY\nmeasurement: {kind}\nname: x\n")
    root, target = str(tmp_path), str(tmp_path / "fit.yaml")
    assert browse_jobs.turns(quiet, root) == ["turn"]
    with pytest.raises(ValueError, match="unloaded turns"):
        browse_jobs.identify(quiet, root, "slip", "m", "2026-01-01", target)
    with pytest.raises(ValueError, match="no bag"):
        browse_jobs.identify(quiet, root, "turn", "m", "2026-01-01", target)


def test_too_short_a_turn_gives_no_fit(tmp_path):
    angle = np.linspace(0.0, 5.0 * np.pi, 1000)
    turn = UnloadedTurns(angle, np.tile(np.sin(angle)[:, None], (1, 6)))
    with pytest.raises(ValueError, match="900 deg and 1080"):
        identify_turn(turn, "m", "2026-01-01", tmp_path / "fit.yaml")
    assert not list(tmp_path.iterdir())


PLAN = (
    "format: flatplank-plan/1\nname: judged\ntire: TOY\nr_e: given\nruns:\n"
    "- {measurement: slip, kappa: 0.05, start: [1, 2, 3], effective_rolling_radius: 0.31}\n"
)


def test_campaigns_are_folders_with_any_file_that_can_be_read(tmp_path):
    for name in ("x/a.mat", "x/b.TDX", "y/notes.txt", "open/run/run_0.mcap"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    assert browse_jobs.campaigns(quiet, str(tmp_path)) == [{"folder": "x", "runs": 2}]


def test_runs_have_the_verdicts_of_their_campaign(tmp_path):
    folder = campaign(tmp_path / "x")
    files = [row["file"] for row in browse_jobs.runs(quiet, str(folder))["rows"]]
    plan = plan_from_text(PLAN, "plan")
    conductor = Conductor(plan, Journal(folder / "judged.journal.jsonl", plan.name, plan.digest))
    drift = [Verdict((Finding("load_drift", v, 0.02),)) for v in (0.3, 0.001, 0.2, 0.2)]
    for file, verdict in zip(files, drift, strict=False):
        conductor.finish(conductor.next_job(), Outcome(file, verdict))
    rows = {r["file"]: r["verdict"] for r in browse_jobs.runs(quiet, str(folder))["rows"]}
    again = f"rejected, made again as {files[1]}: load_drift 0.3 (limit 0.02)"
    assert [rows[f] for f in files[:2]] == [again, "good"]
    assert rows[files[2]].startswith("rejected, made again") and "(limit" in rows[files[3]]
    assert rows[files[3]].startswith("rejected: ") and rows[files[4]] == "ok"


def test_a_journal_without_words_gives_its_numbers(tmp_path):
    line = '{"event": "end", "run": "0", "file": "a", "ok": false, "final": true, '
    text = '{"event": "plan"}\n' + line + '"facts": {"findings": {"settling": 3.25}}}\n{"torn'
    (tmp_path / "j.journal.jsonl").write_text(text)
    assert verdicts_of(tmp_path) == {"a": "rejected: settling 3.25"}


def test_a_change_inside_the_folder_of_a_run_is_seen(tmp_path):
    bag = tmp_path / "bag"
    bag.mkdir()
    (bag / "run.yaml").write_text("status: armed")
    before = stamp_of(tmp_path)
    (tmp_path / "model.yaml").write_text("x")
    assert stamp_of(tmp_path) == before
    (bag / "run.yaml").write_text("status: complete")
    assert stamp_of(tmp_path) != before


def test_what_the_samples_tell_is_in_the_verdicts(tmp_path):
    folder = campaign(tmp_path / "x")
    rows = browse_jobs.runs(quiet, str(folder))["rows"]
    assert {r["verdict"] for r in rows} == {"ok"}
    broken = rows[0]["file"]
    (folder / broken).write_bytes(b"no table")
    found = browse_jobs.curves(
        quiet, str(folder), [r["file"] for r in rows], "fx", "plank_position"
    )
    assert found["verdicts"][broken] != "ok" and found["verdicts"][rows[1]["file"]] == "ok"
    assert len(found["curves"]) == len(rows) - 1
