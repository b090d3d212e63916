# SPDX-License-Identifier: Apache-2.0
"""Every verb that ends with a result tells it to programs, too."""

from __future__ import annotations

import json
import re
from contextlib import suppress
from importlib.metadata import entry_points

import pytest

from flatplank_control.cli.calibrate import main as calibrate
from flatplank_control.cli.run import main as run
from flatplank_control.cli.tune import main as tune
from flatplank_sim.cli.simulate import main as simulate

WITHOUT = {"bench", "demo", "panel", "test", "esi"}
"""they last until they are ended, or their output is for people; `esi` prints YAML"""
GROUPS = [
    group
    for group in entry_points().groups
    if group.startswith("flatplank.verbs.") and not group.endswith(".benchmarks")
]
VERBS = sorted((entry.name, entry) for group in GROUPS for entry in entry_points(group=group))


@pytest.mark.parametrize(("name", "entry"), [v for v in VERBS if v[0] not in WITHOUT])
def test_a_verb_has_json(name, entry, capsys):
    with suppress(SystemExit):
        entry.load()(["--help"])
    assert re.search(r"^ *--json ", capsys.readouterr().out, re.MULTILINE)


def test_the_gains_are_told_to_programs(capsys):
    assert tune(["--cx", "400", "--json"]) == 0
    out, err = capsys.readouterr()
    told = json.loads(out)
    gain = told["parameters"]["proportional_gain"]
    assert f"proportional_gain: {gain:g}" in err
    assert f"tuned   phase margin {told['loops']['tuned']['phase_margin']:.2f} deg" in err


def test_the_runs_of_a_plan_are_told_to_programs(capsys, tmp_path):
    plan = tmp_path / "short.yaml"
    plan.write_text(
        "format: flatplank-plan/1\nname: short\ntire: TOY\nruns:\n"
        "- {measurement: slip, kappa: [0.01], start: [1], end_position: 1.6, step_position: 1.2}\n"
    )
    words = [str(plan), "--sim", "--data", str(tmp_path / "runs"), "--json"]
    assert run([*words, "--dry-run"]) == 0
    keys = json.loads(capsys.readouterr().out)["runs"]
    code = run([*words, "--jobs", "1"])
    told = json.loads(capsys.readouterr().out)
    assert [r["run"] for r in told["runs"]] == keys
    assert (code == 0) == all(r["state"] == "good" for r in told["runs"])
    assert all((tmp_path / "runs" / r["file"]).is_file() for r in told["runs"])


def test_what_was_simulated_is_told_to_programs(capsys, tmp_path):
    assert simulate([str(tmp_path / "c"), "--slips", "1", "--starts", "1", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert [f.name for f in (tmp_path / "c").glob("*.parquet")] == told["files"]


def test_a_calibration_is_told_to_programs(capsys, tmp_path):
    book = ["--book", str(tmp_path / "book.yaml"), "--json"]
    assert calibrate([*book, "status"]) == 1
    assert json.loads(capsys.readouterr().out)["valid"] is False
    pairs = "0:0.0,0.1:1.0,0.2:2.0"
    assert calibrate([*book, "lvdt", "--pairs", pairs]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["instrument"] == "lvdt" and told["parameters"]["lvdt_gain"] == pytest.approx(0.1)
