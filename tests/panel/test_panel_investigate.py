# SPDX-License-Identifier: Apache-2.0
"""An investigation by mouse: each batch is approved, or all; stopped safely, gone on with."""

from __future__ import annotations

import asyncio
import json
import re
from pathlib import Path
from types import SimpleNamespace

import pytest
import yaml
from looks import looked_after, take
from own_loop import finished
from panel_rig import wait_for

from flatplank_control.investigate.opening import NAME
from flatplank_panel.analysis import investigating
from flatplank_panel.bench_state import Progress
from flatplank_panel.charge import PageInCharge
from flatplank_panel.investigation import Investigation
from flatplank_panel.service import AnalysisService

pytestmark = pytest.mark.timeout(1800)  # whole searches: a busy machine takes minutes
FITS = "document.documentElement.scrollWidth == innerWidth"
PLANT = "defects: {drive_brake_asymmetry: {friction: 0.2}}\n"
WISH = {
    "folder": "looked_for", "minutes": 60.0, "place": "twin", "tire": "", "preset": "",
    "plant": "", "seed": 1,
}  # fmt: skip


class Steps:
    """Answers of the worker: two batches, then the end; a batch that was not made is refused."""

    def __init__(self) -> None:
        self.asked: list[str] = []
        self.made, self.measured = 0, True

    async def ask(self, job, _tell, **about):
        self.asked.append(job)
        if job == "measure_batch":
            if not self.measured:
                raise ValueError("batch_01: 2 of 7 runs are made")
            self.made += 1
        waiting = None
        if job == "choose_batch" and self.made < 2:
            plan = f"batch {self.made + 1}"
            waiting = {"number": self.made + 1, "what": "w", "plan": plan, "minutes": 6.0}
        return {
            "entries": [], "waiting": waiting, "ended": "decided", "reason": "r", "left": 30.0,
        }  # fmt: skip


class Bench:
    """An operator whose runner makes what it is asked when it is told so."""

    def __init__(self) -> None:
        self.charge = PageInCharge()
        self.link = SimpleNamespace(state=SimpleNamespace(progress=Progress()))
        self.plans: list[str] = []

    async def measure(self, page: str, plan: str, folder: str) -> None:
        self.charge.require_charge(page)
        assert folder == WISH["folder"]  # below the data folder, as pages name it
        self.plans.append(plan)
        self.link.state.progress = Progress(True, "slip +2 %", share=0.5, time_left=600.0)

    def over(self) -> None:
        self.link.state.progress = Progress(message="complete")

    async def cancel_measurement(self, page: str) -> None:
        self.charge.require_charge(page)
        self.over()


async def _until(ask) -> None:
    for _ in range(500):
        if ask():
            return
        await asyncio.sleep(0.01)
    raise AssertionError("has not come")


def _investigation(tmp_path: Path) -> tuple[Investigation, Steps, Bench]:
    steps, bench = Steps(), Bench()
    service = AnalysisService(tmp_path)
    service.investigating = steps
    return Investigation(service, bench), steps, bench


def test_each_batch_waits_until_it_is_approved(tmp_path):
    async def scene() -> None:
        of, steps, _ = _investigation(tmp_path)
        of.begin("page", WISH, each=True)
        await _until(lambda: of.asking)
        assert steps.asked == ["choose_batch"]
        assert of.progress == ("waiting to be approved; 36 min left", 0.0)
        with pytest.raises(ValueError, match="under way"):
            of.begin("other", WISH, each=True)
        of.approve_batch("page")
        await _until(lambda: steps.made == 1 and of.asking)
        of.run_all("page")
        await _until(lambda: not of.busy)
        assert steps.asked == ["choose_batch", "measure_batch"] * 2 + ["choose_batch"]
        assert of.progress[0] == "ended: decided (r)"
        with pytest.raises(ValueError, match="no batch waits"):
            of.approve_batch("page")

    finished(scene())


