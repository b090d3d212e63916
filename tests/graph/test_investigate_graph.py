# SPDX-License-Identifier: Apache-2.0
"""An investigation on the real graph with the simulated plant, without a hand on the keyboard."""

from __future__ import annotations

import json
import math
import subprocess
import sys

import pytest
from bench_graph import graph
from inv_fresh import fresh_challenge, investigated

from flatplank_analysis.investigation.evidence import ALPHA
from flatplank_sim.sealed.seal import PLANT

pytestmark = [pytest.mark.graph, pytest.mark.long, pytest.mark.timeout(7200)]
VERB = "import sys; from flatplank_control.cli.investigate import main; main(sys.argv[1:])"


def test_what_is_hidden_is_found_confirmed_and_reported(tmp_path, monkeypatch):
    plant = tmp_path / "hidden.yaml"
    plant.write_text("defects: {drive_brake_asymmetry: {friction: 0.12}}\n")
    folder = tmp_path / "data"
    command = [sys.executable, "-c", VERB, str(folder), "--minutes", "90", "--json"]
    with graph(tmp_path, monkeypatch, plant_file=str(plant)):
        done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout)
    first = told["verdict"]["effects"][0]
    assert "drive_brake_asymmetry" in [first["name"], *first["class"]], told["verdict"]
    assert told["log_e"] >= -math.log(ALPHA)
    assert "min left" in done.stderr
    assert "over the whole loop" in (folder / "investigation.txt").read_text()
    page = (folder / "investigation" / "index.html").read_text()
    assert "nothing is known yet" in page
    assert page.count("<svg") == 2


def test_what_a_fresh_seed_hides_is_found_confirmed_and_reported(tmp_path, monkeypatch):
    challenge = fresh_challenge(tmp_path / "challenge")
    with graph(tmp_path, monkeypatch, plant_file=str(challenge / PLANT)):
        investigated(tmp_path / "data", challenge)
