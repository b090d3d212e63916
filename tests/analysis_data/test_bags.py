# SPDX-License-Identifier: Apache-2.0
"""Bags: own topics, foreign topics, compression, cut-off files, the cache."""

from __future__ import annotations

import shutil
import sqlite3

import numpy as np
import pytest
from bagmaker import MSG, Bag, store, wrench, write_run
from mcap.reader import make_reader
from mcap.writer import CompressionType
from steptable import step_table

from flatplank_data.bags.cdr import decode_one, parse_definition
from flatplank_data.campaign import Campaign
from flatplank_data.errors import FlatplankError
from flatplank_data.parquet_files import KEPT
from flatplank_data.readers import cache
from flatplank_data.readers.base import Loaded, Request
from flatplank_data.store import LocalStore

NAME = "TOY_REL_LNG_5perc_T_p25_Fz3700_1"
RECORD = "kappa: 0.05\nfz: 3700.0\nstep_position: 1.5\neffective_rolling_radius: 0.31\n"
SHARED = [
    "fx",
    "fy",
    "fz",
    "mx",
    "my",
    "mz",
    "plank_position",
    "wheel_angle",
    "wheel_velocity",
    "loaded_radius",
]


@pytest.fixture(scope="module")
def source():
    return step_table(0.05)


@pytest.fixture(scope="module")
def bag(tmp_path_factory, source):
    folder = tmp_path_factory.mktemp("bags")
    write_run(folder / NAME, dict(source.columns), RECORD, NAME, chunk_size=100_000)
    return folder


@pytest.mark.parametrize("compression", [CompressionType.NONE, CompressionType.ZSTD])
def test_own_topics(tmp_path, source, compression):
    write_run(tmp_path / NAME, dict(source.columns), RECORD, NAME, compression=compression)
    campaign = Campaign.load(tmp_path)
    (table,) = campaign.tables()
    for name in SHARED:
        np.testing.assert_array_equal(table[name], source[name])
    np.testing.assert_allclose(table["time"], source["time"], atol=1e-9)
    assert campaign.infos[0].step_position == 1.5
    assert table.info.uuid == f"u-{NAME}" and table.info.status == "complete"
    assert not campaign.problems


def test_the_second_reading_comes_from_the_cache(tmp_path, bag, source):
    folder = shutil.copytree(bag, tmp_path / "copy")
    first = Campaign.load(folder).runs[0].table()
    kept = list((folder / KEPT).glob("*.parquet"))
    assert len(kept) == 1
    second = Campaign.load(folder).runs[0].table(["fx"])
    np.testing.assert_array_equal(first["fx"], second["fx"])
    mcap = next(folder.rglob("*.mcap"))
    mcap.write_bytes(mcap.read_bytes() + b" ")
    Campaign.load(folder).runs[0].table()
    assert [p.name for p in (folder / KEPT).glob("*.parquet")] != [p.name for p in kept]


def test_the_cache_of_a_run_with_a_longer_name_stays(tmp_path):
    loaded = Loaded({"fx": np.zeros(3)})
    longer, run = (Request(LocalStore(str(tmp_path)), name) for name in ("A-1", "A"))
    cache.save_to_cache(longer, "0" * 16, loaded)
    for key in ("1" * 16, "2" * 16):
        cache.save_to_cache(run, key, loaded)
    names = sorted(p.name for p in (tmp_path / KEPT).iterdir())
    assert names == [f"A-1-{'0' * 16}.parquet", f"A-{'2' * 16}.parquet"]


@pytest.mark.parametrize("share", [0.5, 0.97])
def test_a_bag_without_its_end_is_read_as_far_as_it_goes(tmp_path, bag, source, share):
    folder = shutil.copytree(bag, tmp_path / "cut")
    (folder / NAME / "run.yaml").write_text(RECORD + "status: complete\n")
    mcap = next(folder.rglob("*.mcap"))
    data = mcap.read_bytes()
    mcap.write_bytes(data[: int(share * len(data))])
    campaign = Campaign.load(folder)
    (table,) = campaign.tables()
    rows = len(table)
    assert share * len(source) - 200 < rows < len(source)
    np.testing.assert_array_equal(table["fx"], source["fx"][:rows])
    assert "no end" in str(campaign.problems[0])


