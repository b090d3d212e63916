# SPDX-License-Identifier: Apache-2.0
"""The blind kit: generators, detectable sizes, journal, scores, a small kit from end to end."""

from __future__ import annotations

import json
import math
import tempfile
import time
from pathlib import Path

import numpy as np
import pytest

from flatplank_analysis.effects.registry import library
from flatplank_control.bench.setup import BenchSetup
from flatplank_control.runner.measurement import Measurement
from flatplank_control.runner.plans import plan_of
from flatplank_data.campaign import Campaign as Folder
from flatplank_sim.plant.campaign import Campaign, CampaignRun
from flatplank_sim.plant.config import PlantConfig
from flatplank_sim.sealed.menu import OUTSIDE
from flatplank_sim.sealed.score import score
from flatplank_sim.twin.log import TableLog
from flatplank_sim.twin.twin import Twin
from flatplank_sim.twin.twin_bench import TwinBench
from flatplank_validation.blind import journal
from flatplank_validation.blind.cases import Case, make, size_of
from flatplank_validation.blind.detectable import (
    NEEDED,
    consequence_of_force,
    detectable,
    strength_of,
)
from flatplank_validation.blind.lists import SCATTERS, WIDE, five_slips, full
from flatplank_validation.blind.menu import KIN, MENU, PAIRS
from flatplank_validation.blind.noise import NOISES, covariance, noise, shown
from flatplank_validation.blind.page import page
from flatplank_validation.blind.plan import runs_of
from flatplank_validation.blind.second import late
from flatplank_validation.blind.third import ThirdMachine, ThirdTire, _shown
from flatplank_validation.blind.worlds import COMBINED, PRESENT, WORLDS, Scatter
from flatplank_validation.verbs.bench_blind import main


def test_every_effect_of_the_library_is_on_the_menu():
    without = set(library()) - set(MENU)
    assert without <= {"tire_law", "slip_definition", "sliding_friction", "ply_steer"}, without
    assert set(MENU) <= set(library())
    assert {n for pair in PAIRS for n in pair} <= set(MENU)
    assert {n for kin in KIN.values() for n in kin} <= set(library())


def test_the_kit_is_as_large_as_asked():
    cases = full(1)
    groups = [c.group for c in cases]
    assert groups.count("none") >= 100
    assert groups.count("pair") >= 40 and groups.count("outside") >= 40
    for name in MENU:
        own = [c for c in cases if c.hidden == (name,) and c.group == "single"]
        steps = {(c.rung, c.factor) for c in own}
        if MENU[name].least < MENU[name].most:
            assert steps == {("x", 1.0), ("x", 2.0), ("x", 4.0), ("c", 1.5), ("c", 3.0)}
        assert own
    assert len({c.key for c in cases}) == len(cases)
    for group in set(groups):
        own = [c for c in cases if c.group == group]
        assert {c.scatter for c in own} == set(SCATTERS)
        assert {"measured", "loud", "usual"} <= {c.noise for c in own}
    assert {c.noise for c in cases if c.group == "none"} == set(NOISES)
    wide = [c for c in cases if c.group == "combined" and c.world == "third"]
    assert {c.design for c in wide} == {"combined", "wide_loads"} and len(wide) >= 50


def test_the_quick_list_has_all_kinds_of_plain_campaigns_with_fifteen_runs():
    cases = five_slips(1)
    assert len({c.key for c in cases}) == len(cases) > 300
    assert {c.group for c in cases} == {"none", "single", "pair", "outside"}
    assert {len(runs_of(c.design, np.random.default_rng(0))) for c in cases} == {15}


def test_combined_slip_is_true_of_a_tire_with_a_circle_and_not_a_false_name():
    for world, design in zip(COMBINED, WIDE, strict=True):
        case = Case("none", world, design=design)
        _, answer = make(case, 1)
        assert answer["present"] == list(PRESENT[world]) and not answer["effects"]
        said = {"name": "combined_slip", "size": 1.0, "interval": [0.9, 1.1], "class": []}
        assert score({"verdict": "found", "effects": [said]}, answer)["right"]
        assert score({"verdict": "at floor", "effects": []}, answer)["right"]
        other = dict(said, name="wear")
        assert not score({"verdict": "found", "effects": [said, other]}, answer)["right"]
        assert not score({"verdict": "partly", "effects": [said]}, answer)["right"]


