# SPDX-License-Identifier: Apache-2.0
"""The run record: round trips and refusals."""

from __future__ import annotations

import math
from dataclasses import fields

import numpy as np
import pytest
import rec_samples as samples

from flatplank_control.recording.filled import in_words, requested_record
from flatplank_control.recording.topics import RUN_TOPIC, run_message
from flatplank_control.recording.typestore import typestore
from flatplank_data.errors import FlatplankError, RecordingError
from flatplank_data.limits import IN_FILES
from flatplank_data.record_checks import STATUSES
from flatplank_data.run_record import (
    FORMAT,
    RunRecord,
    load_record,
    read_run,
    record_from_dict,
    record_from_yaml,
    stem_of,
)
from flatplank_data.yaml_text import load_yaml

FULL = samples.toyo(
    operator="Jürgen: 'x'",
    serial="0042",
    effective_rolling_radius=0.3108,
    r_e_source="TOY_ERR_REL_LNG_T_p25_Fz5550_2",
    waveform={"kind": "step", "amplitude": 0.05},
    step_position=1.5,
    et_value=0.045,
    calibration={"hub": {"date": "2023-05-01", "factors": [1.0, 2.0]}},
    plant={"preset": "thesis2023", "seed": 7},
    notes="two\nlines # and more",
)


def test_yaml_and_file_give_the_record_back(tmp_path):
    assert record_from_yaml(FULL.to_yaml()) == FULL
    FULL.save(tmp_path)
    assert load_record(tmp_path) == FULL


def test_keys_are_those_of_a_campaign():
    """DESIGN 4: a run of campaign.yaml and a record name the same things alike."""
    campaign = [
        "tire",
        "kappa",
        "fz",
        "pressure",
        "alpha_deg",
        "gamma_deg",
        "start",
        "run_index",
        "effective_rolling_radius",
        "step_position",
        "measurement",
        "waveform",
        "speed",
        "direction",
        "repeat",
        "et_value",
        "adapter_thickness",
        "wheel_camber_deg",
        "r_e_source",
        "uuid",
        "notes",
    ]
    assert set(campaign) <= {item.name for item in fields(RunRecord)}


def test_numbers_of_numpy_are_written_as_numbers():
    record = samples.toyo(kappa=np.float64(0.02), calibration={"c": np.array([1.0, 2.0])})
    again = record_from_yaml(record.to_yaml())
    assert (again.kappa, again.calibration) == (0.02, {"c": [1.0, 2.0]})


def test_every_record_has_its_own_identity():
    assert samples.toyo().uuid != samples.toyo().uuid


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("kappa", math.nan),
        ("kappa", 0.6),
        ("kappa", "5"),
        ("fz", -1.0),
        ("pressure", math.inf),
        ("fz", 10**400),
        ("start", 4),
        ("start", True),
        ("effective_rolling_radius", -0.3),
        ("step_position", math.nan),
        ("tire", ""),
        ("tire", "../TOY"),
        ("name", "../x"),
        ("status", "done"),
        ("uuid", "1"),
        ("operator", 3),
    ],
)
def test_bad_values_are_refused_by_name(key, value):
    with pytest.raises(RecordingError, match="TOY|x|" + key):
        samples.toyo(**{key: value})


def test_unknown_key_names_the_nearest():
    with pytest.raises(RecordingError, match=r"'presure'.*'pressure'"):
        record_from_dict({"tire": "TOY", "presure": 2.5}, "plan.yaml")
    with pytest.raises(RecordingError, match=r"'kapa'.*'kappa'"):
        samples.toyo().with_changes(kapa=0.1)


@pytest.mark.parametrize(
    "text", ["", "- 1", "tire: [", "format: other/1\ntire: TOY", "kappa: 0.1", "tire: TOY\nfz: x"]
)
def test_what_is_no_record_is_refused_with_its_source(text):
    with pytest.raises(RecordingError, match=r"some\.yaml"):
        record_from_yaml(text, "some.yaml")


def test_an_unknown_status_is_refused_with_the_known_ones():
    with pytest.raises(RecordingError) as raised:
        FULL.with_changes(status="fine")
    assert f"status 'fine' is unknown; use {', '.join(STATUSES)}" in str(raised.value)


@pytest.mark.parametrize("status", STATUSES)
def test_message_says_what_the_record_says(status):
    record = FULL.with_changes(status=status)
    message = typestore().deserialize_cdr(run_message(record, 12_000_000_034), RUN_TOPIC.type)
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (12, 34)
    assert (message.uuid, message.name, message.status) == (record.uuid, record.name, status)
    assert record_from_yaml(message.record) == record


