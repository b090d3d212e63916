# SPDX-License-Identifier: Apache-2.0
"""Decoys: refused where nothing is left, seen where the data have one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flatplank_analysis.contact_patch.model import TireModel
from flatplank_analysis.effects.registry import library
from flatplank_analysis.inference.search import run_search
from flatplank_analysis.investigation import decoys
from flatplank_validation.investigate.fast import FastBench

pytestmark = pytest.mark.timeout(900)
FEW = {
    n: library()[n]
    for n in ("drive_brake_asymmetry", "parasitic_force", "road_play", "mesh_ripple", "worn_patch")
}


@pytest.fixture(scope="module")
def search():
    bench = FastBench(901, effects=FEW)
    session = bench.session(bench.make(bench.seed().settings, 0))
    return run_search(session.model, list(FEW.values()))


def test_none_is_accepted_where_nothing_is_hidden_and_the_search_is_left_alone(search):
    before = search.last.state.candidates
    found = decoys.decoys_of(search)
    assert found.looked_at >= 2
    assert found.accepted == ()
    assert search.last.state.candidates is before
    assert decoys.decoys_of(search) == found


def test_one_that_the_machine_had_is_accepted(search):
    state = search.last.state
    groups = state.runs.groups
    order = decoys._derangement(groups, "".join(state.runs.names))
    item = max(search.last.screen.ranked, key=lambda i: i.visible)
    column = decoys._decoy(item, groups, order).column
    size = 80.0 / np.sqrt(np.mean(column[0] ** 2))
    data = search.model.data
    runs = replace(data.runs, measured=data.runs.measured + size * column)
    model = TireModel(replace(data, runs=runs))
    made = decoys.decoys_of(run_search(model, list(FEW.values())))
    assert f"decoy_of_{item.identifier}" in made.accepted
