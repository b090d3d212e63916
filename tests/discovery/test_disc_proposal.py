# SPDX-License-Identifier: Apache-2.0
"""Whole proposals: a force that is in no library goes from `none of these` to a file, a fallen
error, and a confirmation by runs that took no part in the search."""

from __future__ import annotations

import json
import os
from dataclasses import replace

import numpy as np
import pytest
import yaml
from bristles import Truth, campaign, save

from asked import asked
from flatplank_analysis.cli import change, confirm, effects, propose
from flatplank_analysis.contact_patch.session import Session
from flatplank_analysis.discovery.modelfile import ModelFile
from flatplank_analysis.effects.grammar.hooks import HOOKS
from flatplank_analysis.effects.grammar.modulators import BY_NAME
from flatplank_analysis.effects.registry import load_file
from flatplank_analysis.proposal.propose import propose as of_session
from flatplank_analysis.proposal.propose import reason_against
from flatplank_analysis.proposal.scan import CURVE, FURTHER, SETTING, WAVE, Scanner, ScanResult
from flatplank_analysis.proposal.search import (
    bonferroni_divisors,
    few_per_hook,
)
from flatplank_analysis.proposal.sites import Site, sites_of, varying_coordinates
from flatplank_data.errors import FlatplankError

pytestmark = pytest.mark.timeout(900)  # whole searches: a busy machine takes minutes

FEW = (-0.05, -0.01, 0.0, 0.01, 0.05)
PULL = 45.0


def _parted(tables, last: int):
    """Runs of the search, and those of the last starts, which it does not see."""
    return [t for t in tables if t.info.start < last], [t for t in tables if t.info.start >= last]


@pytest.fixture(scope="module")
def pulled(tmp_path_factory):
    """Folders: a campaign with a pull at one place while driving, new runs of the same bench with
    it, new runs with half of it; and the proposal as the verb printed it."""
    folder = tmp_path_factory.mktemp("pulled")
    truth = Truth(seed=71, slips=FEW, repeats=5, pull=PULL)
    search, new = _parted(campaign(truth), 4)
    _, weaker = _parted(campaign(replace(truth, pull=0.5 * PULL)), 4)
    places = [folder / n for n in ("search", "new", "weaker")]
    for place, tables in zip(places, (search, new, weaker), strict=True):
        place.mkdir()
        save(tables, place)
    return places


@pytest.fixture(scope="module")
def proposed(pulled):
    """The campaign's proposal: what the verb says for programs."""
    return asked(propose.main, pulled[0], "--report", pulled[0].parent / "page")


def test_a_pull_is_proposed_with_place_size_and_form(proposed):
    assert proposed["verdict"] == "proposed", proposed
    assert (proposed["hook"], proposed["coordinate"]) == ("fx", "plank position")
    assert (proposed["modulator"], proposed["shape"]) == ("driving", "bump")
    refit = proposed["refit"]
    assert refit["size"] == pytest.approx(PULL, rel=0.15)
    assert proposed["numbers"]["start"] == pytest.approx(2.0, abs=0.1)
    assert proposed["numbers"]["length"] == pytest.approx(0.8, abs=0.15)
    assert refit["rmse"] < refit["rmse_before"]
    assert refit["held_out"] < 1.1 * refit["floor"]
    assert refit["held_out_level"] < 1.5 * refit["floor"]


def test_the_page_shows_curve_form_and_file(proposed, pulled):
    page = (pulled[0].parent / "page" / "index.html").read_text()
    assert "<svg" in page and "free curve" in page
    assert proposed["name"] in page and "acts_on: fx" in page
    assert (pulled[0].parent / "page" / "proposal.png").stat().st_size > 1000


def test_the_file_is_an_ordinary_effect(proposed, pulled, tmp_path, capsys):
    file = proposed["file"]
    assert effects.main(["check", file]) == 0
    model = tmp_path / "model.yaml"
    arguments = [proposed["name"], str(pulled[0]), "--effects", file, "--model", str(model)]
    capsys.readouterr()
    assert change.add([*arguments, "--json"]) == 0
    added = json.loads(capsys.readouterr().out)
    assert added["rmse"] < added["rmse_before"]
    assert yaml.safe_load(model.read_text())["effects"][0]["file"] == os.path.relpath(
        file, tmp_path
    )
    assert "while driving" in load_file(file)[0].what


