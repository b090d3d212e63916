# SPDX-License-Identifier: Apache-2.0
"""R1.I to R1.XII, N.I, N.II of thesis 4.1 as an operator clicks them; the effect is read at the
plant, in the bag or in the parameter, never on the page alone.

A check takes the operator, the observer of the graph and the data folder; AssertionError: not met.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import NamedTuple
from uuid import uuid4

import numpy as np
import pytest
import yaml
from panel_rig import BUS_HZ, wait_for

from flatplank_data.campaign import Campaign
from flatplank_hw.drive.modes import MODES
from flatplank_hw.hub.parasitic import ParasiticFit, Sine, fit_to_text

SPEED = 0.03092
HELD = 50.0
"""Fx of free rolling, thesis 5.5 [N]"""
NODES = ("simulated_plant", "measurement_hub", "encoders", "wheel_drive", "recorder")


class Check(NamedTuple):
    """One requirement."""

    run: Callable
    fixture: str
    """who clicks: `operator` of a running bench, or `enabled` with the drive enabled"""
    stub: str
    """what a panel must not do for the check to fail: `hands` act, or `eyes` see"""


CHECKS: dict[str, Check] = {}


def requirement(name: str, fixture: str = "operator", stub: str = "hands") -> Callable:
    def register(run: Callable) -> Callable:
        CHECKS[name] = Check(run, fixture, stub)
        return run

    return register


def turn(who, button: str) -> None:
    """Enable, which clears a stop, and ask for the motion."""
    who.click("Reset fault")
    who.click("Enable")
    who.page.wait_for_timeout(500)
    who.click(button)


def load(who, observer, newtons: float) -> None:
    who.tab("Machine")
    who.fill("Load [N]", newtons)
    who.click("Set Load")
    observer.wait(lambda: abs(observer.force("z") - newtons) < 60.0, 40.0, "the tire is loaded")


@requirement("R1.I stops and starts the bench")
def stops_and_starts(who, observer, data):
    who.tab("Machine")
    who.click("Stop bench")
    wait_for(lambda: not observer.running, 40.0, "the bus is silent")
    who.word_is("bench", "not running")
    wait_for(lambda: np.isnan(who.number("fz")), what="no number of a bench that is gone")
    who.fill("Bus rate [Hz]", BUS_HZ)
    who.click("Start bench")
    observer.client.wait_connected(NODES, 120.0)
    observer.fresh()
    before = observer.inputs.cycle
    observer.wait(lambda: observer.inputs.cycle > before + 25, what="the bus makes cycles")
    who.word_is("bench", "running")
    times = wait_for(lambda: who.page.evaluate("fp.rows.map(r => r[0])"), what="rows of the plots")
    assert np.all(np.diff(times) > 0.0), "nothing of the bench before is in the plots"


@requirement("R1.II, R1.III logs and saves")
def logs_and_saves_under_name_and_folder(who, observer, data):
    who.tab("Measure")
    who.fill("Folder below the data folder", "monday/first")
    who.fill("Name", "TOY_by_hand_7")
    who.fill("Note", "<b>by</b> hand")
    who.page.get_by_text("at once, not from").click()
    who.click("Start logging")
    who.word_is("run", "recording")
    observer.fresh()
    start = observer.inputs.cycle
    observer.wait(lambda: observer.inputs.cycle > start + BUS_HZ, what="a second of cycles")
    who.click("Stop and save")
    who.word_is("run", "complete")
    bag = data / "monday" / "first" / "TOY_by_hand_7"
    record = yaml.safe_load((bag / "run.yaml").read_text())
    assert record["status"] == "complete" and record["notes"] == "<b>by</b> hand"
    assert record["cycles_received"] >= 0.95 * BUS_HZ
    assert record["et_value"] == pytest.approx(0.04)
    assert (bag / "metadata.yaml").exists()


@requirement("R1.II discards")
def discards(who, observer, data):
    who.tab("Measure")
    who.fill("Name", "TOY_thrown_away")
    who.click("Start logging")
    who.word_is("run", "armed")
    assert (data / "TOY_thrown_away").is_dir()
    who.click("Discard")
    who.word_is("run", "discarded")
    assert not (data / "TOY_thrown_away").exists()


@requirement("R1.IV, R1.V, R1.IX numbers and plots", stub="eyes")
def numbers_and_plots_follow_the_bench(who, observer, data):
    load(who, observer, 900)
    wait_for(lambda: abs(who.number("fz") - 900.0) < 80.0, what="Fz in the ribbon")
    wait_for(
        lambda: abs(who.number("rl") - observer.latest["hub"].loaded_radius) < 2e-4,
        what="the loaded radius of this moment",
    )
    drawn = (
        "() => { const c = fp.charts[0]; const s = getElement(c.id).chart.getOption().series;"
        " return s.map(x => (x.data[x.data.length - 1] || [0, 0])[1]); }"
    )
    wait_for(lambda: abs(who.page.evaluate(drawn)[2] - 900.0) < 80.0, what="Fz in the plot")
    assert len(who.page.evaluate(drawn)) == 6


@requirement("R1.VI constants")
def constants_reach_the_hub(who, observer, data):
    from rcl_interfaces.srv import GetParameters

    def value() -> float:
        answer = observer.client.call(
            GetParameters, "/measurement_hub/get_parameters", names=["et_value"]
        )
        return answer.values[0].double_value

    who.tab("Set-up")
    who.click("Read from bench")
    for wanted in (0.055, 0.04):
        who.fill("ET value [m]", wanted)
        who.click("Set constants")
        wait_for(lambda wanted=wanted: value() == wanted, what=f"et_value is {wanted}")
    who.fill("ET value [m]", 0.9)
    who.click("Set constants")
    who.said("must be within")
    assert value() == 0.04


@requirement("R1.VII enables and disables")
def enables_and_disables(who, observer, data):
    who.tab("Drive")
    who.click("Enable")
    click = partial(who.click, "Enable")
    observer.wait(observer.enabled, 60.0, "operation enabled on the bus", again=click)
    who.click("Disable")
    observer.wait(lambda: not observer.enabled(), what="disabled on the bus")


@requirement("R1.VIII velocity and its plot", "enabled")
def velocity_and_its_plot(who, observer, data):
    who.tab("Drive")
    who.fill("Velocity [rad/s]", 0.08)
    turn(who, "Set velocity")
    observer.wait(
        lambda: observer.speed() == pytest.approx(0.08, rel=0.05),
        60.0,
        "the shaft turns",
        again=lambda: turn(who, "Set velocity"),
    )
    wait_for(lambda: abs(who.number("omega") - 0.08) < 0.01, what="speed in the ribbon")
    drawn = (
        "() => { const s = getElement(fp.charts[1].id).chart.getOption().series;"
        " return [s[2], s[3]].map(x => (x.data[x.data.length - 1] || [0, 0])[1]); }"
    )
    wait_for(
        lambda: who.page.evaluate(drawn) == pytest.approx([0.08, 0.08], rel=0.1),
        what="actual and reference in the plot",
    )


@requirement("R1.VIII, N.I position buttons", "enabled")
def position_buttons_turn_the_shaft(who, observer, data):
    who.tab("Drive")
    who.click("Home: this is 0°")
    observer.wait(
        lambda: abs(observer.latest["drive"].position) < 1e-3,
        60.0,
        "homed",
        again=lambda: turn(who, "Home: this is 0°"),
    )
    before = observer.shaft()
    who.fill("Angle [deg]", 4)
    who.click("Turn there")
    observer.wait(
        lambda: abs(observer.shaft() - before - 4.0) < 0.1,
        60.0,
        "4 deg at the shaft",
        again=lambda: turn(who, "Turn there"),
    )
    assert all(who.button(f"{a}°").is_enabled() for a in (240, 360, 1080))
    who.click("120°")
    observer.wait(
        lambda: abs(observer.shaft() - before - 120.0) < 0.3,
        60.0,
        "120 deg at the shaft",
        again=lambda: turn(who, "120°"),
    )
    who.click("0°")
    observer.wait(
        lambda: abs(observer.shaft() - before) < 0.3,
        60.0,
        "back at the shaft",
        again=lambda: turn(who, "0°"),
    )


@requirement("R1.VIII torque", "enabled")
def torque(who, observer, data):
    who.tab("Drive")
    who.fill("Torque [N m]", 1.2)
    who.click("Set torque")
    observer.wait(
        lambda: observer.inputs.axes[0].torque * 1e-4 == pytest.approx(1.2, abs=0.05),
        60.0,
        "torque at the motor, by the bus",
        again=lambda: turn(who, "Set torque"),
    )
    who.click("Quick stop")
    observer.wait(lambda: abs(observer.speed()) < 1e-3, what="the shaft rests")


@requirement("R1.VIII, N.II slip over the road", "enabled")
def slip_over_the_road(who, observer, data):
    """The waveform editor, a recording from the motion trigger on, and the plots over the road."""
    page = who.page
    who.tab("Drive")
    who.fill("Starts at [m]", 0.06)
    who.fill("kappa [%]", 30)
    who.click("Set slip control")
    who.said("mode slip")
    who.tab("Measure")
    who.fill("Name", "TOY_slip_by_hand")
    who.click("Start logging")
    who.word_is("run", "armed")
    who.tab("Machine")
    who.fill("Stops at [m]", 0.18)
    who.click("Plank forward")
    observer.wait(
        lambda: observer.latest["encoders"].plank_position > 0.1, 40.0, "the plank is at 0.1 m"
    )
    wanted = SPEED * 1.3 / 0.3108
    assert observer.speed() == pytest.approx(wanted, rel=0.03)
    page.get_by_role("button", name="road displacement").click()
    wait_for(
        lambda: page.evaluate(
            "() => { const d = getElement(fp.charts[0].id).chart.getOption().series[0].data;"
            " const p = d[d.length - 1]; return p && p[0] > 0.1 && p[0] < 0.4; }"
        ),
        what="the plot is over road displacement",
    )
    observer.wait(lambda: not observer.latest["encoders"].plank_moving, 40.0, "the plank rests")
    who.tab("Measure")
    who.click("Stop and save")
    who.word_is("run", "complete")
    record = yaml.safe_load((data / "TOY_slip_by_hand" / "run.yaml").read_text())
    assert record["cycles_received"] > 4 * BUS_HZ


@requirement("R1.X status of the bus", stub="eyes")
def status_of_the_bus(who, observer, data):
    who.tab("Bus")
    who.word_is("health", "ok")
    wait_for(
        lambda: abs(int(who.word("cycle")) - observer.inputs.cycle) < 500 or observer.look(),
        what="cycle number of the bus",
    )
    row = who.page.get_by_role("row", name="wheel")
    word = f"0x{observer.inputs.axes[0].status_word:04X}"
    wait_for(lambda: word in (row.first.text_content() or ""), what=f"status word {word}")
    wait_for(lambda: " of " in who.word("late"), what="number of late cycles")
    wait_for(lambda: who.word("frame_to_frame").endswith("µs"), what="times of the bus")


@requirement("R1.XI, R1.XII parasitic filter")
def parasitic_filter(who, observer, data):
    sine = Sine(0.05, 1.0, 0.3, 0.0, 0.001)
    fit = ParasiticFit("test mounting", "2026-01-01", (sine,) * 5)
    (data / "mounting.yaml").write_text(fit_to_text(fit))
    who.tab("Set-up")
    who.click("Filter on")
    who.said("no parasitic fit is loaded")
    who.page.get_by_role("button", name="Look for fits again").click()
    who.choose("Fit of this mounting", "mounting.yaml")
    who.click("Load")
    who.said("parasitic fit mounting.yaml loaded")
    before = observer.latest["wheel"].wrench.force.y
    who.click("Filter on")
    observer.wait(lambda: observer.latest["hub"].filter_on, what="the hub filters")
    observer.look(0.3)
    assert abs(observer.latest["wheel"].wrench.force.y - before) > 5.0
    who.click("Filter off")
    observer.wait(lambda: not observer.latest["hub"].filter_on, what="the filter is off")


@requirement("R1.VIII free rolling", "enabled")
def free_rolling(who, observer, data):
    load(who, observer, 1500)
    who.tab("Drive")
    turn(who, "Free rolling")
    observer.wait(
        lambda: observer.enabled() and observer.latest["drive"].mode == MODES["free_rolling"].code,
        30.0,
        "the drive is in free rolling",
        again=lambda: turn(who, "Free rolling"),
    )
    who.tab("Machine")
    who.fill("Stops at [m]", 0.3)
    who.click("Plank forward")
    observer.wait(
        lambda: observer.latest["encoders"].plank_position > 0.2, 40.0, "the plank is at 0.2 m"
    )
    forces, speeds = zip(*[(observer.force("x"), observer.speed()) for _ in range(5)], strict=True)
    assert np.mean(forces) == pytest.approx(HELD, abs=20.0), "Fx is held"
    assert np.mean(speeds) == pytest.approx(SPEED / 0.32, rel=0.05), "the wheel rolls"


@requirement("R1.II, R1.VIII a whole measurement")
def measures_a_slip_step(who, observer, data):
    folder = f"measured_{uuid4().hex[:6]}"
    who.tab("Measure")
    who.fill("Folder below the data folder", folder)
    run = {"Slip [%]": 5, "Load [N]": 1500, "Step at [m]": 0.04, "Ends at [m]": 0.2}
    for label, value in run.items():
        who.fill(label, value)
    who.click("Measure")

    def saved() -> bool:
        records = list((data / folder).glob("*/run.yaml"))
        return bool(records) and yaml.safe_load(records[0].read_text())["status"] == "complete"

    wait_for(saved, 240.0, "the measurement is complete")
    (run,) = Campaign.load(data / folder).runs
    assert run.info.kappa == pytest.approx(0.05) and run.info.fz == 1500.0
    table = run.table(("plank_position", "plank_velocity", "wheel_velocity"))
    there = (table["plank_position"] > 0.08) & (table["plank_position"] < 0.19)
    slip = table["wheel_velocity"][there] * 0.3108 / table["plank_velocity"][there] - 1.0
    assert np.mean(slip) == pytest.approx(0.05, abs=0.005)