@pytest.mark.parametrize(
    ("file", "stem"),
    [("a/b/run_one.csv", "run_one"), ("run.parquet", "run"), ("bag/", "bag"), ("RUN.CSV", "RUN")],
)
def test_a_run_is_named_after_its_file(file, stem):
    assert stem_of(file) == stem


@pytest.mark.parametrize(
    ("measurement", "waveform", "kind"),
    [("slip", "step", "slip"), ("slip", "sine", "slip sine"), ("cleat", "sine", "cleat")],
)
def test_only_a_slip_run_is_named_after_its_waveform(measurement, waveform, kind):
    record = record_from_dict(
        {"tire": "TOY", "measurement": measurement, "waveform": {"name": waveform}}
    )
    assert record.kind == kind


@pytest.mark.parametrize(("start", "degrees"), [(1, 0.0), (2, 120.0), (3, 240.0)])
def test_the_wheel_starts_at_three_places_of_its_turn(start, degrees):
    record = samples.toyo(start=start)
    assert math.degrees(record.start_angle) == pytest.approx(degrees)
    given = record.with_changes(start_angle_deg=75.0)
    assert math.degrees(given.start_angle) == pytest.approx(75.0)


@pytest.mark.parametrize(
    ("written", "way"),
    [("forward", 1.0), ("reverse", -1.0), ("reversed", -1.0), ("backward", -1.0), (-1.0, -1.0),
     (1, 1.0), ("-1", -1.0), (None, 1.0)],
)  # fmt: skip
def test_a_direction_is_a_word_or_a_sign(written, way):
    record, _ = read_run({"tire": "TOY", "direction": written, "notes": "reverse"}, "a.yaml")
    assert (record.direction, record.notes) == (way, "reverse")


@pytest.mark.parametrize("written", ["sideways", [1.0], {"a": 1}])
def test_another_direction_is_refused_with_its_file(written):
    with pytest.raises(FlatplankError, match=r"a\.yaml.*direction"):
        read_run({"tire": "TOY", "direction": written}, "a.yaml")


def test_a_pressure_of_zero_is_not_known_and_any_other_is():
    pressures = [read_run({"pressure": p}, "")[0].pressure for p in (0, 0.0, "0", 1e-3, 2.5)]
    np.testing.assert_array_equal(pressures, [math.nan, math.nan, math.nan, 1e-3, 2.5])


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"kappa": -0.05, "step_position": 1.5}, "slip -5 %, from 1.5 m"),
        ({"waveform": {"name": "sine"}}, "slip sine"),
        ({"measurement": "free_rolling"}, "free rolling"),
        ({"effective_rolling_radius": 0.31085}, "r_e 310.9 mm"),
        ({"fz": 3700.0}, "Fz 3700 N"),
        ({"fz": 0.5}, "Fz 0.5 N"),
        ({"pressure": 0.0}, "pressure not given"),
        ({"cycles_received": 90, "cycles_lost": 10}, "10 of 100 cycles lost"),
        ({"cycles_received": 90, "cycles_late": 3}, "0 of 90 cycles lost, 3 late"),
    ],
)
def test_a_run_in_words_says_what_was_measured(changes, words):
    said = in_words(samples.toyo(**{"cycles_received": 9, **changes}))
    assert words in said and "\n" not in said
    unknown = samples.toyo(fz=0.0, pressure=2.5, cycles_received=9)
    assert "Fz" not in in_words(unknown) and "not given" not in in_words(unknown)
    assert "late" not in in_words(unknown)


def test_what_was_not_recorded_is_said():
    assert "nothing was recorded" in in_words(samples.toyo())


def test_a_request_keeps_the_keys_that_it_gives():
    said = requested_record("{tire: TOY, measurement: slip, kappa: 0.05}")
    assert said.given_keys == {"tire", "measurement", "kappa"}
    assert said.record.name.startswith("TOY_") and said.record.kappa == 0.05
    assert requested_record("{tire: TOY, name: mine}").record.name == "mine"
    assert requested_record("{tire: TOY, name: mine}", "other").record.name == "other"
    assert requested_record("", "by_me").record.name == "by_me"


@pytest.mark.parametrize("key", IN_FILES)
def test_the_ends_of_a_range_are_in_it_and_nothing_beyond_is(key):
    limit = IN_FILES[key]
    for value in (limit.low, limit.high):
        record = samples.toyo(**{key: value})
        expected = math.nan if key == "pressure" and value == 0.0 else value
        np.testing.assert_equal(getattr(record, key), expected)
    step = 1 if isinstance(limit.low, int) else 1e-6
    whole = isinstance(limit.high, int) and limit.high > 2**53
    for value in (limit.low - step, limit.high * 2 if whole else limit.high + step):
        with pytest.raises(RecordingError) as raised:
            samples.toyo(**{key: value})
        unit = limit.unit.replace("1", "-") or "-"  # a share in the file
        span = f"{limit.low:g} to {limit.high:g} [{unit}]"
        assert str(raised.value).endswith(f"{key} is {value!r}; it must be {span}")