def test_a_file_that_is_there_is_never_written_over(proposed, pulled):
    with pytest.raises(FlatplankError, match="is there already"):
        propose.main([str(pulled[0]), "--out", proposed["file"]])


def test_new_runs_confirm_or_say_what_failed(proposed, pulled, capsys):
    search, new, weaker = map(str, pulled)
    capsys.readouterr()
    arguments = [proposed["file"], search, "--with", new, weaker, "--json"]
    assert confirm.main(arguments) == 0
    result = json.loads(capsys.readouterr().out)
    good, bad = result["sets"]
    assert good["reasons"] == [] and good["size"] == pytest.approx(PULL, rel=0.2)
    assert good["rmse"] < good["rmse_before"]
    assert "the size is another one" in bad["reasons"]
    assert result["verdict"] == "not confirmed"
    assert confirm.main([proposed["name"], search, "--with", new]) == 0
    assert "verdict: confirmed" in capsys.readouterr().out


def test_confirm_wants_other_runs_and_an_interval(proposed, pulled, tmp_path):
    search, new, _ = map(str, pulled)
    with pytest.raises(FlatplankError, match="are the runs of the search"):
        confirm.main([proposed["file"], search, "--with", search])
    text = proposed["text"]
    old = tmp_path / "old.yaml"
    old.write_text("\n".join(row for row in text.splitlines() if "interval:" not in row))
    with pytest.raises(FlatplankError, match="has no interval"):
        confirm.main([str(old), search, "--with", new])


def _warm(seed: int, size: float, repeats: int = 3):
    """A campaign with a column of temperature, and a force of `size` per 10 K."""
    rng = np.random.default_rng(seed)
    for table in campaign(Truth(seed=seed, slips=FEW, repeats=repeats)):
        warm = rng.uniform(18.0, 32.0) + 0.5 * table["time"] / 130.0
        fx = table["fx"] + size * (warm - 25.0) / 10.0
        shown = warm + 0.05 * rng.standard_normal(len(warm))
        yield table.with_columns(fx=fx, **{"temperature [degC]": shown})


