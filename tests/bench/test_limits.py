# SPDX-License-Identifier: Apache-2.0
"""One table of limits: whoever takes a setting refuses the same values with the same words."""

from __future__ import annotations

import math
from collections.abc import Callable
from types import SimpleNamespace

import pytest

from flatplank_control.load_control import LoadController, LoadParameters
from flatplank_control.recording.filled import requested_record
from flatplank_control.runner.measurement import Measurement
from flatplank_control.sequencer import SequencerParameters, SlipSequencer
from flatplank_data.errors import RecordingError
from flatplank_data.limits import LIMITS, RECORDED, refusal
from flatplank_data.machine import COUNTS_PER_TURN, GEAR_RATIO, ROAD_LENGTH, USABLE_ROAD
from flatplank_panel import validation
from flatplank_sim.nodes.operator_services import VALUES, OperatorServices
from flatplank_sim.plant import PlantConfig


def planned(setting: str, value: float) -> str:
    """What a plan says to a setting."""
    known = {"steer_deg": "alpha_deg", "camber_deg": "wheel_camber_deg"}
    key = known.get(setting, setting)
    given = {key: value, **({"gamma_deg": value} if key == "wheel_camber_deg" else {})}
    given |= {"step_position": 0.0} if key == "end_position" else {}
    return said(lambda: Measurement(**given)).replace(key, setting)


def on_the_page(setting: str, value: float) -> str:
    return said(lambda: validation.setting(value, setting))


def recorded(setting: str, value: float) -> str:
    """What the service says that starts a recording."""
    return said(lambda: requested_record(f"{{tire: TOY, {setting}: {value}}}"))


def sequenced(setting: str, value: float) -> str:
    """What the slip service says."""
    given = {"kappa": 0.01, "step_position": 1.0, "effective_rolling_radius": 0.3, setting: value}
    answer = SlipSequencer(SequencerParameters()).set_slip_step(*given.values())
    return answer.reason


def loaded(setting: str, value: float) -> str:
    """What the load controller says."""
    return said(lambda: LoadController(LoadParameters()).set_load(value))


def simulated(setting: str, value: float) -> str:
    """What the services of the simulated bench say."""
    served: dict[str, Callable] = {}
    node = SimpleNamespace(add_service=lambda _kind, name, call: served.update({name: call}))
    OperatorServices(node, lambda *_: None, lambda: 0)
    (service,) = [name for name, (key, *_) in VALUES.items() if key == setting][:1]
    response = SimpleNamespace(accepted=None, reason="", cycle=0)
    served[f"/simulated_plant/{service}"](SimpleNamespace(value=value), response)
    return response.reason


def said(act: Callable[[], object]) -> str:
    try:
        act()
    except (ValueError, RecordingError) as error:
        return str(error).partition(": ")[2] or str(error)
    return ""


ASKED = {
    "kappa": (planned, on_the_page, recorded, sequenced),
    "fz": (planned, on_the_page, recorded, loaded, simulated),
    "pressure": (planned, on_the_page, recorded, simulated),
    "effective_rolling_radius": (planned, on_the_page, recorded, sequenced),
    "step_position": (planned, on_the_page, recorded, sequenced),
    "end_position": (planned, on_the_page),
    "steer_deg": (planned, on_the_page, simulated),
    "camber_deg": (planned, on_the_page, simulated),
    "cleat_mm": (planned, on_the_page, simulated),
}
"""setting -> whoever takes it"""


def test_every_limit_is_asked():
    assert set(ASKED) == set(LIMITS)
    assert set(RECORDED.values()) <= set(LIMITS.values())


@pytest.mark.parametrize(
    ("setting", "ask"), [(setting, ask) for setting, asked in ASKED.items() for ask in asked]
)
def test_the_same_values_are_refused_with_the_same_words(setting, ask):
    low, high = LIMITS[setting].bounds
    for value in (low - 0.1, high + 0.1):
        assert refusal(setting, value) in ask(setting, value) != ""
    inside = 0.5 * (low + high)
    assert "must be within" not in ask(setting, inside)


def test_a_value_that_is_no_number_is_refused():
    assert all(refusal(setting, math.nan) for setting in LIMITS)


def test_the_simulated_machine_is_the_one_of_the_parameters():
    machine = PlantConfig.load()
    assert machine.wheel_drive.gear_ratio == GEAR_RATIO
    assert machine.plank.road_length == ROAD_LENGTH > USABLE_ROAD
    assert machine.encoders.wheel_counts_per_turn == COUNTS_PER_TURN
    assert machine.encoders.plank_counts_per_turn == COUNTS_PER_TURN
    assert machine.axes.steer_limit_deg == LIMITS["steer_deg"].high