def three(folder):
    """Bags of one condition: complete, discarded by the operator, interrupted by a crash."""
    ends = {
        NAME: "status: complete\n",
        f"{NAME}_r02": "status: discarded\nstop_reason: discard by the operator\n",
        f"{NAME}_r03": "status: interrupted\n",
    }
    for name, end in ends.items():
        write_run(folder / name, dict(step_table(0.05).columns), RECORD, name)
        (folder / name / "metadata.yaml").write_text("{}")
        (folder / name / "run.yaml").write_text(RECORD + end)
    return folder


def test_runs_that_did_not_end_well_are_left_out_and_named(tmp_path):
    campaign = Campaign.load(three(tmp_path / "data"))
    assert [run.info.name for run in campaign.runs] == [NAME]
    discarded, interrupted = campaign.problems
    assert discarded.file.endswith("_r02") and "(discard by the operator)" in str(discarded)
    assert interrupted.file.endswith("_r03") and "ended as 'interrupted'" in str(interrupted)
    assert not discarded.fatal and "run kept" not in str(discarded)


def test_a_list_counts_and_what_it_does_not_name_is_told(tmp_path):
    folder = three(tmp_path / "data")
    entry = f"- {{file: {NAME}, kappa: 0.05, fz: 3700.0, step_position: 1.5}}\n"
    text = "format: flatplank-measurement-table/1\ntire: TOY\nruns:\n"
    (folder / "campaign.yaml").write_text(text + entry)
    write_run(folder / "attempt", dict(step_table(0.05).columns), RECORD, "attempt")
    (folder / "attempt" / "metadata.yaml").write_text("{}")
    (folder / "attempt" / "run.yaml").write_text(RECORD + "status: complete\n")
    campaign = Campaign.load(folder)
    assert [run.info.name for run in campaign.runs] == [NAME]
    told = {problem.file: str(problem) for problem in campaign.problems}
    assert set(told) == {"attempt", f"{NAME}_r02", f"{NAME}_r03"}
    assert "not in campaign.yaml" in told["attempt"]
    assert "ended as 'discarded'" in told[f"{NAME}_r02"]


def test_an_empty_bag_is_told(tmp_path, bag):
    folder = shutil.copytree(bag, tmp_path / "empty")
    next(folder.rglob("*.mcap")).write_bytes(b"")
    with pytest.raises(FlatplankError, match="not an MCAP file") as caught:
        Campaign.load(folder)
    assert NAME in str(caught.value)


def test_foreign_topics_by_mapping(tmp_path):
    bag = Bag(tmp_path / "foreign")
    types = bag.types.types
    joint = types["sensor_msgs/msg/JointState"]
    for i in range(400):
        stamp = 10**9 + i * 10**7
        plank, wheel = 0.3 * i, 0.001 * i
        message = joint(
            bag.header(stamp, "x" * (i % 3)),
            ["plank", "wheel"],
            np.array([plank, wheel]),
            np.array([30.0, 0.1]),
            np.zeros(0),
        )
        bag.write("/rig/joints", "sensor_msgs/msg/JointState", stamp, message)
        force = wrench(bag, stamp + 5 * 10**6, (-float(i), 0.0, -3700.0, 0.0, 0.0, 0.0), "hub")
        bag.write("/rig/hub", "geometry_msgs/msg/WrenchStamped", stamp, force)
    bag.close()
    mapping = {
        "topics": {
            "/rig/joints": {
                "plank_position": {"field": "position[0]", "unit": "mm"},
                "wheel_angle": "position[1]",
            },
            "/rig/hub": {
                "fx": {"field": "wrench.force.x", "factor": -1.0},
                "fz": {"field": "wrench.force.z", "factor": -1.0},
            },
        }
    }
    table = Campaign.load(tmp_path, mapping=mapping).runs[0].table()
    assert len(table) == 399
    np.testing.assert_allclose(table["plank_position"], 0.3e-3 * np.arange(1, 400))
    np.testing.assert_allclose(table["fx"], np.arange(1, 400) - 0.5)
    np.testing.assert_allclose(table["fz"], 3700.0)


