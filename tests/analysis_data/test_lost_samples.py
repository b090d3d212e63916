# SPDX-License-Identifier: Apache-2.0
"""Samples that a run lacks are counted from its stamps, told, and stop a fit that needs them."""

from __future__ import annotations

import json

import numpy as np
import pytest
from bagmaker import write_run
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer
from steptable import RATE, SPEED, step_table

from flatplank_analysis.cli import fit, table
from flatplank_analysis.contact_patch.data import load_runs
from flatplank_analysis.report import tables
from flatplank_analysis.report.analysis import analyse
from flatplank_data.campaign import Campaign
from flatplank_data.errors import NothingUsableError
from flatplank_data.exporters import export_campaign
from flatplank_data.lost import lost_samples

NAME = "TOY_REL_LNG_5perc_T_p25_Fz3700_1"
RECORD = "kappa: 0.05\nfz: 3700.0\nstep_position: 1.5\neffective_rolling_radius: 0.31\n"


def without(run, *spans):
    """The run without the rows [first, last) of each span."""
    keep = np.ones(len(run), dtype=bool)
    for first, last in spans:
        keep[first:last] = False
    return run.rows(keep)


@pytest.mark.parametrize("share", [0.001, 0.1, 0.67])
def test_every_lost_sample_is_counted(share):
    run = step_table(0.05)
    keep = np.random.default_rng(4).random(len(run)) >= share
    keep[[0, -1]] = True
    found = lost_samples(run.rows(keep))
    assert (found.lost, found.of) == (int((~keep).sum()), len(run))
    lengths = np.diff(np.flatnonzero(keep))
    assert found.longest == pytest.approx(lengths.max() / RATE)
    assert found.road == pytest.approx(SPEED * lengths.max() / RATE)


def test_samples_of_no_clock_are_not_called_lost():
    """On even cells of road, at a speed that is not constant."""
    run = step_table(0.05)
    time = run["time"] + 0.6 * np.sin(0.3 * run["time"])
    assert lost_samples(run).lost == lost_samples(run.with_columns(time=time)).lost == 0


def test_the_record_counts_where_the_stamps_show_nothing():
    found = lost_samples(step_table(0.05, cycles_lost=6552, cycles_received=3156))
    assert (found.lost, found.of) == (6552, 9708)
    assert not found.allows_fit


def few_and_many(write_campaign):
    """Braking and driving; the second run lacks a little, the third a stretch of the road."""
    runs = [step_table(k, start, noise=5.0) for k in (-0.02, 0.02) for start in (1, 2, 3)]
    runs[1] = without(runs[1], (300, 303))
    runs[2] = without(runs[2], (1000, 1060))
    return write_campaign(runs)


def test_a_run_that_lacks_little_is_told_and_one_that_lacks_much_is_not_fitted(
    write_campaign, capsys
):
    folder = few_and_many(write_campaign)
    lacking = [run.info.file for run in Campaign.load(folder).runs][1:3]
    assert fit.main([str(folder), "--json"]) == 0
    out = json.loads(capsys.readouterr().out)
    assert out["runs"] == 5
    little, much = (next(p for p in out["problems"] if p.startswith(file)) for file in lacking)
    assert "3 of 2710 cycles lost (0.11 %), up to 0.2 s and 6.2 mm of road" in little
    assert little.endswith("(run kept)")
    assert "60 of 2710 cycles lost (2.2 %), up to 3.05 s and 94.5 mm of road" in much
    assert "no model is fitted across them" in much and "kept" not in much


def test_the_search_does_without_it_too(write_campaign):
    campaign = Campaign.load(few_and_many(write_campaign))
    assert len(load_runs(campaign).kappa) == 5


def test_a_campaign_with_nothing_else_is_refused(tmp_path, capsys):
    record = {"cycles_lost": 6552, "cycles_received": 3156}
    folder = export_campaign([step_table(0.05, **record)], tmp_path / "lost", ".parquet")
    assert fit.main([str(folder)]) == 2
    assert "6552 of 9708 cycles lost (67 %)" in capsys.readouterr().err
    with pytest.raises(NothingUsableError, match="6552 of 9708"):
        load_runs(Campaign.load(folder))


def test_the_table_of_runs_shows_them(write_campaign, capsys):
    folder = few_and_many(write_campaign)
    assert table.main([str(folder)]) == 0
    said = capsys.readouterr()
    rows = said.out.splitlines()
    assert "lost" in rows[2]
    assert [row.split()[-1] for row in rows[3:5]] == ["63", "0"]
    assert table.main([str(folder), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert [c["cycles_lost"] for c in found["conditions"]] == [63, 0]
    assert [(e["lost"], e["of"], e["used"]) for e in found["lost"]] == [
        (3, 2710, True), (60, 2710, False),
    ]  # fmt: skip


def test_a_message_that_one_topic_lacks_is_a_lost_sample(tmp_path):
    """Forces that were not recorded are not made up from their neighbours."""
    run = step_table(0.05)
    write_run(tmp_path / "all" / NAME, dict(run.columns), RECORD, NAME)
    folder = tmp_path / "some" / NAME
    folder.mkdir(parents=True)
    heard = 0
    with (
        open(next((tmp_path / "all").rglob("*.mcap")), "rb") as source,
        open(folder / f"{NAME}_0.mcap", "wb") as target,
    ):
        writer = Writer(target, compression=CompressionType.NONE)
        writer.start(profile="ros2")
        channels: dict[str, int] = {}
        for schema, channel, message in make_reader(source).iter_messages():
            topic = channel.topic
            if topic not in channels:
                number = writer.register_schema(schema.name, schema.encoding, schema.data)
                channels[topic] = writer.register_channel(topic, "cdr", number)
            heard += topic == "/measurement_hub/wrench_contact"
            if topic != "/measurement_hub/wrench_contact" or not 500 < heard <= 505:
                at = message.log_time
                writer.add_message(channels[topic], at, message.data, at)
        writer.finish()
    (found,) = (r.table() for r in Campaign.load(tmp_path / "some").runs)
    assert len(found) == len(run) - 5
    assert lost_samples(found).lost == 5
    np.testing.assert_array_equal(found["fx"], np.delete(run["fx"], range(500, 505)))


def test_the_report_shows_them_beside_its_runs(write_campaign):
    campaign = Campaign.load(few_and_many(write_campaign))
    steps = tables.step_table(analyse(campaign, nonlinear=False, jobs=1))
    at = steps.header.index("cycles lost")
    assert [row[at] for row in steps.rows] == ["3", "0"]
