# SPDX-License-Identifier: Apache-2.0
"""A form for what no effect of sweeps explains: proposed, added, confirmed on other sweeps."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from series_of_sweeps import series_in

from asked import asked
from flatplank_analysis.cli import change, compare, confirm, propose
from flatplank_analysis.discovery.model import ParameterSet
from flatplank_analysis.effects.grammar.modulators import BY_NAME
from flatplank_analysis.effects.grammar.sentence import Sentence, Site, effect_of
from flatplank_analysis.effects.grammar.shapes import shapes
from flatplank_analysis.effects.grammar.sweep_hooks import SWEEP_HOOKS
from flatplank_analysis.effects.registry import library
from flatplank_analysis.proposal.sites import varying_coordinates
from flatplank_analysis.slip_sweeps.session import SweepSession
from flatplank_data.errors import FlatplankError
from flatplank_validation.sweep_sets.brush import Brush, Plan, sweeps, text_of
from flatplank_validation.sweep_sets.outside import is_right

BRUSHES = {
    "offset": (Brush(zero_by_temperature=2.0), 7),
    "again": (Brush(zero_by_temperature=2.0), 8),
    "null": (Brush(), 9),
    "known": (Brush(over_temperature=0.003), 1),
}


@pytest.fixture(scope="module")
def bench(tmp_path_factory) -> Path:
    """A tire file; two series whose zero of the force follows the tread temperature; one with
    nothing hidden, and one with what the library has."""
    return series_in(tmp_path_factory.mktemp("bench"), BRUSHES)


@pytest.fixture(scope="module")
def session(bench) -> SweepSession:
    return SweepSession.of_file(str(bench / "null.csv"), str(bench / "tire.tir"))


def test_from_a_residual_to_a_confirmed_proposal(bench) -> None:
    file, tir, new = bench / "offset.csv", ("--tir", bench / "tire.tir"), bench / "again.csv"
    told = asked(propose.main, file, *tir)
    assert told["verdict"] == "proposed", told["reason"]
    assert (told["hook"], told["coordinate"]) == ("swept force", "temperature")
    made = Path(told["file"])
    assert made.parent == bench and "acts_on: swept force" in made.read_text()
    assert told["refit"]["rmse"] < 0.7 * told["refit"]["rmse_before"]
    added = asked(change.add, told["name"], file, *tir, "--effects", made)
    assert added["rmse"] < 0.5 * added["rmse_before"]
    # the model file knows the file of the proposal
    assert asked(compare.main, file)["rmse"] == pytest.approx(added["rmse"], rel=0.02)
    again = asked(confirm.main, made, file, "--with", new)
    assert again["verdict"] == "confirmed", again
    none = asked(confirm.main, told["name"], file, "--with", bench / "null.csv")
    assert none["verdict"] == "not confirmed"


@pytest.mark.parametrize("name", ["null", "known"])
def test_nothing_is_proposed_where_nothing_is_left(name, bench) -> None:
    told = asked(propose.main, bench / f"{name}.csv", "--tir", bench / "tire.tir")
    assert told["verdict"] == "nothing to propose" and told["file"] is None


def test_sweeps_that_repeat_nothing_are_told_so(bench, tmp_path) -> None:
    path = tmp_path / "once.csv"
    path.write_text(text_of(sweeps(BRUSHES["offset"][0], Plan(visits=1), 1)), encoding="utf-8")
    told = asked(propose.main, path, "--tir", bench / "tire.tir")
    assert told["verdict"] == "nothing to propose"
    assert "sweep each condition twice" in told["reason"]


@pytest.mark.parametrize("hook", SWEEP_HOOKS, ids=lambda hook: hook.name)
def test_every_hook_changes_the_force_by_its_size_and_by_nothing_without(hook, session) -> None:
    (over,) = (c for c in varying_coordinates(session.data) if c.name == "temperature")
    effect = effect_of(Sentence(Site(hook, over, BY_NAME[""]), shapes()["ramp"], {}))
    base = np.array([p.null for p in session.model.parameters])
    sets = [ParameterSet(base, ((effect, np.array([size])),)) for size in (0.0, hook.screen)]
    plain = session.model.predict([ParameterSet(base, ())])
    none, some = session.model.predict(sets)
    assert (none == plain[0]).all()
    assert np.abs(some - plain[0]).max() > 1.0


def test_the_coordinates_are_all_channels_but_those_of_the_law(session) -> None:
    names = {n for c in varying_coordinates(session.data) for n in (c.name, *c.alias)}
    assert names == {"", "time", "distance", "temperature", "pressure"}
    with pytest.raises(FlatplankError, match="no 'humidity'.*known: .*temperature"):
        session.data.coordinate("humidity")


PROPOSAL = """\
format: flatplank-proposal/1
name: proposed_one
acts_on: {acts_on}
over: {over}
within: [0.0, 100.0]
unit: "1"
form: ramp
"""


def test_a_proposal_for_other_runs_is_refused_in_a_line(bench, tmp_path) -> None:
    mine, plank = tmp_path / "sweeps.yaml", tmp_path / "plank.yaml"
    mine.write_text(PROPOSAL.format(acts_on="swept force", over="temperature"))
    plank.write_text(PROPOSAL.format(acts_on="fx", over="load"))
    with pytest.raises(FlatplankError, match="is of sweeps"):
        library([mine])
    with pytest.raises(FlatplankError, match="is not of sweeps"):
        SweepSession.of_file(str(bench / "null.csv"), str(bench / "tire.tir"), files=[str(plank)])


def test_what_counts_as_right(session) -> None:
    coordinates = {c.name: c for c in varying_coordinates(session.data)}
    hooks = {h.name: h for h in SWEEP_HOOKS}

    def right(hook: str, over: str, hidden: str) -> bool:
        site = Site(hooks[hook], coordinates[over], BY_NAME[""])
        return is_right(Sentence(site, shapes()["ramp"], {}), hidden)

    assert right("swept force", "temperature", "zero_by_temperature")
    assert not right("swept force", "pressure", "zero_by_temperature")
    assert not right("swept grip", "temperature", "zero_by_temperature")
    assert not right("swept force", "pressure", "")
    assert is_right(None, "") and not is_right(None, "late")
