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

from flatplank_analysis.data import Campaign as Folder
from flatplank_analysis.effects.registry import library
from flatplank_control.bench.log import TableLog
from flatplank_control.bench.setup import BenchSetup
from flatplank_control.bench.twin import Twin
from flatplank_control.bench.twin_bench import TwinBench
from flatplank_control.blind import journal
from flatplank_control.blind.cases import Case, full, make
from flatplank_control.blind.detectable import detectable
from flatplank_control.blind.menu import MENU, PAIRS
from flatplank_control.blind.page import page, summary
from flatplank_control.blind.plan import NOISES, covariance, noise, runs_of
from flatplank_control.blind.points import Share, points_of
from flatplank_control.blind.worlds import WORLDS, Scatter
from flatplank_control.cli.bench_blind import main
from flatplank_control.runner.measurement import Measurement
from flatplank_control.runner.plans import plan_of
from flatplank_hw.plant.campaign import Campaign, CampaignRun
from flatplank_hw.plant.config import PlantConfig


def test_every_effect_of_the_library_is_on_the_menu_or_a_twin_of_one():
    named = {name for item in MENU.values() for name in item.names}
    without = set(library()) - named
    assert without <= {"tire_law", "slip_definition", "sliding_friction"}, without
    assert named <= set(library())
    assert {n for pair in PAIRS for n in pair} <= set(MENU)


def test_the_kit_is_as_large_as_asked():
    cases = list(full())
    groups = [c.group for c in cases]
    assert groups.count("none") >= 100
    assert groups.count("pair") >= 40 and groups.count("outside") >= 40
    for name in MENU:
        for factor in (1.0, 2.0) if MENU[name].least < MENU[name].most else (1.0,):
            own = [c for c in cases if c.hidden == (name,) and c.factor == factor]
            assert len([c for c in own if c.group == "single"]) >= 5
    assert len({c.key for c in cases}) == len(cases)


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
    # twice the noise, at most twice the size; invisible where one load was measured
    assert detectable("second", "road_speed_error", design="small") == math.inf
    assert detectable("second", "rolling_resistance", design="small") == math.inf


def test_noise_has_the_covariance_that_the_generator_reckons_with():
    random = np.random.default_rng(3)
    kind = NOISES["coloured"]
    rows = np.array([noise(kind, 2000, 0.05, random) for _ in range(400)])
    blocks = rows.reshape(400, 100, 20).mean(axis=2)
    times = (np.arange(100) + 0.5) * 1.0
    model = covariance(kind, times, 1.0)
    seen = blocks.T @ blocks / 400
    assert np.trace(seen) == pytest.approx(np.trace(model), rel=0.1)
    assert np.diag(seen, 5).mean() == pytest.approx(np.diag(model, 5).mean(), rel=0.2)


def test_wilson():
    low, high = Share(19, 20).interval()
    assert (low, high) == pytest.approx((0.7639, 0.9911), abs=1e-3)
    assert str(Share(0, 0)) == "-"


def entry(group, hidden, named, verdict="found", outside=None, where=()):
    effects = [
        {"name": n, "size": s, "class": [], "interval": [0.9 * s, 1.1 * s]} for n, s in named
    ]
    answer = {"outside": outside, "effects": []}
    if outside is None:
        answer["effects"] = [{"name": n, "size": 1.0, "class": [], "sized": True} for n in hidden]
    return {
        "key": f"{group}/{'+'.join(hidden)}", "seed": 1, "code": "c", "kit": "k", "answer": answer,
        "case": {"group": group, "hidden": list(hidden), "world": "second", "factor": 2.0},
        "diagnosis": {"verdict": verdict, "effects": effects, "floor_rmse": 10.0,
                      "held_out_after": 10.5, "unexplained": {"where": list(where)}},
    }  # fmt: skip


def test_points():
    good = points_of(entry("single", ["wear"], [("wear", 1.05)]))
    assert good["right"] and good["covered"] == [True] and good["held_out"] == 1.05
    assert not points_of(entry("single", ["wear"], [("wear", 1.0), ("road_play", 1.0)]))["right"]
    assert points_of(entry("single", ["wear"], [("wear", 1.0), ("tire_law", 1.0)]))["right"]
    assert not points_of(entry("none", [], [("wear", 1.0)]))["right"]
    assert points_of(entry("none", [], [], "tire law only"))["right"]
    assert not points_of(entry("pair", ["wear", "road_play"], [("wear", 1.0)]))["right"]
    place = {"coordinate": "plank position", "range": [2.0, 2.5]}
    found = entry("outside", ["bump"], [], "none of these", place, [place])
    assert points_of(found)["right"]
    elsewhere = dict(place, range=[3.0, 3.5])
    assert not points_of(entry("outside", ["bump"], [], "partly", place, [elsewhere]))["right"]


def test_sizes_of_unlike_units_are_not_compared():
    one = entry("single", ["wear"], [("wear", 1.05)])
    one["diagnosis"]["effects"][0]["unit"] = "m"
    for unit, covered in (("m", [True]), ("1", [])):
        one["answer"]["effects"][0]["unit"] = unit
        assert points_of(one)["covered"] == covered and points_of(one)["right"]


def test_the_page_says_what_the_journal_says():
    entries = [
        entry("single", ["wear"], [("wear", 1.05)]),
        entry("single", ["wear"], [("road_play", 1.0)]),
        entry("none", [], [], "at floor"),
    ]
    text = page(entries, "the command")
    assert "| wear | 2 | road_play 1, wear 1 |" in text or "wear 1, road_play 1" in text
    assert "1/2 = 50 %" in text.replace("50%", "50 %")
    assert summary(entries)["x2"]["hits"] == 1


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
    assert scores["none"] == {"hits": 2, "trials": 2, "interval": scores["none"]["interval"]}
    assert scores["x2"]["hits"] == 2
    assert scores["outside"]["trials"] == 1
    assert main([*options, "--no-run", "--write", str(written)]) == 0
    assert "parasitic_force" in written.read_text()
    whole = journal.of_this_code(journal.read(path), 3)
    assert len(whole) == 5 and all(e["code"] == journal.code_version() for e in whole.values())


def test_a_pattern_without_campaigns_is_told(tmp_path, capsys):
    assert main(["--only", "nothing/like/this", "--journal", str(tmp_path / "j")]) == 2
    told = capsys.readouterr().err
    assert "nothing/like/this" in told and len(told.splitlines()) == 1
    assert not (tmp_path / "j").exists()
