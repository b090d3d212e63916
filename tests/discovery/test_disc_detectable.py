# SPDX-License-Identifier: Apache-2.0
"""The smallest size that a diagnosis states of every effect is one that it names."""

from __future__ import annotations

import pytest
from ball import Drag, Wind, throw

from flatplank_analysis.discovery.verdict import diagnose
from flatplank_analysis.inference import detectable
from flatplank_analysis.inference.search import run_search

SEEDS = range(40, 52)


def named(effect: type, size: float) -> int:
    """How many campaigns with this effect name it."""
    sizes = {"k": 0.0, "a": 0.0} | {("k" if effect is Drag else "a"): size}
    results = [diagnose(run_search(throw(s, **sizes), [Drag, Wind])) for s in SEEDS]
    return sum(effect in [f.decision.term.effect for f in r.found] for r in results)


@pytest.mark.parametrize("effect", [pytest.param(Drag, marks=pytest.mark.long), Wind])
def test_four_in_five_campaigns_name_the_size_that_is_stated(effect):
    """A drag is limited by what is of consequence, a wind by what the timing of the camera
    imitates."""
    nothing = diagnose(run_search(throw(3, 0.0), [Drag, Wind]))
    size, _ = nothing.detectable[effect.identifier]
    assert named(effect, size) >= 0.6 * len(SEEDS)
    assert named(effect, 0.6 * size) <= 0.2 * len(SEEDS)


def test_what_no_size_shows_is_left_out(monkeypatch):
    scales = run_search(throw(3, 0.0), [Drag, Wind]).scales
    assert set(detectable.detectable_sizes(scales)) == {"drag", "wind"}
    monkeypatch.setattr(detectable, "detectable_size", lambda *_: 0.02)
    assert detectable.detectable_sizes(scales)["drag"] == (0.02, "1/m")
    monkeypatch.setattr(detectable, "detectable_size", lambda *_: 2.1)
    assert not detectable.detectable_sizes(scales)
