# SPDX-License-Identifier: Apache-2.0
"""A lab bench: nothing is set by services, the operator is asked and may be at lunch."""

from __future__ import annotations

import re

import pytest
from bench_graph import shared_graph
from short_plan import short_plan
from std_srvs.srv import Trigger

from flatplank_control.nodes.client import BenchError
from flatplank_control.runner.campaign import Journal, plan_from_text
from flatplank_data.run_record import load_record
from flatplank_hw.cia402 import State
from flatplank_msgs.msg import DriveStatus, EncoderState
from flatplank_msgs.srv import PlankSwitch, SetValue

pytestmark = pytest.mark.graph
PLANT = "/simulated_plant"
SHORT = {"kappa": 0.02, "step_position": 0.02, "end_position": 0.04}
SETTINGS = {
    "lower the axle": "load_to",
    "set the steering": "set_steer_deg",
    "set the road camber": "set_road_camber_deg",
    "set the inflation": "set_pressure_bar",
}
SWITCH = {"forward": 1, "stop": 0, "reverse": -1}
PLAN = short_plan("lab")
bench = shared_graph()


class Hands:
    """Does what is asked, on the machine, and says so; `but` is asked first."""

    def __init__(self, bench, but=lambda _prompt: False) -> None:
        self.bench, self.but = bench, but
        self.asked: list[str] = []
        self._prompt = ""

    def hear(self, feedback) -> None:
        self._prompt = feedback.prompt

    def idle(self) -> None:
        prompt, self._prompt = self._prompt, ""
        if not prompt:
            return
        self.asked.append(prompt)
        if not self.but(prompt):
            self.obey(prompt)
            self.bench.call(Trigger, "/measurement_runner/confirm")

    def obey(self, prompt: str) -> None:
        switch = re.match(r"turn the plank switch to (\w+)", prompt)
        if switch:
            direction = SWITCH[switch[1]]
            self.bench.call(PlankSwitch, f"{PLANT}/plank", direction=direction, fast=True,
                            stop_at=float("nan"))  # fmt: skip
        elif prompt.startswith("lift the wheel"):
            self.bench.call(Trigger, f"{PLANT}/unload")
        else:
            (service,) = [name for words, name in SETTINGS.items() if prompt.startswith(words)]
            value = float(re.search(r"-?[\d.]+", prompt)[0])
            self.bench.call(SetValue, f"{PLANT}/{service}", value=value)


def drive_state(bench, drive: str = "wheel_drive") -> int:
    return bench.message_after(50, bench.listen(DriveStatus, f"/{drive}/status")).state


def test_ctrl_c_while_the_operator_is_asked_ends_safely(bench):
    """At the prompt to stop the plank, the wheel driven and the bag open."""

    def leave(prompt: str) -> bool:
        if "to stop" in prompt and any("forward" in asked for asked in hands.asked):
            assert drive_state(bench) == State.OPERATION_ENABLED
            raise KeyboardInterrupt
        return False

    hands = Hands(bench, leave)
    folder = bench.data / "left"
    folder.mkdir(parents=True)
    with pytest.raises(KeyboardInterrupt, match="cancelled; turn the plank switch to stop"):
        bench.client.measure(
            SHORT, simulated=False, folder=str(folder), hear=hands.hear, idle=hands.idle
        )
    assert drive_state(bench) != State.OPERATION_ENABLED
    (bag,) = [p.parent for p in folder.glob("*/run.yaml")]
    assert load_record(bag).status == "stopped"
    with pytest.raises(BenchError, match="kapa"):  # not busy
        bench.client.measure({"kapa": 1}, simulated=False)


def test_a_drag_is_begun_and_stopped_in_time_without_a_key(bench):
    """Who has his hand at the plank's switch presses no key: the encoder sees it."""
    stopped_at = []

    def at_the_switch(prompt: str) -> bool:
        if any("forward" in asked for asked in hands.asked[:-1]):
            if stopped_at:
                assert prompt.startswith("lower the axle"), "stop is asked for once"
                raise KeyboardInterrupt
            encoders = bench.message_after(1, bench.listen(EncoderState, "/encoders/state"))
            stopped_at.append(encoders.plank_position)
        elif "forward" not in prompt:
            return False
        hands.obey(prompt)
        bench.advance(100)
        return True

    hands = Hands(bench, at_the_switch)
    with pytest.raises(KeyboardInterrupt):
        bench.client.measure(
            {"measurement": "stiffness_longitudinal"}, simulated=False,
            hear=hands.hear, idle=hands.idle,
        )  # fmt: skip
    forward = "turn the plank switch to forward, fast; stop it 0.13 m behind the trigger"
    assert hands.asked[-3:-1] == [forward, "turn the plank switch to stop"]
    assert 0.13 <= stopped_at[0] < 0.18


def test_a_run_is_skipped_while_the_operator_is_asked_for_it(bench):
    plan = plan_from_text(PLAN, "plan")

    def skip(_prompt: str) -> bool:
        return bench.call(Trigger, "/measurement_runner/skip").success

    hands = Hands(bench, skip)
    assert not bench.client.measure(
        PLAN, simulated=False, folder=str(bench.data), hear=hands.hear, idle=hands.idle
    )
    assert len(hands.asked) == 1
    journal = Journal(bench.data / "lab.journal.jsonl", plan.name, plan.digest)
    assert journal.done[plan.runs[0].key].skipped
