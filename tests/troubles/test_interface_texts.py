# SPDX-License-Identifier: Apache-2.0
"""What people read in message definitions and parameter dumps is true."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from rclpy.parameter import Parameter
from rclpy.parameter import get_parameter_value as as_the_command_line_reads_it

from flatplank_control.bench.setup import DRIVEN, BenchSetup
from flatplank_control.steering_hold import PROFILES, AngleControl, AngleParameters
from flatplank_data.params import parameter_infos
from flatplank_data.waveforms import WAVEFORMS

ROOT = Path(__file__).resolve().parents[2]
DEFINITION = ROOT / "ros_ws/src/flatplank_msgs/srv/SetWaveform.srv"


def rows(title: str) -> dict[str, list[str]]:
    """Names and parameters in the comment below a title."""
    text = DEFINITION.read_text(encoding="utf-8").split(title, 1)[1]
    found = {}
    for line in text.splitlines()[1:]:
        row = re.fullmatch(r"#   (\w+) +([\w, ]+)", line)
        if row is None:
            break
        found[row[1]] = row[2].split(", ")
    return found


def test_the_service_names_every_waveform_and_profile_with_its_parameters():
    waves = {name: [i.name for i in parameter_infos(wave)] for name, wave in WAVEFORMS.items()}
    assert rows("# /slip_sequencer/set_waveform") == waves
    profiles = {name: [i.name for i in parameter_infos(kind)] for name, kind in PROFILES.items()}
    assert rows("# /steering_hold/set_profile") == profiles


@pytest.mark.parametrize("name", PROFILES)
def test_every_profile_is_taken_as_the_service_gives_it(name):
    """All values of the message are float64, also whole numbers."""
    hold = AngleControl(AngleParameters())
    given = {i.name: float(i.default) for i in parameter_infos(PROFILES[name])}
    done = hold.set_profile(name, given)
    assert done.accepted, done.reason


@pytest.mark.parametrize("kind", ["sim", "lab"])
def test_texts_of_a_parameter_dump_are_texts_when_it_is_loaded(kind):
    """`ros2 param load` reads every value as YAML: '2008' would become a number."""
    setup = BenchSetup(kind=kind, axes=tuple(DRIVEN), interface="eth7")
    texts = {
        f"{node.name}.{name}": value
        for node in setup.nodes()
        for name, value in setup.of(node).items()
        if isinstance(value, str) and value
    }
    assert "measurement_hub.calibration_date" in texts
    kinds = {key: as_the_command_line_reads_it(value).type for key, value in texts.items()}
    wrong = [key for key, kind in kinds.items() if kind != Parameter.Type.STRING.value]
    assert wrong == []
