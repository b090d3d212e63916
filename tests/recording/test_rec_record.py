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
from flatplank_data.record_checks import STATUSES
from flatplank_data.run_record import (
    RunRecord,
    load_record,
    read_run,
    record_from_dict,
    record_from_yaml,
    stem_of,
)

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
    ],
)
def test_a_run_in_words_says_what_was_measured(changes, words):
    said = in_words(samples.toyo(**{"cycles_received": 9, **changes}))
    assert words in said and "\n" not in said
    unknown = samples.toyo(fz=0.0, pressure=2.5, cycles_received=9)
    assert "Fz" not in in_words(unknown) and "not given" not in in_words(unknown)


def test_what_was_not_recorded_is_said():
    assert "nothing was recorded" in in_words(samples.toyo())


def test_a_request_keeps_the_keys_that_it_gives():
    said = requested_record("{tire: TOY, measurement: slip, kappa: 0.05}")
    assert said.given_keys == {"tire", "measurement", "kappa"}
    assert said.record.name.startswith("TOY_") and said.record.kappa == 0.05
    assert requested_record("{tire: TOY, name: mine}").record.name == "mine"
    assert requested_record("{tire: TOY, name: mine}", "other").record.name == "other"
    assert requested_record("", "by_me").record.name == "by_me"