@pytest.mark.long
def test_a_column_of_the_user_can_be_the_cause(tmp_path, capsys):
    search, new = _parted(list(_warm(72, 40.0, repeats=5)), 4)
    (tmp_path / "new").mkdir()
    save(new, tmp_path / "new")
    tmp_path = tmp_path / "search"
    tmp_path.mkdir()
    save(search, tmp_path)
    assert propose.main([str(tmp_path), "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert result["verdict"] == "proposed", result
    assert (result["hook"], result["coordinate"]) == ("fx", "temperature")
    (effect,) = load_file(result["file"])
    low, high = effect.ranges["temperature"]
    assert result["refit"]["size"] == pytest.approx(40.0 * (high - low) / 10.0, rel=0.2)
    assert result["refit"]["rmse"] < 0.9 * result["refit"]["rmse_before"]
    assert effects.main(["check", result["file"]]) == 0
    new = str(tmp_path.parent / "new")
    assert confirm.main([result["file"], str(tmp_path), "--with", new, "--json"]) == 0
    told = json.loads(capsys.readouterr().out.split("contract\n")[1])
    assert told["verdict"] == "confirmed", told


def test_a_column_that_makes_the_scatter_of_repeats_is_no_noise():
    """The gain of an amplifier goes with its supply: without that column all is at the floor."""
    rng, tables = np.random.default_rng(78), []
    for table in campaign(Truth(seed=78, slips=FEW)):
        volts = rng.uniform(9.4, 10.6) + 0.02 * np.sin(table["time"] / 11.0)
        fx = table["fx"] * (1.0 + 0.025 * (volts - 10.0) / 1.2)
        tables.append(table.with_columns(fx=fx, **{"supply voltage [V]": volts}))
    result = of_session(Session.of_tables(tables)).to_dict()
    assert result["diagnosis"] == "at floor", result
    assert result["verdict"] == "proposed", result
    assert (result["hook"], result["coordinate"]) == ("gain", "supply voltage")
    assert not [d for d in result["refit"]["doubts"] if "scatter" in d], result


@pytest.mark.long
def test_a_force_may_fade_with_the_slip():
    """At one place of the plank, and there the less the more it slips."""
    tables = []
    for table in campaign(Truth(seed=79, slips=FEW)):
        u = (table["plank_position"] - 2.4) / 0.4
        part = 1.0 / (1.0 + (table.info.kappa / 0.015) ** 2)
        fx = table["fx"] - 60.0 * part * np.sin(np.pi * np.clip(u, 0.0, 1.0))
        tables.append(table.with_columns(fx=fx))
    result = of_session(Session.of_tables(tables)).to_dict()
    assert result["verdict"] == "proposed", result
    told = [result[k] for k in ("hook", "coordinate", "modulator", "shape")]
    assert told == ["fx", "plank position", "little slip", "bump"], result


@pytest.mark.long
def test_a_column_without_effect_is_proposed_as_none(tmp_path, capsys):
    save(list(_warm(73, 0.0)), tmp_path)
    assert propose.main([str(tmp_path)]) == 0
    assert capsys.readouterr().out.startswith("nothing to propose")
    assert not list(tmp_path.glob("*.py"))


def test_a_campaign_at_the_floor_is_searched_too():
    """What turns with the wheel is scatter among repeats for a library that is empty."""
    tables = campaign(Truth(seed=74, slips=FEW, runout=2e-4))
    result = of_session(Session.of_tables(tables, {})).to_dict()
    assert result["diagnosis"] == "at floor", result
    assert result["verdict"] == "proposed" and result["coordinate"] == "wheel angle", result
    assert result["refit"]["rmse"] < 0.5 * result["refit"]["rmse_before"]


def _begun_before_zero(table):
    """The same run where the plank begins 2 cm before its zero, as on the bench."""
    moved = table.with_columns(plank_position=table["plank_position"] - 0.02)
    return moved.with_info(step_position=table.info.step_position - 0.02)


@pytest.mark.long
def test_a_wave_that_dies_away_is_found_from_the_step_on():
    """No wave of one size shows what fades."""
    tables = []
    for table in campaign(Truth(seed=76, slips=FEW)):
        since = table["plank_position"] - table.info.step_position
        wave = 40.0 * np.sin(2.0 * np.pi * since / 0.2) * np.exp(-np.maximum(since, 0.0) / 0.6)
        fx = table["fx"] + wave * (since > 0.0) * (table.info.kappa != 0.0)
        tables.append(table.with_columns(fx=fx))
    session = Session.of_tables([_begun_before_zero(t) for t in tables], {})
    data = session.data
    assert np.allclose(data.position - data.since_step, tables[0].info.step_position)
    result = of_session(session).to_dict()
    assert result["verdict"] == "proposed", result
    told = [result[k] for k in ("hook", "coordinate", "modulator", "shape")]
    assert told == ["fx", "distance since the step", "slipping", "ringing"], result
    assert result["refit"]["size"] == pytest.approx(40.0, rel=0.15)
    assert result["numbers"]["period"] == pytest.approx(0.2, rel=0.03)


def test_what_grows_after_the_step_begins_at_the_step():
    """Over the plank it would begin before the slip does. A slip that the encoders do not see may
    stand for the slow rise."""
    tables = []
    for table in campaign(Truth(seed=77, slips=FEW)):
        since = np.maximum(table["plank_position"] - table.info.step_position, 0.0)
        rise = 60.0 * (1.0 - np.exp(-since / 0.5)) * (table.info.kappa < 0.0)
        tables.append(table.with_columns(fx=table["fx"] + rise))
    result = of_session(Session.of_tables(tables, {})).to_dict()
    assert result["verdict"] == "proposed", result
    each = [result, *result["confused_with"]]
    told = [[one[k] for k in ("hook", "coordinate", "modulator", "shape")] for one in each]
    assert ["fx", "distance since the step", "braking", "relaxation"] in told, result


def test_coordinates_that_hardly_differ_fill_no_list():
    """Sites of one hook and modulator after the third make room for others."""
    fx, slip = (h for h in HOOKS if h.name in ("fx", "slip"))
    sites = [Site(slip, None, BY_NAME["braking"])] * 5 + [Site(fx, None, BY_NAME["braking"])]
    assert few_per_hook(sites, lambda s: s, 9) == [*sites[:3], sites[5]]
    assert few_per_hook(sites, lambda s: s, 2) == sites[:2]


def test_a_site_is_ranked_by_its_best_form_where_that_takes_more_for_its_price():
    curve = ScanResult(None, 60.0, 14, 14, CURVE)
    assert curve.evidence(1.0, 3.0) == pytest.approx(18.0)
    assert replace(curve, forms={2: 50.0}).evidence(1.0, 3.0) == pytest.approx(44.0)
    assert replace(curve, forms={2: 10.0}).evidence(1.0, 3.0) == pytest.approx(18.0)
    assert replace(curve, forms={14: 20.0}).evidence(1.0, 3.0) == pytest.approx(18.0)


@pytest.mark.parametrize(
    ("interval", "p", "gain", "after", "acts_in", "why"),
    [
        ([-1.0, 2.0], 0.99, 0.2, 8.0, 1.0, "its interval covers zero"),
        ([1.0, 2.0], 0.94, 0.2, 8.0, 1.0, "it may be chance, P = 0.94"),
        ([1.0, 2.0], 0.99, -0.1, 8.0, 1.0, "left-out conditions are no better with it"),
        ([1.0, 2.0], 0.99, 0.0013, 8.0, 1.0, "left-out conditions are no better with it"),
        ([1.0, 2.0], 0.99, 0.01, 9.9, 1.0,
         "it takes 1.4 N out of the error where it acts, 3.0 N count"),
        ([1.0, 2.0], 0.99, 0.01, 9.9, 0.1, ""),
        ([1.0, 2.0], 0.96, 0.2, 8.0, 1.0, ""),
    ],
)  # fmt: skip
def test_a_sentence_must_stand_its_refit(interval, p, gain, after, acts_in, why):
    """What acts at one place only is of consequence there."""
    numbers = {"interval": interval, "probability": p, "held_out_gain": gain, "acts_in_runs": 6.0}
    numbers |= {"rmse": after, "acts_in": acts_in, "rmse_before": 10.0, "floor_before": 10.0}
    assert reason_against(numbers, at_floor=True) == why


def test_a_sentence_must_act_in_more_than_one_run():
    """Over the run order, beyond the last but one: nothing repeats it. That was proposed where
    nothing was hidden."""
    numbers = {
        "interval": [1.0, 2.0],
        "probability": 0.99,
        "held_out_gain": 0.2,
        "acts_in_runs": 1.0,
    }
    assert reason_against(numbers) == "it acts in 1.0 runs, and one run repeats nothing"


def test_a_curve_does_not_pay_for_the_periods_of_waves():
    curve, wave = ScanResult(None, 0.0, 5, 5, CURVE), ScanResult(None, 0.0, 2, 400, WAVE)
    looks = bonferroni_divisors([curve, wave] * 3)
    assert looks == {CURVE: 22.5, WAVE: 3600}
    own = ScanResult(None, 0.0, 5, 5, FURTHER)
    setting = ScanResult(None, 0.0, 3, 3, SETTING)
    scanned = [*[curve, wave] * 3, own, setting]
    looks = bonferroni_divisors(scanned)
    assert looks == {CURVE: 45, WAVE: 7200, FURTHER: 15, SETTING: 18}
    assert sum(s.looks / looks[s.kind] for s in scanned) == pytest.approx(1.0)


def test_constants_and_settings_do_not_pay_for_curves_along_the_run():
    """What is examined once per run has few values, and a share of the test level of its own."""
    session = Session.of_tables(campaign(Truth(seed=80, slips=FEW)))
    scanner = Scanner(session.fit(ModelFile()).state, session.data)
    kinds = {
        site.coordinate.name: scanner.curve(site).kind
        for site in sites_of(session.data, varying_coordinates(session.data))
        if site.hook.name == "friction" and not site.modulator.name
    }
    assert kinds["plank position"] == CURVE
    assert kinds["run order"] == SETTING
    held = Site(HOOKS[0], varying_coordinates(session.data)[0], BY_NAME["driving"])
    assert scanner.curve(held).kind == SETTING
