# SPDX-License-Identifier: Apache-2.0
"""A campaign of somebody else on the page: its Python is shown first, and runs after consent."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml
from made_up import campaign
from panel_rig import shows, status, wait_for

from flatplank_analysis.discovery.modelfile import FORMAT
from flatplank_panel.analysis.worker import do_request

PYTHON = """import pathlib
from dataclasses import dataclass

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.base import Signal, TireEffect

pathlib.Path({mark!r}).write_text("ran")


@dataclass(frozen=True)
class Pull(TireEffect):
    identifier = "pull"
    title = "<script>document.title = 'ran'</script>"
    coordinate = "slip level"
    source = what = check = removes = "<img src=x onerror=alert(1)>"
    force: float = param(0.0, unit="N", bounds=(-99, 99), screen=10.0, matters=5.0)

    def signal(self, signal: Signal) -> None:
        signal.fx = signal.fx + self.force * (signal.data.kappa[:, None] > 0.0)
"""


def colleague(folder: Path, mark: Path) -> Path:
    """A campaign whose model runs a file that leaves a mark."""
    campaign(folder)
    (folder / "some.py").write_text(PYTHON.format(mark=str(mark)))
    model = {"format": FORMAT, "effects": [{"name": "pull", "file": "some.py"}]}
    (folder / "model.yaml").write_text(yaml.safe_dump(model))
    return folder


def quiet(_text: str, _share: float) -> None:
    pass


def test_the_worker_shows_a_file_and_runs_what_was_shown(tmp_path: Path) -> None:
    mark = tmp_path / "mark"
    folder = colleague(tmp_path / "colleague", mark)
    about = {"folder": str(folder), "model": str(folder / "model.yaml")}
    answer = do_request({"do": "open", "with": about}, quiet)
    asked = answer["consent"]
    assert asked["text"] == (folder / "some.py").read_text() and not mark.exists()
    shown = {"file": asked["file"], "digest": asked["digest"]}
    (folder / "some.py").write_text(asked["text"] + "# more\n")
    assert "was changed" in do_request({"do": "allow", "with": shown}, quiet)["error"]
    (folder / "some.py").write_text(asked["text"])
    assert do_request({"do": "allow", "with": shown}, quiet) == {"result": {}}
    opened = do_request({"do": "open", "with": about}, quiet)["result"]
    assert opened["effects"] == [{"name": "pull", "text": "pull"}] and mark.exists()


@pytest.mark.browser
def test_the_page_asks_and_shows_the_text(visitor, data: Path, tmp_path: Path) -> None:
    mark, who = tmp_path / "mark", visitor()
    folder = colleague(data / "colleague", mark)
    who.tab("Discover")
    shows(who, "colleague (")
    who.click("Open")
    shown = who.page.get_by_role("region", name="Python of the model")
    shown.wait_for()
    assert (shown.text_content() or "").strip() == (folder / "some.py").read_text().strip()
    who.click("Do not run it")
    wait_for(lambda: who.page.get_by_text("not allowed to run").count() > 0, what="it is refused")
    assert not mark.exists()
    who.click("Open")
    who.click("Let it run")
    wait_for(lambda: "floor" in status(who), 300.0, "the model is fitted")
    assert mark.exists() and who.page.title() == "Flat Plank"
    assert not who.errors
