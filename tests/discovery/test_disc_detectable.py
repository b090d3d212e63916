# SPDX-License-Identifier: Apache-2.0
"""The smallest size that a diagnosis states of every effect is one that it names."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest
from ball import Drag, Wind, throw
from scipy.stats import f as f_distribution
from scipy.stats import norm

from flatplank_analysis.discovery import detectable
from flatplank_analysis.discovery.decide import CONDITIONS, FORM, Scatter
from flatplank_analysis.discovery.decision import CLEAR
from flatplank_analysis.discovery.detectable import smallest_size
from flatplank_analysis.discovery.search import Options, run_search
from flatplank_analysis.discovery.size_errors import SizeErrors
from flatplank_analysis.discovery.verdict import diagnose

SEEDS = range(40, 52)
QUIET = Scatter(1.0, 1e6, 1.0, 1.0, 1e6)
"""no more scatter than the noise model says, known exactly"""
SURE = SizeErrors(4.0, 0.0, 0.0, np.ones(1))
"""a standard deviation of half a unit, and no error of the model"""
LEVEL = 1e-4
OFTEN, CLEAR_OF_ZERO = norm.isf(0.2), CLEAR * norm.isf(0.05)


def named(effect: type, size: float) -> int:
    """How many campaigns with this effect name it."""
    sizes = {"k": 0.0, "a": 0.0} | {("k" if effect is Drag else "a"): size}
    results = [diagnose(run_search(throw(s, **sizes), [Drag, Wind], Options())) for s in SEEDS]
    return sum(effect in [f.decision.term.effect for f in r.found] for r in results)


@pytest.mark.parametrize("effect", [pytest.param(Drag, marks=pytest.mark.long), Wind])
def test_four_in_five_campaigns_name_the_size_that_is_stated(effect):
    """Of a drag, which is limited by what is of consequence, it stated what the noise alone would
    show; of a wind, which the timing of the camera imitates, a third of what is needed."""
    nothing = diagnose(run_search(throw(3, 0.0), [Drag, Wind], Options()))
    size, _ = nothing.detectable[effect.identifier]
    assert named(effect, size) >= 0.6 * len(SEEDS)
    assert named(effect, 0.6 * size) <= 0.2 * len(SEEDS)


def test_each_demand_on_a_size():
    """By the scatter among repeats and conditions, by what is of consequence, and by zero, which
    the interval must not cover: the largest counts."""
    chance = 0.5 * OFTEN
    repeats = 0.5 * math.sqrt(f_distribution.isf(LEVEL, 1, 1e6)) + chance
    assert smallest_size(SURE, QUIET, 1.0, LEVEL, 0.0) == pytest.approx(repeats)
    assert smallest_size(SURE, QUIET, 1.0, LEVEL, 7.0) == pytest.approx(7.0 + chance)
    loose = Scatter(1.0, 1e6, 9.0, 9.0, 1e6)
    conditions = 1.5 * math.sqrt(f_distribution.isf(CONDITIONS, 1, 1e6)) + chance
    assert smallest_size(SURE, loose, 1.0, LEVEL, 0.0) == pytest.approx(conditions, rel=0.01)
    late = SizeErrors(4.0, 0.0, 3.0, np.ones(1))
    left = 1.0 - CLEAR_OF_ZERO**2 * FORM**2 / 0.02
    zero = (CLEAR_OF_ZERO * math.hypot(0.5, 3.0) + chance) / math.sqrt(left)
    assert smallest_size(late, QUIET, 0.02, LEVEL, 0.0) == pytest.approx(zero)
    law = SizeErrors(4.0, 9.0, 0.0, np.ones(1))
    of_law = math.sqrt(9.25 * f_distribution.isf(CONDITIONS, 1, 1e6)) + chance
    assert smallest_size(law, QUIET, 1.0, LEVEL, 0.0) == pytest.approx(of_law)
    # the form alone makes an interval that covers zero, however large the effect
    assert smallest_size(SURE, QUIET, 0.005, LEVEL, 0.0) == math.inf


def test_what_no_size_shows_is_left_out(monkeypatch):
    search = run_search(throw(3, 0.0), [Drag, Wind], Options())
    step, looked_at = search.last, search.looked_at
    assert set(detectable.detectable_sizes(step, looked_at)) == {"drag", "wind"}
    monkeypatch.setattr(detectable, "smallest_size", lambda *_: math.inf)
    assert not detectable.detectable_sizes(step, looked_at)
    monkeypatch.setattr(detectable, "smallest_size", lambda *_: 2.0)
    assert detectable.detectable_sizes(step, looked_at)["drag"] == (0.02, "1/m")
    monkeypatch.setattr(detectable, "VISIBLE", 1.1)
    assert not detectable.detectable_sizes(step, looked_at)


def test_no_size_is_stated_of_a_form_without_a_cause_or_of_a_size_that_is_not_screened():
    def told(generic: bool, main: str) -> bool:
        effect = SimpleNamespace(
            generic=generic,
            linear=lambda: [SimpleNamespace(name="a")],
            main_parameter=lambda: SimpleNamespace(name=main),
        )
        item = SimpleNamespace(candidate=SimpleNamespace(effect=effect), visible=1.0)
        return detectable._may_be_named(item)

    assert told(False, "a")
    assert not told(True, "a") and not told(False, "b")
