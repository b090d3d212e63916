# SPDX-License-Identifier: Apache-2.0
"""Killed at every step: it goes on, no run is lost or doubled, and the end is the same."""

from __future__ import annotations

import json
import multiprocessing
import random
import signal
from pathlib import Path

import pytest
import yaml
from inv_stub import BAD, ENOUGH, investigate

from flatplank_analysis.investigation.notebook import summary, text_of
from flatplank_control.investigate.opening import NAME, DiskLog
from flatplank_data.errors import FlatplankError

pytestmark = pytest.mark.timeout(900)  # fifty processes: a busy machine takes minutes


def _events(folder: Path) -> list[dict]:
    return [json.loads(line) for line in (folder / NAME).read_text().splitlines()]


def _in_a_process(folder: Path, at: int) -> int:
    process = multiprocessing.get_context("fork").Process(target=investigate, args=(folder, at))
    process.start()
    process.join()
    return process.exitcode


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The folder of an investigation that nobody killed."""
    folder = tmp_path_factory.mktemp("whole")
    assert _in_a_process(folder, 0) == 0
    return folder


def test_it_begins_with_six_runs_and_comes_to_its_end(whole):
    told = summary(_events(whole))
    assert (told["ended"], told["runs"], told["runs_before"]) == ("decided", ENOUGH, 0)
    assert len(told["batches"][0]["settings"]) == 6
    assert told["batches"][0]["bet"] == []
    made = sum(len(b["files"]) for b in told["batches"][1:])
    assert told["log_e"] == pytest.approx(0.25 * made)


def test_rejected_runs_are_handed_back_and_not_asked_for_ever(whole):
    told = summary(_events(whole))
    asked = [b for b in told["batches"] if b["settings"][0]["kappa"] == BAD]
    assert len(asked) == 2
    assert told["handed_back"] == 4
    listed = {r["file"] for r in yaml.safe_load((whole / "campaign.yaml").read_text())["runs"]}
    assert not any("_1perc_" in name for name in listed)
    assert "handed back: slip +1 %, start 2" in text_of(_events(whole))


def test_no_two_runs_share_a_name_or_a_number(whole):
    runs = yaml.safe_load((whole / "campaign.yaml").read_text())["runs"]
    for key in ("file", "run_index"):
        assert len({r[key] for r in runs}) == len(runs)


def test_killed_at_fifty_steps(whole, tmp_path):
    draw = random.Random(11)
    killed = 0
    expected = _events(whole)
    files = sorted(p.name for p in whole.iterdir())
    for number in range(10):
        folder = tmp_path / str(number)
        folder.mkdir()
        for _ in range(5):
            killed += _in_a_process(folder, draw.randint(1, 14)) == -signal.SIGKILL
        assert _in_a_process(folder, 0) == 0
        assert _events(folder) == expected
        assert sorted(p.name for p in folder.iterdir()) == files
    assert killed == 50


def test_more_minutes_go_on_after_the_end(whole, tmp_path):
    log = DiskLog(tmp_path)
    log.write({"event": "begin", "minutes": 5.0, "files": []})
    log.write({"event": "end", "why": "budget spent", "reason": "r", "verdict": None})
    log.write({"event": "begin", "minutes": 50.0})
    told = summary(log.events)
    assert (told["budget"], told["ended"]) == (50.0, None)


def test_another_file_of_that_name_is_refused(tmp_path):
    (tmp_path / NAME).write_text('{"format": "something/1"}\n')
    with pytest.raises(FlatplankError, match="is not of format"):
        DiskLog(tmp_path)
