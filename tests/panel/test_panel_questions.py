# SPDX-License-Identifier: Apache-2.0
"""What a page asks of the analysis, and how a proposed run becomes a plan: word for word."""

from __future__ import annotations

import asyncio
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
import yaml
from own_loop import finished
from test_panel_investigate import WISH

from flatplank_panel import service as services
from flatplank_panel.investigation import Investigation
from flatplank_panel.next_plan import block_of, plans_of, write_next
from flatplank_panel.service import AnalysisService, PageAnalysis

RUN = {"kappa": 0.05, "fz": "3700", "step_position": 1.5}


@pytest.mark.parametrize(
    ("more", "block"),
    [
        ({}, {}), ({"start": 2}, {"start": 2}), ({"start": 1.5}, {"start_angle_deg": 60.0}),
        ({"speed": 0.0015}, {"speed": 0.0015}), ({"alpha_deg": 1, "gamma_deg": -2},
         {"alpha_deg": 1.0, "gamma_deg": -2.0}),
        ({"preload": -0.02}, {"step_position": 0.0, "waveform": "double_step",
         "waveform_parameters": {"kappa_1": -0.02, "kappa_2": 0.05, "length": 1.5}}),
    ],
)  # fmt: skip
def test_settings_of_a_proposal_as_a_run_of_a_plan(more, block):
    usual = {"measurement": "slip", "kappa": 0.05, "fz": 3700.0, "step_position": 1.5}
    assert block_of({**more, **RUN}) == {**usual, **block}


def test_a_proposal_is_written_as_a_plan(tmp_path):
    proposal = {"what": "two\n  words", "tire": "TOY", "repeats": "2",
                "runs": [{**RUN, "pressure": 2.5}, {**RUN, "kappa": -0.05}]}  # fmt: skip
    path = write_next(proposal, "camp", tmp_path)
    again = write_next({**proposal, "repeats": None, "what": ""}, "camp2", tmp_path)
    assert path == tmp_path / "plans/next_run_camp.yaml"
    text = path.read_text()
    assert text.startswith("# two words\n")
    plan, second = yaml.safe_load(text), yaml.safe_load(again.read_text())
    assert (plan["name"], plan["tire"]) == ("next_run_camp", "TOY")
    assert [(r["kappa"], r["repeats"]) for r in plan["runs"]] == [(0.05, 2), (-0.05, 2)]
    assert [r["repeats"] for r in second["runs"]] == [3, 3]
    own = {title: p for title, p in plans_of(tmp_path).items() if title.startswith("plans/")}
    assert own == {"plans/next_run_camp.yaml": path, "plans/next_run_camp2.yaml": again}
    with pytest.raises(ValueError, match="names no run"):
        write_next({}, "camp", tmp_path)


class Worker:
    """Answers of an analysis; what it is asked is kept."""

    def __init__(self, **answers: Any) -> None:
        self.asked: list[tuple[str, dict[str, Any]]] = []
        self.answers = answers

    async def ask(self, job: str, progress=None, **about: Any) -> Any:
        self.asked.append((job, about))
        if progress:
            progress(f"{job} goes on", 0.25)
        return self.answers.get(job, {})

    def close(self) -> None:
        self.asked.append(("close", {}))


@pytest.fixture
def service(tmp_path) -> AnalysisService:
    for name in ("x", "y"):
        (tmp_path / name).mkdir()
    made = AnalysisService(tmp_path)
    made.browse_jobs = Worker(identify={"left": {"Fx": [2.0, 0.1]}})
    made.fit_jobs = Worker(
        report={"page": str(tmp_path / "reports/x/index.html")},
        diagnose={"next_run": {"runs": [dict(RUN)], "tire": "TOY"}},
    )
    made.investigating = Worker()
    return made


