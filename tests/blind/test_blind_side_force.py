# SPDX-License-Identifier: Apache-2.0
"""Effects of the side force, on a tire that scatters from run to run."""

from __future__ import annotations

import pytest

from flatplank_analysis.contact_patch.session import Session
from flatplank_analysis.effects.registry import library
from flatplank_validation.blind import cases
from flatplank_validation.blind.cases import Case, make


def diagnosed(case: Case, seed: int, *names: str) -> dict:
    session = Session.of_tables(make(case, seed)[0])
    session.effects = {name: library()[name] for name in names}
    return session.diagnose().to_dict()


@pytest.mark.long
@pytest.mark.timeout(300)
def test_a_steering_zero_is_named_with_its_size(monkeypatch):
    """The tire scatters by 3 %, across as along. Where the noise knew it along only, repeats
    scattered 43 times as expected, and the effect was refused."""
    monkeypatch.setattr(cases, "size_of", lambda _case, _name: 3e-3)
    case = Case("single", "second", ("steering_zero",), 1.5, "quiet", 0.03, "angles", rung="c")
    found = diagnosed(case, 5151, "steering_zero", "conicity", "carcass_softening")
    (effect,) = found["effects"]
    assert effect["name"] == "steering_zero"
    low, high = effect["interval"]
    assert low < 3e-3 < high and high - low < 2e-3, effect


@pytest.mark.timeout(300)
def test_what_an_effect_of_no_consequence_explains_has_no_other_name(monkeypatch):
    """A crosstalk that saturates stays below its consequence; `crosstalk_mz` explained half as
    much and was named in its place."""
    monkeypatch.setattr(cases, "size_of", lambda _case, _name: 0.03)
    case = Case("single", "forms", ("crosstalk_fy",), 1.5, "coloured", 0.03, "angles", rung="c")
    found = diagnosed(case, 52817, "crosstalk_fy", "crosstalk_mz")
    assert {e["name"] for e in found["effects"]} <= {"crosstalk_fy"}, found


@pytest.mark.long
@pytest.mark.timeout(300)
def test_the_direction_of_both_forces_is_no_difference_between_driving_and_braking():
    """No scatter of the grip hides it, so that a small error of the base's form was named."""
    case = Case("none", "circle", (), 1.0, "trending", 0.03, "combined", 4)
    names = "drive_brake_asymmetry", "load_loss_braking", "combined_slip", "tire_law"
    assert diagnosed(case, 36914, *names)["verdict"] == "at floor"
