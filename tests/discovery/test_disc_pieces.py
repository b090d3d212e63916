# SPDX-License-Identifier: Apache-2.0
"""Which nodes of a record repeat each other: laps, levels, the way back."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from spring import SAMPLES, measured, sine, stairs, there_and_back

from flatplank_analysis.discovery import recurring
from flatplank_analysis.discovery.model import ParameterSet
from flatplank_analysis.discovery.recurring import cut_into_pieces
from flatplank_analysis.discovery.runs import RunSet
from flatplank_analysis.discovery.sources import (
    FOUND,
    PARTLY,
    Source,
    can_show,
    cut_where_needed,
    limited_by_source,
    scatter_lower_bound,
)


def runs_of(*inputs: np.ndarray, **more: np.ndarray) -> RunSet:
    runs = measured(*inputs).runs
    return replace(runs, inputs={**runs.inputs, **more})


def runs_of_any(u: np.ndarray) -> RunSet:
    """A record of any length, of which nothing but the input is asked."""
    one = measured(sine()).runs
    return replace(one, inputs={"u": u[None]}, measured=np.zeros((1, 1, len(u))))


def nodes_of(pieces, name: str) -> list[np.ndarray]:
    return list(pieces.nodes[pieces.condition == pieces.names.index(name)])


def test_laps_are_cut_into_segments():
    """Eight laps of 120 nodes, six segments of 20 each."""
    pieces = recurring.lap_pieces(runs_of(sine()))
    assert pieces.names == tuple(f"record 1, segment {k} of the lap" for k in range(1, 7))
    for k, name in enumerate(pieces.names):
        for lap, nodes in enumerate(nodes_of(pieces, name)):
            np.testing.assert_array_equal(nodes, 120 * lap + 20 * k + np.arange(20))
    assert np.bincount(pieces.condition).tolist() == [8] * 6 and not pieces.rows.any()


@pytest.mark.parametrize(("laps", "segments"), [(40, 2), (80, 1), (4, 6)])
def test_segments_have_twelve_nodes_at_least(laps, segments):
    pieces = recurring.lap_pieces(runs_of(sine(laps)))
    assert len(pieces.names) == segments and pieces.nodes.shape[1] >= 12


def test_laps_begin_where_the_input_does():
    waits = np.concatenate([np.zeros(120), np.sin(2.0 * np.pi * np.arange(SAMPLES - 120) / 120)])
    pieces = recurring.lap_pieces(runs_of(waits))
    first = nodes_of(pieces, pieces.names[0])
    assert [n[0] for n in first] == [120 + 120 * lap for lap in range(7)]


def test_no_laps_where_the_input_does_not_come_again():
    n = np.arange(SAMPLES)
    drifts = np.sin(2.0 * np.pi * n / 120) + n / 960
    assert recurring.lap_pieces(runs_of(drifts)) is None
    # two inputs are periodic together only after a common period
    other = np.sin(2.0 * np.pi * n / 160)[None]
    pieces = recurring.lap_pieces(runs_of(sine(), turn=other))
    assert [x[0] for x in nodes_of(pieces, pieces.names[0])] == [0, 480]
    # an input that stands still says nothing, and one period alone does not come again
    assert recurring.lap_pieces(runs_of(sine(), still=np.zeros((1, SAMPLES)))) is not None
    assert recurring.lap_pieces(runs_of(np.zeros(SAMPLES))) is None
    assert recurring.lap_pieces(runs_of(sine(1))) is None


def test_levels_that_are_held_and_held_again():
    pieces = recurring.level_pieces(runs_of(stairs()))
    u = stairs()
    assert len(pieces.names) == 7 and np.bincount(pieces.condition).tolist() == [2] * 7
    for name in pieces.names:
        one, two = nodes_of(pieces, name)
        assert np.ptp(u[one]) < 1e-9 and np.ptp(u[two]) < 1e-9
        assert abs(u[one].mean() - u[two].mean()) < 1e-9
        # one stretch each, the whole of it
        assert np.ptp(one) >= 55 and abs(one[0] - two[0]) > 60
    # the shape of the ramps in between is in no piece
    used = np.unique(pieces.nodes)
    assert np.abs(np.diff(u, prepend=u[0]))[used].max() < 0.02 * 0.1 * np.ptp(u)


def test_levels_that_are_nearly_the_same_are_one():
    """In steps of a twenty-fifth of the range; held for a twenty-fifth of the record."""
    moves = np.linspace(0.0, 1.0, 3)[1:-1]

    def levels(*held: float, nodes: int = 100):
        pieces = [np.full(nodes, h) for h in held]
        joints = [a + (b - a) * moves for a, b in zip(held, held[1:], strict=False)]
        u = np.concatenate([x for pair in zip(pieces, [*joints, []], strict=True) for x in pair])
        found = recurring.level_pieces(runs_of_any(u))
        return None if found is None else [int(n.split()[-1]) for n in found.names]

    assert levels(0.0, 1.0, 0.405, 0.43, 0.0, 1.0, 0.405, 0.43) == [0, 25, 10, 11]
    assert levels(0.0, 1.0, 0.405, 0.41, 0.0, 1.0) == [0, 25, 10]
    # the first node of a level is not held yet: twelve are, at least
    assert levels(0.0, 1.0, 0.0, 1.0, nodes=12) is None
    assert levels(0.0, 1.0, 0.0, 1.0, nodes=13) == [0, 25]
    # 26 of them, each held for 3.8 hundredths of the record; of 24 it is 4.1 hundredths
    assert levels(*np.tile([0.0, 1.0], 13)) is None
    assert levels(*np.tile([0.0, 1.0], 12)) == [0, 25]


def test_an_input_that_creeps_is_not_held():
    """By a five-hundredth of its range per node."""
    for rate, held in ((0.0019, True), (0.0021, False)):
        rise = rate * np.arange(20)
        u = np.concatenate([rise, np.ones(20), 0.5 + 0.0 * rise, rise, np.ones(20)])
        assert (recurring.level_pieces(runs_of_any(u)) is not None) is held


def test_levels_are_too_few_or_too_short():
    steps = np.repeat([0.0, 1.0, 0.4, 0.7], SAMPLES // 4)
    assert recurring.level_pieces(runs_of(steps)) is None
    short = np.tile(np.repeat([0.0, 1.0], 30), 16)
    assert recurring.level_pieces(runs_of(short)) is None


def test_the_same_values_upwards_and_downwards():
    u = there_and_back()
    pieces = recurring.up_and_down_pieces(runs_of(u))
    assert pieces.names == tuple(f"record 1, part {k} of the range" for k in range(1, 7))
    turn = SAMPLES // 2
    low, high = -0.1, 1.0
    for k, name in enumerate(pieces.names):
        up, down = nodes_of(pieces, name)
        assert up.max() <= turn <= down.min() + 2
        edges = low + (high - low) * np.array([k, k + 1]) / 6.0
        for nodes in (up, down):
            assert (u[nodes[0]], u[nodes[-1]]) == pytest.approx(edges, abs=0.02)
        np.testing.assert_allclose(u[up], u[down], atol=0.01)
    assert recurring.up_and_down_pieces(runs_of(np.linspace(0.0, 1.0, SAMPLES))) is None
    # a step of the sensor back and forth is no turn
    shaken = u + np.diff(u).max() * np.cos(np.pi * np.arange(SAMPLES) / 2.0)
    assert recurring.up_and_down_pieces(runs_of(shaken)).names == pieces.names
    # a sixth of the shorter way has as many nodes as every part; half of the range is a way
    assert pieces.nodes.shape[1] == SAMPLES // 2 // 6
    for back, parts in ((0.48, 6), (0.52, None)):
        way = np.concatenate([np.linspace(0.0, 1.0, 480), np.linspace(1.0, back, 480)])
        found = recurring.up_and_down_pieces(runs_of(way))
        assert (found and len(found.names)) == parts
    # a little way back is none
    hook = np.concatenate([np.linspace(0.0, 1.0, 700), np.linspace(1.0, 0.7, 260)])
    assert recurring.up_and_down_pieces(runs_of(hook)) is None
    assert recurring.up_and_down_pieces(runs_of(u, other=u[None] ** 2)) is None


def test_most_of_every_record_must_come_again():
    laps = np.concatenate([sine()[:240], np.linspace(0.0, 1.0, 720) ** 2])
    assert recurring.lap_pieces(runs_of(laps)) is None
    twice = runs_of(sine(), sine(8, 0.5))
    assert recurring.lap_pieces(twice).rows.tolist() == [0] * 48 + [1] * 48
    assert recurring.lap_pieces(runs_of(sine(), np.linspace(0.0, 1.0, SAMPLES))) is None


def test_a_record_cut_into_pieces():
    """Everything that has a value per node goes with them; the clock of a piece begins at zero."""
    model = measured(sine(), sine(8, 0.5))
    rough = 1.0 + np.arange(2 * SAMPLES, dtype=float).reshape(2, SAMPLES)
    model.runs = replace(model.runs, roughness=rough, facts={"load": np.array([3.0, 4.0])})
    whole = cut_where_needed(model)
    runs, pieces, before = whole.runs, whole.pieces, model.runs
    assert runs.floor_from == "laps" and cut_where_needed(whole) is whole
    rows, nodes = pieces.rows, pieces.nodes
    for i in (0, 7, 50, 95):
        r, n = rows[i], nodes[i]
        np.testing.assert_array_equal(runs.measured[:, i], before.measured[:, r, n])
        np.testing.assert_allclose(runs.time[i], before.time[r, n] - before.time[r, n[0]])
        np.testing.assert_array_equal(runs.roughness[i], rough[r, n])
        np.testing.assert_array_equal(runs.inputs["stretch"][i], before.inputs["stretch"][r, n])
        stretch = runs.coordinates["stretch"].values[i]
        np.testing.assert_array_equal(stretch, before.coordinates["stretch"].values[r, n])
        assert runs.facts["load"][i] == (3.0, 4.0)[r]
        assert runs.names[i] == f"record {r + 1}, part {i + 1}"
    assert runs.order.tolist() == list(range(96))
    base = np.array([8.0, 0.5])
    (found,) = whole.predict([ParameterSet(base)])
    np.testing.assert_allclose(found[0], 8.0 * runs.inputs["stretch"] + 0.5)
    assert cut_into_pieces(replace(before, roughness=None), pieces).roughness is None


def test_what_is_the_floor_itself_cannot_be_shown():
    """Up and down differ by it: on such a floor it is none of the effects."""
    whole = cut_where_needed(measured(there_and_back()))
    runs = whole.runs
    same = np.ones((1, *runs.measured.shape))
    way = np.where(np.arange(12) < 6, 1.0, -1.0)[:, None]
    assert runs.floor_from == "ways" and not can_show(runs, same * way)
    assert can_show(runs, same)
    laps = cut_where_needed(measured(sine())).runs
    differs = np.random.default_rng(1).standard_normal((1, *laps.measured.shape))
    assert can_show(laps, laps.contrast(differs))


def test_the_smallest_scatter_that_is_known():
    """A step of s makes s/sqrt(12); rest and step are seen together, inputs come on top."""
    runs = measured(*[np.linspace(0.0, 1.0, SAMPLES)] * 2).runs
    for known, wanted in (
        ({"resolution": (1.2,)}, 1.2 / 12.0**0.5),
        ({"rest": (0.3,), "resolution": (0.12,)}, 0.3),
        ({"resolution": (12.0**0.5 * 0.3,), "input_noise": (0.4,)}, 0.5),
        ({}, 0.0),
    ):
        assert scatter_lower_bound(replace(runs, **known), 0) == pytest.approx(wanted)


@pytest.mark.parametrize(
    ("most", "verdict", "told", "words"),
    [
        (FOUND, "found", "found", "down to it"),
        (PARTLY, "found", PARTLY, "repeat the conditions"),
        (PARTLY, "found group", PARTLY, "repeat the conditions"),
        (PARTLY, "at floor", "at floor", "the floor is from rest"),
    ],
)
def test_a_verdict_says_no_more_than_its_floor_allows(most, verdict, told, words):
    source = Source("rest", "rest", most, lambda _: True)
    found, reason = limited_by_source(source, verdict, "down to it")
    assert found == told and words in reason and reason.startswith("down to it")
    assert ("the floor is from" in reason) is (most != FOUND)
    assert ("repeat" in reason) is (told == PARTLY)


def test_pieces_scatter_as_the_records_do():
    model = measured(sine())
    model.usual_scatter = (0.02,)
    pieces = recurring.PieceModel(model, recurring.lap_pieces(model.runs), "laps")
    assert pieces.usual_scatter == (0.02,)
    assert pieces.runs.floor_from == "laps"
