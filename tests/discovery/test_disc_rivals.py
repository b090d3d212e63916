# SPDX-License-Identifier: Apache-2.0
"""What could stand in for an effect is refitted in its place, and told with it."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from flatplank_analysis.cli.diagnose import text_of
from flatplank_analysis.contact_patch.session import Session
from flatplank_analysis.discovery.steps import LARGEST_CLASS, AcceptedEffect, Rival
from flatplank_analysis.discovery.verdict import GROUP
from flatplank_validation.blind.cases import measured_table
from flatplank_validation.blind.noise import NOISES, noise
from flatplank_validation.blind.plan import runs_of
from flatplank_validation.blind.worlds import WORLDS, Scatter


def diagnosis(world: str, seed: int, **hidden: float):
    """Of a small campaign with usual noise."""
    random = np.random.default_rng(seed)
    tire = WORLDS[world](random)
    runs = runs_of("small", random)
    columns = tire.run(runs, hidden, random, Scatter.drawn(len(runs), 0.01, random))
    for c in columns:
        dt = float(c["time"][1] - c["time"][0])
        for name in ("fx", "fy", "fz"):
            c[name] = c[name] + noise(NOISES["usual"], len(c["time"]), dt, random)
    tables = [measured_table(c, run, tire.radius) for c, run in zip(columns, runs, strict=True)]
    return Session.of_tables(tables).diagnose()


def test_backlash_of_the_rack_and_play_of_the_road_are_one_class():
    """The bearings of the plank hold it: both are a gap that is crossed at a force."""
    result = diagnosis("plant", 81, rack_backlash=8e-4)
    assert result.verdict == GROUP, result.reason
    (effect,) = result.to_dict()["effects"]
    names = [effect["name"], *effect["class"]]
    assert {"rack_backlash", "road_play"} <= set(names) and len(names) <= LARGEST_CLASS
    assert effect["size"] == pytest.approx(8e-4, rel=0.15)
    assert [a["name"] for a in effect["members"]] == names
    assert all(a["check"] and a["removes"] for a in effect["members"])
    assert result.next_run["what"]
    told = text_of(result)
    assert all(a["check"] in told and a["removes"] in told for a in effect["members"])


@pytest.mark.long
def test_the_data_exclude_a_gap_that_slip_travel_crosses():
    """A backlash of the drive is crossed both ways whatever the force: no class with the play."""
    result = diagnosis("second", 82, drive_backlash=6e-4)
    (effect,) = result.to_dict()["effects"]
    assert {effect["name"], *effect["class"]} == {"drive_backlash", "rack_backlash"}


def test_at_most_four_others_are_told():
    term = SimpleNamespace(effect=SimpleNamespace(identifier="x"))
    rivals = tuple(Rival(term, 1.0 / (i + 1), i > 5) for i in range(9))
    found = AcceptedEffect(decision=None, rivals=rivals)
    assert [r.odds for r in found.reported] == [1.0, 0.5, 1.0 / 3.0, 0.25]
    assert len(found.alike) == 6 and found.excluded_names == ("x", "x", "x")
