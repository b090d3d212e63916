# SPDX-License-Identifier: Apache-2.0
"""`flatplank simulate`: every tire under its own name, load, pressure, radius and record."""

from __future__ import annotations

import math

import numpy as np
import pytest

from flatplank_analysis.models.tire_record import FILE, read_record
from flatplank_control.cli.operator import NOT_ALL_GOOD
from flatplank_data.campaign import Campaign
from flatplank_sim.cli.simulate import main, parser, tire_and_radius
from flatplank_sim.plant.config import PlantConfig
from flatplank_validation.truth import truth_row

TIRES = {"toyo": "TOY", "continental": "CON", "michelin": "MIC", "racing": "RAC"}


@pytest.mark.parametrize("plant", TIRES)
def test_every_tire_has_its_own_name_and_numbers(plant, tmp_path, capsys):
    folder = tmp_path / plant
    words = [str(folder), "--tire", plant, "--slips", "2", "--starts", "1", "--at", "1.2"]
    assert main([*words, "--jobs", "1"]) == 0
    config = PlantConfig.load(plant)
    truth = truth_row(config, config.tire.nominal_load, config.tire.nominal_pressure_bar)
    found = Campaign.load(folder)
    slip = next(i for i in found.infos if i.measurement == "slip")
    assert found.tire == slip.tire == TIRES[plant]
    assert slip.file.startswith(f"{TIRES[plant]}_REL_LNG_2perc_")
    assert (slip.fz, slip.pressure) == (truth.fz, truth.pressure)
    assert slip.effective_rolling_radius == pytest.approx(truth.effective_rolling_radius, rel=1e-3)
    record = read_record(folder / FILE)
    assert record.name == TIRES[plant] and record.free_radius == config.tire.free_radius
    capsys.readouterr()


def test_a_known_radius_is_taken_at_the_nominal_condition_only(tmp_path):
    def asked(*words: str) -> tuple[str, float]:
        record, radius = tire_and_radius(parser().parse_args([str(tmp_path), *words]))
        return record.name, radius

    assert asked() == ("TOY", 0.3108)
    assert asked("--fz", "3700", "--pressure", "2.5") == ("TOY", 0.3108)
    for words in (("--fz", "5550"), ("--alpha", "5"), ("--tire", "racing")):
        assert math.isnan(asked(*words)[1])
    assert asked("--tire", "continental", "--name", "BMW", "--re", "0.34") == ("BMW", 0.34)


@pytest.mark.parametrize(
    ("words", "option", "remedy"),
    [
        (("--plan", "short", "--tire", "racing"), "--tire", "in the plan"),
        (("--plan", "short", "--tire", "toyo"), "--tire", "in the plan"),
        (("--plan", "short", "--alpha", "0"), "--alpha", "in the plan"),
        (("--plan", "short", "--slips", "2", "--fz", "3700"), "--slips, --fz", "in the plan"),
        (("--plan", "short", "--free-rolling"), "--free-rolling", "in the plan"),
        (("--hidden", "4", "--tire", "racing"), "--tire", "leave"),
        (("--hidden", "4", "--plan", "short"), "--plan", "leave"),
        (("--hidden", "0", "--bags"), "--bags", "leave"),
    ],
)
def test_what_would_be_ignored_is_refused(words, option, remedy, tmp_path):
    folder = tmp_path / "campaign"
    with pytest.raises(ValueError) as refusal:
        main([str(folder), *words])
    text = str(refusal.value)
    assert text.startswith(f"{option}: ") and words[0] in text and remedy in text
    assert "\n" not in text and not folder.exists()


@pytest.mark.parametrize("rate", [50, 200])
def test_a_slower_bus_measures_too(rate, tmp_path):
    """Where nothing is measured no batch may be longer than the drive waits for its inputs."""
    folder = tmp_path / "slow"
    words = ["--slips", "5", "--starts", "1", "--rate", str(rate), "--jobs", "1"]
    assert main([str(folder), *words]) == 0
    (run,) = Campaign.load(folder).tables()
    step = np.diff(run["time"])
    assert np.median(step) == pytest.approx(1.0 / rate, rel=1e-6)


PRELOADED = """format: flatplank-plan/1
name: preloaded
tire: TOY
attempts: 2
r_e: given
runs:
- measurement: slip
  kappa: 0.0
  effective_rolling_radius: 0.3108
  step_position: 0.3
  end_position: 2.0
"""


def test_a_preloaded_shaft_without_a_filter_is_told_once_with_what_to_do(tmp_path, capsys):
    plan = tmp_path / "preloaded.yaml"
    plan.write_text(PRELOADED)
    words = [str(tmp_path / "runs"), "--plan", str(plan), "--preset", "thesis2023", "--jobs", "1"]
    assert main(words) == NOT_ALL_GOOD
    told = [line for line in capsys.readouterr().out.splitlines() if "once_per_turn" in line]
    assert len(told) == 3, "two attempts, and the flagged run at the end"
    assert ["calibrate parasitic" in line and "--sim" in line for line in told] == [1, 0, 0]