def test_the_third_tire_resists_its_rolling_and_it_is_no_false_name_to_say_so():
    tire = ThirdTire()
    load = np.array([2000.0, 4000.0])
    turn = np.array([100.0, 100.0])
    zero = np.zeros(2)
    shown = _shown(tire, ThirdMachine(), turn, turn, 0.0, zero, zero, load)
    np.testing.assert_allclose(shown["fx"], -tire.rolling * load)
    said = {"name": "rolling_resistance", "size": 0.01, "interval": [0.0, 0.02], "class": []}
    _, answer = make(Case("none", "third", design="wide_loads"), 1)
    assert score({"verdict": "found", "effects": [said]}, answer)["right"]
    _, answer = make(Case("none", "circle", design="wide_loads"), 1)
    assert not score({"verdict": "found", "effects": [said]}, answer)["right"]


def test_another_seed_is_another_list():
    one, other = full(1), full(2)
    assert {c.key for c in full(1)} == {c.key for c in one} != {c.key for c in other}
    assert [c.hidden for c in one] != [c.hidden for c in other]


def test_the_same_seed_makes_the_same_campaign_and_the_answer_is_not_in_it():
    case = Case("single", "second", ("drive_backlash",), 2.0, design="small")
    one, other = make(case, 5), make(case, 5)
    assert one is not None and other is not None
    assert one[1] == other[1]
    for a, b in zip(one[0], other[0], strict=True):
        np.testing.assert_array_equal(a["fx"], b["fx"])
        assert "felt" not in a.columns and "backlash" not in repr(a.info)


@pytest.mark.parametrize("world", WORLDS)
def test_a_campaign_without_defects_is_a_tire_at_rest_that_is_pulled_and_slips(world):
    made = WORLDS[world](None)
    runs = runs_of("small", np.random.default_rng(0))
    out = made.run(runs, {}, np.random.default_rng(0), Scatter.none(len(runs)))
    for columns, run in zip(out, runs, strict=True):
        late = columns["fx"][columns["plank_position"] > 3.5].mean()
        assert np.sign(late) == np.sign(run.setting.kappa) or abs(late) < 150.0
        if abs(run.setting.kappa) == 0.05:
            assert 2300.0 < abs(late) < 3700.0
        assert abs(columns["fx"][0]) < 1.0


def test_detectable_sizes():
    size = detectable("second", "parasitic_force", design="small")
    assert 1.0 < size < 50.0
    # invisible where one load was measured
    assert detectable("second", "road_speed_error", design="small") == math.inf
    assert detectable("second", "rolling_resistance", design="small") == math.inf


@pytest.mark.parametrize("name", ["mesh_ripple", "road_play", "wear"])
def test_what_is_hidden_is_a_true_multiple_of_the_detectable_size(name):
    """No least size is put in: the ripple can be seen far below what is of consequence."""
    least = detectable("second", name, design="small")
    found = strength_of("second", name, least, "usual", 0.01, "small")
    assert found == pytest.approx(NEEDED, rel=0.05)
    case = Case("single", "second", (name,), 2.0, design="small")
    _, answer = make(case, 1)
    assert answer["effects"][0]["size"] == pytest.approx(2.0 * least)
    assert answer["effects"][0]["detectable"] == least
    if name == "mesh_ripple":
        assert least < 0.2 * MENU[name].least
        slight = Case("single", "second", (name,), 3.0, design="small", rung="c")
        assert size_of(slight, name) == 3.0 * MENU[name].least
    # loud noise needs more
    assert detectable("second", name, "loud", design="small") > 1.5 * least


