# SPDX-License-Identifier: Apache-2.0
"""One table of limits: whoever takes a setting refuses the same values with the same words."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from types import SimpleNamespace

import pytest

from flatplank_control.load_control import LoadController, LoadParameters
from flatplank_control.recording.filled import requested_record
from flatplank_control.runner.measurement import Measurement
from flatplank_control.sequencer import SequencerParameters, SlipSequencer
from flatplank_data.errors import RecordingError
from flatplank_data.limits import FORCE, IN_FILES, LIMITS, RECORDED, Limit, refusal
from flatplank_data.machine import COUNTS_PER_TURN, GEAR_RATIO, ROAD_LENGTH, USABLE_ROAD
from flatplank_hw.drive import DriveParameters
from flatplank_hw.hub import HubParameters
from flatplank_panel import validation
from flatplank_sim.nodes.operator_services import VALUES, OperatorServices
from flatplank_sim.plant import PlantConfig


def planned(setting: str, value: float) -> str:
    """What a plan says to a setting."""
    key = {"steer_deg": "alpha_deg", "road_camber_deg": "gamma_deg"}.get(setting, setting)
    hub = min(max(value, LIMITS["wheel_camber_deg"].low), LIMITS["wheel_camber_deg"].high)
    beside = {
        "wheel_camber_deg": {"gamma_deg": value},
        "gamma_deg": {"wheel_camber_deg": hub},
        "end_position": {"step_position": 0.0},
    }
    return said(lambda: Measurement(**{key: value}, **beside.get(setting, {}))).replace(
        key, setting
    )


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
    served[f"simulated_plant/{service}"](SimpleNamespace(value=value), response)
    return response.reason


def at_the_hub(setting: str, value: float) -> str:
    """What the parameters of the hub say."""
    return said(lambda: HubParameters(**{setting: value}))


def driven(setting: str, value: float) -> str:
    """What the parameters of a drive say."""
    return said(lambda: DriveParameters(**{setting: value}))


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
    "wheel_camber_deg": (planned, on_the_page, recorded, simulated, at_the_hub),
    "road_camber_deg": (planned, on_the_page, simulated),
    "gamma_deg": (planned, recorded),
    "free_radius": (driven,),
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
    for value in (low, 0.5 * (low + high), high):
        assert "must be within" not in ask(setting, value), value


def test_every_limit_has_its_sentence_of_the_thesis_or_is_said_to_have_none():
    for setting, limit in LIMITS.items():
        named = limit.source.startswith("placeholder: ")
        assert named != bool(limit.quotation), setting
        if limit.quotation:
            assert limit.source.startswith("thesis "), setting


QUOTED = ("fz", "wheel_camber_deg", "road_camber_deg", "gamma_deg", "steer_deg", "free_radius")


@pytest.mark.parametrize("setting", QUOTED)
def test_a_limit_is_the_number_of_its_sentence(setting):
    """8 kN is 8000 N; +-30 is -30 .. 30."""
    limit = LIMITS[setting]
    numbers = [float(n) for n in re.findall(r"\d+(?:\.\d+)?", limit.quotation)]
    scale = 1000.0 if setting == "fz" else 1.0
    assert limit.high in [scale * n for n in numbers]
    if setting == "free_radius":
        assert limit.low in numbers
    elif setting != "fz":
        assert limit.low == -limit.high


def test_a_hub_tilted_by_30_deg_on_a_road_tilted_by_15_deg():
    assert Measurement(wheel_camber_deg=30.0, gamma_deg=30.0).gamma_deg == 30.0
    assert Measurement(wheel_camber_deg=30.0, gamma_deg=45.0).gamma_deg == 45.0
    with pytest.raises(ValueError, match="road_camber_deg is 16 deg.*wheel_camber_deg"):
        Measurement(wheel_camber_deg=29.0, gamma_deg=45.0)


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_a_value_that_is_no_number_is_refused_as_such(value):
    for limit in [*LIMITS.values(), FORCE, *IN_FILES.values()]:
        assert limit.refusal("it", value) == f"it is {value}, must be finite"
    endless = Limit(-math.inf, math.inf, "N")
    assert not endless.admits(value) and endless.admits(0.0)


def test_zero_is_a_number():
    """Refused by its range where that begins above it, and else accepted."""
    for setting, limit in LIMITS.items():
        inside = limit.low <= 0.0 <= limit.high
        assert limit.admits(0.0) == inside
        assert ("must be within" in refusal(setting, 0.0)) != inside


def test_the_simulated_machine_is_the_one_of_the_parameters():
    machine = PlantConfig.load()
    assert machine.wheel_drive.gear_ratio == GEAR_RATIO
    assert machine.plank.road_length == ROAD_LENGTH > USABLE_ROAD
    assert machine.encoders.wheel_counts_per_turn == COUNTS_PER_TURN
    assert machine.encoders.plank_counts_per_turn == COUNTS_PER_TURN
    assert machine.axes.steer_limit_deg == LIMITS["steer_deg"].high
