# SPDX-License-Identifier: Apache-2.0
"""R1.I to R1.XII, N.I, N.II of thesis 4.1, clicked; the effect is read at the plant, in the bag or
in the parameter, never on the page alone."""

from __future__ import annotations

import re
from functools import partial

import pytest
import yaml
from panel_rig import wait_for

from flatplank_control.bench.log import BagLog
from flatplank_control.bench.setup import BenchSetup
from flatplank_control.bench.twin import Twin
from flatplank_control.bench.twin_bench import TwinBench
from flatplank_control.runner.measurement import Measurement
from flatplank_control.runner.plans import plan_of
from flatplank_hw.hub.parasitic import ParasiticFit, Sine, to_text

pytestmark = [pytest.mark.browser, pytest.mark.graph, pytest.mark.timeout(180)]
SPEED = 0.03092


def turn(who, button: str) -> None:
    """Enable, which clears a stop, and ask for the motion."""
    who.click("Reset fault")
    who.click("Enable")
    who.page.wait_for_timeout(500)
    who.click(button)


def test_r1_i_starts_the_bench(operator, observer):
    before = observer.inputs.cycle
    observer.wait(lambda: observer.inputs.cycle > before + 25, what="the bus makes cycles")
    names = observer.client.node.get_node_names()
    assert {"simulated_plant", "measurement_hub", "wheel_drive", "recorder"} <= set(names)


def test_r1_ii_iii_logs_and_saves_under_name_and_folder(operator, observer, data):
    operator.tab("Measure")
    operator.fill("Folder below the data folder", "monday/first")
    operator.fill("Name", "TOY_by_hand_7")
    operator.fill("Note", "<b>by</b> hand")
    operator.page.get_by_text("at once, not from").click()
    operator.click("Start logging")
    operator.word_is("run", "recording")
    observer.fresh()
    start = observer.inputs.cycle
    observer.wait(lambda: observer.inputs.cycle > start + 100, what="a second of cycles")
    operator.click("Stop and save")
    operator.word_is("run", "complete")
    bag = data / "monday" / "first" / "TOY_by_hand_7"
    record = yaml.safe_load((bag / "run.yaml").read_text())
    assert record["status"] == "complete" and record["notes"] == "<b>by</b> hand"
    assert record["cycles_received"] >= 95
    assert record["et_value"] == pytest.approx(0.04)
    assert (bag / "metadata.yaml").exists()


def test_r1_ii_discards(operator, data):
    operator.tab("Measure")
    operator.fill("Name", "TOY_thrown_away")
    operator.click("Start logging")
    operator.word_is("run", "armed")
    assert (data / "TOY_thrown_away").is_dir()
    operator.click("Discard")
    operator.word_is("run", "discarded")
    assert not (data / "TOY_thrown_away").exists()


def test_r1_iv_v_ix_numbers_and_plots_follow_the_bench(operator, observer):
    operator.fill("Load [N]", 900)
    operator.click("Set Load")
    observer.wait(
        lambda: abs(observer.latest["contact"].wrench.force.z - 900.0) < 60.0,
        40.0,
        "the tire is loaded",
    )
    wait_for(lambda: abs(operator.number("fz") - 900.0) < 80.0, what="Fz in the ribbon")
    assert operator.number("rl") == pytest.approx(observer.latest["hub"].loaded_radius, abs=2e-4)
    drawn = (
        "() => { const c = fp.charts[0]; const s = getElement(c.id).chart.getOption().series;"
        " return s.map(x => (x.data[x.data.length - 1] || [0, 0])[1]); }"
    )
    wait_for(lambda: abs(operator.page.evaluate(drawn)[2] - 900.0) < 80.0, what="Fz in the plot")
    assert len(operator.page.evaluate(drawn)) == 6
    operator.click("Lift the wheel")
    observer.wait(
        lambda: observer.latest["hub"].loaded_radius > 0.326, 40.0, "the wheel is lifted"
    )


