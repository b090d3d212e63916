# SPDX-License-Identifier: Apache-2.0
"""The transients of a tire of another form are no effects, and limit how well sizes are known."""

from __future__ import annotations

import pytest

from flatplank_analysis.contact_patch.session import Session
from flatplank_analysis.discovery.fit import Term
from flatplank_analysis.effects.force_channel import TimeSkew
from flatplank_analysis.effects.registry import library
from flatplank_analysis.inference.beside import Beside
from flatplank_validation.blind.cases import Case, make


@pytest.mark.timeout(300)
def test_the_start_of_the_side_force_is_no_worn_patch():
    """Was found, -3 % at 0.36 m: the force across the wheel rises there in all runs alike."""
    case = Case("none", "circle", (), 1.0, "quiet", 0.0, "combined", 2)
    effects = {name: library()[name] for name in ("worn_patch", "combined_slip")}
    session = Session.of_tables(make(case, 60257)[0])
    session.effects = effects
    assert {e["name"] for e in session.diagnose().to_dict()["effects"]} <= {"combined_slip"}


@pytest.mark.parametrize("number", [0, *(pytest.param(n, marks=pytest.mark.long) for n in (1, 2))])
def test_a_skew_that_a_tire_of_another_form_feigns_is_no_finding(number):
    """Its interval is as wide as other tires differ: by the noise alone it would be 1.7 ms."""
    case = Case("none", "second", (), 1.0, "quiet", 0.0, "plain", number)
    session = Session.of_tables(make(case, 9090)[0])
    beside = Beside.of(session.fit(None).state, list(session.effects.values()))
    decided = beside.decide(beside.with_term(Term(TimeSkew, TimeSkew.vector({"skew": 1e-3}))))
    low, high = decided.interval
    assert not decided.accepted and 3e-3 < 0.5 * (high - low) < 40e-3
