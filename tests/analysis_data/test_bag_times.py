# SPDX-License-Identifier: Apache-2.0
"""Bags of other benches: stamps, clocks, names and mappings are checked before physics."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from bagmaker import Bag, wrench, write_run
from mcap.reader import make_reader
from steptable import step_table

from flatplank_data.bags.topics import OWN, topic_map
from flatplank_data.errors import FlatplankError
from flatplank_data.readers.bag import import_bag

JOINT, WRENCH = "sensor_msgs/msg/JointState", "geometry_msgs/msg/WrenchStamped"
MAPPING = {
    "topics": {
        "/enc": {"plank_position": "position[0]", "wheel_angle": "position[1]"},
        "/hub": {"fx": "wrench.force.x", "fz": "wrench.force.z"},
    }
}
COUNT, PERIOD, START = 400, 10**7, 1_700_000_000 * 10**9
NAMES = ("plank", "wheel")
DELAY = 2 * 10**6
"""from stamp to log time [ns]"""


def write(folder, enc=lambda i, t: t, hub=lambda i, t: t, names=lambda i: NAMES, log=None):
    """A bag whose stamps are functions of number and time [ns] of a message; its values tell the
    number."""
    bag = Bag(folder)
    log = log or (lambda i, t: t + DELAY + 1000 * (i * 7919 % 500))
    for i in range(COUNT):
        t = START + i * PERIOD
        place = {"plank": 1e-3 * i, "wheel": 2e-3 * i, "spare": -1.0}
        positions = np.array([place[name] for name in names(i)])
        kind = bag.types.types[JOINT]
        joints = kind(bag.header(enc(i, t)), list(names(i)), positions, np.zeros(0), np.zeros(0))
        force = wrench(bag, hub(i, t), (float(i), 0.0, 3700.0 + i, 0.0, 0.0, 0.0))
        for topic, what, message in (("/enc", JOINT, joints), ("/hub", WRENCH, force)):
            data = bytes(bag.types.serialize_cdr(message, what))
            at = max(log(i, t), 0)
            bag.writer.add_message(bag.channel(topic, what), at, data, at)
    bag.close()
    return folder


def read(folder, mapping=None):
    return import_bag(folder, topic_map(mapping or MAPPING))


def assert_whole(loaded, rows=COUNT):
    """Every column agrees with the number of its row."""
    number = loaded.columns["plank_position"] / 1e-3
    assert number.size >= rows - 2
    np.testing.assert_allclose(loaded.columns["wheel_angle"], 2e-3 * number, atol=1e-9)
    np.testing.assert_allclose(loaded.columns["fx"], number, atol=0.06)
    np.testing.assert_allclose(np.diff(loaded.columns["time"]), 1e-9 * PERIOD, atol=6e-4)


def test_good_stamps_say_nothing_and_are_exact(tmp_path):
    loaded = read(write(tmp_path / "b"))
    assert not loaded.remarks
    np.testing.assert_array_equal(loaded.columns["fx"], np.arange(COUNT))
    np.testing.assert_allclose(loaded.columns["time"], 0.01 * np.arange(COUNT), atol=1e-12)


@pytest.mark.parametrize(
    ("enc", "hub", "told"),
    [
        (lambda i, t: 0, lambda i, t: 0, "stamps of /enc are all equal"),
        (lambda i, t: START, lambda i, t: t, "stamps of /enc are all equal"),
        (lambda i, t: t, lambda i, t: 0, "stamps of /hub are all equal"),
        (lambda i, t: t if i > 20 else 0, lambda i, t: t, "21 of 400 stamps of /enc are zero"),
        (lambda i, t: t // 10**9 * 10**9, lambda i, t: t, "396 of 400 stamps of /enc are those"),
        (lambda i, t: t - 10**10 * (i > 150), lambda i, t: t, "/enc was set by -10.000 s at mess"),
        (lambda i, t: t, lambda i, t: t + 10**11 * (i > 99), "/hub was set by +100.000 s at mess"),
    ],
)
def test_stamps_that_cannot_be_right_give_way_to_the_log_time(tmp_path, enc, hub, told):
    loaded = read(write(tmp_path / "b", enc, hub))
    assert_whole(loaded)
    assert len(loaded.remarks) == 1 and told in loaded.remarks[0]
    assert "the log time is used" in loaded.remarks[0]
    assert not read(tmp_path / "b", {**MAPPING, "time": "log_time"}).remarks


@pytest.mark.parametrize("ahead", [-86400.0, -30.0, 2.5, 3600.0])
def test_clocks_of_two_computers_are_named(tmp_path, ahead):
    loaded = read(write(tmp_path / "b", hub=lambda i, t: t + int(ahead * 1e9)))
    assert_whole(loaded)
    (remark,) = loaded.remarks
    assert f"/hub and /enc have clocks that differ by {ahead:+.3f} s" in remark


def test_a_small_shift_is_told_and_the_stamps_count(tmp_path):
    loaded = read(write(tmp_path / "b", hub=lambda i, t: t - 3 * 10**8))
    ends, remark = sorted(loaded.remarks, reverse=True)
    assert "the last 30 rows (0.3 s) are left out: not all topics cover them" in ends
    assert "stamps of /hub are -300 ms off those of /enc" in remark
    expected = 1e3 * loaded.columns["plank_position"] + 30.0
    np.testing.assert_allclose(loaded.columns["fx"], expected, rtol=1e-12)


def test_without_any_time_the_bag_is_refused(tmp_path):
    folder = write(tmp_path / "b", enc=lambda i, t: 0, log=lambda i, t: START)
    with pytest.raises(
        FlatplankError, match="/enc are all equal .*, and the log time tells nothing"
    ):
        read(folder)


def test_times_that_do_not_overlap_are_named_where_the_log_time_tells_nothing(tmp_path):
    """A bag that was written at once, long after the run."""
    folder = write(tmp_path / "b", hub=lambda i, t: t + 10**11, log=lambda i, t: START + i)
    with pytest.raises(FlatplankError, match="the times of /hub .* and of /enc .* do not overlap"):
        read(folder, {**MAPPING, "base": "/enc"})


@pytest.mark.parametrize(
    "names",
    [
        lambda i: NAMES if i % 3 else NAMES[::-1],
        lambda i: (*NAMES, "spare") if i % 2 else ("spare", *NAMES[::-1]),
        lambda i: list(itertools.permutations((*NAMES, "spare")))[i % 6],
    ],
)
@pytest.mark.parametrize("by_name", [False, True])
def test_joints_are_followed_by_their_names(tmp_path, names, by_name):
    first = list(names(0))
    keys = {name: name if by_name else first.index(name) for name in NAMES}
    topics = {
        "/enc": {
            "plank_position": f"position[{keys['plank']}]",
            "wheel_angle": f"position[{keys['wheel']}]",
        },
        "/hub": MAPPING["topics"]["/hub"],
    }
    loaded = read(write(tmp_path / "b", names=names), {"topics": topics})
    np.testing.assert_allclose(loaded.columns["plank_position"], 1e-3 * np.arange(COUNT))
    np.testing.assert_allclose(loaded.columns["wheel_angle"], 2e-3 * np.arange(COUNT))
    said = [r for r in loaded.remarks if "names in messages of /enc change" in r]
    assert len(said) == (0 if by_name else 2)


@pytest.mark.parametrize(
    "delay",
    [
        lambda topic, i: 2 * 10**6 + 1000 * (i * 7919 % 500),
        lambda topic, i: 10**6 + 2 * 10**8 * (i > 1500),  # held up for good
        lambda topic, i: 10**6 + 8 * 10**6 * ("hub" in topic),
        lambda topic, i: 3 * 10**9 * (topic == "/wheel_drive/status"),
    ],
)
def test_delays_do_not_change_what_is_read_of_the_bench(tmp_path, delay):
    """All stamps are those of one bus: whenever its messages were received, they are right."""
    run = step_table(0.05)
    columns = {name: run[name] for name in run.columns}
    write_run(tmp_path / "at once", columns, "kappa: 0.05\n", "at once")
    bag = Bag(tmp_path / "late")
    with (tmp_path / "at once" / "at once_0.mcap").open("rb") as file:
        for i, (schema, channel, message) in enumerate(make_reader(file).iter_messages()):
            number = bag.channel(channel.topic, schema.name)
            at = message.log_time + delay(channel.topic, i)
            bag.writer.add_message(number, at, message.data, message.log_time)
    bag.close()
    there, late = (import_bag(tmp_path / name, OWN) for name in ("at once", "late"))
    assert late.remarks == there.remarks
    assert late.columns.keys() == there.columns.keys()
    for name, column in there.columns.items():
        np.testing.assert_array_equal(late.columns[name], column)


def mapped(enc=None, hub=None, **more):
    topics = {"/enc": enc or MAPPING["topics"]["/enc"], "/hub": hub or MAPPING["topics"]["/hub"]}
    return {"topics": topics, **more}


@pytest.mark.parametrize(
    ("mapping", "told"),
    [
        (mapped(enc={"plank_position": "position[7]"}), r"no member 'position\[7\]' .*of /enc"),
        (mapped(enc={"plank_position": "position[plonk]"}), r"no 'plonk' .* \(plank, wheel\)"),
        (mapped(enc={"plank_position": "velocity[0]"}), r"no member 'velocity\[0\]'"),
        (mapped(enc={"plank_position": "name[0]"}), r"'name\[0\]' is text"),
        (mapped(hub={"fx": "wrench.forces.x"}), "no member 'wrench.forces.x' .*wrench.force.x"),
        (mapped(hub={"fx": "wrench.force"}), "no member 'wrench.force'"),
        ({"topics": {"/enc": MAPPING["topics"]["/enc"], "/hup": {"fx": "wrench.force.x"}}},
         r"no message on /hup; .*\(the bag has /enc\)"),
        (mapped(time="header.stump"), "no stamp 'header.stump' in messages of /enc"),
    ],
)  # fmt: skip
def test_what_a_mapping_names_and_the_bag_has_not_is_told(tmp_path, mapping, told):
    with pytest.raises(FlatplankError, match=told):
        read(write(tmp_path / "b"), mapping)


def test_messages_without_the_mapped_joint_are_told(tmp_path):
    folder = write(tmp_path / "b", names=lambda i: NAMES if i % 2 else ("plank", "spare"))
    with pytest.raises(FlatplankError, match="no 'wheel' among the names of /enc"):
        read(
            folder, mapped(enc={"plank_position": "position[0]", "wheel_angle": "position[wheel]"})
        )