def test_r1_vi_constants_reach_the_hub(operator, observer):
    from rcl_interfaces.srv import GetParameters

    def value() -> float:
        answer = observer.client.call(
            GetParameters, "/measurement_hub/get_parameters", names=["et_value"]
        )
        return answer.values[0].double_value

    operator.tab("Set-up")
    operator.click("Read from bench")
    for wanted in (0.055, 0.04):
        operator.fill("ET value [m]", wanted)
        operator.click("Set constants")
        wait_for(lambda wanted=wanted: value() == wanted, what=f"et_value is {wanted}")
    operator.fill("ET value [m]", 0.9)
    operator.click("Set constants")
    operator.said("must be within")
    assert value() == 0.04


def test_r1_vii_enables_and_disables(operator, observer):
    operator.tab("Drive")
    operator.click("Enable")
    click = partial(operator.click, "Enable")
    observer.wait(observer.enabled, 60.0, "operation enabled on the bus", again=click)
    operator.click("Disable")
    observer.wait(lambda: not observer.enabled(), what="disabled on the bus")


def test_r1_viii_velocity_and_its_plot(enabled, observer):
    enabled.fill("Velocity [rad/s]", 0.08)
    turn(enabled, "Set velocity")
    observer.wait(
        lambda: observer.speed() == pytest.approx(0.08, rel=0.05),
        60.0,
        "the shaft turns",
        again=lambda: turn(enabled, "Set velocity"),
    )
    wait_for(lambda: abs(enabled.number("omega") - 0.08) < 0.01, what="speed in the ribbon")
    drawn = (
        "() => { const s = getElement(fp.charts[1].id).chart.getOption().series;"
        " return [s[2], s[3]].map(x => (x.data[x.data.length - 1] || [0, 0])[1]); }"
    )
    wait_for(
        lambda: enabled.page.evaluate(drawn) == pytest.approx([0.08, 0.08], rel=0.1),
        what="actual and reference in the plot",
    )


def test_r1_viii_n_i_position_buttons_turn_the_shaft(enabled, observer):
    enabled.click("Home: this is 0°")
    observer.wait(
        lambda: abs(observer.latest["drive"].position) < 1e-3,
        60.0,
        "homed",
        again=lambda: turn(enabled, "Home: this is 0°"),
    )
    before = observer.inputs.axes[0].position
    enabled.fill("Angle [deg]", 4)
    enabled.click("Turn there")
    observer.wait(
        lambda: abs(observer.turned(before) - 4.0) < 0.1,
        60.0,
        "4 deg at the shaft",
        again=lambda: turn(enabled, "Turn there"),
    )
    names = [f"{a}°" for a in (0, 120, 240, 360, 1080)]
    assert all(enabled.button(n).is_enabled() for n in names)
    enabled.click("0°")
    observer.wait(
        lambda: abs(observer.turned(before)) < 0.1,
        60.0,
        "back at the shaft",
        again=lambda: turn(enabled, "0°"),
    )


def test_r1_viii_torque(enabled, observer):
    enabled.fill("Torque [N m]", 1.2)
    enabled.click("Set torque")
    observer.wait(
        lambda: observer.inputs.axes[0].torque * 1e-4 == pytest.approx(1.2, abs=0.05),
        60.0,
        "torque at the motor, by the bus",
        again=lambda: turn(enabled, "Set torque"),
    )
    enabled.click("Quick stop")
    observer.wait(lambda: abs(observer.speed()) < 1e-3, what="the shaft rests")