def test_what_is_asked_about_the_folders(service, tmp_path, monkeypatch):
    day = SimpleNamespace(today=lambda: SimpleNamespace(isoformat=lambda: "2026-11-29"))
    monkeypatch.setattr(services, "date", day)

    async def work() -> Any:
        await service.campaigns()
        await service.runs("x")
        await service.curves("x", ("a.csv", "b.csv"), "fx", "time")
        await service.unloaded_turns()
        return await service.identify("x/turn", "hub_2")

    file = "parasitic/parasitic_hub_2_2026-11-29.yaml"
    assert finished(work()) == (file, {"Fx": [2.0, 0.1]})
    root, x = str(tmp_path), str(tmp_path.resolve() / "x")
    assert service.browse_jobs.asked == [
        ("campaigns", {"root": root}), ("runs", {"folder": x}),
        ("curves", {"folder": x, "files": ["a.csv", "b.csv"], "channel": "fx", "over": "time",
                    "beside": ""}),
        ("turns", {"root": root}),
        ("identify", {"root": root, "bag": "x/turn", "mounting": "hub_2", "date": "2026-11-29",
                      "target": str(tmp_path.resolve() / file)}),
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("ask", "said"),
    [(lambda s: s.runs("z"), "'z': no such folder below the data folder"),
     (lambda s: s.curves("x", ["../y/a"], "fx", "time"), "file '../y/a' is outside"),
     (lambda s: s.identify("../x", "m"), "run '../x' is outside"),
     (lambda s: s.identify("x", "a/b"), "not a name")],
)  # fmt: skip
def test_what_lies_outside_is_not_asked_about(service, ask, said):
    with pytest.raises(ValueError, match=said):
        finished(ask(service))
    assert service.browse_jobs.asked == []


def test_the_end_of_the_service_ends_its_workers(service):
    service.close()
    for worker in (service.browse_jobs, service.fit_jobs, service.investigating):
        assert worker.asked == [("close", {})]


def test_a_search_is_kept_until_the_model_changes(service, tmp_path):
    async def work() -> Path:
        page, other = PageAnalysis(service), PageAnalysis(service)
        await page.open("x")
        await other.open("x")
        assert not page.searched and page.progress == ("", 0.0) and not page.busy
        found = await page.diagnose()
        assert found["next_run"]["tire"] == "TOY" == page.next_run["tire"]
        assert page.searched and other.searched and not page.busy
        assert await other.diagnose() == found
        await page.compare()
        assert page.searched
        path = page.plan_next()
        await other.undo()
        assert not page.searched
        await page.diagnose()
        return path

    assert finished(work()) == tmp_path / "plans/next_run_x.yaml"
    jobs = [job for job, _ in service.fit_jobs.asked]
    assert jobs == ["open", "open", "diagnose", "compare", "undo", "diagnose"]
    model = str(tmp_path.resolve() / "x/model.yaml")
    assert service.fit_jobs.asked[2][1] == {
        "folder": str(tmp_path.resolve() / "x"),
        "model": model,
    }


def test_a_job_tells_how_far_it_is(service):
    async def work() -> None:
        page = PageAnalysis(service)
        going = asyncio.Event()

        async def ask(job: str, progress, **about: Any) -> dict[str, Any]:
            progress("reading", 0.5)
            await going.wait()
            return {}

        service.fit_jobs.ask = ask
        opening = asyncio.create_task(page.open("x"))
        await asyncio.sleep(0)
        await asyncio.sleep(0)
        assert page.busy and page.progress == ("reading", 0.5) and page.campaign == ""
        going.set()
        await opening
        assert not page.busy and page.progress == ("", 0.0)

    finished(work())


def test_a_twin_is_told_its_machine(service, tmp_path):
    (tmp_path / "plant.yaml").write_text("{}")
    seen = []

    class Steps(Worker):
        async def ask(self, job: str, progress=None, **about: Any) -> Any:
            seen.append((job, about))
            progress(job, 0.5)
            waiting = {"plan": "p", "minutes": 6.0} if len(seen) == 1 else None
            return {"entries": [], "waiting": waiting, "left": 5.0, "ended": "e", "reason": "r"}

    service.investigating = Steps()
    charge = SimpleNamespace(require_charge=lambda page: None)
    operator: Any = SimpleNamespace(charge=charge)

    async def scene() -> Investigation:
        of = Investigation(service, operator)
        assert of.progress == ("", 0.0) and not of.asking
        wish = {**WISH, "plant": " plant.yaml ", "seed": "7", "tire": "TOY", "minutes": "30"}
        of.begin("page", wish, each=False)
        while of.busy:
            await asyncio.sleep(0)
        return of

    of = finished(scene())
    folder = str(tmp_path.resolve() / WISH["folder"])
    about = {"folder": folder, "minutes": 30.0, "tire": "TOY"}
    twin = {"preset": "", "plant": str((tmp_path / "plant.yaml").resolve()), "seed": 7}
    assert seen == [
        ("choose_batch", about), ("measure_batch", {**about, "twin": twin}),
        ("choose_batch", about),
    ]  # fmt: skip
    assert of.last_message == "ended: e (r)" and of.folder == WISH["folder"] and not of.each
