# SPDX-License-Identifier: Apache-2.0
"""From where the base and an effect are fitted, and how far."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np
import pytest
from shapes import LONG, OTHER, TIME, Hum, Hummed, Sum, measured, searched

from flatplank_analysis.discovery.fit import Fitter
from flatplank_analysis.discovery.parameters import Parameter
from flatplank_analysis.discovery.state import start_base
from flatplank_analysis.discovery.verdict import AT_FLOOR, diagnose


class Tone(Sum):
    """level + sin(2 pi f t): from a wrong pitch no fit gets to the right one."""

    parameters = (
        Parameter("level", "1", 0.0, -5.0, 5.0, 0.1),
        Parameter("pitch", "1/s", 0.5, 0.1, 3.0, 0.02),
    )

    def predict(self, sets):
        out = np.empty((len(sets), *self.runs.measured.shape))
        for row, one in zip(out, sets, strict=True):
            row[0] = one.base[0] + np.sin(2.0 * np.pi * one.base[1] * TIME)
            for effect, values in one.effects:
                row[0] += values[0] * effect.form(self.setting)
        return out


def test_a_base_in_a_corner_is_fitted_from_elsewhere():
    heard = measured(20, (1.0, lambda c: np.sin(2.0 * np.pi * 1.2 * TIME)))
    tone = Tone(replace(heard.runs, measured=heard.runs.measured - 0.1 * TIME))
    alone = searched(tone, LONG, OTHER)
    assert alone.starts == 1 and alone.steps[0].state.floors[0].unexplained > 0.3
    tone.starts = ({"pitch": 2.5}, {"pitch": 1.15})
    search = searched(tone, LONG, OTHER)
    assert search.starts == 3 and diagnose(search).verdict == AT_FLOOR
    assert search.last.state.fit.base[1] == pytest.approx(1.2, abs=0.01)
    # where nothing is left, no other start is tried
    assert searched(tone, LONG, start={"pitch": 1.15}).starts == 1


def test_a_search_tells_what_it_does_and_how_long_it_took():
    heard = measured(20, (1.0, lambda c: np.sin(2.0 * np.pi * 1.2 * TIME)), (0.1, LONG.form))
    tone = Tone(replace(heard.runs, measured=heard.runs.measured - 0.1 * TIME))
    tone.starts = ({"pitch": 2.5}, {"pitch": 1.15})
    told, began = [], time.perf_counter()
    search = searched(tone, LONG, OTHER, progress=lambda *what: told.append(what))
    assert 0.0 < search.base_fit < search.first_ranking < search.seconds
    assert search.seconds < time.perf_counter() - began
    assert told[0] == ("fit of the base", 0.0) and ("other starts", 0.9) in told
    assert {text for text, _ in told} >= {"effects beside the base", "noise beside long", "answer"}
    assert all(0.0 <= share < 1.0 for _, share in told)


@pytest.mark.parametrize(("known", "found"), [({}, 0), ({"hum": {"pitch": 2.05}}, 1)])
def test_an_effect_starts_from_what_was_measured_on_the_machine(known, found):
    model = Hummed(measured(27, (0.2, lambda c: np.sin(2.0 * np.pi * 2.1 * TIME))).runs)
    named = searched(model, Hum, measured=known).last.found
    assert len(named) == found
    pitches = [f.decision.term.named()["pitch"] for f in named]
    assert pitches == [pytest.approx(2.1, abs=0.01)] * found


class Pair(Sum):
    """Two channels with one level."""

    def predict(self, sets):
        return np.repeat(super().predict(sets)[:, :1], 2, axis=1)


def test_the_base_is_fitted_with_the_weights_that_later_fits_use():
    """One channel scatters from run to run, but hardly along a run: the first weights trust it."""
    runs = measured(26, noise=0.01).runs
    offsets = 0.5 * np.random.default_rng(26).standard_normal((runs.runs, 1))
    x, y = runs.measured[0] + offsets, runs.measured[0] - 0.3
    model = Pair(replace(runs, channels=("x", "y"), measured=np.stack([x, y])))
    state = searched(model, LONG).steps[0].state
    again = state.fitter.fit(state.fit.base)
    assert state.fitter.error(again) > 0.99 * state.fitter.error(state.fit)
    assert state.fit.base[0] == pytest.approx(0.7, abs=0.005)


def test_channels_count_by_their_weights():
    runs = measured(29, noise=0.0).runs
    x = runs.measured[0]
    model = Pair(replace(runs, channels=("x", "y"), measured=np.stack([x, x + 2.0])))
    fit = Fitter(model, np.array([10.0, 1.0])[:, None, None]).fit(start_base(model))
    assert fit.base == pytest.approx([1.0 + 2.0 / 101.0, 0.1], rel=1e-5)