def test_a_refused_batch_is_not_made_and_another_is_chosen(tmp_path):
    async def scene() -> None:
        of, steps, _ = _investigation(tmp_path)
        with pytest.raises(ValueError, match="no batch waits"):
            of.refuse_batch("page")
        of.begin("page", WISH, each=True)
        await _until(lambda: of.asking)
        of.refuse_batch("page")
        await _until(
            lambda: steps.asked == ["choose_batch", "refuse_batch", "choose_batch"] and of.asking
        )
        of.run_all("page")
        await _until(lambda: not of.busy)
        assert steps.asked[3:] == ["measure_batch", "choose_batch"] * 2 and steps.made == 2

    finished(scene())


def test_a_batch_that_was_begun_is_not_refused(tmp_path):
    about = {"folder": str(tmp_path), "minutes": 60.0, "tire": ""}
    told = investigating.choose_batch(lambda *_: None, **about)
    begun = tmp_path / "batch_01.journal.jsonl"
    begun.touch()
    with pytest.raises(ValueError, match="batch_01 was begun: approve it"):
        investigating.refuse_batch(lambda *_: None, **about)
    begun.unlink()
    assert told["left"] < 60.0
    told = investigating.refuse_batch(lambda *_: None, **about)
    assert told["left"] == 60.0 and told["waiting"] is None
    (entry,) = told["entries"]
    assert entry["runs"] == "no run" and entry["answer"].startswith("refused")


def test_on_the_bench_the_runner_makes_them_for_the_page_in_charge(tmp_path):
    async def scene() -> None:
        of, steps, bench = _investigation(tmp_path)
        wish = {**WISH, "place": "bench"}
        with pytest.raises(ValueError, match="charge"):
            of.begin("page", wish, each=False)
        bench.charge.take_charge("page", "me", 0.0)
        of.begin("page", wish, each=False)
        await _until(lambda: bench.plans == ["batch 1"] and "slip" in of.progress[0])
        assert of.progress == ("slip +2 %; 40 min left", 0.5)
        assert steps.made == 0
        bench.over()
        await _until(lambda: bench.plans == ["batch 1", "batch 2"])
        assert steps.made == 1
        # stopped in the middle of the second: it has no answer
        steps.measured = False
        await of.stop("page")
        await _until(lambda: not of.busy)
        assert of.progress[0] == "stopped; batch_01: 2 of 7 runs are made"
        assert steps.made == 1

    finished(scene())


def test_on_the_bench_a_page_that_watches_approves_nothing(tmp_path):
    async def scene() -> None:
        of, _, bench = _investigation(tmp_path)
        bench.charge.take_charge("page", "me", 0.0)
        of.begin("page", {**WISH, "place": "bench"}, each=True)
        await _until(lambda: of.asking)
        for act in (of.approve_batch, of.refuse_batch, of.run_all):
            with pytest.raises(ValueError, match="this page only watches: me is in charge"):
                act("other")
        await asyncio.sleep(0)  # nothing was let go
        assert of.asking and of.each and bench.plans == []
        bench.charge.release_page("page")
        bench.charge.take_charge("other", "you", 0.0)
        of.approve_batch("other")  # who approves makes the batch
        await _until(lambda: bench.plans == ["batch 1"])
        await of.stop("other")
        await _until(lambda: not of.busy)

    finished(scene())


@pytest.mark.parametrize(
    ("wish", "said"),
    [
        ({"folder": "../x"}, "../x"), ({"folder": ""}, "name"), ({"minutes": 0}, "minutes"),
        ({"minutes": None}, "minutes"), ({"plant": "/etc/passwd"}, "outside the data folder"),
        ({"plant": "none.yaml"}, "not there"), ({"tire": "TOX"}, "TOX"),
        ({"place": "moon"}, "moon"), ({"seed": -1}, "seed"), ({"preset": "x"}, "preset"),
    ],
)  # fmt: skip
def test_what_a_page_asks_is_checked(wish, said, tmp_path):
    async def scene() -> None:
        of, _, _ = _investigation(tmp_path)
        with pytest.raises(ValueError, match=said):
            of.begin("page", WISH | wish, each=True)
        assert not of.busy

    finished(scene())


