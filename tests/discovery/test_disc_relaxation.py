# SPDX-License-Identifier: Apache-2.0
"""A tire of one relaxation length, the commonest model of the textbooks, with nothing hidden: the
base fits it, and no effect is named."""

from __future__ import annotations

import numpy as np
import pytest
from other_world import contact_point, runs_of

from flatplank_analysis.contact_patch.model import TireModel
from flatplank_analysis.contact_patch.session import Session
from flatplank_analysis.discovery import verdict
from flatplank_analysis.effects.registry import library
from flatplank_data.campaign import Campaign

EVERY_DAY = ("to 10 %", 1.0)
"""the largest slip, where the length of the base's own tire has fallen most"""


@pytest.mark.parametrize(
    ("design", "fixed"),
    [
        pytest.param(design, fixed, marks=() if (design, fixed) == EVERY_DAY else pytest.mark.long)
        for design in ("to 5 %", "to 10 %")
        for fixed in (0.0, 0.5, 1.0)
    ],
)
def test_a_fixed_relaxation_length_is_no_effect(design: str, fixed: float) -> None:
    rng = np.random.default_rng(20)
    columns = contact_point(design, {"fixed": fixed})
    for c in columns:
        c["fx"] = c["fx"] * (1.0 + 0.01 * rng.standard_normal())
        for name in ("fx", "fy", "fz"):
            c[name] = c[name] + rng.normal(0.0, 8.0, len(c[name]))
    data = runs_of(design, columns)
    result = Session(Campaign("made", []), data, TireModel(data), library()).diagnose()
    assert result.verdict == verdict.AT_FLOOR, (result.reason, result.found)
    base = result.search.last.state.fit.base
    (share,) = (
        v
        for p, v in zip(result.search.model.parameters, base, strict=True)
        if p.name == "fixed_length"
    )
    assert abs(share - fixed) < 0.3
