# SPDX-License-Identifier: Apache-2.0
"""State of the page without a browser: rings, samples, live data, strict JSON, previews."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from panel_samples import COLUMN, samples, strict

from flatplank_data.waveforms import WAVEFORMS
from flatplank_hw.bus.image import AXES
from flatplank_hw.bus.timing import BusTiming, told_times
from flatplank_panel.analysis.worker import to_strict_json
from flatplank_panel.bench_state import BEHIND, BenchState, Ring, Slip
from flatplank_panel.live import LiveData, script
from flatplank_panel.signals import SIGNALS
from flatplank_panel.views.drive import preview


def test_ring_forgets_the_oldest():
    ring = Ring(4, 2)
    for i in range(11):
        ring.push((i, -i))
    assert ring.serial == 11
    assert ring.since(9).tolist() == [[9, -9], [10, -10]]
    assert ring.since(0)[:, 0].tolist() == [7, 8, 9, 10]
    assert ring.since(11).shape == (0, 2)


def test_state_takes_a_row_per_new_cycle_and_stays_small():
    state = BenchState()
    for cycle in (1, 1, 2, 3):
        state.accept(samples(cycle, 10.0 * cycle), cycle * 0.05)
    assert state.ring.serial == 3
    assert state.ring.since(0)[:, COLUMN["fz"]].tolist() == [10.0, 20.0, 30.0]
    assert state.state_texts(0.2)["state"] == "operation enabled"
    assert state.state_texts(9.0)["bench"] == "not running"
    assert [a["axis"] for a in state.axes(0.2)] == list(AXES)
    assert state.axes(9.0) == []


def test_samples_far_behind_the_bus_are_missing():
    """The hub has died: no number of its last sample is shown or drawn."""
    state = BenchState()
    for cycle in range(0, BEHIND + 100, 50):
        now = samples(cycle)
        now.hub = samples(0).hub
        now.slip = Slip(0, 0.1, 0.1)
        state.accept(now, 0.0)
    gone = np.isnan(state.ring.since(0))
    for key in ("fx", "mz", "rl", "slip", "slip_ref"):
        assert gone[:, COLUMN[key]].tolist() == [False] * 6 + [True], key
    assert not gone[:, [COLUMN[key] for key in ("t", "x", "vel")]].any()
    assert "filter" not in state.state_texts(0.0) and "plank" in state.state_texts(0.0)


def test_another_bus_begins_with_an_empty_table():
    """Neither rows nor samples of the bus before it are mixed in."""
    state = BenchState()
    live = LiveData(state)
    for cycle in (1000, 1010):
        state.accept(samples(cycle), 0.0)
    live.tick()
    state.accept(samples(1020), 0.0)
    begins = samples(3)
    begins.hub = samples(1020).hub
    state.accept(begins, 0.0)
    message = strict(live.tick())
    assert message["begun"] == 3 and message["serial"] == 4
    (row,) = message["rows"]
    assert row[COLUMN["t"]] == 0.0 and row[COLUMN["fz"]] is None
    assert state.ring.since(0).shape[0] == 1


def test_live_message_is_strict_json_with_what_is_new():
    state = BenchState()
    live = LiveData(state)
    state.accept(samples(1), 0.0)
    first = strict(live.tick())
    again = strict(live.tick())
    assert len(first["rows"]) == 1 and len(first["rows"][0]) == len(SIGNALS)
    assert first["rows"][0][COLUMN["pos_ref"]] is None
    assert again["rows"] == [] and again["serial"] == 1


def test_nothing_in_a_message_ends_its_script():
    text = script({"name": "</script><!-- & '\u2028"})
    assert not set("<>&\u2028") & set(text)
    assert json.loads(text) == {"name": "</script><!-- & '\u2028"}


@pytest.mark.parametrize("name", sorted(WAVEFORMS))
def test_preview_of_every_waveform_is_the_waveform(name):
    wave = WAVEFORMS[name]()
    points = np.array(preview(name, {}, 1.5))
    after = points[points[:, 0] > 1.5]
    assert np.allclose(after[:, 1], [100.0 * wave.slip(x - 1.5) for x in after[:, 0]], atol=0.2)
    assert (points[points[:, 0] < 1.5][:, 1] == 0.0).all()


def test_answers_of_the_analysis_are_strict_json():
    value = {"a": np.array([1.0, math.nan]), "b": (np.float64(2.5), math.inf), 3: "x"}
    assert (
        json.dumps(to_strict_json(value), allow_nan=False)
        == '{"a": [1.0, null], "b": [2.5, null], "3": "x"}'
    )


def test_the_times_of_the_bus_and_the_troubles_are_words():
    timing = BusTiming()
    for cycle in range(200):
        timing.add_wake_up(60_000)
        timing.add_frame(cycle, 1, (1 + cycle) * 4_000_000)
    timing.late = 5
    state = BenchState()
    state.times = told_times({key: str(value) for key, value in timing.values().items()})
    state.troubles = {"/simulated_plant": "too slow (12 batches left out so far)"}
    state.accept(samples(1), 0.0)
    words = state.state_texts(0.0)
    assert words["late"] == "5 of 200 (2.5 %)"
    assert words["troubles"] == "/simulated_plant: too slow (12 batches left out so far)"
    assert words["wake_up"] == "p50 60, p99 60, p99.9 60, p99.99 60, worst 60 µs"
    assert words["frame_to_frame"].endswith("p99.99 4000, worst 4000 µs")
    assert told_times({"cycle": "7"}) is None