def test_mapping_errors_name_the_place(bag):
    with pytest.raises(FlatplankError, match="unknown column 'fq'"):
        mapping = {"topics": {"/x": {"fq": "data"}}}
        Campaign.load(bag, mapping=mapping).runs[0].table()
    with pytest.raises(FlatplankError, match="does not fit"):
        mapping = {"topics": {"/x": {"fx": {"field": "data", "unit": "mm"}}}}
        Campaign.load(bag, mapping=mapping).runs[0].table()


def test_sqlite_storage(tmp_path, bag, source):
    folder = tmp_path / NAME
    folder.mkdir()
    (folder / "metadata.yaml").write_text("rosbag2_bagfile_information: {}\n")
    base = sqlite3.connect(folder / f"{NAME}_0.db3")
    base.execute("CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT)")
    base.execute("CREATE TABLE messages(topic_id INTEGER, timestamp INTEGER, data BLOB)")
    base.execute(
        "CREATE TABLE message_definitions(topic_type TEXT, encoded_message_definition TEXT)"
    )
    numbers: dict[str, int] = {}
    with open(next(bag.rglob("*.mcap")), "rb") as stream:
        for schema, channel, message in make_reader(stream).iter_messages():
            if channel.topic not in numbers:
                numbers[channel.topic] = len(numbers) + 1
                row = (numbers[channel.topic], channel.topic, schema.name)
                base.execute("INSERT INTO topics VALUES(?,?,?)", row)
                row = (schema.name, schema.data.decode())
                base.execute("INSERT INTO message_definitions VALUES(?,?)", row)
            row = (numbers[channel.topic], message.log_time, message.data)
            base.execute("INSERT INTO messages VALUES(?,?,?)", row)
    base.commit()
    base.close()
    table = Campaign.load(tmp_path).runs[0].table()
    for name in SHARED:
        np.testing.assert_array_equal(table[name], source[name])


def test_every_message_of_the_bench_is_decoded_as_rosbags_does():
    """Every type of flatplank_msgs, with text and sequences filled, member by member."""
    types = store()
    for path in sorted(MSG.glob("*.msg")):
        name = f"flatplank_msgs/msg/{path.stem}"
        message = _filled(types, name)
        payload = bytes(types.serialize_cdr(message, name))
        kind = parse_definition(name, types.generate_msgdef(name, ros_version=2)[0])
        found = decode_one(kind, payload)
        for key, value in found.items():
            expected = eval(f"message.{key}", {"message": message})
            assert value == expected or (value != value and expected != expected), (name, key)


def _filled(types, name, depth=1):
    """A message whose members all differ."""
    values = {}
    for number, (field, (kind, detail)) in enumerate(types.fielddefs[name][1], start=depth):
        if kind.name == "BASE":
            text = detail[0] == "string"
            values[field] = "t" * number if text else _number(detail[0], number)
        elif kind.name == "NAME":
            values[field] = _filled(types, detail, depth + 7)
        else:
            base = detail[0][1][0]
            values[field] = np.arange(number, number + 3).astype(_numpy(base))
    return types.types[name](**values)


def _numpy(base):
    return {"float64": "f8", "float32": "f4", "bool": "u1", "octet": "u1"}.get(base, base)


def _number(base, number):
    return bool(number % 2) if base == "bool" else number * (0.5 if "float" in base else 1)


def test_a_single_bag_knows_how_its_run_ended(tmp_path, source):
    """Opened by its own folder too, and without the record beside it."""
    record = RECORD + "status: armed\nuuid: u1\n"
    folder = tmp_path / NAME
    write_run(folder, dict(source.columns), record, NAME)
    assert Campaign.load(folder).infos[0].status == "complete"
    (folder / "run.yaml").write_text(RECORD + "status: interrupted\nuuid: u1\n")
    assert Campaign.load(folder).infos[0].status == "interrupted"
    with pytest.raises(FlatplankError, match="left out: it ended as 'interrupted'"):
        Campaign.load(tmp_path)