IN_WORDS = {
    "kappa": "-0.5 to 0.5 [-]", "fz": "0 to 20000 [N]", "pressure": "0 to 10 [bar]",
    "alpha_deg": "-90 to 90 [deg]", "gamma_deg": "-90 to 90 [deg]",
    "effective_rolling_radius": "0.01 to 2 [m]", "step_position": "0 to 10 [m]",
    "speed": "0 to 5 [m/s]", "et_value": "-1 to 1 [m]", "adapter_thickness": "-1 to 1 [m]",
    "wheel_camber_deg": "-90 to 90 [deg]", "road_camber_offset_deg": "-90 to 90 [deg]",
    "slip_angle_offset_deg": "-90 to 90 [deg]", "start": "1 to 3 [-]",
    "start_angle_deg": "-360 to 360 [deg]",
}  # fmt: skip


@pytest.mark.parametrize("key", IN_WORDS)
def test_the_range_is_told_in_its_unit(key):
    with pytest.raises(RecordingError) as raised:
        samples.toyo(**{key: 1e9})
    assert str(raised.value).endswith(f"{key} is 1000000000.0; it must be {IN_WORDS[key]}")


@pytest.mark.parametrize("key", ["speed", "step_position", "start_angle_deg", "et_value"])
def test_a_value_that_may_be_unknown_may_be_left_empty(key):
    assert math.isnan(getattr(samples.toyo(**{key: None}), key))


@pytest.mark.parametrize("key", ["kappa", "alpha_deg", "start", "cycles_lost"])
def test_a_value_that_every_run_has_may_not_be_left_empty(key):
    with pytest.raises(RecordingError, match=f"{key} is None"):
        samples.toyo(**{key: None})


@pytest.mark.parametrize(
    ("key", "written", "read"),
    [
        ("kappa", "0.05", 0.05), ("kappa", 1, 1.0), ("kappa", None, 0.0), ("fz", None, math.nan),
        ("start", "2", 2), ("start", 3.0, 3), ("start", None, 1), ("repeat", None, 1),
        ("tire", 12, "12"), ("tire", None, ""), ("notes", 1.5, "1.5"), ("notes", "0", "0"),
        ("waveform", {"name": "sine"}, {"name": "sine"}), ("waveform", None, None),
        ("calibration", None, {}), ("filled_in", None, []), ("filled_in", ["fz"], ["fz"]),
        ("cycle_first", 7, 7), ("cycle_first", None, None), ("direction", None, 1.0),
    ],
)  # fmt: skip
def test_a_value_of_a_file_has_the_type_of_its_key(key, written, read):
    record, remarks = read_run({key: written}, "a.yaml")
    found = getattr(record, key)
    np.testing.assert_equal(found, read)
    assert type(found) is type(read) and not remarks


@pytest.mark.parametrize(
    ("key", "value", "remedy"),
    [("fz", "heavy", "write one number"), ("kappa", [0.1], "write one number"),
     ("pressure", "soft", "write one whole number"), ("start", "first", "write one whole number"),
     ("run_index", {"a": 1}, "write one whole number")],
)  # fmt: skip
def test_what_is_no_number_is_refused_with_its_file_and_remedy(key, value, remedy):
    remedy = "write one number" if key == "pressure" else remedy
    with pytest.raises(FlatplankError) as raised:
        read_run({key: value}, "a.yaml")
    error = raised.value
    assert (error.what, error.where) == (f"'{key}: {value}' is not a number", "a.yaml")
    assert error.remedy == remedy


def test_unknown_keys_are_kept_and_those_that_look_misspelt_are_told():
    raw = {"format": FORMAT, "tire": "TOY", "presure": 2.5, "colour": "red", 7: "x"}
    record, remarks = read_run(raw, "a.yaml")
    assert record == RunRecord(tire="TOY")
    assert record.extra == {"presure": 2.5, "colour": "red", "7": "x"}
    assert remarks == ["unknown key 'presure' (nearest: 'pressure')"]


ALWAYS = {"file": "", "tire": "", "kappa": 0.0, "alpha_deg": 0.0, "gamma_deg": 0.0, "start": 1}
"""what stands in every run of a campaign, unless it is not a number"""


