# SPDX-License-Identifier: Apache-2.0
"""A force that is in no library: the loop ends with a proposal, in notebook, page and JSON."""

from __future__ import annotations

import json

import numpy as np
import pytest

from flatplank_analysis.effects.checks import check_effect
from flatplank_analysis.effects.registry import library, load_file
from flatplank_analysis.investigation.loop import Loop
from flatplank_analysis.investigation.notebook import summary, text_of
from flatplank_analysis.investigation.report import write_notebook
from flatplank_control.investigate.opening import DiskLog, propose_effect
from flatplank_panel.analysis.investigating import investigation_state
from flatplank_sim.sealed.menu import MENU, OUTSIDE
from flatplank_validation.investigate.fast import FastBench

pytestmark = pytest.mark.timeout(1800)  # whole searches: a busy machine takes minutes
SIZE = 110.0
NAMES = {n for m in MENU.values() for n in m.names} - {"worn_patch"}
"""with eight runs a worn patch stands for the force, see docs/explanation/search.md"""
FEW = {k: v for k, v in library().items() if k in NAMES}


@pytest.mark.long
def test_what_no_effect_explains_is_proposed_at_the_end(tmp_path):
    force, place = OUTSIDE["bump"](SIZE, np.random.default_rng(8))
    bench, log = FastBench(77, effects=FEW, force=force), DiskLog(tmp_path)
    at_end = lambda session, result: propose_effect(session, result, tmp_path)  # noqa: E731
    Loop(bench, log, 90.0, at_end=at_end).run()
    told, text = summary(log.events), text_of(log.events)
    assert told["verdict"]["verdict"] in ("none of these", "partly"), text
    found = told["proposal"]
    assert found is not None and found["verdict"] == "proposed", text
    assert "plank position" in found["reason"], (found, place)
    (effect,) = load_file(found["file"])
    assert check_effect(effect) == []
    page = write_notebook(log.events, tmp_path / "investigation", "a made bench").read_text()
    shown = investigation_state(lambda _text, _share: None, str(tmp_path))
    kept = json.loads((tmp_path / "investigation" / "investigation.json").read_text())
    assert kept["proposal"] == found
    for words in (text, page, shown["proposal"]):
        assert f"proposed: {found['reason']}" in words
        assert "a guess until `flatplank confirm` has seen new runs" in words
    assert "acts_on: " in shown["code"] and "acts_on: " in page