def test_r1_viii_n_ii_slip_over_the_road(enabled, observer, data):
    """The waveform editor, a recording from the motion trigger on, and the plots over the road."""
    page = enabled.page
    enabled.fill("Starts at [m]", 0.06)
    enabled.fill("kappa", 0.3)
    enabled.click("Set slip control")
    enabled.said("mode slip")
    enabled.tab("Measure")
    enabled.fill("Name", "TOY_slip_by_hand")
    enabled.click("Start logging")
    enabled.word_is("run", "armed")
    enabled.tab("Machine")
    enabled.fill("Stops at [m]", 0.3)
    enabled.click("Plank forward")
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
    enabled.tab("Measure")
    enabled.click("Stop and save")
    enabled.word_is("run", "complete")
    record = yaml.safe_load((data / "TOY_slip_by_hand" / "run.yaml").read_text())
    assert record["cycles_received"] > 400
    enabled.tab("Machine")
    enabled.click("Plank back")
    observer.wait(
        lambda: (
            not observer.latest["encoders"].plank_moving
            and observer.latest["encoders"].plank_position < 0.01
        ),
        40.0,
        "the plank is back",
    )


def test_r1_x_status_of_the_bus(operator, observer):
    operator.tab("Bus")
    operator.word_is("health", "ok")
    wait_for(
        lambda: abs(int(operator.word("cycle")) - observer.inputs.cycle) < 500 or observer.look(),
        what="cycle number of the bus",
    )
    row = operator.page.get_by_role("row", name="wheel")
    word = f"0x{observer.inputs.axes[0].status_word:04X}"
    wait_for(lambda: word in (row.first.text_content() or ""), what=f"status word {word}")


def test_r1_xi_xii_parasitic_filter(operator, observer, data):
    sine = Sine(0.05, 1.0, 0.3, 0.0, 0.001)
    fit = ParasiticFit("test mounting", "2026-01-01", (sine,) * 5)
    (data / "mounting.yaml").write_text(to_text(fit))
    operator.tab("Set-up")
    operator.click("Filter on")
    operator.said("no parasitic fit is loaded")
    operator.page.get_by_role("button", name="Look for fits again").click()
    operator.choose("Fit of this mounting", "mounting.yaml")
    operator.click("Load")
    operator.said("parasitic fit mounting.yaml loaded")
    before = observer.latest["wheel"].wrench.force.y
    operator.click("Filter on")
    observer.wait(lambda: observer.latest["hub"].filter_on, what="the hub filters")
    observer.look(0.3)
    assert abs(observer.latest["wheel"].wrench.force.y - before) > 5.0
    operator.click("Filter off")
    observer.wait(lambda: not observer.latest["hub"].filter_on, what="the filter is off")


def test_r1_xi_the_filter_is_identified_from_a_run(operator, observer, data):
    """The run itself takes three minutes at the machine; here the twin has made it."""
    setup = BenchSetup(preset="thesis2023", pace="hold")
    (data / "mounting").mkdir()
    log = BagLog(data / "mounting")
    TwinBench(Twin(setup), log).perform(plan_of(Measurement(measurement="unloaded_turn")))
    operator.tab("Measure")
    operator.choose("Measurement", "three unloaded turns")
    operator.choose("Measurement", "slip step")
    operator.tab("Set-up")
    operator.page.get_by_role("button", name="Look for fits again").click()
    operator.page.get_by_label("Run of three unloaded turns", exact=True).click()
    operator.page.get_by_role("option").filter(has_text="mounting/TOY").first.click()
    operator.fill("Mounting", "../m")
    operator.click("Identify from the run")
    operator.said("not a name")
    operator.fill("Mounting", "m7")
    operator.click("Identify from the run")
    said = operator.page.get_by_text("Once per turn, before and after")
    said.wait_for(timeout=60_000)
    before, after = (float(w) for w in re.findall(r"[\d.]+(?= to| N)", said.text_content())[:2])
    assert before > 200.0 and after < 5.0
    operator.said("parasitic fit parasitic_m7_")
    fit = next((data / "parasitic").glob("parasitic_m7_*.yaml"))
    assert yaml.safe_load(fit.read_text())["mounting"] == "m7"
    operator.click("Filter on")
    observer.wait(lambda: observer.latest["hub"].filter_on, what="the hub filters")
    operator.click("Filter off")
    observer.wait(lambda: not observer.latest["hub"].filter_on, what="the filter is off")