@pytest.mark.parametrize(
    ("world", "name"),
    [("second", "crosstalk_fz"), ("forms", "crosstalk_fz"), ("second", "measured_load")],
)
def test_what_stands_around_an_effect_is_not_the_effect(world, name):
    """A load that waves is there with and without the crosstalk that it shows."""
    design = "small"
    assert strength_of(world, name, 0.0, "usual", 0.01, design) == 0.0
    size = detectable(world, name, design=design)
    assert size < MENU[name].most
    change = [strength_of(world, name, k * size, "usual", 0.01, design) for k in (1.0, 2.0)]
    assert change[1] == pytest.approx(4.0 * change[0], rel=0.25)
    if name == "crosstalk_fz":
        assert name not in KIN
        made = WORLDS[world](None)
        runs = runs_of(design, np.random.default_rng(0))
        (plain, *_), (mixed, *_) = (
            made.run(runs, {name: s}, np.random.default_rng(0), Scatter.none(len(runs)))
            for s in (0.0, 0.25)
        )
        # three per cent of the load wave, in Fx a quarter of that, and no radius changes
        np.testing.assert_array_equal(plain["wheel_angle"], mixed["wheel_angle"])
        assert 200.0 < np.ptp(plain["fz"]) < 400.0
        more = mixed["fx"] - plain["fx"]
        assert np.corrcoef(more, plain["fz"])[0, 1] > 0.99
        # the crosstalk of the other forms saturates: half of a quarter at least is left
        assert 0.125 < np.ptp(more) / np.ptp(plain["fz"]) < 0.26


@pytest.mark.parametrize("name", ["coloured", "trending", "measured"])
def test_noise_has_the_covariance_that_the_generator_reckons_with(name):
    random = np.random.default_rng(3)
    kind = NOISES[name]
    rows = np.array([noise(kind, 2000, 0.05, random) for _ in range(400)])
    blocks = rows.reshape(400, 100, 20).mean(axis=2)
    times = (np.arange(100) + 0.5) * 1.0
    model = covariance(kind, times, 1.0)
    seen = blocks.T @ blocks / 400
    assert np.trace(seen) == pytest.approx(np.trace(model), rel=0.1)
    assert np.diag(seen, 5).mean() == pytest.approx(np.diag(model, 5).mean(), rel=0.2)


def test_measured_noise_has_what_a_whitener_does_not_expect():
    random, kind = np.random.default_rng(1), NOISES["measured"]
    rows = [shown(kind, np.zeros(2600), 0.05, random) for _ in range(60)]
    values = np.array(rows)
    np.testing.assert_allclose(values % kind.step, 0.0)
    steps = np.abs(np.diff(values, axis=1))
    assert np.mean(steps > 45.0) > 2e-4
    still = [max(len(r) for r in np.split(v, np.flatnonzero(np.diff(v)) + 1)) for v in values]
    assert sum(n >= 9 for n in still) >= 2
    # the power falls with frequency over three decades, and does not level off
    slow = values - values.mean(axis=1, keepdims=True)
    power = (np.abs(np.fft.rfft(slow)) ** 2).mean(axis=0)
    low, middle = power[2:6].mean(), power[20:60].mean()
    high = power[300:600].mean()
    assert low > 4.0 * middle > 16.0 * high


def test_a_lag_is_that_of_its_time_however_small():
    """Half a sample of lag was there as soon as there was any."""
    ramp = np.arange(400.0)
    for lag in (1e-9, 0.02, 0.3):
        assert ramp[-1] - late(ramp, lag)[-1] == pytest.approx(lag / 0.05, abs=1e-6)
    step = np.r_[np.zeros(100), np.ones(300)]
    at = late(step, 0.5)
    assert at[109] == pytest.approx(1.0 - np.exp(-9.5 * 0.05 / 0.5), abs=2e-3)