@pytest.mark.browser
def test_it_is_found_on_the_twin_by_mouse(visitor, data: Path, pictures):
    (data / "machine.yaml").write_text(PLANT)
    folder = data / "looked_for"
    who = visitor()
    who.tab("Investigate")
    who.fill("Folder below the data folder", "looked_for")
    who.fill("Bench time [min]", 90)
    who.choose("Where", "on the twin")
    who.fill("Plant file (below the data folder)", "machine.yaml")
    who.click("Begin or go on")
    waits(who, 1)
    who.said("six runs to begin with: three slips")
    who.said("nothing is known yet; 43 of 90 min left")
    assert not list(folder.glob("*.parquet"))
    looked_after(who)
    who.click("Approve")
    wait_for(lambda: list(folder.glob("*.parquet")), 300.0, "a run is made")
    who.click("Stop safely")
    wait_for(lambda: "stopped" in status(who), 30.0, "it is stopped")
    who.click("Begin or go on")
    waits(who, 1)
    who.click("Approve")
    waits(who, 2)
    who.click("Refuse")
    waits(who, 3)
    who.said("refused: not made, and not asked for again")
    assert "e = 1 so far" in (who.page.get_by_text("so far; decoys").text_content() or "")
    looked_after(who)
    for width in (1280, 390):
        who.page.set_viewport_size({"width": width, "height": 1700})
        wait_for(lambda: who.page.evaluate(FITS), 60.0, "nothing is wider than the page")
        take(who, pictures / f"panel-investigate-{width}.png")
    who.page.set_viewport_size({"width": 1440, "height": 1400})
    who.click("Run all")
    wait_for(lambda: "ended: " in status(who), 900.0, "the end")
    who.said("drive_brake_asymmetry")
    who.said("over the whole loop")
    looked_after(who)
    take(who, pictures / "panel-investigate.png")
    assert "drive_brake_asymmetry" in (folder / "investigation.txt").read_text()
    runs = yaml.safe_load((folder / "campaign.yaml").read_text())["runs"]
    assert sorted(r["file"] for r in runs) == sorted(p.name for p in folder.glob("*.parquet"))
    assert not who.errors


def waits(who, number: int) -> None:
    """A batch waits to be approved."""
    batch = who.page.get_by_text(re.compile(rf"^{number}\. ")).first

    def shown() -> bool:
        refused = who.page.locator(".q-notification").all_text_contents()
        assert not refused, refused
        return batch.is_visible() and who.button("Approve").is_enabled()

    wait_for(shown, 600.0, f"batch {number} waits")


def status(who) -> str:
    """What the page says of its work."""
    return who.page.get_by_role("status").filter(visible=True).text_content() or ""


@pytest.mark.browser
@pytest.mark.graph
def test_on_the_bench_a_batch_is_begun_by_mouse_and_stopped_safely(operator, observer, data):
    who, folder = operator, data / "on_the_bench"
    who.tab("Investigate")
    who.fill("Folder below the data folder", "on_the_bench")
    who.fill("Bench time [min]", 60)
    who.click("Begin or go on")
    waits(who, 1)
    assert not list(folder.glob("batch*"))
    who.click("Approve")
    journal = folder / "batch_01.journal.jsonl"

    def begun() -> bool:
        assert "left" in status(who), status(who)
        return journal.exists()

    wait_for(begun, 120.0, "the runner has begun")

    def left() -> int:
        found = re.search(r"; (\d+) min left$", status(who))
        return int(found[1]) if found else 0

    # 17 after the batch, and the minutes of its runs
    wait_for(lambda: 50 < left() <= 62, 120.0, "the minutes of the runs to come are told")
    who.click("Stop safely")
    wait_for(lambda: "stopped; batch_01: 0 of 7 runs are made" in status(who), 120.0, "the end")
    observer.wait(lambda: not observer.enabled(), 60.0, "the wheel is not driven")
    events = (folder / NAME).read_text().splitlines()
    assert [json.loads(e)["event"] for e in events] == ["begin", "batch"]
    who.click("Look")
    who.said("six runs to begin with: three slips")
