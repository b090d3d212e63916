# SPDX-License-Identifier: Apache-2.0
"""The page Catalogue: the runs of all campaigns in the language of the command, page by page."""

from __future__ import annotations

import os
import shutil
import time
from datetime import date, timedelta
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest
from looks import looked_after, take
from made_up import campaign
from own_loop import finished
from panel_rig import wait_for

from flatplank_analysis.catalogues.kept import SCHEMA, file_of, store
from flatplank_panel.analysis.catalogue_jobs import catalogue
from flatplank_panel.analysis.chart_jobs import reference_chart
from flatplank_panel.analysis.worker import do_request
from flatplank_panel.service import AnalysisService

FOLDERS, EACH = 3704, 27
"""100,008 records"""
ASKED = "tire=T3 pressure=2.5bar since=2026-05-01"


def quiet(_text: str, _share: float) -> None:
    """Progress that nobody looks at."""


def large(root: Path, folders: int = FOLDERS) -> Path:
    """A catalogue of records that nobody has measured; no campaigns are there."""
    count = folders * EACH
    k = np.arange(count)
    texts = {
        "folder": [f"c{i // EACH:04d}" for i in k], "file": [f"run_{i % EACH:02d}" for i in k],
        "tire": [f"T{i // EACH % 8}" for i in k], "kind": ["slip"] * count,
        "quality": ["ok"] * count, "bench": [f"hall {i // EACH % 2}" for i in k],
        "date": [(date(2026, 1, 1) + timedelta(days=int(i) // EACH % 300)).isoformat() for i in k],
    }  # fmt: skip
    numbers = {"kappa": (k % EACH - 13) * 0.01, "fz": np.full(count, 3700.0),
               "pressure": np.where(k // EACH % 2 == 1, 2.5, 2.0),
               "effective_rolling_radius": np.full(count, 0.3109)}  # fmt: skip
    own = {**texts, **numbers}
    columns = [pa.array(own.get(f.name, [None] * count), f.type) for f in SCHEMA]
    store(str(root), pa.Table.from_arrays(columns, schema=SCHEMA), {})
    return root


@pytest.fixture(scope="module")
def records(tmp_path_factory) -> Path:
    return large(tmp_path_factory.mktemp("large"))


def test_a_hundred_thousand_records_answer_within_a_second(records):
    wanted = {"root": str(records), "where": ASKED, "order": "kappa", "descending": True}
    begun = time.process_time()
    catalogue(quiet, **wanted)
    read, asked = time.process_time() - begun, time.process_time()
    found = catalogue(quiet, **wanted, first=50)
    took = time.process_time() - asked
    print(f"first answer {read:.3f} s, further ones {took:.3f} s of processor time")
    assert read < 1.0 and took < 1.0
    assert found["of"] == FOLDERS * EACH and len(found["rows"]) == 50
    days = [k % 300 for k in range(FOLDERS) if k % 8 == 3]
    assert found["size"] == EACH * sum(day >= 120 for day in days)
    first = found["rows"][0]
    assert {first[k] for k in ("tire", "pressure")} == {"T3", "2.5"} and first["kappa"] == "13"


def test_values_are_those_that_people_see(tmp_path):
    campaign(tmp_path / "x" / "deep" / "down" / "here")
    rows = catalogue(quiet, str(tmp_path), "slip=-5%")["rows"]
    assert len(rows) == 3
    seen = {name: rows[0][name] for name in ("kappa", "fz", "pressure", "date")}
    assert seen == {"kappa": "-5", "fz": "3700", "pressure": "2.5", "date": "-"}
    assert rows[0]["effective_rolling_radius"] == "310"


def test_a_folder_without_a_catalogue_gets_one_and_tells_it(tmp_path):
    campaign(tmp_path / "x")
    told: list[tuple[str, float]] = []
    found = catalogue(lambda *words: told.append(words), str(tmp_path))
    assert found["size"] == found["of"] == 9 and file_of(tmp_path).exists()
    assert told[0] == ("this folder has no catalogue yet, it is made", 0.0)
    assert told[-1] == ("this folder has no catalogue yet, it is made: folder 1 of 1", 1.0)
    campaign(tmp_path / "y")
    assert catalogue(quiet, str(tmp_path))["size"] == 9
    again = catalogue(quiet, str(tmp_path), again=True)
    assert again["size"] == 18 and again["folders"] == 2
    file_of(tmp_path).unlink()
    shutil.rmtree(tmp_path / "y")
    assert catalogue(quiet, str(tmp_path))["size"] == 9


def test_a_folder_that_cannot_be_written_is_read_once(tmp_path, monkeypatch):
    def refuse(*_words, **_more):
        raise PermissionError(13, "Permission denied")

    campaign(tmp_path / "x")
    monkeypatch.setattr(os, "replace", refuse)
    told: list[str] = []
    for _ in range(2):
        found = catalogue(lambda text, _: told.append(text), str(tmp_path))
        assert found["size"] == 9 and not found["kept"]
    assert len(told) == 2


def test_files_that_cannot_be_used_are_told(tmp_path):
    next(campaign(tmp_path / "x").glob("*.parquet")).unlink()
    found = catalogue(quiet, str(tmp_path))
    assert found["size"] == 8 and found["unusable"] == 1
    assert found["errors"][0].startswith("x: ") and "no such file" in found["errors"][0]


@pytest.mark.parametrize(
    ("where", "said"),
    [
        ("tyre=TOY", "where: no condition 'tyre'; the nearest is 'tire'; write KEY=VALUE"),
        ("tire=TOY load", "where: 'load' is not KEY=VALUE; write tire=TOY"),
        ("bench='hall", "where: a quote has no end; write bench='hall 2'"),
        ("tire=TOY tire=CON", "where: 'tire' is there twice"),
        ("since=May", "where, since: 'May' is no date"),
    ],
)
def test_a_wrong_condition_is_told_in_a_line(tmp_path, where, said):
    request = {"do": "catalogue", "with": {"root": str(tmp_path), "where": where}}
    assert do_request(request, quiet)["error"].startswith(said)


def test_the_service_asks_about_the_data_folder(tmp_path):
    campaign(tmp_path / "x")

    async def asked():
        service = AnalysisService(tmp_path)
        found = await service.catalogue("slip=5%", order="start", descending=True, count=2)
        with pytest.raises(ValueError, match="2500 characters, at most 2000"):
            await service.catalogue("x" * 2500)
        process = service.cataloguing._process
        service.close()
        await process.wait()
        return found

    found = finished(asked())
    assert found["size"] == 3 and [row["start"] for row in found["rows"]] == ["3", "2"]


def sessions(root: Path) -> None:
    """The reference tire on five days."""
    for k in range(5):
        campaign(root / f"s{k}", scatter=0.004 * (3 * k % 5), repeats=1, rate=20.0)


def test_the_reference_tire_is_charted(tmp_path):
    sessions(tmp_path)
    told: list[str] = []
    target = tmp_path / "reports" / "reference_tire"
    found = reference_chart(lambda text, _: told.append(text), str(tmp_path), "", str(target))
    assert "session 5 of 5: s4" in told and Path(found["page"]).exists()
    drawn = {figure["title"]: figure for figure in found["figures"]}
    assert any("slip stiffness" in title for title in drawn)
    assert all("<svg" in f["svg"] and "s0 to" in f["caption"] for f in found["figures"])
    again = catalogue(quiet, str(tmp_path), again=True)
    assert again["unusable"] == 0 and again["folders"] == 5, "a report is no campaign"


@pytest.fixture
def lab(data):
    """Campaigns below the data folder of the panel, which has no catalogue yet."""
    shutil.rmtree(data / ".flatplank-cache", ignore_errors=True)
    campaign(data / "lab" / "a" / "b" / "deep")
    sessions(data / "lab" / "sessions")
    yield data / "lab"
    shutil.rmtree(data / "lab")
    shutil.rmtree(data / "reports" / "reference_tire", ignore_errors=True)


@pytest.mark.browser
def test_runs_are_found_opened_and_charted_by_mouse(visitor, lab, pictures):
    who = visitor()
    who.tab("Catalogue")
    who.page.get_by_text("as of").wait_for()
    who.field("Conditions").fill("tyre=TOY")
    who.click("Find")
    who.page.get_by_text("no condition 'tyre'; the nearest is 'tire'").wait_for()
    who.field("Conditions").fill("folder=lab/a slip=5%")
    who.page.keyboard.press("Enter")
    who.page.get_by_text("3 of the ").wait_for()
    assert not who.page.get_by_text("no condition").is_visible()
    who.page.get_by_role("columnheader", name="Start").click()
    who.page.get_by_role("columnheader", name="Start").click()  # the second click turns it round
    name = "TOY_REL_LNG_5perc_T_p25_Fz3700_3.parquet"
    who.page.locator(".fp-table tbody tr:first-child").get_by_text(name).wait_for()
    looked_after(who)
    who.page.get_by_role("button", name=name).click()
    who.page.get_by_label(f"Select {name}").wait_for()
    assert who.field("Campaign").input_value().startswith("lab/a/b/deep")
    who.page.get_by_text("1 record selected").wait_for()
    who.tab("Catalogue")
    who.field("Conditions").fill("folder=lab/sessions")
    who.click("Find")
    who.page.get_by_text("15 of the ").wait_for()
    who.click("Draw")
    charts = who.page.get_by_role("img", name="Reference tire")
    wait_for(lambda: charts.count() >= 2, 120.0, "the charts are drawn")
    who.page.set_viewport_size({"width": 1440, "height": 1330})
    take(who, pictures / "panel-catalogue.png")
    assert not who.errors
