# SPDX-License-Identifier: Apache-2.0
"""Whole loops: something hidden is found and confirmed, nothing is found where nothing is; the
same on the twin, by the command, and on a graph."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest
from markupsafe import escape

from bare_numbers import bare_numbers, text_of_page
from flatplank_analysis.effects.registry import library
from flatplank_analysis.investigation.evidence import ALPHA
from flatplank_analysis.investigation.loop import Loop, MemoryLog
from flatplank_analysis.investigation.notebook import summary, text_of
from flatplank_analysis.investigation.report import write_notebook
from flatplank_control.cli.investigate import main
from flatplank_sim.sealed.menu import MENU
from flatplank_validation.investigate.fast import FastBench
from printed_words import unknown_in_page, unknown_labels

pytestmark = pytest.mark.timeout(1800)  # whole searches: a busy machine takes minutes
FEW = {n for hidden in MENU.values() for n in hidden.names}
HIDDEN = "defects: {drive_brake_asymmetry: {friction: 0.12}}\n"


def _made(seed: int, name: str, size: float, minutes: float, folder: Path) -> tuple[dict, str]:
    effects = {k: v for k, v in library().items() if k in FEW}
    log = MemoryLog()
    Loop(FastBench(seed, MENU[name].defects(size), effects), log, minutes).run()
    assert write_notebook(log.events, folder, "a made bench") == folder / "index.html"
    return summary(log.events), text_of(log.events)


def test_something_hidden_is_found_and_confirmed(tmp_path):
    told, text = _made(41, "drive_brake_asymmetry", 0.2, 100.0, tmp_path)
    assert told["verdict"]["verdict"].startswith("found"), text
    named = [e["name"] for e in told["verdict"]["effects"]]
    assert named == ["drive_brake_asymmetry"]
    assert told["log_e"] >= -math.log(ALPHA)
    assert told["minutes"] <= 100.0
    assert "runs 1 to 6: six runs to begin with" in text
    assert "against the tire alone over the whole loop, at least the e = 20" in text
    assert json.loads((tmp_path / "investigation.json").read_text()) == told
    json.dumps(told, allow_nan=False)
    decoys = told["decoys"]
    assert decoys["looked_at"] >= 5 * len(told["batches"])
    page = (tmp_path / "index.html").read_text()
    assert list(bare_numbers(text + text_of_page(page))) == []
    assert unknown_labels(text) == unknown_in_page(page) == []
    for words in (
        f"Decoys accepted: {len(decoys['accepted'])} of {decoys['looked_at']}",
        "1. six runs to begin with", "nothing is known yet", "minute 0 to",
        "drive_brake_asymmetry", "Error and floor", "Evidence against the tire alone",
        f"End: {told['ended']}",
    ):  # fmt: skip
        assert words in page, words
    for b in told["batches"]:
        assert str(escape(b["reason"])) in page
        assert str(escape(b["answer"])) in page
    assert page.count("<svg") == 2
    assert all((tmp_path / f"{name}.png").stat().st_size > 1000 for name in ("error", "evidence"))


def test_a_refused_batch_costs_nothing_and_is_not_asked_for_again():
    effects = {k: v for k, v in library().items() if k in FEW}
    log = MemoryLog()
    loop = Loop(FastBench(41, MENU["drive_brake_asymmetry"].defects(0.12), effects), log, 400.0)
    loop.begin()
    loop.decide()
    loop.measure()
    left = loop.left
    refused = []
    for _ in range(3):
        loop.decide()
        if loop.waiting is None:  # nothing else is worth its minutes
            break
        assert loop.left < left
        refused.append(loop.waiting["settings"])
        loop.refuse()
        assert loop.left == left
    assert len(refused) >= 2
    for i, settings in enumerate(refused):  # each is another one
        assert not [s for s in settings for old in refused[:i] if s in old]
    told, text = summary(log.events), text_of(log.events)
    assert told["runs"] == 6 and told["minutes"] == pytest.approx(400.0 - left, abs=0.1)
    assert text.count("no run: ") == text.count("refused: not made") == len(refused)


def test_nothing_is_found_where_nothing_is_hidden(tmp_path):
    told, text = _made(42, "nothing", 1.0, 70.0, tmp_path)
    assert told["verdict"]["effects"] == [], text
    assert told["log_e"] < -math.log(ALPHA)
    assert told["ended"] in ("decided", "budget spent", "nothing left to learn")
    assert told["minutes"] <= 70.0


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--minutes", "0"], "--minutes 0"),
        (["--tire", "TOX", "--sim"], "unknown tire 'TOX'"),
        (["--preset", "thesis2023"], "--preset and --plant"),
    ],
)
def test_bad_input_is_one_line(words, said, tmp_path):
    from flatplank_data.errors import FlatplankError

    with pytest.raises(FlatplankError, match=said):
        main([str(tmp_path / "new"), *words])


def test_too_few_minutes_end_before_anything_moves(tmp_path, capsys):
    assert main([str(tmp_path / "new"), "--sim", "--minutes", "5", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["ended"], told["runs"], told["verdict"]) == ("budget spent", 0, None)
    assert "take 4" in told["reason"]


@pytest.mark.long
def test_on_the_twin(tmp_path, capsys):
    plant = tmp_path / "hidden.yaml"
    plant.write_text(HIDDEN)
    folder = tmp_path / "data"
    words = [str(folder), "--sim", "--plant", str(plant), "--minutes", "70", "--jobs", "2"]
    assert main([*words, "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    first = told["verdict"]["effects"][0]
    assert "drive_brake_asymmetry" in [first["name"], *first["class"]], told["verdict"]
    assert told["log_e"] >= -math.log(ALPHA)
    assert main(words) == 0  # once more: nothing is left to do, the same notebook
    assert (folder / "investigation.txt").read_text().strip() in capsys.readouterr().out
    page = (folder / "investigation" / "index.html").read_text()
    assert 'href="diagnosis/index.html"' in page
    assert (folder / "investigation" / "diagnosis" / "diagnosis.json").exists()