def test_the_fast_generator_equals_the_twin_and_is_twenty_times_faster():
    """One run of 5 % slip: the same force as the whole bench with bus, hub and drive loop."""
    m = Measurement(kappa=0.05, fz=3700.0, effective_rolling_radius=0.3108, step_position=0.3,
                    end_position=0.8)  # fmt: skip
    config = PlantConfig.load("toyo")
    wanted = CampaignRun(kappa=0.05, fz=3700.0, effective_rolling_radius=0.3108,
                         step_position=0.3, length=0.9)  # fmt: skip
    bench = Campaign(config)
    bench.run(wanted, np.random.default_rng(0))  # compiled

    def twin(folder) -> dict[str, np.ndarray]:
        rig = TwinBench(Twin(BenchSetup(pace="hold")), TableLog(folder))
        rig.perform(plan_of(m))
        found = Folder.load(str(folder))
        return found.runs[0].table().columns

    with tempfile.TemporaryDirectory() as folder:
        began = time.process_time()
        slow = twin(Path(folder))
        twin_rate = float(np.ptp(slow["time"])) / (time.process_time() - began)
    began = time.process_time()
    rounds = 5
    for _ in range(rounds):
        fast = bench.run(wanted, np.random.default_rng(0))
    fast_rate = rounds * float(np.ptp(fast["time"])) / (time.process_time() - began)
    assert fast_rate > 20.0 * twin_rate
    x = np.linspace(0.1, 0.75, 60)
    a = np.interp(x, slow["plank_position"], slow["fx"])
    b = np.interp(x, fast["plank_position"], fast["fx_true"])
    assert np.sqrt(np.mean((a - b) ** 2)) < 0.01 * np.abs(b).max()


def test_a_force_counts_from_a_size_that_goes_with_the_floor():
    """1 N at the crest: the mean over 0.2 m of a bump of 0.6 m is all but that."""
    unit, _ = OUTSIDE["bump"](1.0, np.random.default_rng(2))
    around = ("second", unit)
    sizes = [consequence_of_force(*around, "usual", s) for s in (0.0, 0.01, 0.03)]
    assert 8.0 < sizes[0] < 16.0  # a floor of 8.2 N, and 0.2 % of 3.8 kN
    assert sizes[0] < sizes[1] < sizes[2]
    loud = consequence_of_force(*around, "loud", 0.0)
    assert 2.0 * sizes[0] < loud < 4.0 * sizes[0]


@pytest.mark.long
def test_small_kit_from_end_to_end(tmp_path, capsys):
    """The command, its journal, and that it goes on where it stopped."""
    path, written = tmp_path / "kit.jsonl", tmp_path / "page.md"
    options = ["--small", "--seed", "3", "--journal", str(path)]
    assert main([*options, "--limit", "2"]) == 0
    lines = path.read_text().splitlines()
    assert len(lines) == 2
    # a line that was cut off by a kill does no harm
    path.write_text("\n".join([*lines, '{"key": "cut']) + "\n")
    capsys.readouterr()
    assert main([*options, "--json"]) == 0
    scores = json.loads(capsys.readouterr().out)
    assert (scores["none"]["hits"], scores["none"]["trials"]) == (2, 2)
    assert scores["x2"]["hits"] == 2
    assert (scores["outside2"]["hits"], scores["outside2"]["trials"]) == (1, 1)
    assert main([*options, "--no-run", "--write", str(written)]) == 0
    assert "parasitic_force" in written.read_text()
    header, entries = journal.published(tmp_path / "page.jsonl.gz")
    assert page(entries, header) == written.read_text()
    assert header["seed"] == 3 and entries[0]["commit"] in written.read_text()
    whole = journal.of_this_code(journal.read(path), 3)
    assert len(whole) == 5 and all(e["code"] == journal.code_version() for e in whole.values())


def test_a_pattern_without_campaigns_is_told(tmp_path, capsys):
    assert main(["--only", "nothing/like/this", "--journal", str(tmp_path / "j")]) == 2
    told = capsys.readouterr().err
    assert "nothing/like/this" in told and len(told.splitlines()) == 1
    assert not (tmp_path / "j").exists()
