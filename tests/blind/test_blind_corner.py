# SPDX-License-Identifier: Apache-2.0
"""Without the effect the fit of the tire may end in a corner that hides it: the way out."""

from __future__ import annotations

import pytest

from flatplank_analysis.contact_patch.data import from_tables
from flatplank_analysis.contact_patch.model import TireModel
from flatplank_analysis.discovery.state import start_base
from flatplank_analysis.discovery.verdict import AT_FLOOR
from flatplank_analysis.discovery.verdict import diagnose as diagnosed
from flatplank_analysis.effects.registry import library
from flatplank_analysis.inference.search import run_search
from flatplank_validation.blind import cases
from flatplank_validation.blind.journal import diagnose
from flatplank_validation.blind.menu import KIN


@pytest.mark.long
def test_a_gap_that_a_strange_tire_imitates_is_found(monkeypatch):
    # a contact length at the end of its range takes most of what the gap does in this campaign,
    # and where it stands there the gap of the drive brings nothing
    monkeypatch.setattr(cases, "size_of", lambda _case, _name: 3e-4)
    case = cases.Case("single", "plant", ("rack_backlash",), 2.0, number=1)
    tables, _ = cases.make(case, 4001)
    found = diagnose(tables)
    first, *others = found["effects"]
    assert first["name"] in ("rack_backlash", *KIN["rack_backlash"]) and not others
    assert 2.4e-4 < first["size"] < 3.6e-4


@pytest.mark.long
def test_a_search_does_not_end_in_the_corner_that_its_first_effect_left_behind(monkeypatch):
    monkeypatch.setattr(cases, "size_of", lambda _case, _name: 4e-3)
    # a steering angle that is off drives the tire to strange numbers, which stayed beside it
    case = cases.Case("single", "second", ("steering_zero",), 2.0, design="angles", number=1)
    tables, _ = cases.make(case, 4001)
    model = TireModel(from_tables(tables))
    search = run_search(model, list(library().values()))
    end, (found,) = search.last.state, search.last.found
    # a ply steer does the same in this campaign: which of the two stands first is chance
    assert "steering_zero" in (found.decision.term.effect.identifier, *found.alike)
    anew = end.fit_whitened(end.fitter.fit(start_base(model, {}), end.fit.terms))
    assert end.whitened.chi2 < 1.01 * anew.chi2


@pytest.mark.long
def test_a_fit_that_ends_in_a_corner_is_no_effect():
    """With 1 N of noise the fit of this tire, in which nothing is hidden, ended where -10 % was
    80 N off and no small step was better."""
    case = cases.Case("none", "plant", (), 1.0, "faint", 0.01, number=5)
    tables, answer = cases.make(case, 73190)
    assert answer["effects"] == []
    search = run_search(TireModel(from_tables(tables)), list(library().values()))
    assert diagnosed(search).verdict == AT_FLOOR
