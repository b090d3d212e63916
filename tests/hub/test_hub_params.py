# SPDX-License-Identifier: Apache-2.0
"""Parameter sets: unknown keys, ranges, files, and that the shipped files say what the code
says."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import pytest

from flatplank_control.free_rolling import FreeRollingParameters
from flatplank_control.load_control import LoadParameters
from flatplank_control.sequencer import SequencerParameters
from flatplank_control.steering_hold import AngleParameters
from flatplank_data.params import (
    ParameterError,
    Params,
    from_mapping,
    load_parameter_set,
    param,
    parameter_infos,
    to_mapping,
)
from flatplank_hw.drive import DriveParameters
from flatplank_hw.encoders import EncoderParameters
from flatplank_hw.hub import HubParameters

SRC = Path(__file__).parents[2] / "ros_ws" / "src"
SHIPPED = {
    HubParameters: SRC / "flatplank_hw/config/measurement_hub.yaml",
    EncoderParameters: SRC / "flatplank_hw/config/encoders.yaml",
    DriveParameters: SRC / "flatplank_hw/config/wheel_drive.yaml",
    FreeRollingParameters: SRC / "flatplank_control/config/free_rolling_controller.yaml",
    SequencerParameters: SRC / "flatplank_control/config/slip_sequencer.yaml",
    LoadParameters: SRC / "flatplank_control/config/load_controller.yaml",
    AngleParameters: SRC / "flatplank_control/config/steering_hold.yaml",
}


@dataclass(frozen=True)
class Example(Params):
    gain: float = param(1.0, "a gain", unit="N/V", bounds=(0.0, 10.0))
    count: int = param(3, "a count")
    name: str = param("a", "a name", choices=("a", "b"))
    table: tuple[float, ...] = param((0.0, 1.0), "a table", unit="N m", bounds=(0.0, 5.0))
    on: bool = param(False, "a switch")


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"gian": 2.0}, "file.yaml: unknown parameter 'gian'; the nearest is 'gain'"),
        ({"gain": math.nan}, "file.yaml: gain is nan, must be finite"),
        ({"gain": 11}, "file.yaml: gain is 11 N/V, must be within 0 .. 10"),
        ({"gain": "5 N"}, "file.yaml: gain must be a number, not '5 N'"),
        ({"count": 1.5}, "file.yaml: count must be a whole number, not 1.5"),
        ({"name": "c"}, "file.yaml: name is 'c'; known are a, b"),
        ({"table": [1.0, 6.0]}, "file.yaml: table is 6 N m, must be within 0 .. 5"),
        ({"table": 1.0}, "file.yaml: table must be a list, not 1.0"),
        ({"on": 1}, "file.yaml: on must be true or false, not 1"),
    ],
)
def test_refusals_are_one_line_with_place_and_reason(values, message):
    with pytest.raises(ParameterError) as caught:
        from_mapping(Example, values, "file.yaml")
    assert str(caught.value) == message


def test_round_trip():
    example = from_mapping(Example, {"gain": "2e0", "table": [3, 4]}, "here")
    assert example == Example(gain=2.0, table=(3.0, 4.0))
    assert from_mapping(Example, to_mapping(example), "here") == example


def test_shell_keys_are_left_to_the_node():
    assert from_mapping(Example, {"autostart": False, "use_sim_time": True}, "n") == Example()


@pytest.mark.parametrize("cls", SHIPPED, ids=lambda cls: cls.__name__)
def test_shipped_file_holds_every_parameter_with_its_default(cls):
    assert load_parameter_set(cls, SHIPPED[cls]) == cls()
    text = SHIPPED[cls].read_text(encoding="utf-8")
    for info in parameter_infos(cls):
        assert f"    {info.name}:" in text
        assert info.description in text


@pytest.mark.parametrize("cls", SHIPPED, ids=lambda cls: cls.__name__)
def test_every_parameter_has_note_unit_and_round_trip(cls):
    for info in parameter_infos(cls):
        assert info.note
        assert info.unit
    assert from_mapping(cls, to_mapping(cls()), "default") == cls()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("- 1\n", "expected '/**:'"),
        ("/**:\n  x: 1\n", "has no 'ros__parameters:'"),
        ("a: [1\n", "not YAML"),
    ],
)
def test_bad_files_are_refused_in_one_line(tmp_path, text, message):
    path = tmp_path / "bad.yaml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match=r"bad\.yaml") as caught:
        load_parameter_set(Example, path)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_node_section_overrides_the_common_one(tmp_path):
    path = tmp_path / "p.yaml"
    path.write_text(
        "/**:\n  ros__parameters:\n    gain: 2.0\n    count: 4\n"
        "hub:\n  ros__parameters:\n    gain: 3.0\n",
        encoding="utf-8",
    )
    assert load_parameter_set(Example, path, "hub") == Example(gain=3.0, count=4)