@pytest.mark.parametrize(
    ("given", "more"),
    [
        ({}, {}),
        ({"fz": 0.0, "pressure": 2.5}, {"fz": 0.0, "pressure": 2.5}),
        ({"name": "mine"}, {"name": "mine"}),
        ({"file": "a/mine.csv", "name": "other"}, {"file": "a/mine.csv"}),
        ({"notes": "", "serial": "42", "repeat": 1}, {"serial": "42"}),
        ({"repeat": 2, "direction": -1.0}, {"repeat": 2, "direction": -1.0}),
        ({"calibration": {}, "parameters": {"a": 1}}, {"parameters": {"a": 1}}),
        ({"waveform": {"name": "step"}, "plant": None}, {"waveform": {"name": "step"}}),
        ({"filled_in": [], "cycle_first": 0}, {"cycle_first": 0}),
        ({"speed": 0.03, "extra": {"colour": "red"}}, {"speed": 0.03, "colour": "red"}),
    ],
)
def test_a_run_of_a_campaign_has_what_differs_from_the_defaults(given, more):
    assert RunRecord(**given).to_dict() == {**ALWAYS, **more}


def test_the_file_of_a_record_has_every_key():
    record = samples.toyo(fz=None, pressure=None, direction="reverse", speed=None)
    written = load_yaml(record.to_yaml(), "")
    own = {item.name for item in fields(RunRecord)} - {"file", "date", "extra"}
    assert set(written) == own | {"format"}
    assert written["format"] == FORMAT and written["direction"] == "reverse"
    assert (written["fz"], written["pressure"], written["speed"]) == (0.0, 0.0, None)
    known = samples.toyo(fz=3700.0, pressure=2.5, plant={"seed": 7, "list": (1, math.nan)})
    written = load_yaml(known.to_yaml(), "")
    assert (written["fz"], written["pressure"]) == (3700.0, 2.5)
    assert written["direction"] == "forward" and written["plant"] == {"seed": 7, "list": [1, None]}


@pytest.mark.parametrize(
    ("given", "kind"),
    [
        ({}, "slip"), ({"waveform": {}}, "slip"), ({"waveform": {"name": "constant"}}, "slip"),
        ({"direction": -1.0}, "slip reversed"), ({"direction": 1.0, "speed": 0.0099}, "slip slow"),
        ({"speed": 0.01}, "slip"), ({"speed": math.nan}, "slip"),
        ({"waveform": {"name": "ramp"}, "direction": -1.0, "speed": 0.001},
         "slip ramp reversed slow"),
        ({"measurement": "free_rolling", "speed": 0.0}, "free_rolling slow"),
    ],
)  # fmt: skip
def test_the_kind_of_a_run(given, kind):
    record = RunRecord(**given)
    assert record.kind == kind and record.is_step == (kind == "slip")
    assert record.condition.measurement == kind


def test_the_condition_of_a_run():
    record = RunRecord(tire="TOY", kappa=0.1, fz=4e3, pressure=2.0, alpha_deg=3.0, gamma_deg=-1.0)
    assert record.condition._asdict() == {
        "tire": "TOY", "measurement": "slip", "fz": 4e3, "pressure": 2.0, "alpha_deg": 3.0,
        "gamma_deg": -1.0, "kappa": 0.1,
    }  # fmt: skip


@pytest.mark.parametrize(
    ("file", "stem"),
    [("run.mcap.zstd", "run"), ("RUN.DB3.ZSTD", "RUN"), ("run.zstd", "run"), ("run.csv.old",
     "run.csv.old"), ("run.v1.csv", "run.v1"), ("csv", "csv"), ("a.csv/b.bag", "b")],
)  # fmt: skip
def test_only_the_suffixes_of_samples_are_no_part_of_a_name(file, stem):
    assert stem_of(file) == stem


@pytest.mark.parametrize("raw", [None, 3, "tire: TOY", ["tire"]])
def test_a_record_must_be_keys_and_values(raw):
    with pytest.raises(RecordingError, match=r"^p\.yaml: not a run record"):
        record_from_dict(raw, "p.yaml")


def test_a_new_record_has_what_the_bench_needs_and_what_was_given():
    record = record_from_dict({"format": FORMAT, "tire": "TOY"})
    assert (record.status, record.waveform, record.tire) == ("described", {}, "TOY")
    assert len(record.uuid) == 36 and record.name == "TOY_REL_LNG_0perc_T_p0_Fz0_1"
    uuid = "12345678-1234-5678-1234-567812345678"
    given = record_from_dict({"tire": "TOY", "uuid": uuid, "status": "armed", "name": "mine"})
    assert (given.uuid, given.status, given.name) == (uuid, "armed", "mine")


def test_a_file_that_is_no_text_is_refused(tmp_path):
    (tmp_path / "run.yaml").write_bytes(b"tire: \xff\xfe\x00")
    with pytest.raises(RecordingError, match=r"run\.yaml"):
        load_record(tmp_path)
